//! Which simplices may come near each other.

use rayon::prelude::*;

use super::CollisionSurface;
use super::neighbours::Neighbours;
use super::separation::{edges_squared_distance, nearest_on_triangle};
use crate::mesh::{Aabb, Bvh};
use crate::units::Vec3;

/// How many tasks the search among two trees is divided into.
const TASKS: usize = 64;

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

/// Trees of boxes, whose shape is that of rest: of tissue, and of obstacles, so that no pair of two obstacles is met.
#[derive(Clone, Debug)]
pub(super) struct BroadPhase {
    vertices: [Bvh; 2],
    edges: [Bvh; 2],
    triangles: [Bvh; 2],
    neighbours: Neighbours,
}

impl BroadPhase {
    pub(super) fn new(surface: &CollisionSurface, rest: &[Vec3]) -> Self {
        let motion = Motion { from: rest, to: rest };
        Self {
            vertices: motion.vertex_boxes(surface, |_| 0.).map(|boxes| Bvh::new(&boxes)),
            edges: motion.edge_boxes(surface, 0.).map(|boxes| Bvh::new(&boxes)),
            triangles: motion.triangle_boxes(surface).map(|boxes| Bvh::new(&boxes)),
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
        let motion = Motion { from, to };
        let vertex_triangle = |v: usize, t: usize| {
            let meet = !self.neighbours.vertex_triangle(surface, v, t)
                && motion.vertex_triangle_meet(v as u32, surface.triangles[t], vertex_reach(v));
            meet.then_some([v as u32, t as u32])
        };
        let edge_edge = |e: usize, f: usize| {
            let (e, f) = (e.min(f), e.max(f));
            let meet = !self.neighbours.edges(surface, e, f)
                && motion.edges_meet(surface.edges[e], surface.edges[f], edge_reach);
            meet.then_some([e as u32, f as u32])
        };
        let of_vertices = || {
            let vertices = refitted(&self.vertices, motion.vertex_boxes(surface, &vertex_reach));
            let triangles = refitted(&self.triangles, motion.triangle_boxes(surface));
            let firsts = [surface.n_tissue_vertices(), surface.n_tissue_triangles];
            let mut pairs = overlapping([&vertices[0], &triangles[0]], [0, 0], vertex_triangle);
            pairs.extend(overlapping([&vertices[0], &triangles[1]], [0, firsts[1]], vertex_triangle));
            pairs.extend(overlapping([&vertices[1], &triangles[0]], [firsts[0], 0], vertex_triangle));
            pairs.par_sort_unstable();
            pairs
        };
        let of_edges = || {
            // Either of two edges has half of what is between them.
            let edges = refitted(&self.edges, motion.edge_boxes(surface, 0.5 * edge_reach));
            let mut pairs = overlapping([&edges[0], &edges[0]], [0, 0], edge_edge);
            pairs.extend(overlapping([&edges[0], &edges[1]], [0, surface.n_tissue_edges], edge_edge));
            pairs.par_sort_unstable();
            pairs
        };
        let (vertex_triangles, edge_edges) = rayon::join(of_vertices, of_edges);
        Candidates { vertex_triangles, edge_edges }
    }

    /// What `visit(edge, triangle)` finds for those whose boxes at rest overlap, one of them of tissue.
    pub(super) fn crossings<T: Send>(
        &self,
        surface: &CollisionSurface,
        visit: impl Fn(usize, usize) -> Option<T> + Sync,
    ) -> Vec<T> {
        let (edges, triangles) = (&self.edges, &self.triangles);
        let firsts = [surface.n_tissue_edges, surface.n_tissue_triangles];
        let mut found = overlapping([&edges[0], &triangles[0]], [0, 0], &visit);
        found.extend(overlapping([&edges[0], &triangles[1]], [0, firsts[1]], &visit));
        found.extend(overlapping([&edges[1], &triangles[0]], [firsts[0], 0], &visit));
        found
    }
}

fn refitted(trees: &[Bvh; 2], [tissue, obstacles]: [Vec<Aabb>; 2]) -> [Bvh; 2] {
    [trees[0].refitted(&tissue), trees[1].refitted(&obstacles)]
}

/// What `find` finds for items of two trees whose boxes overlap, counted from `firsts`; in the same order whatever the
/// number of threads.
fn overlapping<T: Send>(
    trees: [&Bvh; 2],
    firsts: [usize; 2],
    find: impl Fn(usize, usize) -> Option<T> + Sync,
) -> Vec<T> {
    let below = |meeting: [usize; 2]| {
        let mut found = Vec::new();
        trees[0].pairs_below(trees[1], meeting, |i, j| found.extend(find(firsts[0] + i, firsts[1] + j)));
        found
    };
    let meetings = trees[0].meetings(trees[1], TASKS);
    meetings.into_par_iter().map(below).collect::<Vec<_>>().into_iter().flatten().collect()
}

/// Vertices on their way.
struct Motion<'a> {
    from: &'a [Vec3],
    to: &'a [Vec3],
}

impl Motion<'_> {
    /// Boxes about the paths of vertices, of tissue and of obstacles, widened by the reach of each.
    fn vertex_boxes(&self, surface: &CollisionSurface, reach: impl Fn(usize) -> f64) -> [Vec<Aabb>; 2] {
        let of = |v: usize| Aabb::around([self.from[v], self.to[v]]).widened(reach(v));
        let first = surface.n_tissue_vertices();
        [(0..first).map(of).collect(), (first..surface.n_vertices()).map(of).collect()]
    }

    fn edge_boxes(&self, surface: &CollisionSurface, reach: f64) -> [Vec<Aabb>; 2] {
        let of = |e: &[u32; 2]| Aabb::around(self.places(*e)).widened(reach);
        let (tissue, obstacles) = surface.edges.split_at(surface.n_tissue_edges);
        [tissue, obstacles].map(|edges| edges.iter().map(of).collect())
    }

    fn triangle_boxes(&self, surface: &CollisionSurface) -> [Vec<Aabb>; 2] {
        let of = |t: &[u32; 3]| Aabb::around(self.places(*t));
        let (tissue, obstacles) = surface.triangles.split_at(surface.n_tissue_triangles);
        [tissue, obstacles].map(|triangles| triangles.iter().map(of).collect())
    }

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
        edges_squared_distance(&[a, b, c, d]) <= (reach + nearer).powi(2)
    }
}
