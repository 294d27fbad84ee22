//! Facets: faces of cells that bound the mesh.

use std::collections::HashMap;

use super::{CellKind, Mesh};

/// Most nodes that a facet has (a face of a Tet10).
const MAX_FACET_NODES: usize = 6;

/// A face of a cell, counter-clockwise seen from outside the cell.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Facet {
    /// The cell (0-based) that owns the face.
    pub cell: usize,
    /// Position of the face in the kind's [`faces`](CellKind::faces).
    pub face: usize,
    n_corners: usize,
    n_nodes: usize,
    nodes: [usize; MAX_FACET_NODES],
}

impl Facet {
    /// Face `face` of cell `cell` of `mesh`.
    ///
    /// # Panics
    /// If the mesh has no such cell or the cell no such face.
    pub fn new(mesh: &Mesh, cell: usize, face: usize) -> Self {
        let (kind, all) = (mesh.cells[cell].kind(), mesh.cells[cell].nodes());
        let corners = kind.faces()[face];
        let mut nodes = [0; MAX_FACET_NODES];
        for (node, &corner) in nodes.iter_mut().zip(corners) {
            *node = all[corner];
        }
        let mut n_nodes = corners.len();
        for mid in face_mid_nodes(kind, corners) {
            nodes[n_nodes] = all[mid];
            n_nodes += 1;
        }
        Self { cell, face, n_corners: corners.len(), n_nodes, nodes }
    }

    /// Corner nodes (0-based), three or four.
    pub fn corners(&self) -> &[usize] {
        &self.nodes[..self.n_corners]
    }

    /// All nodes: the corners, then for a quadratic face the mid-edge nodes of edges 01, 12, 20.
    pub fn nodes(&self) -> &[usize] {
        &self.nodes[..self.n_nodes]
    }

    /// Corner nodes in ascending order, padded with `usize::MAX`: equal for two cells that share the face.
    pub(super) fn key(&self) -> [usize; 4] {
        let mut key = [usize::MAX; 4];
        key[..self.n_corners].copy_from_slice(self.corners());
        key.sort_unstable();
        key
    }
}

/// Local mid-edge nodes of the face with local corners `corners`, edge by edge.
pub(super) fn face_mid_nodes(kind: CellKind, corners: &[usize]) -> Vec<usize> {
    let mids = kind.mid_edge_nodes();
    if mids.is_empty() {
        return Vec::new();
    }
    let of_edge = |a: usize, b: usize| {
        kind.edges().iter().zip(mids).find(|(e, _)| **e == [a, b] || **e == [b, a]).map(|(_, &mid)| mid)
    };
    (0..corners.len()).filter_map(|k| of_edge(corners[k], corners[(k + 1) % corners.len()])).collect()
}

/// Every face of every cell, grouped by its corner nodes, in cell order.
pub(super) fn faces_by_corners(mesh: &Mesh) -> HashMap<[usize; 4], Vec<Facet>> {
    let mut faces: HashMap<[usize; 4], Vec<Facet>> = HashMap::with_capacity(4 * mesh.cells.len());
    for (cell, c) in mesh.cells.iter().enumerate() {
        for face in 0..c.kind().faces().len() {
            let facet = Facet::new(mesh, cell, face);
            faces.entry(facet.key()).or_default().push(facet);
        }
    }
    faces
}

/// The facets that belong to one cell only, by cell and face: the boundary of `mesh`.
pub fn boundary_facets(mesh: &Mesh) -> Vec<Facet> {
    let mut facets: Vec<Facet> = faces_by_corners(mesh)
        .into_values()
        .filter_map(|owners| match owners[..] {
            [only] => Some(only),
            _ => None,
        })
        .collect();
    facets.sort_unstable_by_key(|f| (f.cell, f.face));
    facets
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::mesh::testing::{block, tet10};

    #[test]
    fn a_block_has_the_faces_of_its_six_sides() {
        let mesh = block([2, 3, 4]);
        assert_eq!(boundary_facets(&mesh).len(), 2 * (2 * 3 + 3 * 4 + 2 * 4));
    }

    #[test]
    fn quadratic_facets_carry_the_nodes_between_their_corners() {
        let mesh = tet10();
        for facet in boundary_facets(&mesh) {
            let at = |k: usize| mesh.points[facet.nodes()[k]];
            for k in 0..3 {
                assert!((at(3 + k) - 0.5 * (at(k) + at((k + 1) % 3))).norm() < 1e-14);
            }
        }
    }
}
