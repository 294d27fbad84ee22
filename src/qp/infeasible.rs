//! The proof that constraints contradict each other.

use nalgebra::DVector;

use super::scaling::Scaling;
use super::{PROOF_TOLERANCE, Point, Problem, TOLERANCE};

/// Multipliers that prove `A x = b, G x <= h, lo <= x <= hi` to have no solution (Farkas).
///
/// `A'y + G'z - z_lo + z_hi = 0` with `b'y + h'z - lo'z_lo + hi'z_hi < 0` and `z >= 0`: no `x` can
/// satisfy the weighted sum of its constraints.
#[derive(Clone, Debug, PartialEq)]
pub struct Infeasible {
    /// The multipliers, in the caller's units; `x` is zero.
    pub multipliers: Point,
    /// `|A'y + G'z - z_lo + z_hi|` of the scaled program with the multipliers normalised to value -1:
    /// a feasible scaled `x` would need a 1-norm of at least its inverse.
    pub residual: f64,
}

impl Infeasible {
    /// The proof carried by `point` (scaled), or `None` when it does not hold.
    pub(super) fn verified(problem: &Problem, scaling: &Scaling, mut point: Point) -> Option<Self> {
        if !point.is_finite() {
            return None;
        }
        point.x.fill(0.0);
        point.inequality.apply(|z| *z = z.max(0.0));
        // Bounds can absorb what the rows leave over exactly, whatever the solver put there.
        let left_over =
            problem.equality.tr_mul(&point.equality) + problem.inequality.tr_mul(&point.inequality);
        for (j, &force) in left_over.iter().enumerate() {
            point.lower[j] = if problem.lower[j].is_finite() { force.max(0.0) } else { 0.0 };
            point.upper[j] = if problem.upper[j].is_finite() { (-force).max(0.0) } else { 0.0 };
        }
        // A violation within the tolerance of a solved program contradicts nothing.
        let value = point.constraint_value(problem);
        if value >= -TOLERANCE * slack_allowed(problem, &point) {
            return None;
        }
        for part in [&mut point.equality, &mut point.inequality, &mut point.lower, &mut point.upper] {
            *part /= -value;
        }
        let residual = point.constraint_force(problem).amax();
        (residual <= PROOF_TOLERANCE).then(|| Self { multipliers: scaling.unscale(&point), residual })
    }
}

/// How much the weighted sum of the constraints changes when each is relaxed by one, or by its own size.
fn slack_allowed(problem: &Problem, point: &Point) -> f64 {
    let weigh = |values: &DVector<f64>, multipliers: &DVector<f64>| -> f64 {
        let pairs = values.iter().zip(multipliers.iter()).filter(|(_, z)| **z != 0.0);
        pairs.map(|(v, z)| v.abs().max(1.0) * z.abs()).sum()
    };
    weigh(&problem.equality_value, &point.equality)
        + weigh(&problem.inequality_limit, &point.inequality)
        + weigh(&problem.lower, &point.lower)
        + weigh(&problem.upper, &point.upper)
}

/// The proof that some `lo > hi`, which needs no solver.
pub(super) fn crossing_bounds(problem: &Problem) -> Option<Infeasible> {
    let j = (0..problem.n_variables()).find(|&j| problem.lower[j] > problem.upper[j])?;
    let mut multipliers = Point::at(problem, DVector::zeros(problem.n_variables()));
    let weight = 1.0 / (problem.lower[j] - problem.upper[j]);
    multipliers.lower[j] = weight;
    multipliers.upper[j] = weight;
    Some(Infeasible { multipliers, residual: 0.0 })
}
