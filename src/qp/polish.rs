//! From a nearly optimal point to the exact one of its active set.

use std::collections::BTreeSet;

use nalgebra::{DMatrix, DVector};

use super::linear_system::LinearSystem;
use super::solution::tidy;
use super::{Certificate, Point, Problem};

/// Corrections of the guessed active set before giving up.
const ROUNDS: usize = 40;
/// Newton corrections with one factorisation; each regains the digits lost to its conditioning.
const CORRECTIONS: usize = 4;
/// Violations below this are rounding, dimensionless.
const ROUNDING: f64 = 1e-12;

/// Where a variable is held.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
enum Hold {
    Free,
    Lower,
    Upper,
}

/// The constraints that are treated as equalities.
#[derive(Clone, Debug, PartialEq, Eq, PartialOrd, Ord)]
struct ActiveSet {
    variables: Vec<Hold>,
    rows: Vec<bool>,
}

impl ActiveSet {
    /// A constraint is active when its multiplier exceeds its slack.
    fn of(problem: &Problem, point: &Point) -> Self {
        let slack = &problem.inequality_limit - &problem.inequality * &point.x;
        let variables = (0..point.x.len())
            .map(|j| {
                let (below, above) = (point.x[j] - problem.lower[j], problem.upper[j] - point.x[j]);
                if problem.lower[j] == problem.upper[j] || point.lower[j] > below {
                    Hold::Lower
                } else if point.upper[j] > above {
                    Hold::Upper
                } else {
                    Hold::Free
                }
            })
            .collect();
        Self { variables, rows: (0..slack.len()).map(|i| point.inequality[i] > slack[i]).collect() }
    }
}

/// The optimum of the active set of `point` (scaled), corrected until it is the right one, with its
/// certificate; `None` when no active set tried gave finite numbers.
///
/// A held variable is exactly its bound.
pub(super) fn polish(problem: &Problem, point: &Point) -> Option<(Point, Certificate)> {
    let mut active = ActiveSet::of(problem, point);
    let mut visited = BTreeSet::new();
    let mut best: Option<(Point, Certificate)> = None;
    let mut current = point.clone();
    while visited.len() < ROUNDS && visited.insert(active.clone()) {
        current = optimum(problem, &active, current)?;
        let mut tidied = current.clone();
        tidy(problem, &mut tidied);
        let certificate = Certificate::of_scaled(problem, &tidied);
        if best.as_ref().is_none_or(|(_, b)| certificate.worst() < b.worst()) {
            best = Some((tidied, certificate));
        }
        if !correct(problem, &current, &mut active) {
            break;
        }
    }
    best
}

/// Adds what is violated; otherwise releases what pulls the most; false when neither is there.
fn correct(problem: &Problem, point: &Point, active: &mut ActiveSet) -> bool {
    let mut changed = false;
    let excess = &problem.inequality * &point.x - &problem.inequality_limit;
    for (i, row) in active.rows.iter_mut().enumerate() {
        if !*row && excess[i] > ROUNDING * problem.inequality_limit[i].abs().max(1.0) {
            *row = true;
            changed = true;
        }
    }
    for (j, hold) in active.variables.iter_mut().enumerate().filter(|(_, hold)| **hold == Hold::Free) {
        let tolerance = |bound: f64| ROUNDING * bound.abs().max(1.0);
        if problem.lower[j] - point.x[j] > tolerance(problem.lower[j]) {
            *hold = Hold::Lower;
            changed = true;
        } else if point.x[j] - problem.upper[j] > tolerance(problem.upper[j]) {
            *hold = Hold::Upper;
            changed = true;
        }
    }
    if changed {
        return true;
    }
    let (row, row_pull) = point.inequality.iter().enumerate().fold((0, 0.0), least);
    let pull = point.lower.inf(&point.upper);
    let (variable, variable_pull) = pull.iter().enumerate().fold((0, 0.0), least);
    if row_pull.min(variable_pull) >= -ROUNDING {
        return false;
    }
    if row_pull < variable_pull {
        active.rows[row] = false;
    } else {
        active.variables[variable] = Hold::Free;
    }
    true
}

fn least(best: (usize, f64), (i, value): (usize, &f64)) -> (usize, f64) {
    if *value < best.1 { (i, *value) } else { best }
}

/// The stationary point of the program whose active constraints are equalities, starting from `point`
/// so that what the system leaves undetermined stays where the solver put it.
fn optimum(problem: &Problem, active: &ActiveSet, mut point: Point) -> Option<Point> {
    let n = problem.n_variables();
    let free: Vec<usize> = (0..n).filter(|&j| active.variables[j] == Hold::Free).collect();
    let held: Vec<usize> = (0..active.rows.len()).filter(|&i| active.rows[i]).collect();
    let (f, p) = (free.len(), problem.equality.nrows());
    for (j, hold) in active.variables.iter().enumerate() {
        match hold {
            Hold::Free => {}
            Hold::Lower => point.x[j] = problem.lower[j],
            Hold::Upper => point.x[j] = problem.upper[j],
        }
    }
    for (z, _) in point.inequality.iter_mut().zip(&active.rows).filter(|(_, active)| !**active) {
        *z = 0.0;
    }
    point.lower.fill(0.0);
    point.upper.fill(0.0);
    let size = f + p + held.len();
    let mut matrix = DMatrix::zeros(size, size);
    for (k, &j) in free.iter().enumerate() {
        for (l, &i) in free.iter().enumerate() {
            matrix[(l, k)] = problem.hessian[(i, j)];
        }
        let rows = (0..p).map(|i| problem.equality[(i, j)]);
        for (l, value) in rows.chain(held.iter().map(|&i| problem.inequality[(i, j)])).enumerate() {
            matrix[(f + l, k)] = value;
            matrix[(k, f + l)] = value;
        }
    }
    if size > 0 {
        let system = LinearSystem::new(matrix, f);
        for _ in 0..CORRECTIONS {
            let slope = gradient(problem, &point);
            let equality = &problem.equality_value - &problem.equality * &point.x;
            let inequality = &problem.inequality_limit - &problem.inequality * &point.x;
            let residual = DVector::from_iterator(
                size,
                free.iter()
                    .map(|&j| -slope[j])
                    .chain(equality.iter().copied())
                    .chain(held.iter().map(|&i| inequality[i])),
            );
            let step = system.solve(&residual);
            for (k, &j) in free.iter().enumerate() {
                point.x[j] += step[k];
            }
            for i in 0..p {
                point.equality[i] += step[f + i];
            }
            for (k, &i) in held.iter().enumerate() {
                point.inequality[i] += step[f + p + k];
            }
        }
    }
    let slope = gradient(problem, &point);
    for (j, hold) in active.variables.iter().enumerate() {
        match hold {
            Hold::Free => {}
            _ if problem.lower[j] == problem.upper[j] => {
                point.lower[j] = slope[j].max(0.0);
                point.upper[j] = (-slope[j]).max(0.0);
            }
            Hold::Lower => point.lower[j] = slope[j],
            Hold::Upper => point.upper[j] = -slope[j],
        }
    }
    point.is_finite().then_some(point)
}

/// `P x + q + A'y + G'z`.
fn gradient(problem: &Problem, point: &Point) -> DVector<f64> {
    &problem.hessian * &point.x
        + &problem.linear
        + problem.equality.tr_mul(&point.equality)
        + problem.inequality.tr_mul(&point.inequality)
}
