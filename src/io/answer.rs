//! The folder that an answer was written to, read back.

use std::collections::BTreeMap;
use std::path::{Path, PathBuf};

use serde::Deserialize;
use thiserror::Error;

use super::{MeshFileError, input, text, vtk};

/// What a picture needs of an answer: the face that it moves, by how much, and by which muscles.
#[derive(Clone, Debug, PartialEq)]
pub struct AnswerFiles {
    /// The face: "standard", or the path of its face.toml as it was given.
    pub face: String,
    /// Activation of each muscle, 0 to 1.
    pub activations: BTreeMap<String, f64>,
    /// How far the jaw is open, mm, where that was said.
    pub jaw_opening_mm: Option<f64>,
    /// Displacement (3n), mm, node-major xyz.
    pub displacement: Vec<f64>,
    /// The file that holds the displacement.
    pub vtu: PathBuf,
}

/// A folder that holds no answer to draw.
#[derive(Debug, Error)]
#[non_exhaustive]
pub enum AnswerFileError {
    /// No such folder.
    #[error("{}: there is no such folder; give one that fit or forward wrote, or a face.toml, or \"standard\"", .0.display())]
    NoFolder(PathBuf),
    /// A file that is missing or cannot be read.
    #[error("{}: cannot be read: {reason}; give a folder that fit or forward wrote", path.display())]
    Missing {
        /// The file.
        path: PathBuf,
        /// Why not.
        reason: std::io::Error,
    },
    /// A `solution.json` without what is needed.
    #[error("{}: {reason}; write it again with fit or forward", path.display())]
    Json {
        /// The file.
        path: PathBuf,
        /// What is wrong, with line and column.
        reason: serde_json::Error,
    },
    /// A `face.vtu` without displacement, or not one.
    #[error(transparent)]
    Vtu(#[from] MeshFileError),
}

#[derive(Deserialize)]
struct Head {
    face: String,
    activations: BTreeMap<String, f64>,
    jaw_opening_mm: Option<f64>,
}

/// The answer in the folder `dir`: `solution.json` and the vectors `displacement` of `face.vtu`.
///
/// # Errors
/// [`AnswerFileError`] naming the folder, or the file and the field.
pub fn read_answer(dir: &Path) -> Result<AnswerFiles, AnswerFileError> {
    if !dir.is_dir() {
        return Err(AnswerFileError::NoFolder(dir.to_owned()));
    }
    let path = dir.join("solution.json");
    let json = input::read(&path, input::TEXT_BYTES)
        .map_err(|reason| AnswerFileError::Missing { path: path.clone(), reason })?;
    let head: Head =
        serde_json::from_slice(&json).map_err(|reason| AnswerFileError::Json { path, reason })?;
    let vtu = dir.join("face.vtu");
    if !vtu.is_file() {
        let reason = std::io::ErrorKind::NotFound.into();
        return Err(AnswerFileError::Missing { path: vtu, reason });
    }
    let displacement = vtk::point_vectors(&vtu, &text::read_bytes(&vtu)?, "displacement")?;
    let Head { face, activations, jaw_opening_mm } = head;
    Ok(AnswerFiles { face, activations, jaw_opening_mm, displacement, vtu })
}
