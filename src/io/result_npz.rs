//! A result as NumPy arrays.

use std::io;

use super::npz::Npz;
use super::{AnswerFiles, ProgramFile};
use crate::face::Face;

/// A result as NumPy arrays: the whole field, the rows of the landmarks beside it, the markers, and the program of the answer
/// where something was fitted.
///
/// `points` (n, 3) and `displacement` (n, 3), mm, in the order of the mesh; `contact_pressure_kpa` (n) where there is contact;
/// `landmarks` (l) names, `landmark_points` (l, 3), `landmark_displacement` (l, 3), mm; `muscles` (m) names, `activation` (m),
/// 0 to 1; `jaw_opening_mm` (), zero where the jaw rests; `markers` (k) names, `marker_target` (k, 3), NaN where a component
/// was not observed, and `marker_model` (k, 3), displacements, mm; then those of its program
/// (`P`, `q`, ...).
///
/// # Errors
/// [`io::Error`] when the archive cannot be put together.
pub fn result_npz(
    face: &Face,
    answer: &AnswerFiles,
    program: Option<&ProgramFile<'_>>,
) -> io::Result<Vec<u8>> {
    let mut file = Npz::new();
    let nodes = [face.mesh.n_nodes() as u64, 3];
    file.numbers("points", &nodes, face.mesh.points.iter().flat_map(|p| [p.x, p.y, p.z]))?;
    file.numbers("displacement", &nodes, answer.displacement.iter().copied())?;
    if let Some(pressure) = &answer.pressure_kpa {
        file.numbers("contact_pressure_kpa", &nodes[..1], pressure.iter().copied())?;
    }
    file.landmarks(&face.landmarks, &[], &[&answer.displacement])?;
    let muscles: Vec<String> = face.muscles.iter().map(|muscle| muscle.name.clone()).collect();
    let activation = muscles.iter().map(|name| answer.activations.get(name).copied().unwrap_or(0.));
    file.numbers("activation", &[muscles.len() as u64], activation)?;
    file.names("muscles", &muscles)?;
    file.numbers("jaw_opening_mm", &[], [answer.jaw_opening_mm.unwrap_or(0.)])?;
    let markers: Vec<String> = answer.markers.iter().map(|marker| marker.name.clone()).collect();
    let rows = [markers.len() as u64, 3];
    let target = answer.markers.iter().flat_map(|marker| marker.target_mm);
    file.names("markers", &markers)?;
    file.numbers("marker_target", &rows, target.map(|mm| mm.unwrap_or(f64::NAN)))?;
    file.numbers("marker_model", &rows, answer.markers.iter().flat_map(|marker| marker.model_mm))?;
    if let Some(program) = program {
        program.put(&mut file)?;
    }
    file.finish()
}
