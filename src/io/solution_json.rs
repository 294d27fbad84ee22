//! Answers, `solution.json`.

use std::collections::BTreeMap;

use schemars::generate::SchemaSettings;
use schemars::{JsonSchema, Schema};
use serde::{Deserialize, Serialize};

use super::certainty_json::CertaintyJson;
use super::nonlinear_json::{DeformationJson, LinearJson, OtherJson, StepJson};
use crate::inverse::{ActiveLimit, ContactReport, FeatureFit, LimitKind, MarkerFit, RelaxationEnd, Status};
use crate::qp::Certificate;

/// An answer as `solution.json` states it. Lengths mm, forces N, times s; byte-identical from run to
/// run apart from `timings_s`.
#[derive(Clone, Debug, PartialEq, Serialize, JsonSchema)]
#[schemars(title = "Modiolus solution", deny_unknown_fields)]
pub struct SolutionJson {
    /// How the fit ended; only "solved" is an answer.
    pub status: StatusWord,
    /// The target; null when nothing was fitted.
    pub target: Option<TargetJson>,
    /// How strain was measured: "linear" or "finite".
    pub strain: String,
    /// How the stiffness of the muscles was taken: "activated" or "fixed=A".
    pub stiffness: String,
    /// How strong the muscles were, as a multiple of the face's `max_force_n`.
    pub strength: f64,
    /// How lips, cheeks and teeth touch: "reactions", "kinematic" or "off".
    pub contact_mode: String,
    /// Activation of each muscle, 0 to 1.
    pub activations: BTreeMap<String, f64>,
    /// How far the jaw is open, mm of arc at the lower incisal point; null when nothing was said of it.
    pub jaw_opening_mm: Option<f64>,
    /// Size of the marker residuals, mm; null when there is no observed marker.
    pub residual_mm: ResidualJson,
    /// Share of the observed movement of the markers that the answer explains; null where nothing was seen to move.
    pub explained: Option<f64>,
    /// How each marker was met.
    pub markers: Vec<MarkerJson>,
    /// How each feature was met.
    pub features: Vec<FeatureJson>,
    /// The limits that hold the answer back.
    pub active_limits: Vec<LimitJson>,
    /// Contact at the answer; null when contact is off.
    pub contact: Option<ContactJson>,
    /// Residuals of the program, recomputed from it; null when there is no point to compute them at.
    pub certificate: Option<CertificateJson>,
    /// What the data determine of the activations; null where nothing was fitted.
    pub certainty: Option<CertaintyJson>,
    /// What the target file states for this face; null when it states nothing, or when stiffness or contact
    /// are not the defaults that it holds for.
    pub expected: Option<ExpectedJson>,
    /// How far the answer strains and turns the tissue; null when there is none.
    pub deformation: Option<DeformationJson>,
    /// The quadratic programs of a nonlinear fit, in order.
    pub steps: Vec<StepJson>,
    /// How far the answer at fixed stiffness was from the nonlinear one; null when there is only one.
    pub linear_answer: Option<LinearJson>,
    /// Other local solutions: where there are any, the target does not determine the activations.
    pub other_solutions: Vec<OtherJson>,
    /// What is odd about the target or the answer, each with its remedy.
    pub warnings: Vec<String>,
    /// What is odd about the face, each with its remedy.
    pub face_warnings: Vec<String>,
    /// Wall time of each step, s.
    pub timings_s: BTreeMap<String, f64>,
    /// The face: the name of a built-in face, or the path of its face.toml as given.
    pub face: String,
    /// SHA-256 of each input file, by its name on the command line.
    pub inputs: BTreeMap<String, String>,
    /// SHA-256 of each file that was written with this one and belongs to it, by its name: "face.vtu" holds the
    /// displacement, and is not there when there is none.
    pub files: BTreeMap<String, String>,
    /// Version of the program.
    pub version: String,
}

/// Which target was fitted.
#[derive(Clone, Debug, PartialEq, Eq, Serialize, Deserialize, JsonSchema)]
#[schemars(deny_unknown_fields)]
pub struct TargetJson {
    /// Its name.
    pub name: String,
    /// Its file, as given.
    pub file: String,
}

/// How a fit ended.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize, JsonSchema)]
#[serde(rename_all = "snake_case")]
pub enum StatusWord {
    /// The certificate passes.
    Solved,
    /// The limits contradict each other.
    Infeasible,
    /// The solver stopped short of the tolerance.
    NotConverged,
    /// The certificate passes, but other activations fit as well.
    Underdetermined,
    /// Nothing to fit.
    NoData,
}

impl StatusWord {
    /// The word as a table says it.
    pub fn said(self) -> &'static str {
        match self {
            Self::Solved => "solved",
            Self::Infeasible => "infeasible",
            Self::NotConverged => "not converged",
            Self::Underdetermined => "underdetermined",
            Self::NoData => "no data",
        }
    }
}

