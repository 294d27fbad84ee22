//! Two results set against each other, `--json` of a comparison.

use std::collections::BTreeMap;

use schemars::generate::SchemaSettings;
use schemars::{JsonSchema, Schema};
use serde::Serialize;

use super::answer::AnswerFiles;
use super::solution_json::{ContactJson, to_text};
use crate::study::{Comparison, MovedLandmark, Pair, Sides, matched};
use crate::units::Vec3;

/// Two results set against each other, "a" before "b". Lengths mm, forces N; null where a result has none of something.
#[derive(Clone, Debug, PartialEq, Serialize, JsonSchema)]
#[schemars(title = "Modiolus comparison", deny_unknown_fields)]
pub struct ComparisonJson {
    /// The first result.
    pub a: ComparedResultJson,
    /// The second.
    pub b: ComparedResultJson,
    /// Whether any landmark of both lies elsewhere at rest.
    pub faces_differ: bool,
    /// Activations by muscle.
    pub activations: Vec<ComparedActivationJson>,
    /// Muscles that only the first face has.
    pub only_a: Vec<String>,
    /// Muscles that only the second face has.
    pub only_b: Vec<String>,
    /// Markers that were observed, and how either result met them.
    pub markers: Vec<ComparedMarkerJson>,
    /// Landmarks, at rest and moved.
    pub landmarks: Vec<ComparedLandmarkJson>,
    /// Contact.
    pub contact: ComparedContactJson,
    /// Version of the program.
    pub version: String,
}

/// One of the results.
#[derive(Clone, Debug, PartialEq, Serialize, JsonSchema)]
#[schemars(deny_unknown_fields)]
pub struct ComparedResultJson {
    /// Its folder, as given.
    pub folder: String,
    /// The face: the name of a built-in face, or the path of its face.toml.
    pub face: String,
    /// Name of the target; null when nothing was fitted.
    pub target: Option<String>,
    /// How strain was measured.
    pub strain: String,
    /// How the stiffness of the muscles was taken.
    pub stiffness: String,
    /// How strong the muscles were.
    pub strength: f64,
    /// How far the jaw is open, mm; null when nothing was said of it.
    pub jaw_opening_mm: Option<f64>,
    /// How symmetric it is.
    pub symmetry: SidesJson,
}

/// How symmetric a moved face is.
#[derive(Clone, Debug, PartialEq, Serialize, JsonSchema)]
#[schemars(deny_unknown_fields)]
pub struct SidesJson {
    /// Left activation minus right one, by the muscle's name without side.
    pub activations: BTreeMap<String, f64>,
    /// Root mean square of those.
    pub activations_rms: Option<f64>,
    /// By how much the left landmark misses the mirror image of the right one's movement, mm, by the name without side.
    pub landmarks_mm: BTreeMap<String, f64>,
    /// Root mean square of those, mm.
    pub landmarks_rms_mm: Option<f64>,
}

/// An activation in both results.
#[derive(Clone, Debug, PartialEq, Serialize, JsonSchema)]
#[schemars(deny_unknown_fields)]
pub struct ComparedActivationJson {
    /// Muscle.
    pub name: String,
    /// In the first, 0 to 1.
    pub a: Option<f64>,
    /// In the second.
    pub b: Option<f64>,
    /// The second minus the first.
    pub change: Option<f64>,
}

/// A marker in both results.
#[derive(Clone, Debug, PartialEq, Serialize, JsonSchema)]
#[schemars(deny_unknown_fields)]
pub struct ComparedMarkerJson {
    /// Label.
    pub name: String,
    /// By how much the first misses it, mm.
    pub residual_a_mm: Option<f64>,
    /// By how much the second does, mm.
    pub residual_b_mm: Option<f64>,
}

/// A landmark in both results.
#[derive(Clone, Debug, PartialEq, Serialize, JsonSchema)]
#[schemars(deny_unknown_fields)]
pub struct ComparedLandmarkJson {
    /// Name.
    pub name: String,
    /// Where the second face has it at rest, from where the first has it, mm.
    pub rest_change_mm: Option<[f64; 3]>,
    /// Its displacement in the first, mm.
    pub displacement_a_mm: Option<[f64; 3]>,
    /// Its displacement in the second, mm.
    pub displacement_b_mm: Option<[f64; 3]>,
    /// Length of the difference of the two displacements, mm.
    pub apart_mm: Option<f64>,
}

