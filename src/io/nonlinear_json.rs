//! The parts of `solution.json` that tell of stiffening muscles.

use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

use crate::forward::Deformation;
use crate::inverse::{SequentialStep, Solution};
use crate::study::residual_rms_mm;

/// One quadratic program of the sequence that a nonlinear fit solves.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, JsonSchema)]
#[schemars(deny_unknown_fields)]
pub struct StepJson {
    /// Objective before the step, no unit.
    pub objective: f64,
    /// Largest residual of the nonlinear optimality conditions before the step.
    pub kkt: f64,
    /// Largest change of an activation that the program proposed, or of the jaw's opening as a share of its range.
    pub change: f64,
    /// Half width of the trust region, in units of activation.
    pub radius: f64,
    /// Whether the step was taken.
    pub taken: bool,
}

impl From<&SequentialStep> for StepJson {
    fn from(step: &SequentialStep) -> Self {
        let &SequentialStep { objective, kkt, change, radius, taken } = step;
        Self { objective, kkt, change, radius, taken }
    }
}

/// How far the answer at a fixed stiffness was from the nonlinear one.
#[derive(Clone, Debug, PartialEq, Serialize, JsonSchema)]
#[schemars(deny_unknown_fields)]
pub struct LinearJson {
    /// The activation at which the stiffness was held.
    pub stiffness: f64,
    /// The muscle whose activation differs most.
    pub muscle: String,
    /// By how much, in units of activation.
    pub activation_off: f64,
    /// Root mean square, over the observed points, of the difference between where the linear answer
    /// expected them and where its activations lead, mm.
    pub markers_off_mm: f64,
    /// Root mean square of its own residuals over the markers and features, mm.
    pub residual_rms_mm: f64,
    /// Activation of each muscle that it found, 0 to 1.
    pub activations: std::collections::BTreeMap<String, f64>,
}

/// Another local solution that another start led to.
#[derive(Clone, Debug, PartialEq, Serialize, JsonSchema)]
#[schemars(deny_unknown_fields)]
pub struct OtherJson {
    /// Objective, no unit.
    pub objective: f64,
    /// Root mean square over the markers and features, mm.
    pub residual_rms_mm: f64,
    /// How far the jaw is open, mm; null when nothing was said of it.
    pub jaw_opening_mm: Option<f64>,
    /// Activation of each muscle, 0 to 1.
    pub activations: std::collections::BTreeMap<String, f64>,
}

impl From<&Solution> for OtherJson {
    fn from(solution: &Solution) -> Self {
        let a = &solution.activations;
        Self {
            objective: solution.objective,
            residual_rms_mm: residual_rms_mm(solution),
            jaw_opening_mm: solution.jaw_opening_mm,
            activations: a.names.iter().cloned().zip(a.values.iter().copied()).collect(),
        }
    }
}

/// How far the answer strains and turns the tissue.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[schemars(deny_unknown_fields)]
pub struct DeformationJson {
    /// Largest absolute principal strain.
    pub strain: f64,
    /// Where, at rest, mm.
    pub strain_at_mm: [f64; 3],
    /// Largest rotation, degrees.
    pub rotation_deg: f64,
    /// Where, at rest, mm.
    pub rotation_at_mm: [f64; 3],
    /// Share of the volume where strain is above 0.1 or rotation above 10 degrees, out of the range of
    /// linear elasticity.
    pub beyond_share: f64,
    /// Cells that are turned inside out: where there are any, the answer means nothing about them.
    pub inverted_cells: usize,
    /// Where most, at rest, mm; null without such cells.
    pub inverted_at_mm: Option<[f64; 3]>,
    /// Least share of its volume to which a point of the tissue is squeezed.
    pub volume_ratio: f64,
    /// Largest principal stretch.
    pub stretch: f64,
    /// Where, at rest, mm.
    pub stretch_at_mm: [f64; 3],
}

impl From<&Deformation> for DeformationJson {
    fn from(deformation: &Deformation) -> Self {
        Self {
            strain: deformation.strain,
            strain_at_mm: deformation.strain_at.into(),
            rotation_deg: deformation.rotation_deg,
            rotation_at_mm: deformation.rotation_at.into(),
            beyond_share: deformation.beyond_share,
            inverted_cells: deformation.inverted_cells,
            inverted_at_mm: (deformation.inverted_cells > 0).then(|| deformation.inverted_at.into()),
            volume_ratio: deformation.volume_ratio,
            stretch: deformation.stretch,
            stretch_at_mm: deformation.stretch_at.into(),
        }
    }
}
