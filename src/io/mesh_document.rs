//! A mesh as its file states it, with what the file has beside it.

use std::collections::{BTreeMap, HashSet};

use thiserror::Error;

use super::InputFile;
use crate::mesh::{Cell, Mesh};

/// A mesh with what was odd about its file.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct MeshDocument {
    /// The mesh, mm.
    pub mesh: Mesh,
    /// What was read otherwise than it stands in the file.
    pub warnings: Vec<MeshFileWarning>,
    /// Arrays and groups of the file that are no sets.
    pub no_sets: Vec<NoSet>,
    /// The files that were read, the mesh file first.
    pub files: Vec<InputFile>,
}

/// A named thing of a mesh file that cannot be asked for as a set.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct NoSet {
    /// Its name in the file.
    pub name: String,
    /// Why it is no set.
    pub why: String,
}

/// What was read otherwise than it stands in the file.
#[derive(Clone, Debug, Error, PartialEq, Eq)]
#[non_exhaustive]
pub enum MeshFileWarning {
    /// Quadratic cells of which only the corners are taken.
    #[error(
        "{count} cells of kind {kind} (first: {first}) are read by their corners alone; export linear cells, \
         or 10-node tetrahedra, for a mesh as fine as this one"
    )]
    Corners {
        /// The kind as the file calls it.
        kind: String,
        /// How many.
        count: usize,
        /// The first one's number.
        first: u64,
    },
    /// Cells that another piece of the file owns.
    #[error("{count} ghost cells are left out")]
    Ghosts {
        /// How many.
        count: usize,
    },
}

/// Quadratic cells that become linear: which, and the nodes between their corners.
#[derive(Clone, Debug, Default)]
pub(super) struct Corners {
    kinds: BTreeMap<String, (usize, u64)>,
    between: HashSet<usize>,
}

impl Corners {
    /// Counts cell `id` of kind `kind`, of which the nodes `between` are left out.
    pub(super) fn add(&mut self, kind: &str, id: u64, between: impl IntoIterator<Item = usize>) {
        match self.kinds.get_mut(kind) {
            Some((count, _)) => *count += 1,
            None => {
                self.kinds.insert(kind.to_owned(), (1, id));
            }
        }
        self.between.extend(between);
    }

    /// Takes the nodes between corners out of the mesh of `document`, and says so.
    pub(super) fn finish(self, document: &mut MeshDocument) {
        if self.kinds.is_empty() {
            return;
        }
        let used: HashSet<usize> =
            document.mesh.cells.iter().flat_map(|c| c.nodes().iter().copied()).collect();
        let gone = |node: usize| self.between.contains(&node) && !used.contains(&node);
        remove_nodes(&mut document.mesh, gone);
        let warnings = self.kinds.into_iter().map(|(kind, (count, first))| MeshFileWarning::Corners {
            kind,
            count,
            first,
        });
        document.warnings.extend(warnings);
    }
}

/// Takes the nodes that are `gone`, which no cell uses, out of `mesh` and its sets.
pub(super) fn remove_nodes(mesh: &mut Mesh, gone: impl Fn(usize) -> bool) {
    let mut new = vec![None; mesh.n_nodes()];
    let mut kept = 0;
    for (node, new) in new.iter_mut().enumerate() {
        if !gone(node) {
            *new = Some(kept);
            mesh.points[kept] = mesh.points[node];
            mesh.node_ids[kept] = mesh.node_ids[node];
            kept += 1;
        }
    }
    mesh.points.truncate(kept);
    mesh.node_ids.truncate(kept);
    for cell in &mut mesh.cells {
        let nodes: Vec<usize> = cell.nodes().iter().filter_map(|&node| new[node]).collect();
        *cell = Cell::new(cell.kind(), &nodes);
    }
    for set in mesh.node_sets.values_mut() {
        *set = set.iter().filter_map(|&node| new[node]).collect();
    }
}