impl From<Status> for StatusWord {
    fn from(status: Status) -> Self {
        match status {
            Status::Solved => Self::Solved,
            Status::Infeasible => Self::Infeasible,
            Status::NotConverged => Self::NotConverged,
            Status::Underdetermined => Self::Underdetermined,
            Status::NoData => Self::NoData,
        }
    }
}

/// What a target file states for a face, and whether the answer agrees.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, JsonSchema)]
#[schemars(deny_unknown_fields)]
pub struct ExpectedJson {
    /// Root mean square of the residuals of markers and features that the file states, mm.
    pub residual_rms_mm: f64,
    /// How far the computed value may be from it, mm.
    pub tolerance_mm: f64,
    /// The computed value, mm.
    pub found_rms_mm: f64,
    /// Whether it is within the tolerance.
    pub met: bool,
}

/// Size of the marker residuals, mm.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[schemars(deny_unknown_fields)]
pub struct ResidualJson {
    /// Root mean square over the markers.
    pub rms: Option<f64>,
    /// Largest.
    pub max: Option<f64>,
}

/// How one marker was met.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[schemars(deny_unknown_fields)]
pub struct MarkerJson {
    /// Label.
    pub name: String,
    /// Where it is at rest, mm; null only in files of versions that did not say.
    #[serde(default)]
    pub rest_mm: Option<[f64; 3]>,
    /// Displacement asked for, mm; null is a component that was not observed.
    pub target_mm: [Option<f64>; 3],
    /// Displacement of the model, mm.
    pub model_mm: [f64; 3],
    /// Length of the difference over the observed components, mm; null when there is none.
    pub residual_mm: Option<f64>,
    /// Share of its observed movement that the answer explains; null where it was not seen to move.
    pub explained: Option<f64>,
}

impl From<&MarkerFit> for MarkerJson {
    fn from(fit: &MarkerFit) -> Self {
        Self {
            name: fit.name.clone(),
            rest_mm: Some(fit.rest_mm.into()),
            target_mm: fit.target_mm,
            model_mm: fit.model_mm.into(),
            residual_mm: fit.residual_mm,
            explained: MarkerFit::explained([fit]),
        }
    }
}

/// How one feature was met.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[schemars(deny_unknown_fields)]
pub struct FeatureJson {
    /// Label.
    pub name: String,
    /// Length asked for, mm.
    pub target_mm: f64,
    /// Length in the model, mm.
    pub model_mm: f64,
    /// Size of the difference, mm.
    pub residual_mm: f64,
}

impl From<&FeatureFit> for FeatureJson {
    fn from(fit: &FeatureFit) -> Self {
        let (target_mm, model_mm) = (fit.target_mm, fit.model_mm);
        Self { name: fit.name.clone(), target_mm, model_mm, residual_mm: (model_mm - target_mm).abs() }
    }
}

/// A limit that holds the answer back.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[schemars(deny_unknown_fields)]
pub struct LimitJson {
    /// What kind of limit it is.
    pub kind: LimitKindWord,
    /// What it is, `risorius_l <= 1`.
    pub name: String,
    /// How fast the objective falls when the limit is relaxed, not negative.
    pub multiplier: f64,
    /// Unit of the multiplier: objective per unit of the limit.
    pub unit: String,
    /// By how much the root mean square of the marker residuals falls at first when the limit gives way by one unit, mm; null
    /// without markers.
    pub gain_mm: Option<f64>,
}

/// What kind of limit holds an answer back.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize, JsonSchema)]
#[serde(rename_all = "snake_case")]
pub enum LimitKindWord {
    /// A muscle or the jaw at the end of its range.
    Cap,
    /// A muscle at rest that would have to push, which none does.
    AtRest,
    /// Two muscles that act together.
    Tie,
    /// Teeth or lips.
    Contact,
}

impl From<LimitKind> for LimitKindWord {
    fn from(kind: LimitKind) -> Self {
        match kind {
            LimitKind::Cap => Self::Cap,
            LimitKind::AtRest => Self::AtRest,
            LimitKind::Tie => Self::Tie,
            LimitKind::Contact => Self::Contact,
        }
    }
}

impl From<&ActiveLimit> for LimitJson {
    fn from(limit: &ActiveLimit) -> Self {
        Self {
            kind: limit.kind.into(),
            name: limit.name.clone(),
            multiplier: limit.multiplier,
            unit: limit.unit.to_owned(),
            gain_mm: limit.gain_mm,
        }
    }
}

