//! What may touch: surfaces of tissue, carried by mesh nodes, and obstacles.

use std::collections::BTreeMap;

use crate::contact::Facets;
use crate::mesh::{Mesh, Surface};
use crate::units::Vec3;

/// What a vertex belongs to.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
pub enum Body {
    /// The surface that mesh nodes carry.
    Tissue,
    /// An obstacle, 0-based: its position is given.
    Obstacle(usize),
}

/// Triangles of tissue, whose vertices are carried by mesh nodes, and of obstacles, whose vertices are placed from
/// outside.
///
/// Vertices, triangles and edges of tissue come first, then those of each obstacle in turn.
#[derive(Clone, Debug)]
pub struct CollisionSurface {
    n_nodes: usize,
    /// Where the shares of each tissue vertex begin, and where the last ones end.
    starts: Vec<usize>,
    shares: Vec<(usize, f64)>,
    /// First vertex of each obstacle, and the number of all vertices.
    obstacles: Vec<usize>,
    pub(super) triangles: Vec<[u32; 3]>,
    pub(super) edges: Vec<[u32; 2]>,
    pub(super) n_tissue_triangles: usize,
    pub(super) n_tissue_edges: usize,
}

impl CollisionSurface {
    /// `facets` of `mesh` and the surfaces `obstacles`, which no node carries.
    ///
    /// Of a quadrilateral come `subdivision` x `subdivision` bilinear parts, each as four triangles about its middle, so
    /// that a mirrored mesh has the mirrored triangles; of a triangle `subdivision` squared parts.
    ///
    /// # Panics
    /// If a facet has a node that `mesh` has not.
    pub fn new(mesh: &Mesh, facets: &Facets, obstacles: &[&Surface], subdivision: usize) -> Self {
        let mut tissue = Tissue { parts: subdivision.max(1), ..Tissue::default() };
        for facet in facets.corners() {
            assert!(facet.iter().all(|node| *node < mesh.n_nodes()), "a facet of another mesh");
            match **facet {
                [a, b, c] => tissue.add_triangle([a, b, c]),
                [a, b, c, d] => tissue.add_quadrilateral([a, b, c, d]),
                _ => {}
            }
        }
        let mut starts = vec![0];
        let mut shares = Vec::new();
        for carriers in &tissue.carriers {
            shares.extend_from_slice(carriers);
            starts.push(shares.len());
        }
        let mut triangles = tissue.triangles;
        let n_tissue_triangles = triangles.len();
        let mut edges = unique_edges(&triangles);
        let n_tissue_edges = edges.len();
        let mut firsts = vec![tissue.carriers.len()];
        for surface in obstacles {
            let first = firsts[firsts.len() - 1];
            let own: Vec<[u32; 3]> =
                surface.triangles.iter().map(|t| t.map(|v| (first + v) as u32)).collect();
            edges.extend(unique_edges(&own));
            triangles.extend(own);
            firsts.push(first + surface.points.len());
        }
        Self {
            n_nodes: mesh.n_nodes(),
            starts,
            shares,
            obstacles: firsts,
            triangles,
            edges,
            n_tissue_triangles,
            n_tissue_edges,
        }
    }

    /// Positions of all vertices, mm, where the mesh nodes are at `nodes` (n) and the points of each obstacle at
    /// `obstacles`.
    ///
    /// # Panics
    /// If there are not as many nodes, obstacles or points of an obstacle as at the start.
    pub fn positions(&self, nodes: &[Vec3], obstacles: &[Vec<Vec3>]) -> Vec<Vec3> {
        assert_eq!(nodes.len(), self.n_nodes, "nodes");
        let carried = |v: usize| self.carriers(v).iter().map(|&(node, w)| w * nodes[node]).sum();
        let mut positions: Vec<Vec3> = (0..self.n_tissue_vertices()).map(carried).collect();
        assert_eq!(obstacles.len(), self.obstacles.len() - 1, "obstacles");
        for (points, ends) in obstacles.iter().zip(self.obstacles.windows(2)) {
            assert_eq!(points.len(), ends[1] - ends[0], "points of an obstacle");
            positions.extend_from_slice(points);
        }
        positions
    }

