//! Which cells share one mean dilatation.

use std::collections::{BTreeMap, BTreeSet, VecDeque};

use super::facet::faces_by_corners;
use super::{CellKind, Mesh};

/// What a patch grows to where no edge has all its tetrahedra free, and what left-overs may grow it to.
const GROWN: usize = 6;
const MOST: usize = 10;
/// Fewer cells than this are no patch of their own where there is a neighbour.
const FEWEST: usize = 3;

/// Edge lengths that differ by less than this share of the longest are equal, so that rounding does not choose.
const SAME_LENGTH: f64 = 1e-9;

/// The partition of the cells of a mesh into patches, each of which has one volumetric strain: the mean over its volume.
///
/// A hexahedron, a wedge or a quadratic tetrahedron is a patch of its own. Linear tetrahedra are not: each has one
/// volumetric strain, which is 5.5 constraints a node where tissue hardly changes its volume, and they lock. Patches of
/// six leave about one a node, as hexahedra have; of distorted meshes they hold up to nine on average. They are, in this order, all tetrahedra about an inner edge, the longest
/// edges first (of a hexahedron cut into six that about its diagonal, which gives the hexahedron back), and left-overs
/// joined to the smallest patch beside them. A patch is connected through faces and has only tetrahedra.
///
/// Source: the F-bar-patch of de Souza Neto, Pires and Owen, Int. J. Numer. Meth. Engng 62 (2005) 353, who choose
/// the patches otherwise.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct DilatationPatches {
    /// Cells of each patch, ascending; patches by their first cell.
    cells: Vec<Vec<usize>>,
    /// Patch of each cell.
    patch: Vec<usize>,
}

impl DilatationPatches {
    /// The patches of `mesh`: the same for the same mesh.
    ///
    /// # Panics
    /// If a cell has a node that the mesh has not.
    pub fn new(mesh: &Mesh) -> Self {
        let mut growth = Growth::new(mesh);
        growth.take_edges(mesh);
        growth.join_left_overs();
        Self::of(&growth.group, mesh.cells.len())
    }

    /// Each of `n_cells` cells by itself: linear tetrahedra that lock.
    pub fn alone(n_cells: usize) -> Self {
        Self::of(&vec![None; n_cells], n_cells)
    }

    /// Number of patches.
    pub fn len(&self) -> usize {
        self.cells.len()
    }

    /// Whether there is none.
    pub fn is_empty(&self) -> bool {
        self.cells.is_empty()
    }

    /// The cells (0-based, ascending) of each patch, by the first of them.
    pub fn cells(&self) -> &[Vec<usize>] {
        &self.cells
    }

    /// The patch (0-based) of `cell`.
    pub fn of_cell(&self, cell: usize) -> usize {
        self.patch[cell]
    }

    /// The nodes (0-based) of `patch` of `mesh`: those of a single cell in its own order, those of several ascending.
    pub fn nodes(&self, mesh: &Mesh, patch: usize) -> Vec<usize> {
        match self.cells[patch].as_slice() {
            [cell] => mesh.cells[*cell].nodes().to_vec(),
            cells => {
                let all: BTreeSet<usize> =
                    cells.iter().flat_map(|&cell| mesh.cells[cell].nodes()).copied().collect();
                all.into_iter().collect()
            }
        }
    }

    fn of(group: &[Option<usize>], n_cells: usize) -> Self {
        let mut number: BTreeMap<usize, usize> = BTreeMap::new();
        let (mut cells, mut patch) = (Vec::new(), Vec::with_capacity(n_cells));
        for (cell, group) in group.iter().enumerate() {
            let next = cells.len();
            let own = group.map_or(next, |group| *number.entry(group).or_insert(next));
            if own == next {
                cells.push(Vec::new());
            }
            cells[own].push(cell);
            patch.push(own);
        }
        Self { cells, patch }
    }
}

/// Patches as they grow.
struct Growth {
    is_tetrahedron: Vec<bool>,
    /// Group of each cell, if it has one.
    group: Vec<Option<usize>>,
    size: Vec<usize>,
    /// Tetrahedra beyond the faces of each tetrahedron, with the area of the face, mm².
    beside: Vec<Vec<(usize, f64)>>,
    /// Edges of faces with a tetrahedron on one side only.
    outer: BTreeSet<[usize; 2]>,
}

