//! The part of `solution.json` that tells what the data determine.

use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

use crate::certainty::{Certainty, Discrepancy, SideCertainty, UnknownCertainty};
use crate::inverse::EffortNorm;

/// Correlation from which a pair is listed.
const LISTED: f64 = 0.3;

/// What the data determine, at 95 per cent, on the tangent of the answer. Activations are 0 to 1, the opening of the jaw is
/// in mm.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct CertaintyJson {
    /// How far the model was taken to be from the face.
    pub discrepancy: DiscrepancyJson,
    /// By how much all standard deviations had to be multiplied for the residuals to be likely; 1 where they are.
    pub noise_factor: f64,
    /// Observed components.
    pub components: usize,
    /// Ratio of the best to the worst observed direction of the unknowns; null where one is not observed at all.
    pub condition: Option<f64>,
    /// Each muscle, and the opening of the jaw where that is unknown.
    pub unknowns: Vec<UnknownJson>,
    /// Unknowns that are determined only together.
    pub groups: Vec<Vec<String>>,
    /// Pairs of unknowns whose posterior correlation is 0.3 or more.
    pub correlations: Vec<CorrelationJson>,
    /// What the sides share and by how much they differ.
    pub sides: Vec<SideJson>,
    /// How much effort to weigh by three rules, the noise being that of the target alone; null where none converges.
    pub effort: Option<EffortJson>,
}

/// Misfit against effort over the weight `w` of `w/2 sum c a²` or `w sum c a`, on the tangent of the answer.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct EffortJson {
    /// Which effort.
    #[serde(default)]
    pub norm: NormJson,
    /// Weight at the corner of the L-curve.
    pub l_curve: f64,
    /// Weight of least generalised cross-validation.
    pub cross_validation: f64,
    /// Weight at which the misfit is as large as the noise makes it; null where there is none.
    pub discrepancy: Option<f64>,
    /// The curve: weight, misfit in squared standard deviations, and the sum of the activations (l1) or of their squares (l2),
    /// by their costs.
    pub curve: Vec<[f64; 3]>,
}

/// Which sum an effort is.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize, JsonSchema)]
#[serde(rename_all = "lowercase")]
pub enum NormJson {
    /// Of activations.
    L1,
    /// Of their squares.
    #[default]
    L2,
}

/// How far a model is taken to be from the face that it stands for.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct DiscrepancyJson {
    /// Relative standard deviation of what a muscle does as a whole.
    pub strength: f64,
    /// Relative standard deviation of its movement from point to point.
    pub shape: f64,
    /// Length over which the errors of points go together, mm.
    pub length_mm: f64,
}

impl From<&Discrepancy> for DiscrepancyJson {
    fn from(discrepancy: &Discrepancy) -> Self {
        let Discrepancy { strength, shape, length_mm } = *discrepancy;
        Self { strength, shape, length_mm }
    }
}

/// What the data say about one unknown.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct UnknownJson {
    /// The muscle, or `jaw_opening_mm`.
    pub name: String,
    /// The answer.
    pub value: f64,
    /// Least value that the noise allows.
    pub min: f64,
    /// Greatest value that the noise allows.
    pub max: f64,
    /// Mean of the posterior.
    pub mean: f64,
    /// Standard deviation of the posterior.
    pub sd: f64,
    /// Share of what the limits leave open that the data decide, 0 to 1.
    pub resolution: f64,
    /// How well it is determined: `held`, `determined`, `roughly`, `not_determined` or `not_observed`.
    pub determination: String,
    /// What it trades against, the most first.
    pub trades: Vec<String>,
    /// The same as a sentence.
    pub sentence: String,
}

/// The correlation of two unknowns.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct CorrelationJson {
    /// The two.
    pub between: [String; 2],
    /// -1 to 1.
    pub correlation: f64,
}

/// A muscle of both sides.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct SideJson {
    /// The muscle without its side.
    pub name: String,
    /// (left + right) / 2.
    pub even: IntervalJson,
    /// (left - right) / 2; above zero the left is stronger.
    pub odd: IntervalJson,
    /// Odd part in the least uneven activations that the noise allows; null where none were found.
    pub least_odd: Option<f64>,
    /// Whether the data say which side is stronger.
    pub uneven: bool,
}

/// A value and the interval about it.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct IntervalJson {
    /// Of the answer.
    pub value: f64,
    /// Least.
    pub min: f64,
    /// Greatest.
    pub max: f64,
}

impl From<&Certainty> for CertaintyJson {
    fn from(certainty: &Certainty) -> Self {
        let names: Vec<&str> = certainty.unknowns.iter().map(|u| u.name.as_str()).collect();
        let pairs = (0..names.len()).flat_map(|i| (0..i).map(move |j| (j, i)));
        let correlations = pairs.filter_map(|(j, i)| {
            let correlation = certainty.correlations[(i, j)];
            let between = [names[j].to_owned(), names[i].to_owned()];
            (correlation.abs() >= LISTED).then_some(CorrelationJson { between, correlation })
        });
        Self {
            discrepancy: DiscrepancyJson::from(&certainty.discrepancy),
            noise_factor: certainty.noise_factor,
            components: certainty.components,
            condition: certainty.condition.is_finite().then_some(certainty.condition),
            unknowns: certainty.unknowns.iter().map(UnknownJson::from).collect(),
            groups: certainty.groups.clone(),
            correlations: correlations.collect(),
            sides: certainty.sides.iter().map(SideJson::from).collect(),
            effort: certainty.effort.as_ref().map(|choice| EffortJson {
                norm: match choice.norm {
                    EffortNorm::L1 => NormJson::L1,
                    EffortNorm::L2 => NormJson::L2,
                },
                l_curve: choice.l_curve,
                cross_validation: choice.cross_validation,
                discrepancy: choice.discrepancy,
                curve: choice.curve.iter().map(|p| [p.weight, p.misfit, p.effort]).collect(),
            }),
        }
    }
}

impl From<&UnknownCertainty> for UnknownJson {
    fn from(unknown: &UnknownCertainty) -> Self {
        let shown = |x: f64| unknown.jaw.map_or(x, |range| range.at(x));
        let scale = unknown.jaw.map_or(1., |range| range.width_mm());
        Self {
            name: unknown.name.clone(),
            value: shown(unknown.value),
            min: shown(unknown.min),
            max: shown(unknown.max),
            mean: shown(unknown.mean),
            sd: scale * unknown.sd,
            resolution: unknown.resolution,
            determination: unknown.determination.word().to_owned(),
            trades: unknown.trades.clone(),
            sentence: unknown.to_string(),
        }
    }
}

impl From<&SideCertainty> for SideJson {
    fn from(side: &SideCertainty) -> Self {
        let interval = |[value, min, max]: [f64; 3]| IntervalJson { value, min, max };
        Self {
            name: side.name.clone(),
            even: interval(side.even),
            odd: interval(side.odd),
            least_odd: side.least_odd,
            uneven: side.is_uneven(),
        }
    }
}
