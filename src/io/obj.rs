//! Wavefront OBJ: polygons.

use std::path::Path;

use super::mesh_file_error::{MeshFileError, MeshFileErrorKind};
use super::polygons::Polygons;
use super::{Location, text};
use crate::mesh::Surface;
use crate::units::Vec3;

type Result<T> = std::result::Result<T, MeshFileError>;

/// The surface in the OBJ file `file` whose content is `bytes`, in the file's unit.
pub(super) fn parse(file: &Path, bytes: &[u8]) -> Result<Surface> {
    let text = text::text(file, bytes)?;
    let mut polygons = Polygons::default();
    let mut lines = text.lines().enumerate();
    while let Some((k, line)) = lines.next() {
        let at = |field: &str| Location::file(file).at_line(k + 1).in_field(field);
        let fail = |field: &str, kind| Err(MeshFileError::new(at(field), kind));
        // A backslash continues a line.
        let mut whole = line.to_owned();
        while let Some(begun) = whole.trim_end().strip_suffix('\\') {
            whole = format!("{begun} {}", lines.next().map_or("", |(_, more)| more));
        }
        let mut words = whole.split('#').next().unwrap_or_default().split_whitespace();
        match words.next() {
            Some("v") => {
                let mut p = Vec3::zeros();
                for (x, field) in p.iter_mut().zip(["x", "y", "z"]) {
                    let Some(word) = words.next() else {
                        let found = text::shown(line);
                        return fail(field, MeshFileErrorKind::Syntax { expected: "v x y z".into(), found });
                    };
                    *x = text::number(word, || at(field))?;
                }
                polygons.vertex(p);
            }
            Some("f") => {
                let corner = |word| vertex(word, polygons.n_vertices(), || at("f"));
                let corners = words.map(corner).collect::<Result<Vec<usize>>>()?;
                polygons.polygon(&corners, || at("f"))?;
            }
            // Curves, surfaces and what they look like are no polygons.
            None
            | Some("vn" | "vt" | "vp" | "o" | "g" | "s" | "usemtl" | "mtllib" | "l" | "p" | "mg" | "lod") => {
            }
            Some(word) => {
                let expected = "a statement of a polygon surface (v, vn, vt, f, o, g, s, ...)".to_owned();
                let found = text::shown(word);
                return fail(&found, MeshFileErrorKind::Syntax { expected, found: found.clone() });
            }
        }
    }
    polygons.surface(&Location::file(file))
}

/// The vertex (0-based) of `n` that `word` (`7`, `7/1`, `7//3`, `-1`) names.
fn vertex(word: &str, n: usize, at: impl Fn() -> Location) -> Result<usize> {
    let number = text::integer(word.split('/').next().unwrap_or(word), &at)?;
    let position = match number {
        1.. => number - 1,
        0 => -1,
        _ => n as i128 + number,
    };
    usize::try_from(position).ok().filter(|k| *k < n).ok_or_else(|| {
        let (what, id, node) = ("face", text::shown(word), number.to_string());
        MeshFileError::new(at(), MeshFileErrorKind::MissingNode { what, id, node })
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
            ("v 0 0 0\nf 1 1\n", "a.obj:2: f: a face of 2 corners is not read"),
            ("v 0 0 0\n", "a.obj: expected faces, found `none`"),
            ("curv 0 1\n", "a.obj:1: curv: expected a statement"),
            ("\0\0\0", "a.obj: byte 0: is not text"),
        ] {
            let message = read(text).err().map(|e| e.to_string()).unwrap_or_default();
            assert!(message.starts_with(expected), "{message}");
        }
    }
}
