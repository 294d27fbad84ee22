//! The quadratic program: stated once, solved, polished and certified.
//!
//! [`Problem`] fixes the signs and the multipliers; every other module refers to it.

mod certificate;
mod clarabel;
mod extreme;
mod infeasible;
mod linear_system;
mod point;
mod polish;
mod problem;
mod rescue;
mod scaling;
mod solution;
mod staged;
mod staged_active_set;
mod staged_interior_point;
mod unbounded;

pub use certificate::{Certificate, TOLERANCE};
pub use extreme::{EllipsoidInBox, Extreme};
pub use infeasible::Infeasible;
pub use point::Point;
pub use problem::{Data, Problem, ProblemError};
pub use solution::{Answer, Solution};
pub use staged::{Link, LinkRow, Stage, StagePoint, StagedPoint, StagedProblem};
pub use staged_active_set::{StagedActiveSet, StagedSolution, solve_staged};
pub use unbounded::Unbounded;

/// Residual up to which a proof of infeasibility or unboundedness is believed, dimensionless.
pub const PROOF_TOLERANCE: f64 = 1e-8;

use scaling::Scaling;
use solution::Attempt;

/// Solves `problem`: scale, interior point, polish, certify.
///
/// The answer is [`Answer::Solved`] only when the recomputed [`Certificate`] is within
/// [`TOLERANCE`], and [`Answer::Infeasible`] or [`Answer::Unbounded`] only when the proof was checked.
///
/// # Errors
/// [`ProblemError`] when the program is malformed: shapes, non-finite numbers, indefinite `P`.
pub fn solve(problem: &Problem) -> Result<Answer, ProblemError> {
    problem.validate()?;
    if problem.n_variables() == 0 {
        return Ok(solution::without_variables(problem));
    }
    if let Some(proof) = infeasible::crossing_bounds(problem) {
        return Ok(Answer::Infeasible(proof));
    }
    let scaling = Scaling::of(problem);
    let scaled = scaling.scale(problem);
    let mut best: Option<Attempt> = None;
    for effort in clarabel::Effort::ALL {
        match clarabel::solve(&scaled, effort) {
            clarabel::Outcome::Point(point) => {
                let attempt = solution::best_of(&scaled, &point);
                if best.as_ref().is_none_or(|b| attempt.certificate.worst() < b.certificate.worst()) {
                    best = Some(attempt);
                }
            }
            clarabel::Outcome::Infeasible(point) => {
                if let Some(proof) = Infeasible::verified(&scaled, &scaling, point) {
                    return Ok(Answer::Infeasible(proof));
                }
            }
            clarabel::Outcome::Unbounded(direction) => {
                if let Some(proof) = Unbounded::verified(&scaled, &scaling, direction) {
                    return Ok(Answer::Unbounded(proof));
                }
            }
            clarabel::Outcome::Failed => {}
        }
        if best.as_ref().is_some_and(|b| b.certificate.passes()) {
            break;
        }
    }
    if !best.as_ref().is_some_and(|b| b.certificate.passes()) {
        if let Some(proof) = rescue::infeasible(&scaled, &scaling) {
            return Ok(Answer::Infeasible(proof));
        }
        if let Some(proof) = rescue::unbounded(&scaled, &scaling) {
            return Ok(Answer::Unbounded(proof));
        }
    }
    Ok(match best {
        Some(attempt) => attempt.into_answer(problem, &scaling),
        None => Answer::NotConverged(None),
    })
}

/// The answer whose active set is that of `point`: polished and certified without an interior-point run.
///
/// # Errors
/// [`ProblemError`] when the program is malformed.
pub fn refine(problem: &Problem, point: &Point) -> Result<Answer, ProblemError> {
    problem.validate()?;
    let scaling = Scaling::of(problem);
    let attempt = solution::best_of(&scaling.scale(problem), &scaling.scale_point(point));
    Ok(attempt.into_answer(problem, &scaling))
}
