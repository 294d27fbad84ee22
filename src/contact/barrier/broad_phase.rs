//! Which simplices may come near each other.

use rayon::prelude::*;

use super::CollisionSurface;
use super::neighbours::Neighbours;
use super::separation::{Separation, nearest_on_triangle};
use crate::mesh::{Aabb, Bvh};
use crate::units::Vec3;

/// Simplices that one task looks at.
const BATCH: usize = 256;

/// Pairs that may come within reach: of a vertex and a triangle, and of two edges, each in ascending order.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub struct Candidates {
    pub(super) vertex_triangles: Vec<[u32; 2]>,
    pub(super) edge_edges: Vec<[u32; 2]>,
}

impl Candidates {
    /// Number of pairs.
    pub fn len(&self) -> usize {
        self.vertex_triangles.len() + self.edge_edges.len()
    }

    /// Whether there is none.
    pub fn is_empty(&self) -> bool {
        self.len() == 0
    }
}

/// Trees of boxes, whose shape is that of rest.
///
/// Obstacles have trees of their own, so that no pair of two obstacles is ever met.
#[derive(Clone, Debug)]
pub(super) struct BroadPhase {
    triangles: [Bvh; 2],
    edges: [Bvh; 2],
    neighbours: Neighbours,
}

impl BroadPhase {
    pub(super) fn new(surface: &CollisionSurface, rest: &[Vec3]) -> Self {
        let [triangles, edges] = boxes(surface, rest, rest);
        Self {
            triangles: triangles.map(Bvh::new),
            edges: edges.map(Bvh::new),
            neighbours: Neighbours::new(surface, rest),
        }
    }

    /// The pairs that count and may come nearer to each other than the reach of the vertex, or that of edges, while every
    /// vertex goes straight `from` there `to` here.
    pub(super) fn candidates(
        &self,
        surface: &CollisionSurface,
        from: &[Vec3],
        to: &[Vec3],
        vertex_reach: impl Fn(usize) -> f64 + Sync,
        edge_reach: f64,
    ) -> Candidates {
        let [triangle_boxes, edge_boxes] = boxes(surface, from, to);
        let refit = |trees: &[Bvh; 2], [tissue, obstacles]: [Vec<Aabb>; 2]| {
            [trees[0].refitted(tissue), trees[1].refitted(obstacles)]
        };
        let (triangles, edges) =
            rayon::join(|| refit(&self.triangles, triangle_boxes), || refit(&self.edges, edge_boxes));
        let motion = Motion { from, to };

        let of_vertex = |v: usize, found: &mut Vec<[u32; 2]>| {
            let reach = vertex_reach(v);
            let path = Aabb::around([from[v], to[v]]).widened(reach);
            let start = found.len();
            let mut meet = |t: usize| {
                let corners = surface.triangles[t];
                if motion.vertex_triangle_meet(v as u32, corners, reach)
                    && self.neighbours.vertex_triangle_count(surface, v, t)
                {
                    found.push([v as u32, t as u32]);
                }
            };
            triangles[0].for_each_overlapping(&path, &mut meet);
            if v < surface.n_tissue_vertices() {
                triangles[1].for_each_overlapping(&path, |t| meet(surface.n_tissue_triangles + t));
            }
            found[start..].sort_unstable();
        };
        let of_edge = |e: usize, found: &mut Vec<[u32; 2]>| {
            let ends = surface.edges[e];
            let path = Aabb::around(motion.places(ends)).widened(edge_reach);
            let start = found.len();
            let mut meet = |f: usize| {
                let others = surface.edges[f];
                if f > e
                    && motion.edges_meet(ends, others, edge_reach)
                    && self.neighbours.edges_count(surface, e, f)
                {
                    found.push([e as u32, f as u32]);
                }
            };
            edges[0].for_each_overlapping(&path, &mut meet);
            edges[1].for_each_overlapping(&path, |f| meet(surface.n_tissue_edges + f));
            found[start..].sort_unstable();
        };
        Candidates {
            vertex_triangles: in_order(surface.n_vertices(), of_vertex),
            edge_edges: in_order(surface.n_tissue_edges, of_edge),
        }
    }

