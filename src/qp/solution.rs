//! The answer to a quadratic program.

use nalgebra::DVector;

use super::polish::polish;
use super::scaling::Scaling;
use super::{Certificate, Infeasible, Point, Problem, Unbounded};

/// What became of a program.
#[derive(Clone, Debug, PartialEq)]
pub enum Answer {
    /// The certificate passes.
    Solved(Solution),
    /// The best point found, if any, misses the tolerance.
    NotConverged(Option<Solution>),
    /// No point satisfies the constraints.
    Infeasible(Infeasible),
    /// The objective has no minimum.
    Unbounded(Unbounded),
}

impl Answer {
    /// The solution, only if it is one.
    pub fn solved(self) -> Option<Solution> {
        match self {
            Self::Solved(solution) => Some(solution),
            _ => None,
        }
    }
}

/// A point with its proof of optimality, in the caller's units.
#[derive(Clone, Debug, PartialEq)]
pub struct Solution {
    /// Variables and multipliers.
    pub point: Point,
    /// `1/2 x'Px + q'x + r`.
    pub objective: f64,
    /// Residuals in the scaled program.
    pub certificate: Certificate,
    /// Whether the active set's own system gave the point.
    pub polished: bool,
}

/// A candidate answer to the scaled program.
pub(super) struct Attempt {
    pub(super) point: Point,
    pub(super) certificate: Certificate,
    polished: bool,
}

impl Attempt {
    /// The attempt in the caller's units.
    pub(super) fn into_answer(self, problem: &Problem, scaling: &Scaling) -> Answer {
        let mut point = scaling.unscale(&self.point);
        for (j, x) in point.x.iter_mut().enumerate() {
            *x = x.clamp(problem.lower[j], problem.upper[j]);
        }
        let objective = problem.objective(&point.x);
        let solution = Solution { point, objective, certificate: self.certificate, polished: self.polished };
        if self.certificate.passes() {
            Answer::Solved(solution)
        } else {
            Answer::NotConverged(Some(solution))
        }
    }
}

/// Puts a point into its bounds and its multipliers into their signs.
pub(super) fn tidy(problem: &Problem, point: &mut Point) {
    for (j, x) in point.x.iter_mut().enumerate() {
        *x = x.clamp(problem.lower[j], problem.upper[j]);
    }
    for multipliers in [&mut point.inequality, &mut point.lower, &mut point.upper] {
        multipliers.apply(|z| *z = z.max(0.0));
    }
}

/// The better of the solver's point and its polished neighbour.
pub(super) fn best_of(problem: &Problem, point: &Point) -> Attempt {
    let mut raw = point.clone();
    tidy(problem, &mut raw);
    let certificate = Certificate::of_scaled(problem, &raw);
    if let Some((polished, polished_certificate)) = polish(problem, point)
        && (polished_certificate.passes() || polished_certificate.worst() <= certificate.worst())
    {
        return Attempt { point: polished, certificate: polished_certificate, polished: true };
    }
    Attempt { point: raw, certificate, polished: false }
}

/// The answer when there is nothing to choose: the rows hold or they do not.
pub(super) fn without_variables(problem: &Problem) -> Answer {
    let mut point = Point::at(problem, DVector::zeros(0));
    let certificate = Certificate::of_scaled(problem, &point);
    if certificate.passes() {
        return Answer::Solved(Solution { point, objective: problem.constant, certificate, polished: true });
    }
    let (i, worst) = problem
        .equality_value
        .iter()
        .enumerate()
        .fold((0, 0.0), |best: (usize, f64), (i, b)| if b.abs() > best.1.abs() { (i, *b) } else { best });
    if worst == 0.0 {
        let row = problem.inequality_limit.imin();
        point.inequality[row] = -1.0 / problem.inequality_limit[row];
    } else {
        point.equality[i] = -1.0 / worst;
    }
    Answer::Infeasible(Infeasible { multipliers: point, residual: 0.0 })
}
