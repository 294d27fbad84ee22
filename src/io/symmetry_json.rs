//! What `modiolus symmetry` tells.

use schemars::generate::SchemaSettings;
use schemars::{JsonSchema, Schema};
use serde::Serialize;

use super::{IntervalJson, SideJson};
use crate::face::{PairSymmetry, Symmetry};

/// How far the two sides of a moved face are from mirror images. Lengths mm, angles degrees, activations 0 to 1; left is the
/// subject's.
#[derive(Clone, Debug, PartialEq, Serialize, JsonSchema)]
#[schemars(title = "Modiolus symmetry", deny_unknown_fields)]
pub struct SymmetryJson {
    /// What was measured.
    pub result: String,
    /// Landmarks of both sides.
    pub pairs: Vec<PairJson>,
    /// Landmarks in the middle.
    pub middle: Vec<MiddleJson>,
    /// Root mean square of the differences of the pairs, mm.
    pub mirror_rms_mm: f64,
    /// Root mean square of the differences over the nodes of the skin, mm; null where no skin has skin opposite.
    pub skin_rms_mm: Option<f64>,
    /// Largest difference of a pair, mm; null without pairs.
    pub largest_mm: Option<f64>,
    /// Whether the largest difference is within what was allowed; null when nothing was.
    pub within: Option<bool>,
    /// By how much the noise was raised for the residuals to be likely; null where nothing was fitted.
    pub noise_factor: Option<f64>,
    /// Activations of the muscles of both sides, with the intervals that the data leave where they were fitted.
    pub activations: Vec<SideJson>,
    /// What the published limits are.
    pub published: Vec<PublishedJson>,
}

/// A landmark of both sides.
#[derive(Clone, Debug, PartialEq, Serialize, JsonSchema)]
#[schemars(deny_unknown_fields)]
pub struct PairJson {
    /// Its name without the side.
    pub name: String,
    /// Distance at rest between the one and the mirror image of the other.
    pub rest_mm: f64,
    /// Movement of the left one.
    pub left_mm: [f64; 3],
    /// Movement of the right one.
    pub right_mm: [f64; 3],
    /// Lengths of the movements, left and right.
    pub excursion_mm: [f64; 2],
    /// The lesser length divided by the greater; null where neither moves.
    pub excursion_ratio: Option<f64>,
    /// Directions seen from the front above the outward horizontal, left and right.
    pub direction_deg: [Option<f64>; 2],
    /// Height of the left one above the right one, less that at rest.
    pub height_mm: f64,
    /// Difference between the left movement and the mirror image of the right one.
    pub difference_mm: f64,
}

/// A landmark in the middle.
#[derive(Clone, Debug, PartialEq, Serialize, JsonSchema)]
#[schemars(deny_unknown_fields)]
pub struct MiddleJson {
    /// Its name.
    pub name: String,
    /// Its movement to the subject's left.
    pub to_left_mm: f64,
}

/// A published limit.
#[derive(Clone, Debug, PartialEq, Serialize, JsonSchema)]
#[schemars(deny_unknown_fields)]
pub struct PublishedJson {
    /// What of.
    pub of: String,
    /// Least and greatest, mm.
    pub mm: [f64; 2],
    /// Where it comes from.
    pub source: String,
}

impl SymmetryJson {
    /// Of the face that `result` calls; the pairs may differ by `most_mm`, where that is given.
    pub fn new(
        result: String,
        symmetry: &Symmetry,
        (sides, noise_factor): (Vec<SideJson>, Option<f64>),
        most_mm: Option<f64>,
    ) -> Self {
        let seen: Vec<f64> = symmetry.map_mm.iter().copied().filter(|mm| mm.is_finite()).collect();
        let largest_mm = symmetry.worst().map(PairSymmetry::difference_mm);
        let squares: f64 = seen.iter().map(|mm| mm * mm).sum();
        Self {
            result,
            pairs: symmetry.pairs.iter().map(PairJson::from).collect(),
            middle: symmetry
                .middle
                .iter()
                .map(|(name, mm)| MiddleJson { name: name.clone(), to_left_mm: *mm })
                .collect(),
            mirror_rms_mm: symmetry.mirror_rms_mm,
            skin_rms_mm: (!seen.is_empty()).then(|| (squares / seen.len() as f64).sqrt()),
            largest_mm,
            within: most_mm.zip(largest_mm).map(|(most, largest)| largest <= most),
            noise_factor,
            activations: sides,
            published: published(),
        }
    }
}

impl From<&PairSymmetry> for PairJson {
    fn from(pair: &PairSymmetry) -> Self {
        Self {
            name: pair.name.clone(),
            rest_mm: pair.rest_mm,
            left_mm: pair.left_mm.into(),
            right_mm: pair.right_mm.into(),
            excursion_mm: pair.excursion_mm(),
            excursion_ratio: pair.excursion_ratio(),
            direction_deg: pair.direction_deg(),
            height_mm: pair.height_mm,
            difference_mm: pair.difference_mm(),
        }
    }
}

/// The sides of activations that were given, not fitted: there is no doubt about them.
pub fn given_side(name: &str, left: f64, right: f64) -> SideJson {
    let exactly = |value: f64| IntervalJson { value, min: value, max: value };
    let odd = (left - right) / 2.;
    SideJson {
        name: name.to_owned(),
        even: exactly((left + right) / 2.),
        odd: exactly(odd),
        least_odd: Some(odd),
        uneven: odd != 0.,
    }
}

fn published() -> Vec<PublishedJson> {
    let limit = |of: &str, mm: [f64; 2], source: &str| PublishedJson {
        of: of.to_owned(),
        mm,
        source: source.to_owned(),
    };
    vec![
        limit(
            "smallest change that a repeated posed smile shows for certain",
            [0., 1.5],
            "Tanikawa 2018, n 12",
        ),
        limit("the same at maximal effort", [0., 1.3], "Tanikawa 2018, n 12"),
        limit(
            "difference of the corners of the mouth in social smiles of healthy people aged 13 to 25",
            [-3.85, 2.71],
            "Angle Orthod 87:96 (2017), n 30",
        ),
        limit(
            "difference of the corners of the mouth up to which observers see none",
            [0., 3.],
            "Chu 2011, 10.1001/archfacial.2010.101; Hohman 2014, n 145, 10.1002/lary.24331",
        ),
    ]
}

/// The JSON schema of what `modiolus symmetry --json` prints, as in `schemas/symmetry.schema.json`.
pub fn symmetry_schema() -> String {
    let settings = SchemaSettings::draft2020_12().for_serialize();
    let schema: Schema = super::schema::schema_of::<SymmetryJson>(settings);
    super::schema::pretty(&schema)
}
