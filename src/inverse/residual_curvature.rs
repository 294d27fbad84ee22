//! What the curvature of the face adds to the curvature of the objective.

use nalgebra::{DMatrix, DVector, SymmetricEigen};

use super::program::{Linearisation, Objective};
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

    /// Learns from the step from `x`, with the objective `before`, to `to`, with that `after`.
    pub(super) fn learn(
        &mut self,
        (x, before): (&DVector<f64>, &Objective),
        (to, after): (&DVector<f64>, &Objective),
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

    /// The convex part of this curvature as rows that add it to any linearised terms: with contact the
    /// curvature of the terms themselves is another one on each piece.
    pub(super) fn convex_rows(&self) -> Vec<Row> {
        let SymmetricEigen { eigenvectors, eigenvalues } = SymmetricEigen::new(self.0.clone());
        let convex = eigenvectors.column_iter().zip(eigenvalues.iter()).filter(|(_, value)| **value > 0.);
        let row = |(direction, value): (nalgebra::DVectorView<'_, f64>, &f64)| {
            let activation = direction.iter().enumerate().map(|(k, v)| (k, value.sqrt() * v)).collect();
            Row { value: 0., observed: Vec::new(), activation }
        };
        convex.map(row).collect()
    }

    /// The objective about `state` as terms: to second order, with this curvature where the sum stays convex.
    pub(super) fn terms(&self, model: &Objective, state: &State) -> Linearisation {
        let x = &state.activation;
        let gradient = model.matrix.tr_mul(&model.at(x));
        let SymmetricEigen { eigenvectors, eigenvalues } =
            SymmetricEigen::new(model.matrix.tr_mul(&model.matrix) + &self.0);
        let least = (LEAST * eigenvalues.amax()).max(f64::MIN_POSITIVE);
        let row = |(direction, &value): (nalgebra::DVectorView<'_, f64>, &f64)| {
            let root = value.max(least).sqrt();
            let activation = direction.iter().enumerate().map(|(k, v)| (k, root * v)).collect();
            Row { value: direction.dot(&gradient) / root, observed: Vec::new(), activation }
        };
        let rows = eigenvectors.column_iter().zip(eigenvalues.iter()).map(row).collect();
        Linearisation::of_rows(rows, &model.slope, state)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// `r = 8 + x_0^2 / 2 - x_1^2 / 4` and `x` themselves, linearised at `x`; `sum r hess r = r_0 diag(1, -1/2)`.
    fn at(x: &DVector<f64>) -> Objective {
        let value = 8. + x[0].powi(2) / 2. - x[1].powi(2) / 4.;
        let matrix = DMatrix::from_row_slice(3, 2, &[x[0], -x[1] / 2., 1., 0., 0., 1.]);
        let r = DVector::from_vec(vec![value, x[0], x[1]]);
        Objective { value: r - &matrix * x, matrix, slope: DVector::zeros(2) }
    }

    /// What the rows add to the program's Hessian.
    fn added(curvature: &ResidualCurvature) -> DMatrix<f64> {
        let mut hessian = DMatrix::zeros(2, 2);
        for row in curvature.convex_rows() {
            assert!(row.value == 0. && row.observed.is_empty(), "{row:?}");
            for &(i, a) in &row.activation {
                row.activation.iter().for_each(|&(j, b)| hessian[(i, j)] += a * b);
            }
        }
        hessian
    }

    #[test]
    fn the_convex_part_of_what_was_learnt_is_added() {
        let mut curvature = ResidualCurvature::none(2);
        assert_eq!(added(&curvature), DMatrix::zeros(2, 2));
        // The secant condition along the first unknown, where the residual bends away from zero.
        let (x, to) = (DVector::zeros(2), DVector::from_vec(vec![0.1, 0.]));
        curvature.learn((&x, &at(&x)), (&to, &at(&to)));
        let expected = DMatrix::from_row_slice(2, 2, &[8. + 0.1 * 0.1 / 2., 0., 0., 0.]);
        let found: DMatrix<f64> = added(&curvature) - &expected;
        assert!(found.amax() < 1e-12, "{found}");
        // Along the second it bends towards zero: nothing that is not convex is added.
        let (x, to) = (DVector::from_vec(vec![0., 0.5]), DVector::from_vec(vec![0., 0.4]));
        curvature.learn((&x, &at(&x)), (&to, &at(&to)));
        let values = SymmetricEigen::new(added(&curvature)).eigenvalues;
        assert!(values.min() > -1e-12 && (values.max() - expected[(0, 0)]).abs() < 0.1, "{values}");
    }
}
