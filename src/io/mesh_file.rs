//! Reads volume meshes by the file's extension.

use std::path::Path;

use super::mesh_file_error::{MeshFileError, MeshFileErrorKind};
use super::{Location, inp, msh, text, vtu};
use crate::mesh::Mesh;
use crate::units::LengthUnit;

/// The volume mesh in `path` (`.vtu`, `.msh` or `.inp`) whose lengths are in `unit`, in mm.
///
/// Wedges are taken in either of the two node orders in use. Points, lines and faces are no cells; their groups become node sets. Arrays of zeros and
/// ones in a VTU become sets of their name, other arrays of few whole numbers sets `name=value`. The mesh
/// is complete (every node of every cell exists, every position is finite) but not yet checked for
/// soundness: [`validate`](crate::mesh::validate) does that.
///
/// # Errors
/// With file, line or byte, field, value and fix, whenever the file is not such a mesh.
pub fn read_mesh(path: &Path, unit: LengthUnit) -> Result<Mesh, MeshFileError> {
    parse_mesh(path, &text::read_bytes(path)?, unit)
}

/// The volume mesh in the `bytes` of the file `path`, as [`read_mesh`] has it.
pub(super) fn parse_mesh(path: &Path, bytes: &[u8], unit: LengthUnit) -> Result<Mesh, MeshFileError> {
    let extension = path.extension().and_then(|e| e.to_str()).unwrap_or_default().to_ascii_lowercase();
    let parse = match extension.as_str() {
        "vtu" => vtu::parse,
        "msh" => msh::parse,
        "inp" => inp::parse,
        _ => {
            let what = format!("a mesh file with extension `{extension}`");
            let fix = "export as .vtu, .msh (Gmsh 2.2 or 4.1) or .inp (Abaqus)";
            return Err(MeshFileError::new(
                Location::file(path),
                MeshFileErrorKind::UnsupportedFormat { what, fix },
            ));
        }
    };
    let mut mesh = parse(path, bytes)?;
    let nothing = |what| Err(MeshFileError::new(Location::file(path), MeshFileErrorKind::Nothing { what }));
    if mesh.points.is_empty() {
        return nothing("nodes");
    }
    if mesh.cells.is_empty() {
        return nothing("volume elements");
    }
    mesh.orient_wedges();
    mesh.points.iter_mut().for_each(|p| *p *= unit.in_mm());
    Ok(mesh)
}
