//! What several targets gave, `--json` of a suite.

use std::collections::BTreeMap;

use schemars::generate::SchemaSettings;
use schemars::{JsonSchema, Schema};
use serde::Serialize;

use super::StatusWord;
use super::solution_json::to_text;
use crate::study::Verdict;

/// Several targets fitted on one face, and whether they gave what their files state. Lengths mm, times s;
/// byte-identical from run to run apart from `timings_s`.
#[derive(Clone, Debug, PartialEq, Serialize, JsonSchema)]
#[schemars(title = "Modiolus suite", deny_unknown_fields)]
pub struct SuiteJson {
    /// The face: the name of a built-in face, or the path of its face.toml as given.
    pub face: String,
    /// The name that the face has in `[[expected]]`.
    pub face_name: String,
    /// How strain was measured: "linear" or "finite".
    pub strain: String,
    /// How the stiffness of the muscles was taken: "activated" or "fixed=A".
    pub stiffness: String,
    /// How strong the muscles were, as a multiple of the face's `max_force_n`.
    pub strength: f64,
    /// Each target, in the order given; those of a folder by the names of their files.
    pub targets: Vec<SuiteTargetJson>,
    /// Targets that passed.
    pub passed: usize,
    /// Targets that did not.
    pub failed: usize,
    /// Targets that were not held against anything, because nothing is stated.
    pub skipped: usize,
    /// Wall time of each fit by the target's name, and of everything as "all", s.
    pub timings_s: BTreeMap<String, f64>,
    /// SHA-256 of each input file, by its name on the command line.
    pub inputs: BTreeMap<String, String>,
    /// Version of the program.
    pub version: String,
}

/// What one target gave.
#[derive(Clone, Debug, PartialEq, Serialize, JsonSchema)]
#[schemars(deny_unknown_fields)]
pub struct SuiteTargetJson {
    /// Name of the target.
    pub name: String,
    /// Its file, as given.
    pub file: String,
    /// How the fit ended; null when it stopped with an error.
    pub status: Option<StatusWord>,
    /// Root mean square of the residuals of markers and features, mm; null without an answer.
    pub found_rms_mm: Option<f64>,
    /// The same as the file states it for this face, mm; null when it states nothing.
    pub stated_rms_mm: Option<f64>,
    /// How far the one may be from the other, mm.
    pub tolerance_mm: Option<f64>,
    /// What the one says to the other.
    pub verdict: VerdictWord,
    /// Whether the target passed: `fit` asks for a solved one, `verify` for one as stated; null when there is nothing to hold
    /// it against.
    pub passed: Option<bool>,
    /// Quadratic programs of the nonlinear fit, as many as factorisations.
    pub programs: usize,
    /// Why nothing is stated, or why there is no answer.
    pub remark: Option<String>,
}

/// What a fit says to the statement of its target file.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, JsonSchema)]
#[serde(rename_all = "snake_case")]
pub enum VerdictWord {
    /// It is solved, and its residual is within the tolerance of the stated one.
    AsStated,
    /// It is not.
    NotAsStated,
    /// The file states nothing for this face and these mechanics.
    NotStated,
}

impl From<Verdict> for VerdictWord {
    fn from(verdict: Verdict) -> Self {
        match verdict {
            Verdict::AsStated => Self::AsStated,
            Verdict::NotAsStated => Self::NotAsStated,
            Verdict::NotStated => Self::NotStated,
        }
    }
}

impl VerdictWord {
    /// The verdict as a table says it.
    pub fn said(self) -> &'static str {
        match self {
            Self::AsStated => "as stated",
            Self::NotAsStated => "NOT as stated",
            Self::NotStated => "not stated",
        }
    }
}

impl SuiteJson {
    /// The text of the JSON, with a final newline, as that of [answers](super::SolutionJson::to_text).
    ///
    /// # Errors
    /// When the text cannot be put together, which no value of the fields brings about.
    pub fn to_text(&self) -> Result<String, serde_json::Error> {
        to_text(self)
    }
}

/// The JSON schema of suites, as in `schemas/suite.schema.json`.
pub fn suite_schema() -> String {
    let settings = SchemaSettings::draft2020_12().for_serialize();
    let schema: Schema = super::schema::schema_of::<SuiteJson>(settings);
    super::schema::pretty(&schema)
}
