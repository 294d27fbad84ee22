//! What `modiolus calibrate` tells.

use std::collections::BTreeMap;

use schemars::generate::SchemaSettings;
use schemars::{JsonSchema, Schema};
use serde::Serialize;

use super::DiscrepancyJson;
use crate::calibration::{Calibrated, Combination, Knowledge, Parameter, per_cent};
use crate::study::CalibratedFace;

/// Parameters of a face, from expressions whose activations are known. Every factor is a multiple of what the face had;
/// spreads are standard deviations of logarithms; byte-identical from run to run apart from `timings_s`.
#[derive(Clone, Debug, PartialEq, Serialize, JsonSchema)]
#[schemars(title = "Modiolus calibration", deny_unknown_fields)]
pub struct CalibrationJson {
    /// The face: the name of a built-in face, or the path of its face.toml as given.
    pub face: String,
    /// "solved" when nothing moved any more, else "`not_converged`".
    pub status: String,
    /// "reactions" with contact, "off" without.
    pub contact_mode: String,
    /// The moduli of the calibrated face, kPa.
    pub moduli: ModuliJson,
    /// Each parameter.
    pub parameters: Vec<ParameterJson>,
    /// Combinations of the parameters that act by what the data alone determine of them, the best determined first: the
    /// eigenvectors of their information.
    pub combinations: Vec<CombinationJson>,
    /// How well each expression is explained.
    pub expressions: Vec<ExplainedJson>,
    /// How far the model was taken to be from the face; its strength is what is sought, and 0 here.
    pub discrepancy: DiscrepancyJson,
    /// By how much all standard deviations had to be multiplied for the residuals to be likely; 1 where they are.
    pub noise_factor: f64,
    /// What to be careful about.
    pub warnings: Vec<String>,
    /// Wall times, s.
    pub timings_s: BTreeMap<String, f64>,
    /// SHA-256 of each input file, by its name on the command line.
    pub inputs: BTreeMap<String, String>,
    /// Version of the program.
    pub version: String,
}

/// Moduli, kPa.
#[derive(Clone, Debug, PartialEq, Serialize, JsonSchema)]
#[schemars(deny_unknown_fields)]
pub struct ModuliJson {
    /// Young's modulus of the passive tissue.
    pub tissue_young_kpa: f64,
    /// Modulus of muscle at rest.
    pub muscle_rest_kpa: f64,
    /// Modulus of muscle along the fibre, contracted.
    pub muscle_active_kpa: f64,
}

/// A parameter.
#[derive(Clone, Debug, PartialEq, Serialize, JsonSchema)]
#[schemars(deny_unknown_fields)]
pub struct ParameterJson {
    /// "`tissue_modulus`", "`muscle_modulus`", "`muscle_stress`", or a muscle without its side, whose strength it is.
    pub name: String,
    /// Its value.
    pub factor: f64,
    /// Spread that is left.
    pub spread: f64,
    /// Median before.
    pub prior_median: f64,
    /// Spread before; 0 is held.
    pub prior_spread: f64,
    /// Share of the prior variance that the data took away.
    pub resolution: f64,
    /// "data", "prior", "unseen" or "held".
    pub knowledge: String,
    /// What it trades against, with the correlations.
    pub trades: Vec<TradeJson>,
    /// All of it in a sentence.
    pub sentence: String,
}

/// What a parameter trades against.
#[derive(Clone, Debug, PartialEq, Serialize, JsonSchema)]
#[schemars(deny_unknown_fields)]
pub struct TradeJson {
    /// Another parameter, or "activation of MUSCLE in EXPRESSION".
    pub with: String,
    /// Correlation of the logarithms, or of logarithm and activation.
    pub correlation: f64,
}

/// A combination of parameters.
#[derive(Clone, Debug, PartialEq, Serialize, JsonSchema)]
#[schemars(deny_unknown_fields)]
pub struct CombinationJson {
    /// Weight of each parameter, the greatest 1; those of 0 are left out.
    pub weights: BTreeMap<String, f64>,
    /// Eigenvalue of the information of the data, per squared logarithm.
    pub information: f64,
    /// Spread of the parameter of the greatest weight when all change along the weights; null where the data say nothing.
    pub spread: Option<f64>,
    /// All of it in a sentence.
    pub sentence: String,
}

/// An expression.
#[derive(Clone, Debug, PartialEq, Serialize, JsonSchema)]
#[schemars(deny_unknown_fields)]
pub struct ExplainedJson {
    /// Name of its target.
    pub name: String,
    /// Observed components.
    pub components: usize,
    /// Root mean square of the residuals, in the standard deviations of the markers, at the medians of the priors.
    pub rms_before: f64,
    /// The same with what was found.
    pub rms_after: f64,
    /// How deep surfaces overlap beyond rest, mm: contact is left out.
    pub overlap_mm: f64,
}