    /// The mesh nodes (0-based) that carry vertex `vertex`, and their weights, which sum to one; none of an obstacle.
    pub fn carriers(&self, vertex: usize) -> &[(usize, f64)] {
        match self.starts.get(vertex..vertex + 2) {
            Some(ends) => &self.shares[ends[0]..ends[1]],
            None => &[],
        }
    }

    /// The edges of triangle `t`, from each corner to the next.
    pub(super) fn edges_of(&self, t: usize) -> [Option<usize>; 3] {
        let [a, b, c] = self.triangles[t];
        // Edges ascend within tissue and within obstacles, whose vertices come after those of tissue.
        let (tissue, obstacles) = self.edges.split_at(self.n_tissue_edges);
        let (edges, first) =
            if t < self.n_tissue_triangles { (tissue, 0) } else { (obstacles, self.n_tissue_edges) };
        [[a, b], [b, c], [c, a]]
            .map(|[v, w]| edges.binary_search(&[v.min(w), v.max(w)]).ok().map(|e| first + e))
    }

    /// What vertex `vertex` belongs to.
    pub fn body(&self, vertex: usize) -> Body {
        match self.obstacles.partition_point(|first| *first <= vertex) {
            0 => Body::Tissue,
            k => Body::Obstacle(k - 1),
        }
    }

    /// Number of mesh nodes, those included that carry no vertex.
    pub fn n_nodes(&self) -> usize {
        self.n_nodes
    }

    /// Number of vertices.
    pub fn n_vertices(&self) -> usize {
        self.obstacles[self.obstacles.len() - 1]
    }

    /// Number of vertices that mesh nodes carry; they are the first.
    pub fn n_tissue_vertices(&self) -> usize {
        self.obstacles[0]
    }

    /// The vertices (0-based) of each triangle, counter-clockwise seen from outside.
    pub fn triangles(&self) -> impl ExactSizeIterator<Item = [usize; 3]> + '_ {
        self.triangles.iter().map(|t| t.map(|v| v as usize))
    }
}

/// The edges of `triangles`, each once as its ascending ends, in ascending order.
fn unique_edges(triangles: &[[u32; 3]]) -> Vec<[u32; 2]> {
    let sides = |t: &[u32; 3]| [[t[0], t[1]], [t[1], t[2]], [t[2], t[0]]];
    let mut edges: Vec<[u32; 2]> =
        triangles.iter().flat_map(sides).map(|[a, b]| [a.min(b), a.max(b)]).collect();
    edges.sort_unstable();
    edges.dedup();
    edges
}

/// Triangles of tissue as they are made.
#[derive(Default)]
struct Tissue {
    parts: usize,
    carriers: Vec<Vec<(usize, f64)>>,
    /// Vertices by what carries them, so that parts of a facet and neighbouring facets share those of their sides.
    known: BTreeMap<Vec<(usize, usize)>, u32>,
    triangles: Vec<[u32; 3]>,
}

impl Tissue {
    /// The vertex of these shares, which are counted in whole numbers: they sum to `(2 parts)^2`.
    fn vertex(&mut self, shares: impl Iterator<Item = (usize, usize)>) -> u32 {
        let mut shares: Vec<(usize, usize)> = shares.filter(|(_, share)| *share > 0).collect();
        shares.sort_unstable();
        let whole = (4 * self.parts * self.parts) as f64;
        let carriers = &mut self.carriers;
        *self.known.entry(shares).or_insert_with_key(|shares| {
            carriers.push(shares.iter().map(|&(node, share)| (node, share as f64 / whole)).collect());
            (carriers.len() - 1) as u32
        })
    }

    fn add_triangle(&mut self, nodes: [usize; 3]) {
        let n = self.parts;
        let at = |tissue: &mut Self, i: usize, j: usize| {
            tissue.vertex(nodes.into_iter().zip([n - i - j, i, j].map(|share| 4 * n * share)))
        };
        for j in 0..n {
            for i in 0..n - j {
                let corners = [at(self, i, j), at(self, i + 1, j), at(self, i, j + 1)];
                self.triangles.push(corners);
                if i + j + 2 <= n {
                    let corners = [corners[1], at(self, i + 1, j + 1), corners[2]];
                    self.triangles.push(corners);
                }
            }
        }
    }

