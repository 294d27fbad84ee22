//! What the data determine of an answer, and what they leave open.
//!
//! [`TangentProgram`] -> misfit in the measure of its noise -> the unknowns that it allows
//! (intervals) and their distribution (posterior) -> [`Certainty`].

mod design;
mod determination;
mod discrepancy;
mod effort_choice;
mod feasible;
mod fitted;
mod least_odd;
mod misfit;
mod posterior;
mod seen_points;

use nalgebra::{DMatrix, DVector};
use rayon::prelude::*;

pub use design::{ChosenMarker, MarkerDesign};
pub use determination::{Determination, UnknownCertainty, percent};
pub use discrepancy::Discrepancy;
pub use effort_choice::{EffortChoice, EffortPoint};
pub use seen_points::{Intervals, SeenPoints};

use self::feasible::{Feasible, Range};
use self::fitted::Fitted;
use self::misfit::Misfit;
use self::posterior::Posterior;
use crate::inverse::{FreeUnknowns, TangentProgram};

/// Influence below this share of the strongest is none.
const NEGLIGIBLE: f64 = 1e-9;
/// Samples of the posterior: the first noise is only about right.
const SAMPLES: [usize; 2] = [400, 2000];
/// What another unknown must change by, as a share of the one that trades against it, to be named,
const TRADED: f64 = 0.4;
/// and how many are named.
const NAMED: usize = 2;
/// Correlation from which undetermined unknowns are one group.
const GROUPED: f64 = 0.7;

/// What the data determine of an answer, on its tangent.
///
/// The misfit counts markers, features, mirrored pairs and priors in their standard deviations, to which the
/// [`Discrepancy`] of the model is added, and not the effort: a preference tells nothing about the face. What touches at
/// the answer goes on touching, with forces that follow the activations; contacts that would open or close on the way are
/// not walls, since a face goes on beyond them.
#[derive(Clone, Debug, PartialEq)]
pub struct Certainty {
    /// How far the model was taken to be from the face.
    pub discrepancy: Discrepancy,
    /// By how much all standard deviations had to be multiplied for the residuals to be likely; 1 where they are.
    pub noise_factor: f64,
    /// Observed components.
    pub components: usize,
    /// Ratio of the greatest to the least singular value of the residuals over the free unknowns, in standard
    /// deviations; infinite where a direction is not observed.
    pub condition: f64,
    /// Each of the `n` unknowns.
    pub unknowns: Vec<UnknownCertainty>,
    /// Correlations (n x n) of the posterior; zero with what is held.
    pub correlations: DMatrix<f64>,
    /// Names of unknowns that are not determined each, only together.
    pub groups: Vec<Vec<String>>,
    /// What the two sides share, and by how much they differ.
    pub sides: Vec<SideCertainty>,
    /// How much effort to weigh against the markers' own standard deviations; `None` where no program converges.
    pub effort: Option<EffortChoice>,
}

/// A muscle of both sides: `even = (left + right) / 2`, `odd = (left - right) / 2`.
#[derive(Clone, Debug, PartialEq)]
pub struct SideCertainty {
    /// The muscle without its side.
    pub name: String,
    /// Even part of the answer, its least and its greatest value.
    pub even: [f64; 3],
    /// Odd part of the answer, its least and its greatest value; above zero the left is stronger.
    pub odd: [f64; 3],
    /// Odd part in the activations of the least sum of squared odd parts whose misfit the noise allows: what the data demand
    /// of all muscles together.
    pub least_odd: Option<f64>,
}

impl SideCertainty {
    /// Whether the data say which side is stronger.
    pub fn is_uneven(&self) -> bool {
        self.odd[1] > 0. || self.odd[2] < 0.
    }
}