impl Growth {
    fn new(mesh: &Mesh) -> Self {
        let is_tetrahedron: Vec<bool> = mesh.cells.iter().map(|c| c.kind() == CellKind::Tet4).collect();
        let mut beside = vec![Vec::new(); mesh.cells.len()];
        let mut outer = BTreeSet::new();
        if is_tetrahedron.contains(&true) {
            for owners in faces_by_corners(mesh).values() {
                let own: Vec<usize> = owners.iter().map(|f| f.cell).filter(|&c| is_tetrahedron[c]).collect();
                let corners = owners[0].corners();
                match own[..] {
                    [a, b] => {
                        let x = |k: usize| mesh.points[corners[k]];
                        let area = (x(1) - x(0)).cross(&(x(2) - x(0))).norm() / 2.;
                        beside[a].push((b, area));
                        beside[b].push((a, area));
                    }
                    [] => {}
                    _ => outer.extend((0..3).map(|k| edge(corners[k], corners[(k + 1) % 3]))),
                }
            }
        }
        beside.iter_mut().for_each(|list| list.sort_by_key(|(cell, _)| *cell));
        Self { group: vec![None; is_tetrahedron.len()], is_tetrahedron, size: Vec::new(), beside, outer }
    }

    /// A patch of all tetrahedra about each inner edge none of which has a patch yet, the longest edges first.
    fn take_edges(&mut self, mesh: &Mesh) {
        let mut about: BTreeMap<[usize; 2], Vec<usize>> = BTreeMap::new();
        for (cell, nodes) in mesh.cells.iter().map(|c| c.nodes()).enumerate() {
            if self.is_tetrahedron[cell] {
                for &[a, b] in CellKind::Tet4.edges() {
                    about.entry(edge(nodes[a], nodes[b])).or_default().push(cell);
                }
            }
        }
        about.retain(|ends, _| !self.outer.contains(ends));
        let length = |[a, b]: &[usize; 2]| (mesh.points[*a] - mesh.points[*b]).norm();
        let longest = about.keys().map(length).fold(0., f64::max);
        let rank = |ends: &[usize; 2]| (length(ends) / (SAME_LENGTH * longest)).round();
        let mut ordered: Vec<_> = about.into_iter().map(|(ends, cells)| (rank(&ends), ends, cells)).collect();
        ordered.sort_by(|a, b| b.0.total_cmp(&a.0).then(a.1.cmp(&b.1)));
        for (_, _, cells) in ordered {
            if cells.iter().all(|&cell| self.group[cell].is_none()) {
                self.start(&cells);
            }
        }
    }

    /// Every tetrahedron without a patch joins the smallest one beside it, across the largest face of several; where all
    /// are full, new patches grow, or a full one becomes two.
    fn join_left_overs(&mut self) {
        let mut free: Vec<usize> =
            (0..self.group.len()).filter(|&c| self.is_tetrahedron[c] && self.group[c].is_none()).collect();
        while let Some(&seed) = free.first() {
            let before = free.len();
            for &cell in &free {
                if let Some(patch) = self.smallest_beside(&[cell]).filter(|&patch| self.size[patch] < MOST) {
                    self.join(cell, patch);
                }
            }
            free.retain(|&cell| self.group[cell].is_none());
            if free.len() == before {
                let grown = self.grown(seed);
                match self.smallest_beside(&grown).filter(|_| grown.len() < FEWEST) {
                    Some(patch) => {
                        grown.iter().for_each(|&cell| self.join(cell, patch));
                        if self.size[patch] > MOST {
                            self.cut(patch, seed);
                        }
                    }
                    None => self.start(&grown),
                }
                free.retain(|&cell| self.group[cell].is_none());
            }
        }
    }