    fn add_quadrilateral(&mut self, nodes: [usize; 4]) {
        // In half parts, so that middles too are counted in whole numbers.
        let n = 2 * self.parts;
        let at = |tissue: &mut Self, i: usize, j: usize| {
            tissue.vertex(nodes.into_iter().zip([(n - i) * (n - j), i * (n - j), i * j, (n - i) * j]))
        };
        for j in (0..n).step_by(2) {
            for i in (0..n).step_by(2) {
                let rim = [at(self, i, j), at(self, i + 2, j), at(self, i + 2, j + 2), at(self, i, j + 2)];
                let hub = at(self, i + 1, j + 1);
                for k in 0..4 {
                    self.triangles.push([rim[k], rim[(k + 1) % 4], hub]);
                }
            }
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::contact::barrier::testing::{sheet, triangulated};
    use crate::mesh::{Cell, CellKind};

    #[test]
    fn neighbouring_facets_share_the_vertices_of_their_side() {
        let mesh = sheet(2, 0.);
        for parts in 1..4 {
            let surface = CollisionSurface::new(&mesh, &Facets::of(&mesh), &[], parts);
            // A closed surface: V - E + F = 2 and every edge has two triangles.
            let (v, e, f) = (surface.n_vertices(), surface.edges.len(), surface.triangles.len());
            assert_eq!((v + f - e, 2 * e), (2, 3 * f), "{parts}");
            assert_eq!(f, Facets::of(&mesh).len() * 4 * parts * parts);
        }
    }

    #[test]
    fn a_wedge_joins_triangles_and_quadrilaterals() {
        let points = CellKind::Wedge6.node_positions().iter().map(|p| Vec3::from(*p)).collect();
        let mesh = Mesh::new(points, vec![Cell::new(CellKind::Wedge6, &[0, 1, 2, 3, 4, 5])]);
        for parts in 1..4 {
            let surface = CollisionSurface::new(&mesh, &Facets::of(&mesh), &[], parts);
            let (v, e, f) = (surface.n_vertices(), surface.edges.len(), surface.triangles.len());
            assert_eq!((v + f - e, 2 * e), (2, 3 * f), "{parts}");
            let x = surface.positions(&mesh.points, &[]);
            let volume: f64 =
                surface.triangles().map(|t| t.map(|v| x[v])).map(|[a, b, c]| a.dot(&b.cross(&c)) / 6.).sum();
            let whole = CollisionSurface::new(&mesh, &Facets::of(&mesh), &[], 1);
            let expected: f64 = whole
                .triangles()
                .map(|t| t.map(|v| whole.positions(&mesh.points, &[])[v]))
                .map(|[a, b, c]| a.dot(&b.cross(&c)) / 6.)
                .sum();
            assert!(volume > 0. && (volume - expected).abs() < 1e-12, "{parts}: {volume}");
        }
    }

    #[test]
    fn obstacles_follow_tissue_and_stand_where_they_are_put() {
        let mesh = sheet(1, 0.);
        let (a, b) = (triangulated(2, 1.), triangulated(3, 2.));
        let surface = CollisionSurface::new(&mesh, &Facets::of(&mesh), &[&a, &b], 1);
        let first = surface.n_tissue_vertices();
        assert_eq!(surface.body(first - 1), Body::Tissue);
        assert_eq!(surface.body(first), Body::Obstacle(0));
        assert_eq!(surface.body(first + a.points.len()), Body::Obstacle(1));
        assert_eq!(surface.body(surface.n_vertices() - 1), Body::Obstacle(1));
        let moved: Vec<Vec3> = b.points.iter().map(|p| p + Vec3::x()).collect();
        let x = surface.positions(&mesh.points, &[a.points.clone(), moved.clone()]);
        assert_eq!(x[first + a.points.len()..], moved[..]);
        assert!(surface.carriers(first).is_empty() && surface.carriers(x.len() + 5).is_empty());
        for v in 0..first {
            assert!((surface.carriers(v).iter().map(|s| s.1).sum::<f64>() - 1.).abs() < 1e-15);
        }
    }
}