impl Certainty {
    /// That of the answer of `program` with a model as far from the face as `discrepancy`; `None` when there are no data, or
    /// no program converges.
    pub fn of(program: &TangentProgram, discrepancy: Discrepancy) -> Option<Self> {
        let free = program.free();
        let m = program.n_muscles();
        let alone = discrepancy == Discrepancy::NONE;
        let samples = SAMPLES[usize::from(alone)];
        let first = Known::new(program, &free, &discrepancy, samples, &program.x.rows(0, m).map(|a| a * a))?;
        let known = match alone {
            true => first,
            // What a muscle may do counts as well as what it does in the answer.
            false => {
                let squares = DVector::from_fn(m, |k, _| first.mean[k].powi(2) + first.covariance[(k, k)]);
                Known::new(program, &free, &discrepancy, SAMPLES[1], &squares)?
            }
        };
        let Known { misfit, best, mean, covariance } = known;
        let feasible = Feasible::new(&misfit, &free.bounds, &best);
        let n = program.n_unknowns();
        let unit = |k: usize| free.transform.row(k).transpose();
        let ranges: Vec<Option<Range>> = (0..n).into_par_iter().map(|k| feasible.range(&unit(k))).collect();
        let seen = &misfit.matrix * free.transform.transpose();
        let strongest = seen.column_iter().map(|column| column.norm()).fold(0., f64::max);
        let of = |k: usize| {
            let value = program.x[k];
            let is_held = free.transform.row(k).amax() == 0.;
            let (min, max) = match &ranges[k] {
                // The answer has an effort, and need not be where the misfit is least.
                Some(range) => (range.min.min(value), range.max.max(value)),
                None if is_held => (value, value),
                None => (program.bounds.min[k], program.bounds.max[k]),
            };
            let (min, max) = (min.max(program.bounds.min[k]), max.min(program.bounds.max[k]));
            let is_seen = seen.column(k).norm() > NEGLIGIBLE * strongest;
            let width = program.bounds.max[k] - program.bounds.min[k];
            let sd = covariance[(k, k)].max(0.).sqrt();
            UnknownCertainty {
                name: program.unknowns[k].clone(),
                jaw: program.jaw.filter(|_| k >= program.n_muscles()),
                value,
                min,
                max,
                mean: mean[k],
                sd,
                resolution: if is_held { 1. } else { (1. - 12. * sd * sd / (width * width)).clamp(0., 1.) },
                determination: match is_held {
                    true => Determination::Held,
                    false => Determination::of(max - min, is_seen),
                },
                trades: match &ranges[k] {
                    Some(range) if is_seen => {
                        let change = &free.transform * (&range.at_max - &range.at_min);
                        traded(program, k, &change)
                    }
                    _ => Vec::new(),
                },
            }
        };
        let unknowns: Vec<UnknownCertainty> = (0..n).map(of).collect();
        let correlations = DMatrix::from_fn(n, n, |i, j| {
            let size = unknowns[i].sd * unknowns[j].sd;
            if size > 0. { covariance[(i, j)] / size } else { 0. }
        });
        let groups = groups(&unknowns, &correlations);
        let sides = sides(program);
        let least_odd = uneven(&sides, &free, &misfit, &best);
        let sides = sides.into_par_iter().enumerate().map(|(pair, (name, [left, right]))| {
            let (l, r) = (program.x[left], program.x[right]);
            let part = |sign: f64, value: f64| {
                let f: DVector<f64> = (unit(left) + unit(right) * sign) / 2.;
                let held = (free.offset[left] + sign * free.offset[right]) / 2.;
                let (min, max) = match feasible.range(&f) {
                    Some(range) => (range.min, range.max),
                    // What the bounds leave, where no program converges; a held pair has no width.
                    None => f
                        .iter()
                        .zip(free.bounds.min.iter().zip(free.bounds.max.iter()))
                        .fold((0., 0.), |(min, max), (f, (lo, hi))| {
                            (min + (f * lo).min(f * hi), max + (f * lo).max(f * hi))
                        }),
                };
                [value, (min + held).min(value), (max + held).max(value)]
            };
            let least_odd = least_odd.as_ref().map(|odd| odd[pair]);
            SideCertainty { name, even: part(1., (l + r) / 2.), odd: part(-1., (l - r) / 2.), least_odd }
        });
        let sides = sides.collect();
        // The target weighs its effort against `sigma_mm` alone.
        let plain = Misfit::of(program, &free, &Discrepancy::NONE, &DVector::zeros(m));
        let [most, least] = match misfit.singular.is_empty() {
            true => [1.; 2],
            false => [misfit.singular.max(), misfit.singular.min()],
        };
        let is_full = misfit.singular.len() == free.transform.ncols() && least > NEGLIGIBLE * most;
        Some(Self {
            discrepancy,
            noise_factor: misfit.birge,
            components: misfit.components,
            condition: if is_full { most / least } else { f64::INFINITY },
            unknowns,
            correlations,
            groups,
            sides,
            effort: plain.and_then(|plain| EffortChoice::of(program, &free, &plain)),
        })
    }
}

