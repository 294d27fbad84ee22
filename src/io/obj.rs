//! Wavefront OBJ: surfaces of triangles and quadrilaterals.

use std::collections::HashMap;
use std::path::Path;

use super::mesh_file_error::{MeshFileError, MeshFileErrorKind};
use super::{Location, text};
use crate::mesh::{Surface, first_diagonal};
use crate::units::{LengthUnit, Vec3};

type Result<T> = std::result::Result<T, MeshFileError>;

/// The surface in OBJ file `path`, mm: quadrilaterals split along the shorter diagonal, vertices at
/// exactly the same place merged, triangles without area through that dropped.
///
/// # Errors
/// With the line, whenever the file is not such a surface.
pub fn read_obj(path: &Path, unit: LengthUnit) -> Result<Surface> {
    parse_obj(path, &text::read_bytes(path)?, unit)
}

/// The surface in the `bytes` of the OBJ file `path`, as [`read_obj`] has it.
pub(super) fn parse_obj(path: &Path, bytes: &[u8], unit: LengthUnit) -> Result<Surface> {
    let mut surface = parse(path, bytes)?;
    surface.points.iter_mut().for_each(|p| *p *= unit.in_mm());
    Ok(surface)
}

fn parse(file: &Path, bytes: &[u8]) -> Result<Surface> {
    let text = text::text(file, bytes)?;
    let mut surface = Surface::default();
    let mut vertices: Vec<usize> = Vec::new();
    let mut merged: HashMap<[u64; 3], usize> = HashMap::new();
    for (k, line) in text.lines().enumerate() {
        let at = |field: &str| Location::file(file).at_line(k + 1).in_field(field);
        let fail = |field: &str, kind| Err(MeshFileError::new(at(field), kind));
        let mut words = line.split('#').next().unwrap_or_default().split_whitespace();
        match words.next() {
            Some("v") => {
                let mut p = Vec3::zeros();
                for (x, field) in p.iter_mut().zip(["x", "y", "z"]) {
                    let Some(word) = words.next() else {
                        let found = line.to_owned();
                        return fail(field, MeshFileErrorKind::Syntax { expected: "v x y z".into(), found });
                    };
                    // Adding 0 makes -0 and 0 the same place.
                    *x = text::number(word, || at(field))? + 0.0;
                }
                let key = [p.x, p.y, p.z].map(f64::to_bits);
                vertices.push(*merged.entry(key).or_insert_with(|| {
                    surface.points.push(p);
                    surface.points.len() - 1
                }));
            }
            Some("f") => {
                let corners =
                    words.map(|word| vertex(word, &vertices, || at("f"))).collect::<Result<Vec<usize>>>()?;
                let triangles = match corners[..] {
                    [a, b, c] => vec![[a, b, c]],
                    [a, b, c, d] if first_diagonal([a, b, c, d].map(|v| surface.points[v])) => {
                        vec![[a, b, c], [a, c, d]]
                    }
                    [a, b, c, d] => vec![[a, b, d], [b, c, d]],
                    _ => {
                        let what = format!("a face of {} corners", corners.len());
                        let fix = "export triangles or quadrilaterals";
                        return fail("f", MeshFileErrorKind::UnsupportedFormat { what, fix });
                    }
                };
                let solid = |t: &[usize; 3]| t[0] != t[1] && t[1] != t[2] && t[2] != t[0];
                surface.triangles.extend(triangles.into_iter().filter(solid));
            }
            None | Some("vn" | "vt" | "o" | "g" | "s" | "usemtl" | "mtllib" | "l" | "p") => {}
            Some(word) => {
                let expected = "a statement of a polygon surface (v, vn, vt, f, o, g, s, ...)".to_owned();
                return fail(word, MeshFileErrorKind::Syntax { expected, found: word.to_owned() });
            }
        }
    }
    if surface.triangles.is_empty() {
        let kind = MeshFileErrorKind::Syntax { expected: "faces".into(), found: "none".into() };
        return Err(MeshFileError::new(Location::file(file), kind));
    }
    Ok(surface)
}

/// The vertex that `word` (`7`, `7/1`, `7//3`, `-1`) names.
fn vertex(word: &str, vertices: &[usize], at: impl Fn() -> Location) -> Result<usize> {
    let number = text::integer(word.split('/').next().unwrap_or(word), &at)?;
    let position = match number {
        1.. => number - 1,
        0 => -1,
        _ => vertices.len() as i128 + number,
    };
    usize::try_from(position).ok().and_then(|k| vertices.get(k).copied()).ok_or_else(|| {
        let kind =
            MeshFileErrorKind::MissingNode { what: "face", id: word.to_owned(), node: number.to_string() };
        MeshFileError::new(at(), kind)
    })
}

#[cfg(test)]
mod tests {
    use super::*;

    fn read(text: &str) -> Result<Surface> {
        parse(Path::new("a.obj"), text.as_bytes())
    }

    #[test]
    fn splits_quads_merges_vertices_and_counts_back() -> Result<()> {
        let text =
            "# teeth\nv 0 0 0\nv 2 0 0\nv 2.5 1.5 0\nv -0 0 0\nv 0 1 0.5\nf 1/1 2//2 3/3/3 5\nf 4 -2 -1\n";
        let surface = read(&text.replace('\n', "\r\n"))?;
        assert_eq!(surface.points.len(), 4);
        assert_eq!(surface.triangles.len(), 2, "the last face folds when its vertices merge");
        assert!(surface.triangles.iter().all(|t| t.contains(&1) && t.contains(&3)), "the shorter diagonal");
        Ok(())
    }

    #[test]
    fn says_where_and_what() {
        for (text, expected) in [
            ("v 0 0\n", "a.obj:1: z: expected v x y z"),
            ("v 0 0 1,5\n", "a.obj:1: z: `1,5` has a decimal comma; write a decimal point (`1.5`)"),
            ("v 0 0 0\nf 1 2 3\n", "a.obj:2: f: face 2 uses node 2, which is not defined"),
            ("v 0 0 0\nf 1 0 1\n", "a.obj:2: f: face 0 uses node 0"),
            ("v 0 0 0\nf 1 1 1 1 1\n", "a.obj:2: f: a face of 5 corners is not read"),
            ("v 0 0 0\n", "a.obj: expected faces, found `none`"),
            ("curv 0 1\n", "a.obj:1: curv: expected a statement"),
            ("\0\0\0", "a.obj: byte 0: is not text"),
        ] {
            let message = read(text).err().map(|e| e.to_string()).unwrap_or_default();
            assert!(message.starts_with(expected), "{message}");
        }
    }
}
