//! The face that the options name, checked, with the fingerprints of its files.

use std::collections::BTreeMap;
use std::path::Path;

use modiolus::face::{Face, Pose, standard, standard::Resolution};
use modiolus::io::{FaceDocument, FaceFileErrorKind, UnreadableText, nearest, read_face};

use super::arguments::FaceChoice;
use super::error::CliError;
use super::progress::Progress;

/// A face that can be computed with.
#[derive(Clone)]
pub(crate) struct LoadedFace {
    pub(crate) face: Face,
    /// The name of a built-in face, or the path as given.
    pub(crate) name: String,
    /// How messages call it: its path, or "the standard face".
    pub(crate) called: String,
    pub(crate) warnings: Vec<String>,
    /// SHA-256 of its files, by path.
    pub(crate) inputs: BTreeMap<String, String>,
}

pub(crate) fn load(choice: &FaceChoice, progress: &mut Progress) -> Result<LoadedFace, CliError> {
    progress.step("read_face", || match choice {
        FaceChoice::Standard(resolution) => {
            let face = standard(resolution);
            let called = match *resolution {
                Resolution::COARSE => "the coarse standard face",
                Resolution::FINE => "the fine standard face",
                _ => "the standard face",
            };
            let called = called.to_owned();
            let (errors, odd) = face.check();
            if !errors.is_empty() {
                return Err(CliError::Face { face: called, errors });
            }
            let warnings = odd.iter().map(ToString::to_string).collect();
            let name = face.name.clone();
            Ok(LoadedFace { face, name, called, warnings, inputs: BTreeMap::new() })
        }
        FaceChoice::File(path) => {
            let FaceDocument { face, warnings, files } = read_face(path, None).map_err(|error| {
                let is_missing = matches!(error.kind, FaceFileErrorKind::Unreadable(UnreadableText::Missing));
                match path.to_str().and_then(|name| nearest(&name.to_lowercase(), Resolution::FACES)) {
                    Some(face) if is_missing => CliError::MisspeltFace { path: path.clone(), face },
                    _ => error.into(),
                }
            })?;
            let warnings = warnings.iter().map(ToString::to_string).collect();
            let inputs = files.iter().map(|file| (input_name(&file.path), file.sha256.clone())).collect();
            let called = path.display().to_string();
            let name = called.replace('\\', "/");
            Ok(LoadedFace { face, name, called, warnings, inputs })
        }
    })
}

impl LoadedFace {
    /// The name under which target files state results for this face; `None` for a file that takes the name of a
    /// built-in face, whose results are not its own.
    pub(crate) fn stated_as(&self) -> Option<&str> {
        let own = &self.face.name;
        (*own == self.name || Resolution::of_face(own).is_none()).then_some(own)
    }

    /// The same face with muscles `factor` times as strong.
    pub(crate) fn with_strength(self, factor: f64) -> Self {
        Self { face: self.face.with_strength(factor), ..self }
    }
}

/// Where the bones are with the jaw open by so many mm.
pub(crate) fn pose(face: &Face, jaw_opening_mm: Option<f64>) -> Pose {
    face.jaw.as_ref().zip(jaw_opening_mm).map(|(jaw, q)| Pose::opened(jaw, q)).unwrap_or_default()
}

/// How answers call an input file.
pub(crate) fn input_name(path: &Path) -> String {
    path.display().to_string().replace('\\', "/")
}