    /// Calls `visit(edge, triangle)` for those whose boxes at rest overlap, one of them of tissue.
    pub(super) fn crossings<T: Send>(
        &self,
        surface: &CollisionSurface,
        x: &[Vec3],
        visit: impl Fn(usize, usize) -> Option<T> + Sync,
    ) -> Vec<T> {
        in_order(surface.edges.len(), |e, found| {
            let bounds = Aabb::around(surface.edges[e].map(|v| x[v as usize]));
            let mut hits = Vec::new();
            self.triangles[0].for_each_overlapping(&bounds, |t| hits.push(t));
            if e < surface.n_tissue_edges {
                self.triangles[1]
                    .for_each_overlapping(&bounds, |t| hits.push(surface.n_tissue_triangles + t));
            }
            hits.sort_unstable();
            found.extend(hits.into_iter().filter_map(|t| visit(e, t)));
        })
    }
}

/// What `find` adds for each of `0..n`, in their order whatever the number of threads.
fn in_order<T: Send>(n: usize, find: impl Fn(usize, &mut Vec<T>) + Sync) -> Vec<T> {
    let batch = |k: usize| {
        let mut found = Vec::new();
        (k * BATCH..((k + 1) * BATCH).min(n)).for_each(|i| find(i, &mut found));
        found
    };
    (0..n.div_ceil(BATCH)).into_par_iter().map(batch).collect::<Vec<_>>().into_iter().flatten().collect()
}

/// Boxes about the paths of the triangles and of the edges, of tissue and of obstacles.
fn boxes(surface: &CollisionSurface, from: &[Vec3], to: &[Vec3]) -> [[Vec<Aabb>; 2]; 2] {
    let motion = Motion { from, to };
    let (tissue, obstacles) = surface.triangles.split_at(surface.n_tissue_triangles);
    let triangles = [tissue, obstacles].map(|t| t.iter().map(|t| Aabb::around(motion.places(*t))).collect());
    let (tissue, obstacles) = surface.edges.split_at(surface.n_tissue_edges);
    [triangles, [tissue, obstacles].map(|e| e.iter().map(|e| Aabb::around(motion.places(*e))).collect())]
}

/// Vertices on their way.
struct Motion<'a> {
    from: &'a [Vec3],
    to: &'a [Vec3],
}

impl Motion<'_> {
    /// Where `vertices` start and end.
    fn places<const N: usize>(&self, vertices: [u32; N]) -> impl Iterator<Item = Vec3> + '_ {
        vertices.into_iter().flat_map(|v| [self.from[v as usize], self.to[v as usize]])
    }

    fn at<const N: usize>(&self, vertices: [u32; N]) -> [Vec3; N] {
        vertices.map(|v| self.from[v as usize])
    }

    fn step(&self, v: u32) -> Vec3 {
        self.to[v as usize] - self.from[v as usize]
    }

    /// Distances fall by no more than the greatest of the motions of the corners relative to the vertex.
    fn vertex_triangle_meet(&self, v: u32, t: [u32; 3], reach: f64) -> bool {
        let own = self.step(v);
        let nearer = t.iter().map(|&c| (self.step(c) - own).norm()).fold(0., f64::max);
        let [p] = self.at([v]);
        nearest_on_triangle(p, self.at(t)).1 <= (reach + nearer).powi(2)
    }

    fn edges_meet(&self, e: [u32; 2], f: [u32; 2], reach: f64) -> bool {
        let mean = |[a, b]: [u32; 2]| 0.5 * (self.step(a) + self.step(b));
        let spread = |[a, b]: [u32; 2]| 0.5 * (self.step(a) - self.step(b)).norm();
        let nearer = (mean(e) - mean(f)).norm() + spread(e) + spread(f);
        let [a, b, c, d] = self.at([e[0], e[1], f[0], f[1]]);
        Separation::of_edges(&[a, b, c, d]).offset.norm_squared() <= (reach + nearer).powi(2)
    }
}