impl CalibrationJson {
    /// Deepest overlap, mm, of which there is no warning: that of an answer that may be called solved.
    const BEARABLE_MM: f64 = 0.1;

    /// Of `found` on the face called `face`, whose model was taken to be off by `discrepancy`.
    pub fn new(found: &CalibratedFace, face: String, discrepancy: DiscrepancyJson, contact: &str) -> Self {
        let CalibratedFace { calibration, face: calibrated, overlap_mm } = found;
        let names: Vec<&str> = calibration.parameters.iter().map(|p| p.parameter.name.as_str()).collect();
        let expressions: Vec<ExplainedJson> = calibration
            .expressions
            .iter()
            .zip(overlap_mm)
            .map(|(e, &overlap_mm)| ExplainedJson {
                name: e.name.clone(),
                components: e.components,
                rms_before: e.rms_before,
                rms_after: e.rms_after,
                overlap_mm,
            })
            .collect();
        let deep = expressions.iter().filter(|e| e.overlap_mm > Self::BEARABLE_MM);
        let advice = match contact {
            "off" => {
                "which contact would not let them: calibrate with contact, or by movements that press less"
            }
            _ => "where contact did not settle: leave it out, or calibrate by movements that press less",
        };
        let warnings = deep.map(|e| {
            format!("{}: surfaces overlap by {:.1} mm more than at rest, {advice}", e.name, e.overlap_mm)
        });
        Self {
            face,
            status: if calibration.converged { "solved" } else { "not_converged" }.to_owned(),
            contact_mode: contact.to_owned(),
            moduli: ModuliJson {
                tissue_young_kpa: calibrated.tissue.young_kpa,
                muscle_rest_kpa: calibrated.muscle_tissue.rest_kpa,
                muscle_active_kpa: calibrated.muscle_tissue.active_kpa,
            },
            parameters: calibration.parameters.iter().map(ParameterJson::from).collect(),
            combinations: calibration.combinations.iter().map(|c| CombinationJson::of(c, &names)).collect(),
            warnings: warnings.collect(),
            expressions,
            discrepancy,
            noise_factor: calibration.noise_factor,
            timings_s: BTreeMap::new(),
            inputs: BTreeMap::new(),
            version: env!("CARGO_PKG_VERSION").to_owned(),
        }
    }
}

impl CombinationJson {
    fn of(combination: &Combination, names: &[&str]) -> Self {
        let weights = names.iter().zip(&combination.weights).filter(|(_, weight)| **weight != 0.);
        Self {
            weights: weights.map(|(name, weight)| ((*name).to_owned(), *weight)).collect(),
            information: combination.information,
            spread: combination.spread,
            sentence: combination.sentence.clone(),
        }
    }
}

impl From<&Calibrated> for ParameterJson {
    fn from(calibrated: &Calibrated) -> Self {
        let Calibrated {
            parameter: Parameter { name, prior, .. },
            factor,
            spread,
            resolution,
            knowledge,
            trades,
        } = calibrated;
        let within = per_cent(*spread);
        let mut sentence = match knowledge {
            Knowledge::Held => format!("held at {factor:.3}"),
            Knowledge::Unseen => format!(
                "not determined: active in no expression, or where nothing was observed; stays at {factor:.3} within {within:.0} %, its prior"
            ),
            Knowledge::Prior => format!("not determined: {factor:.3} within {within:.0} %, mostly its prior"),
            Knowledge::Data => format!("{factor:.3} within {within:.0} %"),
        };
        if !trades.is_empty() {
            let named: Vec<&str> = trades.iter().map(|(with, _)| with.as_str()).collect();
            sentence += &format!("; trades against {}", named.join(" and "));
        }
        Self {
            name: name.clone(),
            factor: *factor,
            spread: *spread,
            prior_median: prior.median,
            prior_spread: prior.spread,
            resolution: *resolution,
            knowledge: match knowledge {
                Knowledge::Held => "held",
                Knowledge::Unseen => "unseen",
                Knowledge::Prior => "prior",
                Knowledge::Data => "data",
            }
            .to_owned(),
            trades: trades
                .iter()
                .map(|(with, correlation)| TradeJson { with: with.clone(), correlation: *correlation })
                .collect(),
            sentence,
        }
    }
}

/// The JSON schema of `calibration.json`, as in `schemas/calibration.schema.json`.
pub fn calibration_schema() -> String {
    let settings = SchemaSettings::draft2020_12().for_serialize();
    let schema: Schema = super::schema::schema_of::<CalibrationJson>(settings);
    super::schema::pretty(&schema)
}
