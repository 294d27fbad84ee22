//! What `modiolus register` tells.

use std::collections::BTreeMap;

use schemars::generate::SchemaSettings;
use schemars::{JsonSchema, Schema};
use serde::Serialize;

use crate::face::standard::Parameters;
use crate::registration::{Distances, LandmarkUse, Registration, RegistrationWarning};

/// A face matched to a scan, and how far it can be trusted. Lengths mm, angles degrees.
#[derive(Clone, Debug, PartialEq, Serialize, JsonSchema)]
#[schemars(title = "Modiolus registration", deny_unknown_fields)]
pub struct RegistrationJson {
    /// The name of the face.
    pub face: String,
    /// The face that was matched.
    pub template: String,
    /// From the template to the scan, as the landmarks tell it.
    pub similarity: SimilarityJson,
    /// The fitted proportions, by their names, mm; null where the template is no standard face.
    pub proportions: Option<BTreeMap<String, f64>>,
    /// From the skin to the scan, where that covers it.
    pub skin_to_scan: DistancesJson,
    /// From the scan to the skin, where there is skin.
    pub scan_to_skin: DistancesJson,
    /// Share of the skin that the scan covers, 0 to 1.
    pub covered: f64,
    /// Landmarks that were given.
    pub landmarks: Vec<LandmarkErrorJson>,
    /// Least scaled Jacobian of a cell: 1 for a cube, 0 for one folded flat.
    pub scaled_jacobian: f64,
    /// Cells turned inside out.
    pub inverted_cells: usize,
    /// Lengths of muscles.
    pub muscles: Vec<MuscleLengthJson>,
    /// Depths of bone or mucosa below landmarks.
    pub depths: Vec<DepthJson>,
    /// Asymmetry at rest of landmarks of both sides.
    pub asymmetry: Vec<AsymmetryJson>,
    /// What is odd, with its remedy.
    pub warnings: Vec<String>,
    /// SHA-256 of what was read, by path.
    pub inputs: BTreeMap<String, String>,
    /// Wall time of each step, s.
    pub timings_s: BTreeMap<String, f64>,
    /// Version of the program.
    pub version: String,
}

/// `y = s R x + t` from the template to the scan. A point `y` of the scan's frame is at `R' (y - t)` in that of the face.
#[derive(Clone, Debug, PartialEq, Serialize, JsonSchema)]
#[schemars(deny_unknown_fields)]
pub struct SimilarityJson {
    /// `s`.
    pub scale: f64,
    /// `R`, row by row.
    pub rotation: [[f64; 3]; 3],
    /// `t`, mm.
    pub translation_mm: [f64; 3],
    /// Angle of the rotation, degrees.
    pub angle_deg: f64,
    /// What it leaves of the landmarks, rms, mm.
    pub landmark_rms_mm: f64,
}

/// Distances between two surfaces, by area.
#[derive(Clone, Debug, PartialEq, Serialize, JsonSchema)]
#[schemars(deny_unknown_fields)]
pub struct DistancesJson {
    /// Mean.
    pub mean_mm: f64,
    /// Root mean square.
    pub rms_mm: f64,
    /// What 95 % of the area is within.
    pub p95_mm: f64,
    /// Greatest.
    pub max_mm: f64,
}

/// A landmark that was given.
#[derive(Clone, Debug, PartialEq, Serialize, JsonSchema)]
#[schemars(deny_unknown_fields)]
pub struct LandmarkErrorJson {
    /// Its name.
    pub name: String,
    /// Where it was given, in the axes of the face.
    pub given_mm: [f64; 3],
    /// How far from there that of the face is.
    pub error_mm: f64,
    /// Whether the skin was held to it; otherwise it counted for the position alone.
    pub held: bool,
}

