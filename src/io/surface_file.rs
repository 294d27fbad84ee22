//! Reads surfaces, in whatever format they are.

use std::path::Path;

use super::format::{Format, named_by_ending};
use super::mesh_file_error::{MeshFileError, MeshFileErrorKind};
use super::{InputFile, Location, obj, ply, stl, text, vtk};
use crate::mesh::Surface;
use crate::units::LengthUnit;

const READ: &str = "OBJ, STL, PLY, VTP and VTK";

/// The surface in `path` whose lengths are in `unit`, in mm. The content decides the format: OBJ, STL (ASCII and
/// binary), PLY (ASCII and binary), VTP, or polygons in VTU and legacy VTK; `docs/formats.md` says what is read of
/// each.
///
/// Quadrilaterals are split along the shorter diagonal, polygons of more corners by their ears; vertices at exactly
/// the same place are merged, and triangles without area through that dropped. Orientation is that of the file.
///
/// # Errors
/// With the line or byte, whenever the file is not such a surface.
pub fn read_surface(path: &Path, unit: LengthUnit) -> Result<Surface, MeshFileError> {
    parse_surface(&text::read_bytes(path)?, path, unit)
}

/// The surface in `path` as [`read_surface`] reads it, and the file.
///
/// # Errors
/// As [`read_surface`].
pub fn read_surface_file(path: &Path, unit: LengthUnit) -> Result<(Surface, InputFile), MeshFileError> {
    let bytes = text::read_bytes(path)?;
    Ok((parse_surface(&bytes, path, unit)?, InputFile::new(path, &bytes)))
}

/// The surface in `bytes`; `path` is only named in messages.
///
/// # Errors
/// As [`read_surface`].
pub fn parse_surface(bytes: &[u8], path: &Path, unit: LengthUnit) -> Result<Surface, MeshFileError> {
    let parse = match Format::of(path, bytes) {
        Some(Format::Obj) => obj::parse,
        Some(Format::Stl) => stl::parse,
        Some(Format::Ply) => ply::parse,
        Some(Format::VtkXml) => vtk::xml_polygons,
        Some(Format::VtkLegacy) => vtk::legacy_polygons,
        Some(Format::Msh | Format::Inp | Format::Feb | Format::TetGen) => {
            let what = "a volume mesh in place of a surface".to_owned();
            let kind =
                MeshFileErrorKind::UnsupportedFormat { what, fix: "export its surface as OBJ, STL or PLY" };
            return Err(MeshFileError::new(Location::file(path), kind));
        }
        None => {
            text::text(path, bytes)?;
            let kind = MeshFileErrorKind::Unrecognised { formats: named_by_ending(path, READ) };
            return Err(MeshFileError::new(Location::file(path), kind));
        }
    };
    let mut surface = parse(path, bytes)?;
    surface.points.iter_mut().for_each(|p| *p *= unit.in_mm());
    Ok(surface)
}
