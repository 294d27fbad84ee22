//! What holds the mesh: supports, parts and the joints between them.

use std::collections::{BTreeMap, BTreeSet};

use super::facet::faces_by_corners;
use super::free_mode::{Motion, free_motions};
use super::validate::SHOWN;
use super::{Cell, Extent, FreeMode, Mesh, MeshError};
use crate::units::Vec3;

/// More parts than this in one piece are not analysed as a mechanism: it is in shreds.
const MAX_PARTS: usize = 150;

/// Checks that no part of `mesh`, held at the nodes `fixed`, can move rigidly.
///
/// Cells that share a face move as one body, for no element has other zero-energy modes. The bodies, tied
/// where they share nodes and held at fixed nodes, must have no motion left.
pub(super) fn check_supports(mesh: &Mesh, fixed: &[usize]) -> Result<(), MeshError> {
    if let Some(&node) = fixed.iter().find(|node| **node >= mesh.n_nodes()) {
        return Err(MeshError::MissingSupportNode { node, n_nodes: mesh.n_nodes() });
    }
    let fixed: BTreeSet<usize> = fixed.iter().copied().collect();
    let mut bodies = Groups::new(mesh.cells.len());
    for owners in faces_by_corners(mesh).values() {
        for pair in owners.windows(2) {
            bodies.join(pair[0].cell, pair[1].cell);
        }
    }
    let mut first_cell = vec![usize::MAX; mesh.n_nodes()];
    let mut pieces = bodies.clone();
    for (k, cell) in mesh.cells.iter().enumerate() {
        for &node in cell.nodes() {
            match first_cell[node] {
                usize::MAX => first_cell[node] = k,
                other => pieces.join(other, k),
            }
        }
    }
    let held = |cell: &Cell| cell.nodes().iter().any(|node| fixed.contains(node));
    if !mesh.cells.iter().any(held) {
        return Err(MeshError::NoSupports { modes: FreeMode::all(middle(mesh)) });
    }
    let pieces = pieces.members();
    for cells in &pieces {
        if !cells.iter().any(|&k| held(&mesh.cells[k])) {
            let (cells, n_cells) = sample(mesh, cells);
            return Err(MeshError::Disconnected { cells, n_cells });
        }
    }
    pieces.iter().try_for_each(|cells| check_piece(mesh, &fixed, cells, &mut bodies))
}

fn check_piece(
    mesh: &Mesh,
    fixed: &BTreeSet<usize>,
    cells: &[usize],
    bodies: &mut Groups,
) -> Result<(), MeshError> {
    let mut parts: BTreeMap<usize, Vec<usize>> = BTreeMap::new();
    let mut parts_of: BTreeMap<usize, BTreeSet<usize>> = BTreeMap::new();
    for &cell in cells {
        let part = bodies.root(cell);
        parts.entry(part).or_default().push(cell);
        for &node in mesh.cells[cell].nodes() {
            parts_of.entry(node).or_default().insert(part);
        }
    }
    let number: BTreeMap<usize, usize> = parts.keys().enumerate().map(|(k, part)| (*part, k)).collect();
    let hinge = |part: usize, modes: Vec<FreeMode>| {
        let (cells, n_cells) = sample(mesh, &parts[&part]);
        let joint = parts_of.iter().filter(|(_, all)| all.len() > 1 && all.contains(&part));
        let nodes = joint.map(|(node, _)| mesh.node_id(*node)).take(SHOWN).collect();
        MeshError::Hinge { nodes, cells, n_cells, modes }
    };
    if parts.len() > MAX_PARTS {
        let least = parts.iter().min_by_key(|(_, cells)| cells.len()).map(|(part, _)| *part);
        return Err(hinge(least.unwrap_or_default(), Vec::new()));
    }
    let centre = middle(mesh);
    let size = mesh.extent().longest_mm();
    let mut rows = Vec::new();
    for (node, of) in &parts_of {
        let of: Vec<usize> = of.iter().map(|part| number[part]).collect();
        if fixed.contains(node) {
            rows.extend(of.iter().map(|&b| (mesh.points[*node], vec![(b, 1.)])));
        } else {
            rows.extend(of.windows(2).map(|w| (mesh.points[*node], vec![(w[0], 1.), (w[1], -1.)])));
        }
    }
    let free = free_motions(parts.len(), &rows, centre, size);
    let Some(first) = free.first() else { return Ok(()) };
    // A motion is a hinge's if two bodies move differently; it is blamed on the smallest that moves
    // against the largest.
    let speed = |m: &Motion| m.shift.norm() + size * m.turn.norm();
    let against = |motions: &[Motion], a: usize, b: usize| Motion {
        shift: motions[a].shift - motions[b].shift,
        turn: motions[a].turn - motions[b].turn,
    };
    let sizes: Vec<(usize, usize)> = parts.iter().map(|(part, cells)| (*part, cells.len())).collect();
    let largest = (0..sizes.len()).rev().max_by_key(|&k| sizes[k].1).unwrap_or_default();
    let loose = (0..sizes.len())
        .filter(|&k| free.iter().any(|motions| speed(&against(motions, k, largest)) > 1e-6))
        .min_by_key(|&k| sizes[k].1);
    match loose {
        Some(k) => {
            let relative = free.iter().map(|motions| against(motions, k, largest));
            let modes = relative.filter(|m| speed(m) > 1e-6).map(|m| FreeMode::of(m, centre, size)).collect();
            Err(hinge(sizes[k].0, modes))
        }
        None => {
            debug_assert_eq!(first.len(), sizes.len());
            let modes = free.iter().map(|motions| FreeMode::of(motions[largest], centre, size)).collect();
            Err(MeshError::UnderConstrained { modes })
        }
    }
}

fn middle(mesh: &Mesh) -> Vec3 {
    let Extent { lo, hi } = mesh.extent();
    0.5 * (lo + hi)
}

fn sample(mesh: &Mesh, cells: &[usize]) -> (Vec<u64>, usize) {
    (cells.iter().take(SHOWN).map(|&k| mesh.cell_id(k)).collect(), cells.len())
}

/// Disjoint sets of numbers; the least of each stands for it.
#[derive(Clone)]
struct Groups {
    parent: Vec<usize>,
}

impl Groups {
    fn new(n: usize) -> Self {
        Self { parent: (0..n).collect() }
    }

    fn root(&mut self, k: usize) -> usize {
        let mut root = k;
        while self.parent[root] != root {
            self.parent[root] = self.parent[self.parent[root]];
            root = self.parent[root];
        }
        root
    }

    fn join(&mut self, a: usize, b: usize) {
        let (a, b) = (self.root(a), self.root(b));
        self.parent[a.max(b)] = a.min(b);
    }

    /// The groups, each ascending, by their least member.
    fn members(&mut self) -> Vec<Vec<usize>> {
        let mut groups: BTreeMap<usize, Vec<usize>> = BTreeMap::new();
        for k in 0..self.parent.len() {
            groups.entry(self.root(k)).or_default().push(k);
        }
        groups.into_values().collect()
    }
}
