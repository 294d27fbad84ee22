//! Doubts about a target that its numbers raise.

use std::collections::BTreeSet;

use nalgebra::{DMatrix, DVector};

use super::limit::Limit;
use super::piece::{Outcome, Piece};
use super::pivot::Found;
use super::problem::{MarkerAim, Problem};
use super::program::Linearisation;
use super::solution::{ActiveLimit, LimitKind, MarkerFit};
use super::tangent_program::FreeUnknowns;
use super::target::Goal;
use super::term::Term;
use super::terms::MarkerDisplacement;
use super::warning::Warning;

/// Influence below this share of the strongest muscle's is none; angles below it are parallel.
const NEGLIGIBLE: f64 = 1e-9;
/// Multiplier of a limit that holds an unknown back, at least, as a share of the greatest slope of the effort.
const PUSHING: f64 = 1e-7;
/// Part of a direction of length one from which an unknown is named.
const PART: f64 = 1e-6;
/// Residuals beyond this many standard deviations ask for an explanation.
const FAR: f64 = 3.0;
/// Residual of an outlier, as a multiple of the median one,
const OUTLYING: f64 = 4.0;
/// among at least so many markers.
const FEWEST: usize = 5;
/// How much better the swapped sides must fit.
const SWAPPED_SHARE: f64 = 0.5;
/// Limits named for an unreachable marker, at most.
const NAMED: usize = 3;

/// Warnings that need no answer.
pub(super) fn before(problem: &Problem) -> Vec<Warning> {
    let mut warnings: Vec<Warning> = problem.markers.iter().filter_map(exact_zero).collect();
    warnings.extend(swapped(problem));
    warnings.extend(immovable(problem));
    warnings.extend(influence(problem));
    warnings.extend(underdetermined(problem));
    warnings
}

fn exact_zero(marker: &MarkerAim) -> Option<Warning> {
    let (Goal::Displacement(given) | Goal::Position(given)) = marker.goal;
    (given == [Some(0.0); 3]).then(|| Warning::ExactZero { marker: marker.name.clone() })
}

/// Observed markers that no unknown moves.
fn immovable(problem: &Problem) -> Vec<Warning> {
    let moves = |point: usize| problem.space.observed.rows(3 * point, 3).norm();
    let observed = problem.markers.iter().filter(|marker| marker.target_mm.iter().any(Option::is_some));
    let farthest = observed.clone().map(|marker| moves(marker.point)).fold(0.0, f64::max);
    let is_still = |point: usize| moves(point) <= NEGLIGIBLE * farthest;
    let still = observed.filter(|marker| is_still(marker.point));
    still.map(|marker| Warning::Immovable { marker: marker.name.clone() }).collect()
}

/// Muscles without influence on any residual, and groups with the same.
fn influence(problem: &Problem) -> Vec<Warning> {
    let rest = problem.rest();
    let data = problem.terms.iter().map(AsRef::as_ref).filter(|term| !is_effort(*term, problem));
    let space = &problem.space;
    let matrix = Linearisation::new(data, &rest).over(space).matrix;
    if matrix.nrows() == 0 {
        return Vec::new();
    }
    let norms: Vec<f64> = matrix.column_iter().map(|column| column.norm()).collect();
    let strongest = norms.iter().copied().fold(0.0, f64::max);
    let is_weak = |k: usize| norms[k] <= NEGLIGIBLE * strongest;
    let weak = (0..norms.len()).filter(|&k| is_weak(k));
    let mut warnings: Vec<Warning> =
        weak.map(|k| Warning::NoInfluence { muscle: problem.name_of(k).to_owned() }).collect();
    // Each group by its first member, whose column the others repeat.
    let mut groups: Vec<Vec<usize>> = Vec::new();
    for k in (0..norms.len()).filter(|&k| !is_weak(k)) {
        let alike = |j: usize| {
            let difference = matrix.column(k) / norms[k] - matrix.column(j) / norms[j];
            difference.norm() <= NEGLIGIBLE && is_free(problem, j, k)
        };
        match groups.iter_mut().find(|group| alike(group[0])) {
            Some(group) => group.push(k),
            None => groups.push(vec![k]),
        }
    }
    let names = |group: Vec<usize>| group.iter().map(|&k| problem.name_of(k).to_owned()).collect();
    let alike = groups.into_iter().filter(|group| group.len() > 1);
    warnings.extend(alike.map(|group| Warning::Indistinguishable { muscles: names(group) }));
    warnings
}

/// The effort moves no point: it sees every muscle and hides which the data see.
fn is_effort(term: &dyn Term, problem: &Problem) -> bool {
    term.rows(&problem.rest()).iter().all(|row| row.observed.is_empty())
}

