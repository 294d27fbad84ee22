//! The result that stands where another would be written.

use std::collections::BTreeMap;
use std::fs;
use std::path::Path;

use serde::Deserialize;

use super::{WriteError, input, settle_folder};

/// What a folder holds before it is written to.
#[derive(Clone, Debug, PartialEq, Eq)]
pub enum Standing {
    /// No result.
    Nothing,
    /// A result, of this face and these input files.
    Result {
        /// The face, as it was given.
        face: String,
        /// The input files, by their names on the command line.
        inputs: Vec<String>,
    },
    /// A `solution.json` that is none.
    Foreign,
}

#[derive(Deserialize)]
struct Head {
    face: String,
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
        Ok(head.map_or(Self::Foreign, |Head { face, inputs }| Self::Result {
            face,
            inputs: inputs.into_keys().collect(),
        }))
    }

    /// Whether a result of `face` that was computed from the file `input` may take its place: there is none, or it is an
    /// earlier one of the same face and file.
    pub fn gives_way(&self, face: &str, input: &Path) -> bool {
        let same = |a: &Path, b: &Path| {
            a == b || fs::canonicalize(a).is_ok_and(|a| fs::canonicalize(b).is_ok_and(|b| a == b))
        };
        match self {
            Self::Nothing => true,
            Self::Foreign => false,
            Self::Result { face: own, inputs } => {
                same(own.as_ref(), face.as_ref()) && inputs.iter().any(|i| same(i.as_ref(), input))
            }
        }
    }
}
