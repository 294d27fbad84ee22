//! The proof that an objective falls for ever.

use nalgebra::DVector;

use super::scaling::Scaling;
use super::{PROOF_TOLERANCE, Problem};

/// A direction along which the objective falls without end: `P d = 0, A d = 0, G d <= 0, q'd < 0`,
/// and `d` leaves no bound.
#[derive(Clone, Debug, PartialEq)]
pub struct Unbounded {
    /// `d` (n), in the caller's units.
    pub direction: DVector<f64>,
    /// Largest violation of the conditions in the scaled program with `d` normalised to `q'd = -1`.
    pub residual: f64,
}

impl Unbounded {
    /// The proof carried by `direction` (scaled), or `None` when it does not hold.
    pub(super) fn verified(
        problem: &Problem,
        scaling: &Scaling,
        mut direction: DVector<f64>,
    ) -> Option<Self> {
        if direction.iter().any(|d| !d.is_finite()) {
            return None;
        }
        for (j, d) in direction.iter_mut().enumerate() {
            if problem.lower[j].is_finite() {
                *d = d.max(0.0);
            }
            if problem.upper[j].is_finite() {
                *d = d.min(0.0);
            }
        }
        let slope = problem.linear.dot(&direction);
        if slope >= 0.0 {
            return None;
        }
        direction /= -slope;
        let residual = (&problem.hessian * &direction)
            .amax()
            .max((&problem.equality * &direction).amax())
            .max((&problem.inequality * &direction).iter().fold(0.0, |worst, &g| g.max(worst)));
        (residual <= PROOF_TOLERANCE).then(|| Self { direction: scaling.direction(&direction), residual })
    }
}
