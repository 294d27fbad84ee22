//! What the inverse answers.

use std::fmt;
use std::sync::Arc;

use nalgebra::DVector;

use super::branching::RelaxationEnd;
use super::tangent_program::TangentProgram;
use super::warning::Warning;
use crate::qp::{Certificate, Infeasible};
use crate::units::Vec3;

/// How an inverse ended.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Status {
    /// The certificate passes: primal, dual and gap residuals are at most 1e-9.
    Solved,
    /// The limits contradict each other; the certificate proves it.
    Infeasible,
    /// The solver stopped short of the tolerance.
    NotConverged,
    /// The certificate passes, but other activations fit as well: the observations have a lower rank than there are
    /// unknowns, and no effort decides between them, or a linear one does not decide. The answer is one of many.
    Underdetermined,
    /// Nothing to fit: no marker has an observed component and there is no feature.
    NoData,
}

impl Status {
    /// The word in `solution.json`.
    pub fn word(self) -> &'static str {
        match self {
            Self::Solved => "solved",
            Self::Infeasible => "infeasible",
            Self::NotConverged => "not_converged",
            Self::Underdetermined => "underdetermined",
            Self::NoData => "no_data",
        }
    }

    /// Whether no activations fit better than those of the answer, be it the only one or one of many.
    pub fn is_optimum(self) -> bool {
        matches!(self, Self::Solved | Self::Underdetermined)
    }
}

impl fmt::Display for Status {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(&self.word().replace('_', " "))
    }
}

/// How one marker was met; missing components stay missing.
#[derive(Clone, Debug, PartialEq)]
pub struct MarkerFit {
    /// Label.
    pub name: String,
    /// Where it is at rest, mm.
    pub rest_mm: Vec3,
    /// Displacement asked for, mm.
    pub target_mm: [Option<f64>; 3],
    /// Displacement of the model, mm.
    pub model_mm: Vec3,
    /// Length of the difference over the observed components, mm; `None` when all are missing.
    pub residual_mm: Option<f64>,
}

impl MarkerFit {
    /// Sums of squares, mm^2, over the observed components: of the residual, and of the movement asked for.
    fn squares(&self) -> [f64; 2] {
        let seen = self.target_mm.iter().zip(self.model_mm.iter());
        seen.filter_map(|(target, model)| target.map(|t| [(model - t).powi(2), t * t]))
            .fold([0.; 2], |[r, d], [rr, dd]| [r + rr, d + dd])
    }

    /// Share of the movement of all `markers` that is explained.
    pub fn explained<'a>(markers: impl IntoIterator<Item = &'a Self>) -> Option<f64> {
        let sums = markers.into_iter().map(Self::squares);
        let [residual, movement] = sums.fold([0.; 2], |[r, d], [rr, dd]| [r + rr, d + dd]);
        (movement > 0.).then(|| 1. - residual / movement)
    }
}

/// What kind of limit holds an answer back.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum LimitKind {
    /// A muscle at its greatest activation, or at a least one above rest; the jaw at an end of its range.
    Cap,
    /// A muscle at rest that would have to push, which none does.
    AtRest,
    /// Two muscles that act together.
    Tie,
    /// Teeth or lips.
    Contact,
}

/// A limit that holds the answer back.
#[derive(Clone, Debug, PartialEq)]
pub struct ActiveLimit {
    /// Its kind.
    pub kind: LimitKind,
    /// What it is: `zygomaticus_major_l <= 1`.
    pub name: String,
    /// How fast the objective would fall if the limit were relaxed, not negative.
    pub multiplier: f64,
    /// Unit of the multiplier: objective per unit of the limit, `1`, `1/mm` or `1/N`.
    pub unit: &'static str,
    /// By how much the root mean square of the marker residuals falls at first when the limit gives way by one unit, mm,
    /// if all markers gain alike; `None` without markers.
    pub gain_mm: Option<f64>,
}

/// Contact at the solution.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct ContactReport {
    /// Number of candidate pairs.
    pub pairs: usize,
    /// Number of pairs that touch with a force.
    pub active: usize,
    /// Sum of the contact forces, N.
    pub force_n: f64,
    /// Deepest penetration beyond the rest overlap, mm.
    pub max_penetration_mm: f64,
    /// Objective minus the best lower bound of any contact state, dimensionless: what another could gain at
    /// most. Of a nonlinear fit it is about the tangent at the answer.
    pub relaxation_gap: f64,
    /// Convex relaxations that gave the bound.
    pub relaxation_nodes: usize,
    /// How the bounding ended; `None` without contact reactions.
    pub relaxation_end: Option<RelaxationEnd>,
    /// By how much branching lowered the objective of the search over neighbouring contact states.
    pub branching_gain: f64,
}

/// How one feature was met.
#[derive(Clone, Debug, PartialEq)]
pub struct FeatureFit {
    /// Label.
    pub name: String,
    /// Length or signed component asked for, mm.
    pub target_mm: f64,
    /// That of the model, mm.
    pub model_mm: f64,
}

/// Lengths of the marker residuals.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Residual {
    /// Root mean square over the observed markers, mm.
    pub rms_mm: f64,
    /// The longest, mm.
    pub max_mm: f64,
}

/// Activations by muscle.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Activations {
    /// Names of the `m` muscles.
    pub names: Vec<String>,
    /// Activations (m), in [0, 1].
    pub values: Vec<f64>,
}

impl Activations {
    /// The activation of the muscle called `name`.
    pub fn get(&self, name: &str) -> Option<f64> {
        self.names.iter().position(|n| n == name).map(|k| self.values[k])
    }
}

/// What the inverse found.
///
/// [`activations`](Self::activations) is empty when there is no answer at all: no data, or limits that
/// contradict each other.
#[derive(Clone, Debug, PartialEq)]
pub struct Solution {
    /// How it ended; anything but [`Status::Solved`] is no answer.
    pub status: Status,
    /// Activations `a`.
    pub activations: Activations,
    /// How far the jaw is open, mm, where the target prescribes it or asks for it.
    pub jaw_opening_mm: Option<f64>,
    /// Contact forces `lambda` (c), N; empty without contact reactions.
    pub contact_forces: DVector<f64>,
    /// Displacements `P u` of the observed points (d = 3p, point-major xyz), mm.
    pub observed_mm: DVector<f64>,
    /// `1/2 sum r^2` over all terms, dimensionless.
    pub objective: f64,
    /// Residuals of the markers.
    pub residual: Residual,
    /// Share of the observed movement that the answer explains, `1 - sum r^2 / sum d^2` over the observed components of the
    /// markers; `None` where nothing was seen to move.
    pub explained: Option<f64>,
    /// Markers, in the target's order.
    pub markers: Vec<MarkerFit>,
    /// Features, in the target's order.
    pub features: Vec<FeatureFit>,
    /// Limits that hold the answer back, the strongest first.
    pub active_limits: Vec<ActiveLimit>,
    /// Contact.
    pub contact: ContactReport,
    /// Residuals of the program that was solved, with every contact in it.
    pub certificate: Certificate,
    /// The program of the answer; `None` where there is none.
    pub program: Option<Arc<TangentProgram>>,
    /// Proof that the limits contradict each other, when they do.
    pub infeasible: Option<Infeasible>,
    /// What to look at before believing the answer.
    pub warnings: Vec<Warning>,
}
