//! Reads volume meshes, in whatever format they are.

use std::path::Path;

use super::format::{Format, named_by_ending};
use super::mesh_document::MeshDocument;
use super::mesh_file_error::{MeshFileError, MeshFileErrorKind};
use super::{InputFile, Location, feb, inp, msh, tetgen, text, vtk};
use crate::mesh::Mesh;
use crate::units::LengthUnit;

const READ: &str = "VTU, VTK, Gmsh, Abaqus, TetGen and FEBio";

/// The volume mesh in `path` whose lengths are in `unit`, in mm: [`read_mesh_document`] without what is said
/// about the file.
///
/// # Errors
/// As [`read_mesh_document`].
pub fn read_mesh(path: &Path, unit: LengthUnit) -> Result<Mesh, MeshFileError> {
    read_mesh_document(path, unit).map(|document| document.mesh)
}

/// The volume mesh in `path` whose lengths are in `unit`, in mm. The content decides the format: VTK (`.vtu`,
/// `.vtk`), Gmsh 2.2 and 4.1, Abaqus, TetGen or FEBio; `docs/formats.md` says what is read of each.
///
/// Wedges are taken in either of the two node orders in use. Points, lines and faces are no cells; their groups become
/// node sets. Arrays of zeros and ones in a VTK file become sets of their name, other arrays of few whole numbers sets
/// `name=value`. The mesh is complete (every node of every cell exists, every position is finite) but not yet checked
/// for soundness: [`validate`](crate::mesh::validate) does that.
///
/// # Errors
/// With file, line or byte, field, value and fix, whenever the file is not such a mesh.
pub fn read_mesh_document(path: &Path, unit: LengthUnit) -> Result<MeshDocument, MeshFileError> {
    parse_mesh(&text::read_bytes(path)?, path, unit)
}

/// The mesh in `bytes`; `path` is named in messages, and files that the mesh includes or that lie beside it are looked
/// for there.
///
/// # Errors
/// As [`read_mesh_document`].
pub fn parse_mesh(bytes: &[u8], path: &Path, unit: LengthUnit) -> Result<MeshDocument, MeshFileError> {
    let parse = match Format::of(path, bytes) {
        Some(Format::VtkXml) => vtk::parse_xml,
        Some(Format::VtkLegacy) => vtk::parse_legacy,
        Some(Format::Msh) => msh::parse,
        Some(Format::Inp) => inp::parse,
        Some(Format::Feb) => feb::parse,
        Some(Format::TetGen) => tetgen::parse,
        Some(Format::Stl | Format::Ply | Format::Obj) => {
            let what = "a surface in place of a volume mesh".to_owned();
            let fix = "fill it with cells, as Gmsh or TetGen do, and export those";
            let kind = MeshFileErrorKind::UnsupportedFormat { what, fix };
            return Err(MeshFileError::new(Location::file(path), kind));
        }
        None => {
            text::text(path, bytes)?;
            let kind = MeshFileErrorKind::Unrecognised { formats: named_by_ending(path, READ) };
            return Err(MeshFileError::new(Location::file(path), kind));
        }
    };
    let mut document = parse(path, bytes)?;
    if document.files.is_empty() {
        document.files.push(InputFile::new(path, bytes));
    }
    let mesh = &mut document.mesh;
    let nothing = |what| Err(MeshFileError::new(Location::file(path), MeshFileErrorKind::Nothing { what }));
    if mesh.points.is_empty() {
        return nothing("nodes");
    }
    if mesh.cells.is_empty() {
        return nothing("volume elements");
    }
    mesh.orient_wedges();
    mesh.points.iter_mut().for_each(|p| *p *= unit.in_mm());
    Ok(document)
}
