//! Which simplices are parts of one sheet.

use super::CollisionSurface;
use crate::units::Vec3;

/// Cosine between the normals at rest of parts of one sheet, at least.
const ONE_SHEET: f64 = 0.5;

/// Tells neighbours, which never count: those that have a vertex in common, and those that have a mesh node in common and look
/// the same way at rest within 60 degrees.
///
/// The latter are about as far apart as facets are large, and would hold the reach below that; the cells behind them
/// keep them from folding. Where the tissue has a crease, as at the corners of the mouth, its sides look at each other
/// and count up to the nodes that they share.
#[derive(Clone, Debug)]
pub(super) struct Neighbours {
    vertex_normals: Vec<Vec3>,
    triangle_normals: Vec<Vec3>,
    edge_normals: Vec<Vec3>,
}

impl Neighbours {
    /// Normals of the tissue of `surface`, whose vertices are at `rest`.
    pub(super) fn new(surface: &CollisionSurface, rest: &[Vec3]) -> Self {
        let mut vertex_normals = vec![Vec3::zeros(); surface.n_tissue_vertices()];
        let mut triangle_normals = Vec::with_capacity(surface.n_tissue_triangles);
        let mut edge_normals = vec![Vec3::zeros(); surface.n_tissue_edges];
        for (t, corners) in surface.triangles[..surface.n_tissue_triangles].iter().enumerate() {
            let [a, b, c] = corners.map(|v| rest[v as usize]);
            let area = (b - a).cross(&(c - a));
            triangle_normals.push(unit(area));
            corners.iter().for_each(|&v| vertex_normals[v as usize] += area);
            surface.edges_of(t).into_iter().flatten().for_each(|e| edge_normals[e] += area);
        }
        Self {
            vertex_normals: vertex_normals.into_iter().map(unit).collect(),
            triangle_normals,
            edge_normals: edge_normals.into_iter().map(unit).collect(),
        }
    }

    /// Whether vertex `v` and triangle `t` are neighbours.
    pub(super) fn vertex_triangle(&self, surface: &CollisionSurface, v: usize, t: usize) -> bool {
        let corners = surface.triangles[t];
        let (Some(n), Some(m)) = (self.vertex_normals.get(v), self.triangle_normals.get(t)) else {
            return false;
        };
        corners.contains(&(v as u32)) || n.dot(m) > ONE_SHEET && share_nodes(surface, &[v as u32], &corners)
    }

    /// Whether edges `e` and `f` are neighbours.
    pub(super) fn edges(&self, surface: &CollisionSurface, e: usize, f: usize) -> bool {
        let (ends, others) = (surface.edges[e], surface.edges[f]);
        let (Some(n), Some(m)) = (self.edge_normals.get(e), self.edge_normals.get(f)) else { return false };
        ends.iter().any(|v| others.contains(v))
            || n.dot(m) > ONE_SHEET && share_nodes(surface, &ends, &others)
    }
}

fn unit(v: Vec3) -> Vec3 {
    v.try_normalize(0.).unwrap_or_else(Vec3::zeros)
}

fn share_nodes(surface: &CollisionSurface, some: &[u32], others: &[u32]) -> bool {
    let nodes = |&v: &u32| surface.carriers(v as usize).iter().map(|s| s.0);
    some.iter().flat_map(nodes).any(|node| others.iter().flat_map(nodes).any(|other| other == node))
}
