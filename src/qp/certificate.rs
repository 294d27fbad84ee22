//! How well an answer satisfies its quadratic program.

use nalgebra::{DMatrix, DVector};

use super::scaling::Scaling;
use super::{Point, Problem};

/// Largest residual of an answer that may be called solved, dimensionless.
pub const TOLERANCE: f64 = 1e-9;

/// Residuals recomputed from the scaled program, never taken from the solver.
///
/// Each residual is divided by the largest term that enters it, or by one when all are smaller.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Certificate {
    /// Largest violation of a constraint.
    pub primal: f64,
    /// Largest component of the stationarity residual, or of a multiplier with the wrong sign.
    pub dual: f64,
    /// Difference between primal and dual objective.
    pub gap: f64,
}

/// `(M x, largest |M_ij x_j| of each row)`.
fn product(matrix: &DMatrix<f64>, x: &DVector<f64>) -> (DVector<f64>, DVector<f64>) {
    let (mut sum, mut largest) = (DVector::zeros(matrix.nrows()), DVector::<f64>::zeros(matrix.nrows()));
    for (j, &xj) in x.iter().enumerate() {
        for i in 0..matrix.nrows() {
            let term = matrix[(i, j)] * xj;
            sum[i] += term;
            largest[i] = largest[i].max(term.abs());
        }
    }
    (sum, largest)
}

impl Certificate {
    /// The residuals of `point` in `problem`, both in the caller's units; the scaling is recomputed.
    ///
    /// Shapes must agree, as [`Problem::validate`] checks.
    pub fn of(problem: &Problem, point: &Point) -> Self {
        let scaling = Scaling::of(problem);
        Self::of_scaled(&scaling.scale(problem), &scaling.scale_point(point))
    }

    /// The residuals of `point` in a program that is dimensionless already.
    pub(super) fn of_scaled(problem: &Problem, point: &Point) -> Self {
        if !point.is_finite() {
            return Self { primal: f64::INFINITY, dual: f64::INFINITY, gap: f64::INFINITY };
        }
        Self { primal: primal(problem, &point.x), dual: dual(problem, point), gap: gap(problem, point) }
    }

    /// The largest of the three residuals.
    pub fn worst(&self) -> f64 {
        self.primal.max(self.dual).max(self.gap)
    }

    /// Whether every residual is at most [`TOLERANCE`].
    pub fn passes(&self) -> bool {
        self.worst() <= TOLERANCE
    }

    /// The larger residual of two answers, one by one.
    #[must_use]
    pub fn max(self, other: Self) -> Self {
        Self {
            primal: self.primal.max(other.primal),
            dual: self.dual.max(other.dual),
            gap: self.gap.max(other.gap),
        }
    }
}

fn primal(problem: &Problem, x: &DVector<f64>) -> f64 {
    let mut worst = 0.0_f64;
    let (value, size) = product(&problem.equality, x);
    for i in 0..value.len() {
        let b = problem.equality_value[i];
        worst = worst.max((value[i] - b).abs() / size[i].max(b.abs()).max(1.0));
    }
    let (value, size) = product(&problem.inequality, x);
    for i in 0..value.len() {
        let h = problem.inequality_limit[i];
        worst = worst.max((value[i] - h) / size[i].max(h.abs()).max(1.0));
    }
    for j in 0..x.len() {
        let (lo, hi) = (problem.lower[j], problem.upper[j]);
        if lo.is_finite() {
            worst = worst.max((lo - x[j]) / lo.abs().max(1.0));
        }
        if hi.is_finite() {
            worst = worst.max((x[j] - hi) / hi.abs().max(1.0));
        }
    }
    worst
}

fn dual(problem: &Problem, point: &Point) -> f64 {
    let (curvature, mut size) = product(&problem.hessian, &point.x);
    let mut residual = curvature + &problem.linear;
    for (matrix, multipliers) in
        [(&problem.equality, &point.equality), (&problem.inequality, &point.inequality)]
    {
        let (force, force_size) = product(&matrix.transpose(), multipliers);
        residual += force;
        size = size.sup(&force_size);
    }
    residual += &point.upper - &point.lower;
    size = size.sup(&problem.linear.abs());
    let mut worst = residual.iter().zip(size.iter()).map(|(r, s)| r.abs() / s.max(1.0)).fold(0.0, f64::max);
    for multipliers in [&point.inequality, &point.lower, &point.upper] {
        let largest = multipliers.amax().max(1.0);
        worst = multipliers.iter().fold(worst, |w, z| w.max(-z / largest));
    }
    // Nothing pushes back where there is no bound.
    for (bounds, multipliers) in [(&problem.lower, &point.lower), (&problem.upper, &point.upper)] {
        for (_, z) in bounds.iter().zip(multipliers.iter()).filter(|(b, _)| b.is_infinite()) {
            worst = worst.max(z.abs());
        }
    }
    worst
}

fn gap(problem: &Problem, point: &Point) -> f64 {
    let curvature = point.x.dot(&(&problem.hessian * &point.x));
    let slope = problem.linear.dot(&point.x);
    let value = point.constraint_value(problem);
    let size = curvature.abs().max(slope.abs()).max(value.abs()).max(1.0);
    (curvature + slope + value).abs() / size
}