    /// Makes two of `patch`, which holds `seed`: of the tree through faces from there it is cut across the edge that
    /// leaves the most even parts. No tetrahedron has more than four neighbours, so that neither is less than a quarter.
    fn cut(&mut self, patch: usize, seed: usize) {
        let (mut cells, mut above, mut next) = (vec![seed], vec![0], 0);
        while next < cells.len() {
            for &(other, _) in &self.beside[cells[next]] {
                if self.group[other] == Some(patch) && !cells.contains(&other) {
                    cells.push(other);
                    above.push(next);
                }
            }
            next += 1;
        }
        let mut below = vec![1; cells.len()];
        for k in (1..cells.len()).rev() {
            below[above[k]] += below[k];
        }
        let smaller = |k: &usize| below[*k].min(cells.len() - below[*k]);
        let Some(top) = (1..cells.len()).rev().max_by_key(smaller) else { return };
        let mut is_off = vec![false; cells.len()];
        for k in top..cells.len() {
            is_off[k] = k == top || is_off[above[k]];
        }
        let off: Vec<usize> = (top..cells.len()).filter(|&k| is_off[k]).map(|k| cells[k]).collect();
        self.size[patch] -= off.len();
        self.start(&off);
    }

    /// `seed` and free tetrahedra about it, nearest first.
    fn grown(&self, seed: usize) -> Vec<usize> {
        let (mut grown, mut next) = (vec![seed], VecDeque::from([seed]));
        while let Some(cell) = next.pop_front() {
            for &(other, _) in &self.beside[cell] {
                if grown.len() < GROWN && self.group[other].is_none() && !grown.contains(&other) {
                    grown.push(other);
                    next.push_back(other);
                }
            }
        }
        grown
    }

    fn smallest_beside(&self, cells: &[usize]) -> Option<usize> {
        let beside = cells.iter().flat_map(|&cell| &self.beside[cell]);
        let patches = beside.filter_map(|&(other, area)| Some((self.group[other]?, area)));
        let by_size = |a: &(usize, f64), b: &(usize, f64)| {
            self.size[a.0].cmp(&self.size[b.0]).then(b.1.total_cmp(&a.1)).then(a.0.cmp(&b.0))
        };
        patches.min_by(by_size).map(|(patch, _)| patch)
    }

    fn start(&mut self, cells: &[usize]) {
        let patch = self.size.len();
        self.size.push(0);
        cells.iter().for_each(|&cell| self.join(cell, patch));
    }

    fn join(&mut self, cell: usize, patch: usize) {
        self.group[cell] = Some(patch);
        self.size[patch] += 1;
    }
}

