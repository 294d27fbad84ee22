//! The folder that an answer was written to, read back.

use std::collections::BTreeMap;
use std::path::{Path, PathBuf};

use serde::Deserialize;
use thiserror::Error;

use super::{
    CertaintyJson, CertificateJson, ContactJson, DeformationJson, FeatureJson, LimitJson, MarkerJson,
    MeshFileError, ResidualJson, StatusWord, TargetJson, WriteError, input, settle_folder, sha256, vtk,
};

/// What others need of an answer: the face that it moves, by how much, and by which muscles.
#[derive(Clone, Debug, PartialEq)]
pub struct AnswerFiles {
    /// The face: the name of a built-in face, or the path of its face.toml as it was given.
    pub face: String,
    /// How the fit ended; `None` where the file does not say.
    pub status: Option<StatusWord>,
    /// The target that was fitted, if one was.
    pub target: Option<TargetJson>,
    /// How strain was measured.
    pub strain: String,
    /// How the stiffness of the muscles was taken.
    pub stiffness: String,
    /// How strong the muscles were.
    pub strength: f64,
    /// How contact was treated; empty where the file does not say.
    pub contact_mode: String,
    /// Size of the marker residuals, mm; `None` where there are none.
    pub residual_mm: Option<ResidualJson>,
    /// Share of the observed movement that is explained; `None` where nothing was seen to move.
    pub explained: Option<f64>,
    /// How each marker was met.
    pub markers: Vec<MarkerJson>,
    /// How each feature was met.
    pub features: Vec<FeatureJson>,
    /// The limits that hold the answer back.
    pub active_limits: Vec<LimitJson>,
    /// Residuals of the program; `None` where nothing was fitted.
    pub certificate: Option<CertificateJson>,
    /// How far the tissue is strained; `None` where the file does not say.
    pub deformation: Option<DeformationJson>,
    /// What is odd about the target or the answer.
    pub warnings: Vec<String>,
    /// What is odd about the face.
    pub face_warnings: Vec<String>,
    /// Contact; `None` when it is off.
    pub contact: Option<ContactJson>,
    /// SHA-256 of each input file, by its name on the command line.
    pub inputs: BTreeMap<String, String>,
    /// Activation of each muscle, 0 to 1.
    pub activations: BTreeMap<String, f64>,
    /// How far the jaw is open, mm, where that was said.
    pub jaw_opening_mm: Option<f64>,
    /// Displacement (3n), mm, node-major xyz.
    pub displacement: Vec<f64>,
    /// Contact pressure of the nodes (n), kPa; `None` without contact.
    pub pressure_kpa: Option<Vec<f64>>,
    /// The file that holds the displacement.
    pub vtu: PathBuf,
    /// What the data determine of it; `None` where nothing was fitted.
    pub certainty: Option<CertaintyJson>,
    /// The face that was written with the answer, as surgery does.
    pub operated: Option<PathBuf>,
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
    /// A file of another run, or one that was changed since.
    #[error("{}: is not the file that was written with solution.json; compute the answer again, or put its own files back", .0.display())]
    Foreign(PathBuf),
    /// An answer that moves nothing.
    #[error("{}: the answer has no displacement, so that there is nothing to draw, compare or export", .0.display())]
    NoDisplacement(PathBuf),
    /// The files that a process which ended had written cannot be put in place.
    #[error(transparent)]
    Unsettled(#[from] WriteError),
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
    target: Option<TargetJson>,
    status: Option<StatusWord>,
    residual_mm: Option<ResidualJson>,
    explained: Option<f64>,
    #[serde(default)]
    features: Vec<FeatureJson>,
    #[serde(default)]
    active_limits: Vec<LimitJson>,
    certificate: Option<CertificateJson>,
    deformation: Option<DeformationJson>,
    #[serde(default)]
    warnings: Vec<String>,
    #[serde(default)]
    face_warnings: Vec<String>,
    // Earlier versions did not say all of this.
    #[serde(default)]
    strain: String,
    #[serde(default)]
    stiffness: String,
    #[serde(default)]
    strength: f64,
    #[serde(default)]
    contact_mode: String,
    activations: BTreeMap<String, f64>,
    jaw_opening_mm: Option<f64>,
    #[serde(default)]
    markers: Vec<MarkerJson>,
    contact: Option<ContactJson>,
    #[serde(default)]
    inputs: BTreeMap<String, String>,
    certainty: Option<CertaintyJson>,
    files: BTreeMap<String, String>,
}

/// The answer in the folder `dir`: `solution.json` and the vectors `displacement` of `face.vtu`, which must be the files
/// that were written together.
///
/// # Errors
/// [`AnswerFileError`] naming the folder, or the file and the field.
pub fn read_answer(dir: &Path) -> Result<AnswerFiles, AnswerFileError> {
    if !dir.is_dir() {
        return Err(AnswerFileError::NoFolder(dir.to_owned()));
    }
    settle_folder(dir)?;
    let path = dir.join("solution.json");
    let json = read(&path, input::TEXT_BYTES)?;
    let head: Head = serde_json::from_slice(&json)
        .map_err(|reason| AnswerFileError::Json { path: path.clone(), reason })?;
    let vtu = dir.join("face.vtu");
    let (mut displacement, mut pressure_kpa) = (None, None);
    for (name, sha) in &head.files {
        let file = dir.join(name);
        let bytes = read(&file, input::MESH_BYTES)?;
        if sha256(&bytes) != *sha {
            return Err(AnswerFileError::Foreign(file));
        }
        if file == vtu {
            displacement = Some(vtk::point_vectors(&vtu, &bytes, "displacement")?);
            pressure_kpa = vtk::point_scalars(&vtu, &bytes, "contact_pressure_kpa")?;
        }
    }
    let displacement = displacement.ok_or(AnswerFileError::NoDisplacement(path))?;
    let operated = head.files.contains_key("face.toml").then(|| dir.join("face.toml"));
    let Head { face, target, strain, stiffness, strength, contact_mode, .. } = head;
    let Head { activations, jaw_opening_mm, markers, contact, certainty, inputs, .. } = head;
    let Head { status, residual_mm, explained, features, active_limits, certificate, .. } = head;
    let Head { deformation, warnings, face_warnings, .. } = head;
    Ok(AnswerFiles {
        status,
        residual_mm,
        explained,
        features,
        active_limits,
        certificate,
        deformation,
        warnings,
        face_warnings,
        pressure_kpa,
        face,
        target,
        strain,
        stiffness,
        strength,
        contact_mode,
        markers,
        contact,
        inputs,
        activations,
        jaw_opening_mm,
        displacement,
        vtu,
        certainty,
        operated,
    })
}

fn read(path: &Path, most: u64) -> Result<Vec<u8>, AnswerFileError> {
    input::read(path, most).map_err(|reason| AnswerFileError::Missing { path: path.to_owned(), reason })
}