/// Contact at the answer.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize, Deserialize, JsonSchema)]
#[schemars(deny_unknown_fields)]
pub struct ContactJson {
    /// Number of candidate pairs.
    pub pairs: usize,
    /// Number of pairs that touch with a force.
    pub active: usize,
    /// Sum of the contact forces, N.
    pub force_n: f64,
    /// Of which the upper teeth, N.
    pub upper_teeth_n: f64,
    /// The lower teeth, N.
    pub lower_teeth_n: f64,
    /// The lips against each other, N.
    pub lips_n: f64,
    /// Deepest penetration beyond the rest overlap, mm, of the linearised gaps.
    pub max_penetration_mm: f64,
    /// Deepest overlap beyond that at rest, mm, of the deformed face where it does not hang on bone: at finite strain of dense
    /// samples of its surfaces, at linear strain of the nodes that contact meets; null when it was not measured.
    pub overlap_mm: Option<f64>,
    /// Linearisations of the gaps that the answer took.
    pub linearisations: usize,
    /// Objective minus the best lower bound of any contact state, no unit: what another could gain at most.
    /// Of a nonlinear fit it is about the tangent at the answer.
    pub relaxation_gap: f64,
    /// Convex relaxations that gave the bound.
    pub relaxation_nodes: usize,
    /// How the bounding ended; null when contact states were not searched.
    pub relaxation_end: Option<RelaxationEndWord>,
    /// By how much branching lowered the objective of the search over neighbouring contact states, no unit.
    pub branching_gain: f64,
}

/// How the bounding of the objective from below ended.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize, JsonSchema)]
#[serde(rename_all = "snake_case")]
pub enum RelaxationEndWord {
    /// No set of contacts is better by more than a millionth.
    Closed,
    /// The nodes were spent.
    NodeLimit,
    /// The cost of the relaxations was spent.
    CostLimit,
    /// A relaxation stopped short of its tolerance.
    NotConverged,
}

impl From<RelaxationEnd> for RelaxationEndWord {
    fn from(end: RelaxationEnd) -> Self {
        match end {
            RelaxationEnd::Closed => Self::Closed,
            RelaxationEnd::NodeLimit => Self::NodeLimit,
            RelaxationEnd::CostLimit => Self::CostLimit,
            RelaxationEnd::NotConverged => Self::NotConverged,
        }
    }
}

impl From<&ContactReport> for ContactJson {
    fn from(contact: &ContactReport) -> Self {
        Self {
            pairs: contact.pairs,
            active: contact.active,
            force_n: contact.force_n,
            upper_teeth_n: 0.0,
            lower_teeth_n: 0.0,
            lips_n: 0.0,
            max_penetration_mm: contact.max_penetration_mm,
            overlap_mm: None,
            linearisations: 1,
            relaxation_gap: contact.relaxation_gap,
            relaxation_nodes: contact.relaxation_nodes,
            relaxation_end: contact.relaxation_end.map(Into::into),
            branching_gain: contact.branching_gain,
        }
    }
}

/// Residuals of the program, recomputed from it.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[schemars(deny_unknown_fields)]
pub struct CertificateJson {
    /// Largest violation of a constraint.
    pub primal: f64,
    /// Largest component of the stationarity residual.
    pub dual: f64,
    /// Difference between primal and dual objective.
    pub gap: f64,
}

impl From<&Certificate> for CertificateJson {
    fn from(certificate: &Certificate) -> Self {
        Self { primal: certificate.primal, dual: certificate.dual, gap: certificate.gap }
    }
}

impl SolutionJson {
    /// The text of the file, with a final newline.
    ///
    /// Keys stand in the order of the fields, names in alphabetical order, and every number in the
    /// shortest form that reads back to the same bits. A number that is not finite becomes null.
    ///
    /// # Errors
    /// When the text cannot be put together, which no value of the fields brings about.
    pub fn to_text(&self) -> Result<String, serde_json::Error> {
        to_text(self)
    }
}

/// `value` as JSON that is indented, ends in a newline and steers no terminal.
pub(super) fn to_text(value: &impl Serialize) -> Result<String, serde_json::Error> {
    let text = serde_json::to_string_pretty(value)? + "\n";
    // JSON lets DEL and the C1 controls stand in strings, where they steer a terminal that shows the file.
    let is_control = |c: char| c.is_control() && c != '\n';
    let written = |c: char| if is_control(c) { format!("\\u{:04x}", u32::from(c)) } else { c.to_string() };
    Ok(if text.contains(is_control) { text.chars().map(written).collect() } else { text })
}

/// The JSON schema of answers, as in `schemas/solution.schema.json`.
pub fn solution_schema() -> String {
    let settings = SchemaSettings::draft2020_12().for_serialize();
    let schema: Schema = super::schema::schema_of::<SolutionJson>(settings);
    super::schema::pretty(&schema)
}