/// What is known of the unknowns with one noise.
struct Known {
    misfit: Misfit,
    /// The free unknowns (k) that fit best.
    best: DVector<f64>,
    /// Of the posterior (n).
    mean: DVector<f64>,
    /// Of the posterior (n x n).
    covariance: DMatrix<f64>,
}

impl Known {
    fn new(
        program: &TangentProgram,
        free: &FreeUnknowns,
        discrepancy: &Discrepancy,
        samples: usize,
        squares: &DVector<f64>,
    ) -> Option<Self> {
        let Fitted { misfit, best } =
            Fitted::of(Misfit::of(program, free, discrepancy, squares)?, &free.bounds)?;
        let n = program.n_unknowns();
        let (mean, covariance) = match Posterior::of(&misfit, &free.bounds, &best, samples) {
            Some(posterior) => (
                &free.transform * posterior.mean() + &free.offset,
                &free.transform * posterior.covariance() * free.transform.transpose(),
            ),
            None => (program.x.clone(), DMatrix::zeros(n, n)),
        };
        Some(Self { misfit, best, mean, covariance })
    }
}

/// The unknowns that change by at least a share of the change of `k`, the most first, those tied to it left out.
fn traded(program: &TangentProgram, k: usize, change: &DVector<f64>) -> Vec<String> {
    let is_tied = |j: usize| program.tied.pairs.iter().any(|pair| *pair == [j, k] || *pair == [k, j]);
    let mut others: Vec<usize> = (0..change.len())
        .filter(|&j| j != k && !is_tied(j) && change[j].abs() > TRADED * change[k].abs())
        .collect();
    others.sort_by(|&i, &j| change[j].abs().total_cmp(&change[i].abs()).then(i.cmp(&j)));
    others.into_iter().take(NAMED).map(|j| program.unknowns[j].clone()).collect()
}

/// Unknowns that are not determined and go together.
fn groups(unknowns: &[UnknownCertainty], correlations: &DMatrix<f64>) -> Vec<Vec<String>> {
    let is_open =
        |k: usize| matches!(unknowns[k].determination, Determination::Roughly | Determination::Undetermined);
    let mut group: Vec<usize> = (0..unknowns.len()).collect();
    for i in 0..unknowns.len() {
        for j in 0..i {
            if is_open(i) && is_open(j) && correlations[(i, j)].abs() >= GROUPED {
                let (from, to) = (group[i].max(group[j]), group[i].min(group[j]));
                group.iter_mut().filter(|g| **g == from).for_each(|g| *g = to);
            }
        }
    }
    let members = |lead: usize| -> Vec<String> {
        (0..group.len()).filter(|&k| group[k] == lead).map(|k| unknowns[k].name.clone()).collect()
    };
    (0..group.len()).map(members).filter(|members| members.len() > 1).collect()
}

/// The odd parts of the pairs `sides` in the least uneven activations that the noise allows.
fn uneven(
    sides: &[(String, [usize; 2])],
    free: &FreeUnknowns,
    misfit: &Misfit,
    best: &DVector<f64>,
) -> Option<DVector<f64>> {
    let half = |x: &dyn Fn(usize) -> f64| {
        DVector::from_iterator(sides.len(), sides.iter().map(|(_, [l, r])| (x(*l) - x(*r)) / 2.))
    };
    let columns: Vec<DVector<f64>> =
        free.transform.column_iter().map(|column| half(&|k| column[k])).collect();
    if columns.is_empty() {
        return None;
    }
    let (odd, offset) = (DMatrix::from_columns(&columns), half(&|k| free.offset[k]));
    let y = least_odd::least_odd(misfit, misfit.at(best) + feasible::RISE, &free.bounds, &odd, &offset)?;
    Some(odd * y + offset)
}

/// Muscles that there are on both sides: name and unknowns, left first.
fn sides(program: &TangentProgram) -> Vec<(String, [usize; 2])> {
    let place = |name: &str| program.unknowns.iter().position(|n| n == name);
    (0..program.n_muscles())
        .filter_map(|left| {
            let stem = program.unknowns[left].strip_suffix("_l")?;
            Some((stem.to_owned(), [left, place(&format!("{stem}_r"))?]))
        })
        .collect()
}
