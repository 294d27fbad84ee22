//! `C' K^-1 C` through forward substitutions only.

use faer::linalg::matmul::matmul;
use faer::linalg::matmul::triangular::{BlockStructure, matmul as triangular_matmul};
use faer::linalg::triangular_solve::solve_lower_triangular_in_place;
use faer::sparse::linalg::cholesky::{SymbolicCholeskyRaw, supernodal};
use faer::{Accum, Mat, MatMut, Par};
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
        let k = columns.len();
        let n = symbolic.nrows();
        let position = self.elimination_positions();
        let reached = reached_columns(structure, &position, columns);

        // Row-major on purpose: one row holds a dof of every column.
        let mut y = vec![0.; n * k];
        for (c, column) in columns.iter().enumerate() {
            for &(dof, value) in column {
                if let Some(row) = position[dof] {
                    y[row * k + c] += value;
                }
            }
        }
        let llt = supernodal::SupernodalLltRef::<usize, f64>::new(structure, &self.values);
        let mut gram = Mat::<f64>::zeros(k, k);
        let (mut top, mut below, mut square) = (Vec::new(), Vec::new(), Vec::new());
        for (s, active) in reached.iter().enumerate() {
            let m = active.len();
            if m == 0 {
                continue;
            }
            let supernode = llt.supernode(s);
            let (start, matrix, pattern) = (supernode.start(), supernode.val(), supernode.pattern());
            let width = matrix.ncols();
            let (diagonal, rest) = matrix.split_at_row(width);
            top.clear();
            top.extend(
                active
                    .iter()
                    .flat_map(|&c| (start..start + width).map(move |row| row * k + c))
                    .map(|at| y[at]),
            );
            let mut x = MatMut::from_column_major_slice_mut(&mut top, width, m);
            solve_lower_triangular_in_place(diagonal, x.as_mut(), Par::Seq);
            let x = x.as_ref();

            below.resize(pattern.len() * m, 0.);
            let update = MatMut::from_column_major_slice_mut(&mut below, pattern.len(), m);
            matmul(update, Accum::Replace, rest, x, 1., Par::Seq);
            for (column, &c) in below.chunks_exact(pattern.len().max(1)).zip(active) {
                for (&row, value) in pattern.iter().zip(column) {
                    y[row * k + c] -= value;
                }
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
        DMatrix::from_fn(k, k, |i, j| gram[(i.max(j), i.min(j))])
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

/// The columns of `C` that are not zero in each supernode after substitution: those with an entry in
/// it or in one of its descendants, ascending.
fn reached_columns(
    structure: &supernodal::SymbolicSupernodalCholesky<usize>,
    position: &[Option<usize>],
    columns: &[SparseColumn],
) -> Vec<Vec<usize>> {
    let count = structure.n_supernodes();
    let mut supernode_of = vec![0; structure.nrows()];
    for s in 0..count {
        supernode_of[structure.supernode_begin()[s]..structure.supernode_end()[s]].fill(s);
    }
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
