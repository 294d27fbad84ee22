//! A volume mesh of mixed cells.

use std::collections::BTreeMap;

use super::{Cell, CellKind, Extent, Quality};
use crate::units::Vec3;

/// The nodes of a wedge in VTK's order by their places in ours, and the other way round.
pub(crate) const WEDGE_OTHER_ORDER: [usize; 6] = [0, 2, 1, 3, 5, 4];

/// A volume mesh: points (n x 3, mm) and cells of any of the four kinds.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Mesh {
    /// Node positions, mm.
    pub points: Vec<Vec3>,
    /// Cells on 0-based nodes.
    pub cells: Vec<Cell>,
    /// What the file calls each node, for messages; 0-based positions when it has no numbers.
    pub node_ids: Vec<u64>,
    /// What the file calls each cell, for messages.
    pub cell_ids: Vec<u64>,
    /// Named node sets, 0-based and ascending.
    pub node_sets: BTreeMap<String, Vec<usize>>,
    /// Named cell sets, 0-based and ascending.
    pub cell_sets: BTreeMap<String, Vec<usize>>,
}

impl Mesh {
    /// A mesh without sets whose ids are its positions.
    pub fn new(points: Vec<Vec3>, cells: Vec<Cell>) -> Self {
        let (node_ids, cell_ids) = ((0..points.len() as u64).collect(), (0..cells.len() as u64).collect());
        Self { points, cells, node_ids, cell_ids, ..Self::default() }
    }

    /// Number of nodes.
    pub fn n_nodes(&self) -> usize {
        self.points.len()
    }

    /// What the file calls node `node`, or its position if it has no number.
    pub fn node_id(&self, node: usize) -> u64 {
        self.node_ids.get(node).copied().unwrap_or(node as u64)
    }

    /// What the file calls cell `cell`, or its position if it has no number.
    pub fn cell_id(&self, cell: usize) -> u64 {
        self.cell_ids.get(cell).copied().unwrap_or(cell as u64)
    }

    /// Turns wedges whose Jacobian is negative throughout inside out; returns how many.
    ///
    /// VTK orders the triangles of a wedge against Gmsh and Abaqus, but not all programs that write VTK
    /// files know, and converters carry either order anywhere: only the geometry tells.
    ///
    /// # Panics
    /// If a wedge has a node that the mesh has not.
    pub fn orient_wedges(&mut self) -> usize {
        let mut turned = 0;
        for cell in self.cells.iter_mut().filter(|c| c.kind() == CellKind::Wedge6) {
            if Quality::new(cell, &self.points).max_jacobian < 0. {
                *cell = Cell::new(CellKind::Wedge6, &WEDGE_OTHER_ORDER.map(|k| cell.nodes()[k]));
                turned += 1;
            }
        }
        turned
    }

    /// Positions of the nodes of cell `cell`, mm.
    pub fn cell_points(&self, cell: usize) -> impl ExactSizeIterator<Item = Vec3> + '_ {
        self.cells[cell].nodes().iter().map(|&node| self.points[node])
    }

    /// The box around the nodes of cells, mm: nodes of no cell may be anywhere.
    pub fn extent(&self) -> Extent {
        Extent::of(self.cells.iter().flat_map(Cell::nodes).filter_map(|&node| self.points.get(node)))
    }
}
