//! The format of a file, by its content: endings are wrong as often as they are right.

use std::path::Path;

use super::text::without_bom;

/// Bytes at the start of a file in which its format must show.
const HEAD: usize = 1 << 16;

/// A format of meshes or surfaces that is read.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Format {
    /// VTK's XML: `.vtu`, `.vtp`.
    VtkXml,
    /// VTK's legacy format, `.vtk`.
    VtkLegacy,
    Msh,
    Inp,
    Feb,
    /// TetGen's `.node` and `.ele`.
    TetGen,
    Stl,
    Ply,
    Obj,
}

impl Format {
    /// The format of `bytes`; the name of `file` counts for tables of mere numbers.
    pub(super) fn of(file: &Path, bytes: &[u8]) -> Option<Self> {
        let bytes = without_bom(bytes);
        let head = String::from_utf8_lossy(&bytes[..bytes.len().min(HEAD)]);
        let start = head.trim_start();
        let lines = || head.lines().map(str::trim).filter(|line| !line.is_empty());
        if start.starts_with('<') {
            let has = |tag: &str| head.contains(tag);
            return match () {
                () if has("<febio_spec") => Some(Self::Feb),
                () if has("<VTKFile") || ending(file, &["vtu", "vtp"]) => Some(Self::VtkXml),
                () => None,
            };
        }
        if is_binary_stl(bytes) {
            return Some(Self::Stl);
        }
        if start.starts_with("# vtk DataFile") {
            return Some(Self::VtkLegacy);
        }
        if start.starts_with("ply") && lines().next() == Some("ply") {
            return Some(Self::Ply);
        }
        if start.starts_with("solid") && lines().skip(1).any(|line| is_first(line, &["facet", "endsolid"])) {
            return Some(Self::Stl);
        }
        if lines().any(|line| is_first(line, &["$MeshFormat", "$NOD", "$ELM"])) || start.starts_with('$') {
            return Some(Self::Msh);
        }
        let keyword = |line: &str| {
            line.strip_prefix('*').is_some_and(|rest| rest.starts_with(|c: char| c.is_alphabetic()))
        };
        if lines().any(keyword) {
            return Some(Self::Inp);
        }
        let numbers = |line: &str| line.split_whitespace().all(|word| word.parse::<f64>().is_ok());
        if ending(file, &["node", "ele"]) && lines().find(|line| !line.starts_with('#')).is_some_and(numbers)
        {
            return Some(Self::TetGen);
        }
        const STATEMENTS: [&str; 10] = ["v", "vn", "vt", "f", "o", "g", "s", "usemtl", "mtllib", "l"];
        let statement =
            lines().find(|line| !line.starts_with('#')).is_some_and(|line| is_first(line, &STATEMENTS));
        (statement && lines().any(|line| is_first(line, &["v"]))).then_some(Self::Obj)
    }
}

/// What a file that is of no format might have been: that which its name says, and those that are `read`.
pub(super) fn named_by_ending(file: &Path, read: &str) -> String {
    let endings = [
        ("inp", "Abaqus"),
        ("msh", "Gmsh"),
        ("vtu", "VTK"),
        ("vtp", "VTK"),
        ("vtk", "VTK"),
        ("feb", "FEBio"),
        ("node", "TetGen"),
        ("ele", "TetGen"),
        ("obj", "OBJ"),
        ("stl", "STL"),
        ("ply", "PLY"),
    ];
    match endings.iter().find(|(end, _)| ending(file, &[end])) {
        Some((_, format)) => format!("{format} file, nor one of another format that is read ({read})"),
        None => format!("file of a format that is read ({read})"),
    }
}

fn is_first(line: &str, words: &[&str]) -> bool {
    line.split_whitespace().next().is_some_and(|word| words.contains(&word))
}

fn ending(file: &Path, endings: &[&str]) -> bool {
    let ending = file.extension().and_then(|e| e.to_str()).unwrap_or_default();
    endings.iter().any(|e| ending.eq_ignore_ascii_case(e))
}

/// Its only mark is that it is exactly as long as it says: a header of 80 bytes, a count, and 50 bytes a triangle.
fn is_binary_stl(bytes: &[u8]) -> bool {
    let count = bytes.get(80..84).and_then(|count| count.first_chunk::<4>());
    count.is_some_and(|count| bytes.len() as u64 == 84 + 50 * u64::from(u32::from_le_bytes(*count)))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_content_decides() {
        for (bytes, expected) in [
            (&b"\xEF\xBB\xBF<?xml version=\"1.0\"?>\n<VTKFile>"[..], Some(Format::VtkXml)),
            (b"<febio_spec version=\"4.0\">", Some(Format::Feb)),
            (b"<html>", None),
            (b"\n$MeshFormat\n", Some(Format::Msh)),
            (b"$NOD\n1\n", Some(Format::Msh)),
            (b"** a comment\n*Heading\n", Some(Format::Inp)),
            (b"# vtk DataFile Version 3.0\n", Some(Format::VtkLegacy)),
            (b"solid a\nfacet normal 0 0 1\n", Some(Format::Stl)),
            (b"ply\nformat ascii 1.0\n", Some(Format::Ply)),
            (b"# a\nmtllib b\nv 0 0 0\n", Some(Format::Obj)),
            (b"hello world\nthis is not a mesh\n", None),
            (b"root:x:0:0\n", None),
        ] {
            assert_eq!(Format::of(Path::new("a.inp"), bytes), expected, "{}", String::from_utf8_lossy(bytes));
        }
        assert_eq!(Format::of(Path::new("a.ele"), b"# tets\n1 4 0\n"), Some(Format::TetGen));
        let mut stl = vec![b's'; 84];
        stl[80..].copy_from_slice(&[1, 0, 0, 0]);
        assert_eq!(Format::of(Path::new("a"), &stl), None);
        stl.extend([0; 50]);
        assert_eq!(Format::of(Path::new("a"), &stl), Some(Format::Stl));
    }
}
