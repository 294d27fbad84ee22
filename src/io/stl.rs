//! STL: triangles, ASCII and binary.

use std::path::Path;

use super::mesh_file_error::{MeshFileError, MeshFileErrorKind};
use super::polygons::Polygons;
use super::{Location, text};
use crate::mesh::Surface;
use crate::units::Vec3;

type Result<T> = std::result::Result<T, MeshFileError>;

/// Bytes before the triangles of a binary file: a header and a count.
const HEAD: usize = 84;
/// Bytes of a binary triangle: a normal, three corners, and an attribute.
const EACH: usize = 50;

/// The surface in the STL file `file` whose content is `bytes`, in the file's unit. Normals are not read: the order
/// of the corners says which side is outside.
pub(super) fn parse(file: &Path, bytes: &[u8]) -> Result<Surface> {
    // Binary files may begin with `solid` too, but are exactly as long as they say.
    let count = bytes.get(80..HEAD).and_then(|count| count.first_chunk::<4>());
    let whole = |count: &[u8; 4]| bytes.len() as u64 == 84 + 50 * u64::from(u32::from_le_bytes(*count));
    if count.is_some_and(whole) { binary(file, bytes) } else { ascii(file, bytes) }
}

fn binary(file: &Path, bytes: &[u8]) -> Result<Surface> {
    let mut polygons = Polygons::default();
    for (k, triangle) in bytes[HEAD..].chunks_exact(EACH).enumerate() {
        let at = || Location::file(file).at_byte(HEAD + EACH * k).in_field("vertex");
        let numbers = triangle[12..48].chunks_exact(4).map(|w| f32::from_le_bytes([w[0], w[1], w[2], w[3]]));
        let numbers: Vec<f64> = numbers.map(f64::from).collect();
        if let Some(x) = numbers.iter().find(|x| !x.is_finite()) {
            return Err(MeshFileError::new(at(), MeshFileErrorKind::NotFinite { value: x.to_string() }));
        }
        add(&mut polygons, &numbers, at)?;
    }
    polygons.surface(&Location::file(file))
}

fn ascii(file: &Path, bytes: &[u8]) -> Result<Surface> {
    let text = text::text(file, bytes)?;
    let mut polygons = Polygons::default();
    let mut corners: Vec<f64> = Vec::new();
    let mut open = false;
    for (k, line) in text.lines().enumerate() {
        let at = || Location::file(file).at_line(k + 1);
        let mut words = line.split_whitespace();
        let Some(word) = words.next() else { continue };
        match word.to_ascii_lowercase().as_str() {
            "vertex" => {
                let numbers: Vec<&str> = words.collect();
                let [_, _, _] = numbers[..] else {
                    let (expected, found) = ("vertex x y z".to_owned(), text::shown(line));
                    return Err(MeshFileError::new(at(), MeshFileErrorKind::Syntax { expected, found }));
                };
                for (number, field) in numbers.into_iter().zip(["x", "y", "z"]) {
                    corners.push(text::number(number, || at().in_field(field))?);
                }
            }
            "endloop" => {
                if corners.len() != 9 {
                    let (what, declared, found) =
                        ("vertices of a facet".to_owned(), 3, corners.len() as u64 / 3);
                    return Err(MeshFileError::new(
                        at(),
                        MeshFileErrorKind::CountMismatch { what, declared, found },
                    ));
                }
                add(&mut polygons, &corners, at)?;
                corners.clear();
            }
            "solid" => open = true,
            "endsolid" | "end" => open = false,
            "facet" | "outer" | "endfacet" | "color" => {}
            other => {
                let expected = "a statement of STL (solid, facet, outer loop, vertex, ...)".to_owned();
                let found = text::shown(other);
                return Err(MeshFileError::new(at(), MeshFileErrorKind::Syntax { expected, found }));
            }
        }
    }
    if open || !corners.is_empty() {
        let kind = MeshFileErrorKind::Truncated { expected: "endsolid".to_owned() };
        return Err(MeshFileError::new(Location::file(file).at_line(text.lines().count()), kind));
    }
    polygons.surface(&Location::file(file))
}

fn add(polygons: &mut Polygons, numbers: &[f64], at: impl FnOnce() -> Location) -> Result<()> {
    let first = polygons.n_vertices();
    for p in numbers.chunks_exact(3) {
        polygons.vertex(Vec3::from_column_slice(p));
    }
    polygons.polygon(&[first, first + 1, first + 2], at)
}