/// Contact in both results.
#[derive(Clone, Debug, PartialEq, Serialize, JsonSchema)]
#[schemars(deny_unknown_fields)]
pub struct ComparedContactJson {
    /// In the first; null when contact is off.
    pub a: Option<ContactJson>,
    /// In the second.
    pub b: Option<ContactJson>,
}

/// Rest positions that differ by less than this are rounding, mm.
const SAME_MM: f64 = 1e-6;

impl ComparisonJson {
    /// The comparison of the `answers` in their folders.
    pub fn new(folders: &[String; 2], answers: [&AnswerFiles; 2], comparison: &Comparison) -> Self {
        let [a, b] = [0, 1].map(|k| result(&folders[k], answers[k], &comparison.sides[k]));
        let landmarks: Vec<ComparedLandmarkJson> = comparison.landmarks.iter().map(landmark).collect();
        let moved =
            |l: &ComparedLandmarkJson| l.rest_change_mm.is_some_and(|d| Vec3::from(d).norm() > SAME_MM);
        let only = |which: usize| {
            let one = comparison.activations.iter().filter(move |p| p.values[1 - which].is_none());
            one.map(|p| p.name.clone()).collect()
        };
        let residuals = answers.map(|answer| {
            let observed = answer.markers.iter().filter_map(|m| Some((m.name.clone(), m.residual_mm?)));
            observed.collect()
        });
        Self {
            a,
            b,
            faces_differ: landmarks.iter().any(moved),
            activations: comparison.activations.iter().map(activation).collect(),
            only_a: only(0),
            only_b: only(1),
            markers: matched(&residuals).into_iter().map(marker).collect(),
            landmarks,
            contact: ComparedContactJson { a: answers[0].contact, b: answers[1].contact },
            version: env!("CARGO_PKG_VERSION").to_owned(),
        }
    }

    /// The text of the JSON, with a final newline, as that of [answers](super::SolutionJson::to_text).
    ///
    /// # Errors
    /// When the text cannot be put together, which no value of the fields brings about.
    pub fn to_text(&self) -> Result<String, serde_json::Error> {
        to_text(self)
    }
}

fn result(folder: &str, answer: &AnswerFiles, sides: &Sides) -> ComparedResultJson {
    ComparedResultJson {
        folder: folder.to_owned(),
        face: answer.face.clone(),
        target: answer.target.as_ref().map(|t| t.name.clone()),
        strain: answer.strain.clone(),
        stiffness: answer.stiffness.clone(),
        strength: answer.strength,
        jaw_opening_mm: answer.jaw_opening_mm,
        symmetry: SidesJson {
            activations: sides.activation.iter().cloned().collect(),
            activations_rms: sides.activation_rms,
            landmarks_mm: sides.landmarks_mm.iter().cloned().collect(),
            landmarks_rms_mm: sides.landmarks_rms_mm,
        },
    }
}

fn activation(pair: &Pair<f64>) -> ComparedActivationJson {
    let [a, b] = pair.values;
    ComparedActivationJson { name: pair.name.clone(), a, b, change: a.zip(b).map(|(a, b)| b - a) }
}

fn marker(pair: Pair<f64>) -> ComparedMarkerJson {
    let [residual_a_mm, residual_b_mm] = pair.values;
    ComparedMarkerJson { name: pair.name, residual_a_mm, residual_b_mm }
}

fn landmark(pair: &Pair<MovedLandmark>) -> ComparedLandmarkJson {
    let both = pair.both();
    let [a, b] = pair.values.map(|v| v.map(|l| l.displacement_mm.into()));
    ComparedLandmarkJson {
        name: pair.name.clone(),
        rest_change_mm: both.map(|[a, b]| (b.rest_mm - a.rest_mm).into()),
        displacement_a_mm: a,
        displacement_b_mm: b,
        apart_mm: both.map(|[a, b]| (b.displacement_mm - a.displacement_mm).norm()),
    }
}

/// The JSON schema of comparisons, as in `schemas/comparison.schema.json`.
pub fn comparison_schema() -> String {
    let settings = SchemaSettings::draft2020_12().for_serialize();
    let schema: Schema = super::schema::schema_of::<ComparisonJson>(settings);
    super::schema::pretty(&schema)
}
