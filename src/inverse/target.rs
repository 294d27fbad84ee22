//! What the inverse is asked for, by name, before any face is known.

use crate::face::JawRange;
use crate::units::Vec3;

/// A point of the face.
#[derive(Clone, Debug, PartialEq)]
pub enum Place {
    /// A landmark by name.
    Landmark(String),
    /// A rest position, mm, carried by the tissue nearest to it.
    Point(Vec3),
}

/// Where a marker shall go; `None` is an unobserved component, not zero.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Goal {
    /// Displacement from rest, mm.
    Displacement([Option<f64>; 3]),
    /// Position in the face frame, mm.
    Position([Option<f64>; 3]),
}

impl Goal {
    /// The observed components, mm.
    pub fn observed(&self) -> impl Iterator<Item = f64> {
        let (Self::Displacement(row) | Self::Position(row)) = self;
        row.iter().copied().flatten()
    }
}

/// An observed or wished-for marker.
#[derive(Clone, Debug, PartialEq)]
pub struct Marker {
    /// Label, unique in the target.
    pub name: String,
    /// Which point of the face it is.
    pub at: Place,
    /// Where it shall go.
    pub goal: Goal,
    /// Standard deviation, mm, positive: weight `1/sigma`.
    pub sigma_mm: f64,
}

/// A coordinate axis of the face frame.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Axis {
    /// The subject's left.
    X,
    /// Up.
    Y,
    /// Anterior.
    Z,
}

impl Axis {
    /// Its position in a vector, 0 to 2.
    pub fn index(self) -> usize {
        match self {
            Self::X => 0,
            Self::Y => 1,
            Self::Z => 2,
        }
    }
}

/// What a feature shall measure.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum FeatureGoal {
    /// The value itself, mm.
    Value(f64),
    /// Its change from rest, mm.
    Change(f64),
}

/// A length between two points: the distance, or with an axis the signed component `to - from`
/// along it (an aperture is `to` the upper `from` the lower stomion along y).
#[derive(Clone, Debug, PartialEq)]
pub struct Feature {
    /// Label, unique in the target.
    pub name: String,
    /// One end.
    pub from: Place,
    /// The other end.
    pub to: Place,
    /// Axis of a signed component; `None` is the distance.
    pub axis: Option<Axis>,
    /// What it shall be.
    pub goal: FeatureGoal,
    /// Standard deviation, mm, positive.
    pub sigma_mm: f64,
}

/// Two points that shall move as mirror images in the mid-sagittal plane x = 0.
#[derive(Clone, Debug, PartialEq)]
pub struct MirroredPair {
    /// The subject's left point.
    pub left: Place,
    /// The subject's right point.
    pub right: Place,
    /// Standard deviation of the difference, mm, positive.
    pub sigma_mm: f64,
}

/// Bounds of one activation, within [0, 1]; equal bounds fix the muscle.
#[derive(Clone, Debug, PartialEq)]
pub struct Bound {
    /// Muscle name.
    pub muscle: String,
    /// Least activation.
    pub min: f64,
    /// Greatest activation.
    pub max: f64,
}

/// An activation that was observed, as by electromyography, or is thought likely.
#[derive(Clone, Debug, PartialEq)]
pub struct Prior {
    /// Muscle name.
    pub muscle: String,
    /// Its activation, within [0, 1].
    pub activation: f64,
    /// Standard deviation, positive, in units of activation.
    pub sigma: f64,
}

/// How residuals of markers count.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub enum Loss {
    /// By their squares.
    #[default]
    Squares,
    /// By their squares up to so many standard deviations of a marker, in proportion beyond: a marker with the wrong label
    /// cannot turn the others (Huber 1964).
    Huber(f64),
}

/// What the effort of a muscle is.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum EffortMeasure {
    /// Its activation: all muscles cost the same.
    #[default]
    Activation,
    /// Its force: its greatest force, squared as the activation is in [`EffortNorm::L2`], by the mean of all.
    Force,
    /// Its active volume: greatest force times the mean length of its fibres, by the mean of all; force goes with the
    /// cross-section.
    Volume,
}

/// How the activations of all muscles make one effort.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum EffortNorm {
    /// `w sum c a`: the next unit of a muscle costs as much as the first, so that few muscles act, the others at exactly
    /// zero (Tibshirani, Regression shrinkage and selection via the lasso, J R Stat Soc B 58:267, 1996).
    L1,
    /// `w/2 sum c a^2`: what a muscle does becomes dearer the more it does, so that all that help act, each a little.
    #[default]
    L2,
}

/// What a muscle costs beside what its measure says.
#[derive(Clone, Debug, PartialEq)]
pub struct MuscleCost {
    /// Muscle name.
    pub muscle: String,
    /// Factor on its effort, not negative.
    pub factor: f64,
}

/// How far the jaw is open: the arc of the lower incisal point about the condylar axis, mm.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum JawOpening {
    /// That far.
    Held(f64),
    /// Unknown within these bounds.
    Within(JawRange),
}

impl Target {
    /// Standard deviations that are accepted, mm: from a tenth of a micrometre, which nobody measures on skin, to what
    /// observes nothing. Weights beyond leave the range of numbers.
    pub const SIGMA_MM: [f64; 2] = [1e-4, 1e4];
    /// Standard deviations of an activation that are accepted.
    pub const SIGMA: [f64; 2] = [1e-4, 1e4];
    /// Standard deviations of a marker at which Huber's loss may turn.
    pub const HUBER_SIGMAS: [f64; 2] = [0.1, 100.];
    /// Greatest weight of the effort.
    pub const MOST_EFFORT: f64 = 1e9;
}

impl JawOpening {
    /// Path of the field, and its name in answers.
    pub const FIELD: &str = "jaw_opening_mm";
}

/// A result that a target file states for one face, with its tolerance.
#[derive(Clone, Debug, PartialEq)]
pub struct Expected {
    /// Name of the face.
    pub face: String,
    /// Root mean square of the residuals of markers and features, mm.
    pub residual_rms_mm: f64,
    /// How far the computed value may be from it, mm.
    pub tolerance_mm: f64,
}

/// A target: the terms of the objective and the limits, by name.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Target {
    /// Name, one word.
    pub name: String,
    /// One sentence.
    pub description: String,
    /// Where the figures come from.
    pub provenance: String,
    /// Markers.
    pub markers: Vec<Marker>,
    /// Features.
    pub features: Vec<Feature>,
    /// Mirrored pairs.
    pub symmetry: Vec<MirroredPair>,
    /// Weight `w` of the effort, dimensionless, not negative.
    pub effort: f64,
    /// Which effort: `w/2 sum c a^2` or `w sum c a`.
    pub effort_norm: EffortNorm,
    /// What the effort of a muscle is: its share of `c`.
    pub effort_by: EffortMeasure,
    /// Muscles that cost more or less than their measure says.
    pub costs: Vec<MuscleCost>,
    /// How residuals of markers count.
    pub loss: Loss,
    /// Activations that were observed.
    pub priors: Vec<Prior>,
    /// Bounds other than [0, 1].
    pub bounds: Vec<Bound>,
    /// How far the jaw is open; at rest when absent.
    pub jaw_opening: Option<JawOpening>,
    /// Pairs of muscles whose activations are equal.
    pub tied: Vec<[String; 2]>,
    /// Results stated for known faces.
    pub expected: Vec<Expected>,
}
