//! Symmetric indefinite systems that may be singular.

use nalgebra::{DMatrix, DVector};

/// Rounds of refinement of the regularised factorisation.
const REFINEMENTS: usize = 12;
/// Eigenvalues below this share of the largest count as zero.
const RANK: f64 = 1e-13;

/// A solver of `K x = v`, `K = [P B'; B 0]` symmetric, singular when rows of `B` are redundant.
pub(super) struct LinearSystem {
    matrix: DMatrix<f64>,
    regularised: nalgebra::LU<f64, nalgebra::Dyn, nalgebra::Dyn>,
}

impl LinearSystem {
    /// Factorises `K + diag(delta, -delta)`: positive on the first `positive` unknowns, negative on the others.
    pub(super) fn new(matrix: DMatrix<f64>, positive: usize) -> Self {
        let delta = 1e-10 * matrix.amax().max(f64::MIN_POSITIVE);
        let mut shifted = matrix.clone();
        for i in 0..matrix.nrows() {
            shifted[(i, i)] += if i < positive { delta } else { -delta };
        }
        Self { matrix, regularised: shifted.lu() }
    }

    /// A solution of `K x = v` near zero; the least-squares one when there is none.
    pub(super) fn solve(&self, v: &DVector<f64>) -> DVector<f64> {
        let target = 1e-15 * v.amax();
        let mut x = DVector::zeros(v.len());
        let mut residual = v.clone();
        for _ in 0..REFINEMENTS {
            let Some(step) = self.regularised.solve(&residual) else { break };
            let next = &x + step;
            let next_residual = v - &self.matrix * &next;
            if next_residual.amax().is_nan() || next_residual.amax() >= residual.amax() {
                break;
            }
            (x, residual) = (next, next_residual);
            if residual.amax() <= target {
                break;
            }
        }
        if residual.amax() <= 1e-12 * v.amax() { x } else { self.pseudo_inverse(v) }
    }

    fn pseudo_inverse(&self, v: &DVector<f64>) -> DVector<f64> {
        let eigen = self.matrix.clone().symmetric_eigen();
        let smallest = RANK * eigen.eigenvalues.amax();
        let mut coordinates = eigen.eigenvectors.tr_mul(v);
        for (c, value) in coordinates.iter_mut().zip(eigen.eigenvalues.iter()) {
            *c = if value.abs() > smallest { *c / value } else { 0.0 };
        }
        eigen.eigenvectors * coordinates
    }
}