fn edge(a: usize, b: usize) -> [usize; 2] {
    [a.min(b), a.max(b)]
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::mesh::Cell;
    use crate::mesh::testing::block;
    use crate::units::Vec3;

    /// The hexes of `mesh` but the first `kept`, cut into five tetrahedra each, in two ways by turns so that they conform.
    fn cut(mesh: &Mesh, n: [usize; 3], kept: usize) -> Mesh {
        const EVEN: [[usize; 4]; 5] = [[0, 1, 3, 4], [2, 3, 1, 6], [5, 4, 6, 1], [7, 6, 4, 3], [1, 3, 4, 6]];
        const ODD: [[usize; 4]; 5] = [[1, 2, 0, 5], [3, 0, 2, 7], [4, 7, 5, 0], [6, 5, 7, 2], [0, 2, 7, 5]];
        let lo = mesh.extent().lo;
        let place = |cell: &Cell| ((mesh.points[cell.nodes()[0]] - lo) / 10.).sum().round() as usize;
        let mut cells = mesh.cells[..kept].to_vec();
        for cell in &mesh.cells[kept..] {
            let split = if place(cell) % 2 == 0 { EVEN } else { ODD };
            cells.extend(split.map(|t| Cell::new(CellKind::Tet4, &t.map(|k| cell.nodes()[k]))));
        }
        assert_eq!(mesh.cells.len(), n.iter().product::<usize>());
        Mesh::new(mesh.points.clone(), cells)
    }

    /// Whether the cells of a patch hang together by faces.
    fn is_connected(mesh: &Mesh, cells: &[usize]) -> bool {
        let (mut reached, mut k) = (vec![cells[0]], 0);
        while k < reached.len() {
            let nodes = mesh.cells[reached[k]].nodes();
            let beside =
                |c: &&usize| mesh.cells[**c].nodes().iter().filter(|n| nodes.contains(n)).count() == 3;
            let more: Vec<usize> =
                cells.iter().filter(beside).filter(|c| !reached.contains(c)).copied().collect();
            reached.extend(more);
            k += 1;
        }
        reached.len() == cells.len()
    }

    #[test]
    fn every_tetrahedron_has_one_patch_of_neighbours_and_other_cells_are_alone() {
        let n = [4, 3, 3];
        let mut mesh = cut(&block(n), n, 2);
        for (k, p) in mesh.points.iter_mut().enumerate() {
            *p += 1.5 * Vec3::new((3 * k) as f64, (5 * k) as f64, (7 * k) as f64).map(f64::sin);
        }
        let patches = DilatationPatches::new(&mesh);
        assert_eq!(patches, DilatationPatches::new(&mesh));
        let mut seen = vec![0; mesh.cells.len()];
        for (patch, cells) in patches.cells().iter().enumerate() {
            cells.iter().for_each(|&c| seen[c] += 1);
            assert!(cells.iter().all(|&c| patches.of_cell(c) == patch) && cells.is_sorted());
            let is_hex = mesh.cells[cells[0]].kind() == CellKind::Hex8;
            assert!(
                if is_hex { cells.len() == 1 } else { (FEWEST..=MOST).contains(&cells.len()) },
                "{cells:?}"
            );
            assert!(is_connected(&mesh, cells), "{cells:?}");
        }
        assert!(seen.iter().all(|&n| n == 1));
        assert!(patches.cells().is_sorted_by_key(|cells| cells[0]), "patches by their first cell");
        let mean = (mesh.cells.len() - 2) as f64 / (patches.len() - 2) as f64;
        // Between what an edge of this cut has about it and what left-overs may fill a patch to.
        assert!((5. ..8.).contains(&mean), "{mean} tetrahedra a patch");
    }

    #[test]
    fn the_diagonal_of_a_hexahedron_cut_in_six_gives_it_back() {
        let hexes = block([3, 2, 2]);
        let about = [[0, 1, 2, 6], [0, 2, 3, 6], [0, 3, 7, 6], [0, 7, 4, 6], [0, 4, 5, 6], [0, 5, 1, 6]];
        let cells = hexes
            .cells
            .iter()
            .flat_map(|hex| about.map(|t| Cell::new(CellKind::Tet4, &t.map(|k| hex.nodes()[k]))))
            .collect();
        let mesh = Mesh::new(hexes.points.clone(), cells);
        let patches = DilatationPatches::new(&mesh);
        assert_eq!(patches.len(), hexes.cells.len());
        for (patch, hex) in hexes.cells.iter().enumerate() {
            let mut nodes = hex.nodes().to_vec();
            nodes.sort_unstable();
            assert_eq!(patches.nodes(&mesh, patch), nodes);
        }
        assert_eq!(patches.cells()[1], [6, 7, 8, 9, 10, 11]);
        let alone = DilatationPatches::alone(3);
        assert_eq!(alone.cells(), [vec![0], vec![1], vec![2]]);
    }

    #[test]
    fn a_sheet_without_inner_edges_is_not_one_patch() {
        // A strip of tetrahedra, each beside the next.
        let points = (0..43).map(|k| {
            let (sin, cos) = (f64::from(k) * 2.3).sin_cos();
            Vec3::new(sin, cos, f64::from(k) * 0.5)
        });
        let cells = (0..40).map(|k| Cell::new(CellKind::Tet4, &[k, k + 1, k + 2, k + 3])).collect();
        let patches = DilatationPatches::new(&Mesh::new(points.collect(), cells));
        assert!(patches.cells().iter().all(|c| (FEWEST..=MOST).contains(&c.len())), "{patches:?}");
    }

    #[test]
    fn cells_without_tetrahedra_keep_their_order() {
        let mesh = block([3, 2, 2]);
        let patches = DilatationPatches::new(&mesh);
        assert_eq!(patches, DilatationPatches::alone(mesh.cells.len()));
        assert!((0..patches.len()).all(|k| patches.nodes(&mesh, k) == mesh.cells[k].nodes()));
    }
}