/// Whether the two activations can differ in a way the data might show.
fn is_free(problem: &Problem, j: usize, k: usize) -> bool {
    let fixed = |i: usize| problem.bounds.min[i] == problem.bounds.max[i];
    !fixed(j) && !fixed(k) && !problem.tied.pairs.iter().any(|pair| *pair == [j, k] || *pair == [k, j])
}

/// Whether the terms leave a direction of the free unknowns open: the rank of their residuals at rest, without
/// contact, against the number of unknowns that are neither fixed nor tied to another. An effort of squares has full rank;
/// whether a linear one decides only its answer shows ([`undecided`]).
fn underdetermined(problem: &Problem) -> Option<Warning> {
    if is_linear(problem) {
        return None;
    }
    let free = FreeUnknowns::new(&problem.bounds, &problem.tied).transform;
    let terms = problem.linearise(&problem.rest()).over(&problem.space).matrix;
    let columns = terms * &free;
    let (components, muscles) = (rank(&columns), free.ncols());
    (components < muscles).then_some(Warning::Underdetermined { components, muscles })
}

fn is_linear(problem: &Problem) -> bool {
    problem.terms.iter().any(|term| !term.slopes().is_empty())
}

/// Whether other activations are as good as those of `found` where the effort is linear: it decides where the residuals
/// have full rank over the directions in which no multiplier holds the unknowns back.
///
/// Source: Tibshirani, The lasso problem and uniqueness, Electron J Stat 7:1456 (2013), section 2.3; the limits that push
/// stand in for the signs there.
pub(super) fn undecided(problem: &Problem, found: &Found) -> Option<Warning> {
    if !is_linear(problem) {
        return None;
    }
    let point = &found.optimum.point;
    let model = problem.linearise(&found.optimum.state).over(&found.piece.space);
    let transform = FreeUnknowns::new(&problem.bounds, &problem.tied).transform;
    let pushes = transform.tr_mul(&(&point.lower + &point.upper));
    let pushing = PUSHING * model.slope.amax();
    let idle: Vec<usize> = (0..pushes.len()).filter(|&k| pushes[k] <= pushing).collect();
    let directions = transform.select_columns(&idle);
    // Contacts that push hold back what would open or close them.
    let held = found.piece.pushing(&point.inequality);
    let seen: Vec<DVector<f64>> = [&model.matrix, &held]
        .into_iter()
        .flat_map(|rows| (rows * &directions).row_iter().map(|row| row.transpose()).collect::<Vec<_>>())
        .collect();
    if idle.is_empty() {
        return None;
    }
    let seen = match seen.is_empty() {
        true => DMatrix::zeros(idle.len(), 1),
        false => DMatrix::from_columns(&seen),
    };
    // The left singular vectors of all rows as columns: those without a singular value are not seen.
    let square = seen.clone().resize_horizontally(seen.ncols().max(idle.len()), 0.);
    let svd = square.svd(true, false);
    let (free, values) = (svd.u?, svd.singular_values);
    let unseen: Vec<DVector<f64>> = (0..values.len())
        .filter(|&k| values[k] <= NEGLIGIBLE * values.amax())
        .map(|k| &directions * free.column(k))
        .collect();
    let takes_part = |k: &usize| unseen.iter().any(|way| way[*k].abs() > PART);
    let muscles: Vec<String> =
        (0..problem.n_unknowns()).filter(takes_part).map(|k| problem.name_of(k).to_owned()).collect();
    (!muscles.is_empty()).then_some(Warning::Undecided { muscles })
}

/// Singular values above a negligible share of the largest.
fn rank(matrix: &DMatrix<f64>) -> usize {
    if matrix.is_empty() || !matrix.iter().all(|x| x.is_finite()) {
        return 0;
    }
    let values = matrix.singular_values();
    values.iter().filter(|s| **s > NEGLIGIBLE * values.amax()).count()
}

/// The label on the other side, for a name that has a side.
fn mirrored(name: &str) -> Option<String> {
    name.strip_suffix("_l").map(|stem| format!("{stem}_r"))
}