/// A muscle's length.
#[derive(Clone, Debug, PartialEq, Serialize, JsonSchema)]
#[schemars(deny_unknown_fields)]
pub struct MuscleLengthJson {
    /// Its name.
    pub name: String,
    /// Mean over its fibres.
    pub length_mm: f64,
    /// That of the template.
    pub template_mm: f64,
}

/// A depth below a landmark.
#[derive(Clone, Debug, PartialEq, Serialize, JsonSchema)]
#[schemars(deny_unknown_fields)]
pub struct DepthJson {
    /// The landmark.
    pub landmark: String,
    /// Its distance from bone or mucosa.
    pub depth_mm: f64,
    /// That of the template.
    pub template_mm: f64,
}

/// Asymmetry at rest.
#[derive(Clone, Debug, PartialEq, Serialize, JsonSchema)]
#[schemars(deny_unknown_fields)]
pub struct AsymmetryJson {
    /// The landmark's name without the side.
    pub name: String,
    /// Distance of the one from the mirror image of the other.
    pub distance_mm: f64,
}

impl From<&Distances> for DistancesJson {
    fn from(distances: &Distances) -> Self {
        let Distances { mean_mm, rms_mm, p95_mm, max_mm } = *distances;
        Self { mean_mm, rms_mm, p95_mm, max_mm }
    }
}

impl RegistrationJson {
    /// Of `registration` of the face called `template`, from the `inputs`, in `timings_s`.
    pub fn new(
        registration: &Registration,
        template: String,
        inputs: BTreeMap<String, String>,
        timings_s: BTreeMap<String, f64>,
    ) -> Self {
        let Registration { face, similarity, quality, .. } = registration;
        let value = |parameters: &Parameters| {
            let all = Parameters::PROPORTIONS.iter();
            all.map(|proportion| (proportion.name.to_owned(), proportion.of(parameters))).collect()
        };
        let row = |k: usize| [0, 1, 2].map(|j| similarity.rotation[(k, j)]);
        Self {
            face: face.name.clone(),
            template,
            similarity: SimilarityJson {
                scale: similarity.scale,
                rotation: [0, 1, 2].map(row),
                translation_mm: similarity.translation.into(),
                angle_deg: similarity.angle_deg(),
                landmark_rms_mm: registration.landmark_rms_mm,
            },
            proportions: registration.parameters.as_ref().map(value),
            skin_to_scan: (&quality.from_skin).into(),
            scan_to_skin: (&quality.from_scan).into(),
            covered: quality.covered,
            landmarks: quality
                .landmarks
                .iter()
                .map(|l| LandmarkErrorJson {
                    name: l.name.clone(),
                    given_mm: l.given_mm.into(),
                    error_mm: l.error_mm,
                    held: l.used == LandmarkUse::Held,
                })
                .collect(),
            scaled_jacobian: quality.scaled_jacobian,
            inverted_cells: quality.inverted,
            muscles: quality
                .muscles
                .iter()
                .map(|m| MuscleLengthJson {
                    name: m.name.clone(),
                    length_mm: m.length_mm,
                    template_mm: m.template_mm,
                })
                .collect(),
            depths: quality
                .depths
                .iter()
                .map(|d| DepthJson {
                    landmark: d.name.clone(),
                    depth_mm: d.depth_mm,
                    template_mm: d.template_mm,
                })
                .collect(),
            asymmetry: quality
                .asymmetry
                .iter()
                .map(|a| AsymmetryJson { name: a.name.clone(), distance_mm: a.distance_mm })
                .collect(),
            warnings: registration.warnings.iter().map(RegistrationWarning::to_string).collect(),
            inputs,
            timings_s,
            version: env!("CARGO_PKG_VERSION").to_owned(),
        }
    }
}

/// The JSON schema of `registration.json`, as in `schemas/registration.schema.json`.
pub fn registration_schema() -> String {
    let settings = SchemaSettings::draft2020_12().for_serialize();
    let schema: Schema = super::schema::schema_of::<RegistrationJson>(settings);
    super::schema::pretty(&schema)
}
