//! What the curvature of the face adds to the curvature of the objective.

use nalgebra::{DMatrix, DVector, SymmetricEigen};

use super::program::{Linearisation, Residuals};
use super::term::{Row, State};

/// Least eigenvalue of the program's Hessian, as a share of the greatest.
const LEAST: f64 = 1e-12;

/// An estimate of `sum_i r_i hess r_i` (n x n) from the gradients at successive points.
///
/// Gauss and Newton leave it out, which fails where residuals stay large. Source: Dennis, Gay and Welsch, An adaptive
/// nonlinear least-squares algorithm (1981), with their sizing.
#[derive(Clone, Debug)]
pub(super) struct ResidualCurvature(DMatrix<f64>);

impl ResidualCurvature {
    /// None known yet, over `n` unknowns.
    pub(super) fn none(n: usize) -> Self {
        Self(DMatrix::zeros(n, n))
    }

    /// Learns from the step from `x`, with the residuals `before`, to `to`, with those `after`.
    pub(super) fn learn(
        &mut self,
        (x, before): (&DVector<f64>, &Residuals),
        (to, after): (&DVector<f64>, &Residuals),
    ) {
        let s = to - x;
        let r = after.at(to);
        let y = after.matrix.tr_mul(&r) - before.matrix.tr_mul(&before.at(x));
        let wanted = after.matrix.tr_mul(&r) - before.matrix.tr_mul(&r);
        let along = y.dot(&s);
        if along <= 1e-12 * y.norm() * s.norm() {
            return;
        }
        let known = &self.0 * &s;
        let size = s.dot(&known).abs();
        let sizing = if size > 0. { (s.dot(&wanted).abs() / size).min(1.) } else { 1. };
        self.0 *= sizing;
        let miss = wanted - sizing * known;
        let rank_two = (&miss * y.transpose() + &y * miss.transpose()) / along;
        self.0 += rank_two - (s.dot(&miss) / (along * along)) * &y * y.transpose();
    }

    /// The objective about `state` as terms: `1/2 |r|^2` to second order, with this curvature where the sum stays convex.
    pub(super) fn terms(&self, residuals: &Residuals, state: &State) -> Linearisation {
        let x = &state.activation;
        let gradient = residuals.matrix.tr_mul(&residuals.at(x));
        let SymmetricEigen { eigenvectors, eigenvalues } =
            SymmetricEigen::new(residuals.matrix.tr_mul(&residuals.matrix) + &self.0);
        let least = (LEAST * eigenvalues.amax()).max(f64::MIN_POSITIVE);
        let row = |(direction, &value): (nalgebra::DVectorView<'_, f64>, &f64)| {
            let root = value.max(least).sqrt();
            let activation = direction.iter().enumerate().map(|(k, v)| (k, root * v)).collect();
            Row { value: direction.dot(&gradient) / root, observed: Vec::new(), activation }
        };
        Linearisation::of_rows(eigenvectors.column_iter().zip(eigenvalues.iter()).map(row).collect(), state)
    }
}