/// Fits the markers as given and with every pair of sides exchanged, without contact.
fn swapped(problem: &Problem) -> Option<Warning> {
    let markers = &problem.markers;
    let pairs: Vec<[usize; 2]> = (0..markers.len())
        .filter_map(|l| {
            let right = mirrored(&markers[l].place)?;
            Some([l, markers.iter().position(|marker| marker.place == right)?])
        })
        .collect();
    if pairs.is_empty() {
        return None;
    }
    let given: Vec<[Option<f64>; 3]> = markers.iter().map(|marker| marker.target_mm).collect();
    let mut exchanged = given.clone();
    for &[l, r] in &pairs {
        (exchanged[l], exchanged[r]) = (as_displacement(&markers[l], &markers[r].goal), {
            as_displacement(&markers[r], &markers[l].goal)
        });
    }
    let (residual_mm, weighted) = fit(problem, &given)?;
    let (swapped_mm, swapped_weighted) = fit(problem, &exchanged)?;
    (weighted > FAR && swapped_weighted < SWAPPED_SHARE * weighted).then(|| Warning::SwappedSides {
        pairs: pairs.iter().map(|&[l, r]| [markers[l].name.clone(), markers[r].name.clone()]).collect(),
        residual_mm,
        swapped_mm,
    })
}

fn as_displacement(marker: &MarkerAim, goal: &Goal) -> [Option<f64>; 3] {
    match *goal {
        Goal::Displacement(d) => d,
        Goal::Position(p) => [0, 1, 2].map(|axis| p[axis].map(|v| v - marker.rest_mm[axis])),
    }
}

/// Root mean square residual of the markers, in mm over the markers and in standard deviations over
/// the components.
fn fit(problem: &Problem, targets: &[[Option<f64>; 3]]) -> Option<(f64, f64)> {
    let terms: Vec<MarkerDisplacement> = problem
        .markers
        .iter()
        .zip(targets)
        .map(|(marker, &target_mm)| MarkerDisplacement {
            point: marker.point,
            target_mm,
            sigma_mm: marker.sigma_mm,
        })
        .collect();
    let linearised = Linearisation::new(terms.iter().map(|term| term as &dyn Term), &problem.rest());
    let limits: [&dyn Limit; 2] = [&problem.bounds, &problem.tied];
    let piece = Piece::without_contact(&problem.space);
    let Ok(Outcome::Optimum(optimum)) = piece.optimum(&linearised, &limits, &BTreeSet::new()) else {
        return None;
    };
    let rows: Vec<(f64, f64)> = terms
        .iter()
        .flat_map(|term| term.rows(&optimum.state).into_iter().map(|row| (row.value, term.sigma_mm)))
        .collect();
    let seen = targets.iter().filter(|t| t.iter().any(Option::is_some)).count();
    if rows.is_empty() {
        return None;
    }
    let squares_mm: f64 = rows.iter().map(|(value, sigma)| (value * sigma).powi(2)).sum();
    let squares: f64 = rows.iter().map(|(value, _)| value * value).sum();
    Some(((squares_mm / seen as f64).sqrt(), (squares / rows.len() as f64).sqrt()))
}

/// Markers that stay far where most are near.
pub(super) fn outliers(problem: &Problem, fits: &[MarkerFit]) -> Vec<Warning> {
    let off: Vec<(f64, f64, &str)> = problem
        .markers
        .iter()
        .zip(fits)
        .filter_map(|(marker, fit)| {
            Some((fit.residual_mm? / marker.sigma_mm, fit.residual_mm?, fit.name.as_str()))
        })
        .collect();
    if off.len() < FEWEST {
        return Vec::new();
    }
    let mut sorted: Vec<f64> = off.iter().map(|(sigmas, ..)| *sigmas).collect();
    sorted.sort_by(f64::total_cmp);
    let beyond = (OUTLYING * sorted[off.len() / 2]).max(FAR);
    off.into_iter()
        .filter(|(sigmas, ..)| *sigmas > beyond)
        .map(|(sigmas, residual_mm, name)| Warning::Outlier { marker: name.to_owned(), residual_mm, sigmas })
        .collect()
}

/// The farthest marker, if it is far, and the limits that stop it and that a user can change.
pub(super) fn unreachable(problem: &Problem, fits: &[MarkerFit], limits: &[ActiveLimit]) -> Option<Warning> {
    let far = |(marker, fit): (&MarkerAim, &MarkerFit)| {
        let residual = fit.residual_mm?;
        (residual > FAR * marker.sigma_mm).then(|| (residual / marker.sigma_mm, residual, fit.name.clone()))
    };
    let (_, residual_mm, marker) =
        problem.markers.iter().zip(fits).filter_map(far).max_by(|a, b| a.0.total_cmp(&b.0))?;
    // Nobody can let a muscle push, or move a tooth for a target.
    let changeable = limits.iter().filter(|l| matches!(l.kind, LimitKind::Cap | LimitKind::Tie));
    let limits = changeable.take(NAMED).map(|limit| limit.name.clone()).collect();
    Some(Warning::Unreachable { marker, residual_mm, limits })
}
