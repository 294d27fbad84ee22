//! The result that stands where another would be written.

use std::collections::BTreeMap;
use std::fs;
use std::path::Path;

use serde::Deserialize;

use super::{TargetJson, WriteError, input, settle_folder};

/// What a folder holds before it is written to.
#[derive(Clone, Debug, PartialEq, Eq)]
pub enum Standing {
    /// No result.
    Nothing,
    /// A result, of this face and these input files.
    Result {
        /// The face, as it was given.
        face: String,
        /// Whether a target was fitted.
        is_fit: bool,
        /// The input files, by their names on the command line.
        inputs: Vec<String>,
    },
    /// A `solution.json` that is none.
    Foreign,
}

#[derive(Deserialize)]
struct Head {
    face: String,
    target: Option<TargetJson>,
    inputs: BTreeMap<String, String>,
}

impl Standing {
    /// What stands in `folder`, which need not be there.
    ///
    /// # Errors
    /// [`WriteError`] when files that an ended process had written cannot be put in place.
    pub fn of(folder: &Path) -> Result<Self, WriteError> {
        settle_folder(folder)?;
        let path = folder.join("solution.json");
        if !path.exists() {
            return Ok(Self::Nothing);
        }
        let head =
            input::read(&path, input::TEXT_BYTES).ok().and_then(|text| serde_json::from_slice(&text).ok());
        Ok(head.map_or(Self::Foreign, |Head { face, target, inputs }| Self::Result {
            face,
            is_fit: target.is_some(),
            inputs: inputs.into_keys().collect(),
        }))
    }

    /// Whether a result of `face` and of the target file `target`, or of activations, may take its place: there is none, or
    /// it is an earlier one of the same.
    pub fn gives_way(&self, face: &str, target: Option<&Path>) -> bool {
        let same = |a: &Path, b: &Path| {
            a == b || fs::canonicalize(a).is_ok_and(|a| fs::canonicalize(b).is_ok_and(|b| a == b))
        };
        match self {
            Self::Nothing => true,
            Self::Foreign => false,
            Self::Result { face: own, is_fit, inputs } => {
                let is_own = target.map_or(!is_fit, |t| inputs.iter().any(|i| same(i.as_ref(), t)));
                same(own.as_ref(), face.as_ref()) && is_own
            }
        }
    }
}
