//! Sparse Cholesky of the free part of the stiffness.

use std::sync::Arc;

use faer::dyn_stack::{MemBuffer, MemStack};
use faer::linalg::cholesky::llt::factor::LltRegularization;
use faer::perm::PermRef;
use faer::sparse::linalg::SupernodalThreshold;
use faer::sparse::linalg::cholesky::{
    CholeskySymbolicParams, LltRef, SymbolicCholesky, SymmetricOrdering, factorize_symbolic_cholesky,
};
use faer::sparse::{SparseColMatRef, SymbolicSparseColMat};
use faer::{Conj, MatMut, Par, Side};
use rayon::prelude::*;

use super::ordering::elimination_order;
use super::{ForwardError, Pattern};

/// Right-hand sides solved together: enough to fill the dense kernels, few enough to stay in cache.
const BLOCK: usize = 16;

/// The symbolic factorisation of `K_ff`: made once, used for every activation.
#[derive(Debug)]
pub struct SymbolicFactor {
    n_dofs: usize,
    /// Dofs of the mesh that may move, ascending.
    free: Vec<usize>,
    lower: SymbolicSparseColMat<usize>,
    /// Where each value of `lower` stands among the values of the full pattern.
    source: Vec<usize>,
    pub(super) symbolic: SymbolicCholesky<usize>,
}

impl SymbolicFactor {
    /// Orders and analyses the free part of a matrix on `pattern`; `fixed[dof]` marks supports.
    ///
    /// # Errors
    /// [`ForwardError::Factorisation`] when memory or indices do not suffice.
    pub fn new(pattern: &Pattern, fixed: &[bool]) -> Result<Self, ForwardError> {
        let free: Vec<usize> = (0..fixed.len()).filter(|&dof| !fixed[dof]).collect();
        let mut number = vec![usize::MAX; fixed.len()];
        for (k, &dof) in free.iter().enumerate() {
            number[dof] = k;
        }
        let (mut starts, mut rows, mut source) = (vec![0], Vec::new(), Vec::new());
        for &column in &free {
            for (row, at) in pattern.rows(column).zip(pattern.column(column)) {
                if !fixed[row] {
                    rows.push(number[row]);
                    source.push(at);
                }
            }
            starts.push(rows.len());
        }
        let n = free.len();
        let lower = SymbolicSparseColMat::new_checked(n, n, starts, None, rows);
        let order: Vec<usize> =
            elimination_order(pattern, |dof| !fixed[dof])?.into_iter().map(|dof| number[dof]).collect();
        let mut inverse = vec![0; n];
        for (k, &old) in order.iter().enumerate() {
            inverse[old] = k;
        }
        let parameters = CholeskySymbolicParams {
            supernodal_flop_ratio_threshold: SupernodalThreshold::FORCE_SUPERNODAL,
            ..Default::default()
        };
        let ordering = SymmetricOrdering::Custom(PermRef::new_checked(&order, &inverse, n));
        let symbolic = factorize_symbolic_cholesky(lower.as_ref(), Side::Lower, ordering, parameters)
            .map_err(|error| ForwardError::Factorisation(error.to_string()))?;
        Ok(Self { n_dofs: fixed.len(), free, lower, source, symbolic })
    }

    /// Dofs of the mesh, supports included.
    pub fn n_dofs(&self) -> usize {
        self.n_dofs
    }

    /// Dofs that may move, ascending.
    pub fn free(&self) -> &[usize] {
        &self.free
    }

    /// Stored values of the factor: the memory of [`Cholesky`] in units of 8 bytes.
    pub fn n_values(&self) -> usize {
        self.symbolic.len_val()
    }
}

/// `K_ff = L L'` at one activation.
#[derive(Clone, Debug)]
pub struct Cholesky {
    pub(super) symbolic: Arc<SymbolicFactor>,
    pub(super) values: Vec<f64>,
}

impl Cholesky {
    /// Factorises the free part of the matrix with these `values` on the pattern of `symbolic`.
    ///
    /// # Errors
    /// [`ForwardError::NotPositiveDefinite`] when a pivot is not positive: the supports leave a
    /// free motion.
    pub fn new(symbolic: Arc<SymbolicFactor>, values: &[f64]) -> Result<Self, ForwardError> {
        let mut factor = Self::unfactorised(symbolic);
        factor.renew(values)?;
        Ok(factor)
    }

    /// The memory for a factor, to be [renewed](Self::renew) before it is used.
    pub(super) fn unfactorised(symbolic: Arc<SymbolicFactor>) -> Self {
        Self { values: vec![0.; symbolic.symbolic.len_val()], symbolic }
    }

    /// Factorises again, in the same memory, with other `values` on the same pattern.
    ///
    /// # Errors
    /// As [`new`](Self::new); what the factor holds then is no factor.
    pub fn renew(&mut self, values: &[f64]) -> Result<(), ForwardError> {
        let symbolic = &self.symbolic;
        let free: Vec<f64> = symbolic.source.iter().map(|&at| values[at]).collect();
        let matrix = SparseColMatRef::new(symbolic.lower.as_ref(), &free);
        let par = Par::Seq;
        let scratch = symbolic.symbolic.factorize_numeric_llt_scratch::<f64>(par, Default::default());
        symbolic
            .symbolic
            .factorize_numeric_llt(
                &mut self.values,
                matrix,
                Side::Lower,
                LltRegularization::default(),
                par,
                MemStack::new(&mut MemBuffer::new(scratch)),
                Default::default(),
            )
            .map_err(|_| ForwardError::NotPositiveDefinite)?;
        Ok(())
    }

    /// The analysis that this factor rests on.
    pub fn symbolic(&self) -> &SymbolicFactor {
        &self.symbolic
    }

    /// Solves `K_ff x = b` in place for column-major right-hand sides on the free dofs, in blocks
    /// that run in parallel.
    pub fn solve_in_place(&self, columns: &mut [f64]) {
        let n = self.symbolic.free.len();
        if n == 0 {
            return;
        }
        let llt = LltRef::<usize, f64>::new(&self.symbolic.symbolic, &self.values);
        columns.par_chunks_mut(n * BLOCK).for_each(|block| {
            let k = block.len() / n;
            let scratch = self.symbolic.symbolic.solve_in_place_scratch::<f64>(k, Par::Seq);
            llt.solve_in_place_with_conj(
                Conj::No,
                MatMut::from_column_major_slice_mut(block, n, k),
                Par::Seq,
                MemStack::new(&mut MemBuffer::new(scratch)),
            );
        });
    }

    /// Full displacements (3n each, zero on the supports) for nodal forces (3n each, N).
    pub fn displacements(&self, forces: &[Vec<f64>]) -> Vec<Vec<f64>> {
        let free = &self.symbolic.free;
        let mut columns: Vec<f64> = forces.iter().flat_map(|f| free.iter().map(|&dof| f[dof])).collect();
        self.solve_in_place(&mut columns);
        forces
            .iter()
            .zip(columns.chunks_exact(free.len().max(1)))
            .map(|(force, column)| {
                let mut u = vec![0.; force.len()];
                for (&dof, &x) in free.iter().zip(column) {
                    u[dof] = x;
                }
                u
            })
            .collect()
    }
}
