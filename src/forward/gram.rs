//! `C' K^-1 C` through forward substitutions only.

use faer::linalg::matmul::matmul;
use faer::linalg::matmul::triangular::{BlockStructure, matmul as triangular_matmul};
use faer::linalg::triangular_solve::solve_lower_triangular_in_place;
use faer::sparse::linalg::cholesky::{SymbolicCholeskyRaw, supernodal};
use faer::{Accum, MatMut, Par};
use nalgebra::DMatrix;

use super::Cholesky;

/// A sparse column: dofs of the mesh and their values.
pub type SparseColumn = Vec<(usize, f64)>;

impl Cholesky {
    /// The Gram matrix `C' K_ff^-1 C` (k x k) of sparse columns `C` (entries on supports count for
    /// nothing).
    ///
    /// With `Y = L^-1 C` it is `Y' Y`: half of a solve is enough, and since the columns are sparse
    /// each supernode works only on the columns that reach it. Every block of the response
    /// (observations, contacts and muscles against each other) is a block of this one symmetric
    /// matrix, so reciprocity `P K^-1 F = (F' K^-1 P')'` holds by construction.
    pub fn gram(&self, columns: &[SparseColumn]) -> DMatrix<f64> {
        let symbolic = &self.symbolic.symbolic;
        let SymbolicCholeskyRaw::Supernodal(structure) = symbolic.raw() else {
            unreachable!("the analysis forces supernodes")
        };
        let position = self.elimination_positions();
        let supernode_of = supernodes(structure);
        let reached = reached_columns(structure, &supernode_of, &position, columns);
        let llt = supernodal::SupernodalLltRef::<usize, f64>::new(structure, &self.values);
        let begin = structure.supernode_begin();
        let width = |s: usize| structure.supernode_end()[s] - begin[s];

        // `Y` by supernode: its rows of the columns that reach it, column by column. Zeros are never stored.
        let mut first = vec![0];
        for (s, active) in reached.iter().enumerate() {
            first.push(first[s] + width(s) * active.len());
        }
        let mut y = vec![0.; first[reached.len()]];
        for (c, column) in columns.iter().enumerate() {
            for &(dof, value) in column {
                if let Some(row) = position[dof] {
                    let s = supernode_of[row];
                    let place = reached[s].partition_point(|&other| other < c);
                    y[first[s] + place * width(s) + row - begin[s]] += value;
                }
            }
        }
        let mut gram = DMatrix::<f64>::zeros(columns.len(), columns.len());
        let (mut below, mut square, mut places) = (Vec::new(), Vec::new(), Vec::new());
        for (s, active) in reached.iter().enumerate() {
            let m = active.len();
            if m == 0 {
                continue;
            }
            let supernode = llt.supernode(s);
            let (matrix, pattern) = (supernode.val(), supernode.pattern());
            let (diagonal, rest) = matrix.split_at_row(width(s));
            let (done, above) = y.split_at_mut(first[s + 1]);
            let mut x = MatMut::from_column_major_slice_mut(&mut done[first[s]..], width(s), m);
            solve_lower_triangular_in_place(diagonal, x.as_mut(), Par::Seq);
            let x = x.as_ref();

            below.resize(pattern.len() * m, 0.);
            let update = MatMut::from_column_major_slice_mut(&mut below, pattern.len(), m);
            matmul(update, Accum::Replace, rest, x, 1., Par::Seq);
            let mut taken = 0;
            for rows in pattern.chunk_by(|a, b| supernode_of[*a] == supernode_of[*b]) {
                let ancestor = supernode_of[rows[0]];
                places_among(active, &reached[ancestor], &mut places);
                for (column, place) in below.chunks_exact(pattern.len()).zip(&places) {
                    let start = first[ancestor] - first[s + 1] + place * width(ancestor);
                    for (row, value) in rows.iter().zip(&column[taken..]) {
                        above[start + row - begin[ancestor]] -= value;
                    }
                }
                taken += rows.len();
            }

            square.resize(m * m, 0.);
            let product = MatMut::from_column_major_slice_mut(&mut square, m, m);
            triangular_matmul(
                product,
                BlockStructure::TriangularLower,
                Accum::Replace,
                x.transpose(),
                BlockStructure::Rectangular,
                x,
                BlockStructure::Rectangular,
                1.,
                Par::Seq,
            );
            for (j, &column) in active.iter().enumerate() {
                for (i, &row) in active.iter().enumerate().skip(j) {
                    gram[(row, column)] += square[j * m + i];
                }
            }
        }
        gram.fill_upper_triangle_with_lower_triangle();
        gram
    }

    /// For each dof of the mesh its place in the order of elimination, `None` on supports.
    fn elimination_positions(&self) -> Vec<Option<usize>> {
        let mut position = vec![None; self.symbolic.n_dofs()];
        if let Some(order) = self.symbolic.symbolic.perm() {
            let (_, inverse) = order.arrays();
            for (&dof, &place) in self.symbolic.free().iter().zip(inverse) {
                position[dof] = Some(place);
            }
        }
        position
    }
}

/// The supernode of each row.
fn supernodes(structure: &supernodal::SymbolicSupernodalCholesky<usize>) -> Vec<usize> {
    let mut supernode_of = vec![0; structure.nrows()];
    for s in 0..structure.n_supernodes() {
        supernode_of[structure.supernode_begin()[s]..structure.supernode_end()[s]].fill(s);
    }
    supernode_of
}

/// The `places` of `columns` among `all`, which holds them; both ascending.
fn places_among(columns: &[usize], all: &[usize], places: &mut Vec<usize>) {
    places.clear();
    let mut place = 0;
    for column in columns {
        place += all[place..].iter().take_while(|other| *other < column).count();
        places.push(place);
    }
}

/// The columns of `C` that are not zero in each supernode after substitution: those with an entry in
/// it or in one of its descendants, ascending.
fn reached_columns(
    structure: &supernodal::SymbolicSupernodalCholesky<usize>,
    supernode_of: &[usize],
    position: &[Option<usize>],
    columns: &[SparseColumn],
) -> Vec<Vec<usize>> {
    let count = structure.n_supernodes();
    let parent: Vec<Option<usize>> =
        (0..count).map(|s| structure.supernode(s).pattern().first().map(|&row| supernode_of[row])).collect();
    let mut reached = vec![Vec::new(); count];
    for (c, column) in columns.iter().enumerate() {
        for &(dof, _) in column {
            let mut next = position[dof].map(|row| supernode_of[row]);
            while let Some(s) = next {
                if reached[s].last() == Some(&c) {
                    break;
                }
                reached[s].push(c);
                next = parent[s];
            }
        }
    }
    reached
}
