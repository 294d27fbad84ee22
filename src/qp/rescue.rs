//! Proofs sought directly, when the interior point ends without an answer.

use nalgebra::{DMatrix, DVector};

use super::scaling::Scaling;
use super::solution::{Attempt, best_of};
use super::{Infeasible, Point, Problem, Unbounded, clarabel};

/// The best point of a program that is feasible and bounded by construction.
fn optimum(problem: &Problem) -> Option<Attempt> {
    match clarabel::solve(problem, clarabel::Effort::Rescaled) {
        clarabel::Outcome::Point(point) => Some(best_of(problem, &point)),
        _ => None,
    }
}

/// A proof of infeasibility from the least-squares violation of the scaled constraints:
/// `min 1/2 |t|^2 + 1/2 |s|^2` over `A x - t = b, G x - s <= h, lo <= x <= hi`.
///
/// Its multipliers satisfy Farkas' condition, with the value `-(|t|^2 + |s|^2)`.
pub(super) fn infeasible(problem: &Problem, scaling: &Scaling) -> Option<Infeasible> {
    let (n, p, g) = (problem.n_variables(), problem.equality.nrows(), problem.inequality.nrows());
    let size = n + p + g;
    let mut hessian = DMatrix::zeros(size, size);
    hessian.view_mut((n, n), (p + g, p + g)).fill_with_identity();
    let mut elastic = Problem::unconstrained(hessian, DVector::zeros(size));
    elastic.equality = DMatrix::zeros(p, size);
    elastic.equality.columns_mut(0, n).copy_from(&problem.equality);
    elastic.equality_value.clone_from(&problem.equality_value);
    elastic.inequality = DMatrix::zeros(g, size);
    elastic.inequality.columns_mut(0, n).copy_from(&problem.inequality);
    elastic.inequality_limit.clone_from(&problem.inequality_limit);
    for i in 0..p {
        elastic.equality[(i, n + i)] = -1.0;
    }
    for i in 0..g {
        elastic.inequality[(i, n + p + i)] = -1.0;
    }
    elastic.lower.rows_mut(0, n).copy_from(&problem.lower);
    elastic.upper.rows_mut(0, n).copy_from(&problem.upper);
    let solution = optimum(&elastic)?.point;
    let mut point = Point::at(problem, DVector::zeros(n));
    (point.equality, point.inequality) = (solution.equality, solution.inequality);
    Infeasible::verified(problem, scaling, point)
}

/// A proof of unboundedness from the projection of `-q` on the directions that the scaled constraints
/// and the curvature leave free: `min 1/2 |d + q|^2` over `P d = 0, A d = 0, G d <= 0`.
pub(super) fn unbounded(problem: &Problem, scaling: &Scaling) -> Option<Unbounded> {
    let (n, p, g) = (problem.n_variables(), problem.equality.nrows(), problem.inequality.nrows());
    let mut cone = Problem::unconstrained(DMatrix::identity(n, n), problem.linear.clone());
    cone.equality = DMatrix::zeros(n + p, n);
    cone.equality.rows_mut(0, n).copy_from(&problem.hessian);
    cone.equality.rows_mut(n, p).copy_from(&problem.equality);
    cone.equality_value = DVector::zeros(n + p);
    cone.inequality.clone_from(&problem.inequality);
    cone.inequality_limit = DVector::zeros(g);
    for j in 0..n {
        if problem.lower[j].is_finite() {
            cone.lower[j] = 0.0;
        }
        if problem.upper[j].is_finite() {
            cone.upper[j] = 0.0;
        }
    }
    Unbounded::verified(problem, scaling, optimum(&cone)?.point.x)
}
