//! Reads VTU files.

use std::collections::BTreeMap;
use std::path::Path;

use roxmltree::{Document, Node};

use super::super::mesh_file_error::{MeshFileError, MeshFileErrorKind};
use super::super::{Location, text};
use super::array::{Appended, Encoding, Values, ZLIB_RATIO, values};
use crate::mesh::{Cell, CellKind, Mesh};
use crate::units::Vec3;

type Result<T> = std::result::Result<T, MeshFileError>;

/// Most distinct values of an integer array that become sets: an array of numbers is no set.
const MAX_LABELS: usize = 64;

/// The mesh in the VTU file `file` whose content is `bytes`, in the file's unit.
pub(in super::super) fn parse(file: &Path, bytes: &[u8]) -> Result<Mesh> {
    let (head, appended) = split_appended(text::without_bom(bytes));
    let head = text::text(file, &head)?;
    let document = Document::parse(&head).map_err(|e| not_xml(file, &e))?;
    let root = document.root_element();
    let reader = Reader { file, bytes: bytes.len(), encoding: encoding(file, root, appended)? };
    let grid = child(root, "UnstructuredGrid", || reader.at(root))?;
    let mut mesh = Mesh::default();
    let mut pieces = 0;
    for piece in grid.children().filter(|n| n.has_tag_name("Piece")) {
        reader.piece(piece, &mut mesh)?;
        pieces += 1;
    }
    if pieces == 0 {
        return Err(syntax(reader.at(grid), "a Piece element", "none"));
    }
    Ok(mesh)
}

/// The vectors (3n, node-major xyz) of the point array `name` in the VTU file `file` whose content is `bytes`.
pub(in super::super) fn point_vectors(file: &Path, bytes: &[u8], name: &str) -> Result<Vec<f64>> {
    let (head, appended) = split_appended(text::without_bom(bytes));
    let head = text::text(file, &head)?;
    let document = Document::parse(&head).map_err(|e| not_xml(file, &e))?;
    let root = document.root_element();
    let reader = Reader { file, bytes: bytes.len(), encoding: encoding(file, root, appended)? };
    let grid = child(root, "UnstructuredGrid", || reader.at(root))?;
    let mut vectors = Vec::new();
    for piece in grid.children().filter(|n| n.has_tag_name("Piece")) {
        let section = child(piece, "PointData", || reader.at(piece))?;
        let named = |n: &Node<'_, '_>| n.has_tag_name("DataArray") && n.attribute("Name") == Some(name);
        let array = section
            .children()
            .find(named)
            .ok_or_else(|| syntax(reader.at(section), &format!("a point array called {name}"), "none"))?;
        let at = reader.at(array);
        let components = array.attribute("NumberOfComponents").unwrap_or("1");
        if components != "3" {
            return Err(syntax(at, "NumberOfComponents 3", components));
        }
        let numbers = floats(values(array, &reader.encoding, &at)?);
        check_count(&at, "vectors", reader.declared(piece, "NumberOfPoints")?, numbers.len(), 3)?;
        if let Some(k) = numbers.iter().position(|x| !x.is_finite()) {
            let value = format!("{} (node {})", numbers[k], vectors.len() / 3 + k / 3);
            return Err(MeshFileError::new(at, MeshFileErrorKind::NotFinite { value }));
        }
        vectors.extend(numbers);
    }
    Ok(vectors)
}

/// The XML without the content of its appended section, which need not be text, and that content.
fn split_appended(bytes: &[u8]) -> (Vec<u8>, Option<(usize, &[u8])>) {
    let find = |from: usize, what: &[u8]| {
        bytes.get(from..)?.windows(what.len()).position(|w| w == what).map(|k| from + k)
    };
    let section = || {
        let tag = find(0, b"<AppendedData")?;
        let end = find(tag, b">")? + 1;
        let start = find(end, b"_")? + 1;
        Some((end, start))
    };
    let Some((end, start)) = section() else { return (bytes.to_vec(), None) };
    let head = [&bytes[..end], b"</AppendedData></VTKFile>"].concat();
    (head, Some((start, &bytes[start..])))
}

fn not_xml(file: &Path, error: &roxmltree::Error) -> MeshFileError {
    use roxmltree::Error::{NoRootNode, UnclosedRootNode, UnexpectedEndOfStream};
    let at = Location::file(file).at_line(error.pos().row as usize);
    if matches!(error, NoRootNode | UnclosedRootNode | UnexpectedEndOfStream) {
        let expected = "the end of the VTKFile element".to_owned();
        return MeshFileError::new(at, MeshFileErrorKind::Truncated { expected });
    }
    syntax(at, "XML", &error.to_string())
}

fn syntax(at: Location, expected: &str, found: &str) -> MeshFileError {
    let kind = MeshFileErrorKind::Syntax { expected: expected.to_owned(), found: found.to_owned() };
    MeshFileError::new(at, kind)
}

fn line_of(node: Node<'_, '_>) -> usize {
    node.document().text_pos_at(node.range().start).row as usize
}

fn child<'a, 'd>(node: Node<'a, 'd>, name: &str, at: impl FnOnce() -> Location) -> Result<Node<'a, 'd>> {
    node.children()
        .find(|n| n.has_tag_name(name))
        .ok_or_else(|| syntax(at(), &format!("a {name} element"), node.tag_name().name()))
}

fn encoding<'a>(
    file: &Path,
    root: Node<'_, '_>,
    appended: Option<(usize, &'a [u8])>,
) -> Result<Encoding<'a>> {
    let at = |field: &str| Location::file(file).at_line(line_of(root)).in_field(field);
    let unsupported = |field: &str, what: String, fix| {
        Err(MeshFileError::new(at(field), MeshFileErrorKind::UnsupportedFormat { what, fix }))
    };
    if !root.has_tag_name("VTKFile") {
        return Err(syntax(at("root"), "a VTKFile element", root.tag_name().name()));
    }
    match root.attribute("type") {
        Some("UnstructuredGrid") => {}
        other => {
            let what = format!("a VTK file of type {}", other.unwrap_or("none"));
            return unsupported("type", what, "save the volume as an unstructured grid (.vtu)");
        }
    }
    let zlib = match root.attribute("compressor") {
        None | Some("") => false,
        Some("vtkZLibDataCompressor") => true,
        Some(other) => {
            let fix = "export with zlib compression or with none";
            return unsupported("compressor", format!("compression by {other}"), fix);
        }
    };
    let one_of = |field: &str, default: &str, names: [&str; 2]| {
        let name = root.attribute(field).unwrap_or(default);
        match names.iter().position(|n| *n == name) {
            Some(k) => Ok(k == 1),
            None => Err(syntax(at(field), &names.join(" or "), name)),
        }
    };
    let section = root.children().find(|n| n.has_tag_name("AppendedData"));
    let base64 = section.and_then(|n| n.attribute("encoding")).unwrap_or("raw") == "base64";
    Ok(Encoding {
        big_endian: one_of("byte_order", "LittleEndian", ["LittleEndian", "BigEndian"])?,
        wide_header: one_of("header_type", "UInt32", ["UInt32", "UInt64"])?,
        zlib,
        appended: appended.map(|(start, bytes)| {
            let end = if base64 { bytes.iter().position(|b| *b == b'<') } else { None };
            Appended { bytes: &bytes[..end.unwrap_or(bytes.len())], base64, start }
        }),
    })
}

struct Reader<'a> {
    file: &'a Path,
    bytes: usize,
    encoding: Encoding<'a>,
}

impl Reader<'_> {
    fn at(&self, node: Node<'_, '_>) -> Location {
        let name = node.attribute("Name").unwrap_or(node.tag_name().name());
        Location::file(self.file).at_line(line_of(node)).in_field(name)
    }

    /// A count of the piece, refused when even the best compression could not hold as many.
    fn declared(&self, piece: Node<'_, '_>, field: &str) -> Result<usize> {
        let at = || Location::file(self.file).at_line(line_of(piece)).in_field(field);
        let declared = text::integer(piece.attribute(field).unwrap_or("none"), at)?;
        text::count(declared, field, self.bytes.saturating_mul(ZLIB_RATIO as usize), 1, at)
    }

    fn piece(&self, piece: Node<'_, '_>, mesh: &mut Mesh) -> Result<()> {
        let (first_node, first_cell) = (mesh.n_nodes(), mesh.cells.len());
        let first_id = mesh.cell_ids.last().map_or(0, |id| id + 1);
        let n_points = self.declared(piece, "NumberOfPoints")?;
        let n_cells = self.declared(piece, "NumberOfCells")?;
        self.points(piece, n_points, mesh)?;
        let kept = self.cells(piece, n_points, n_cells, mesh)?;
        mesh.node_ids.extend((first_node..mesh.n_nodes()).map(|k| k as u64));
        mesh.cell_ids.extend(kept.iter().map(|&k| first_id + k as u64));
        self.sets(piece, "PointData", n_points, &mut mesh.node_sets, |k| Some(first_node + k))?;
        let position = |k: usize| kept.binary_search(&k).ok().map(|at| first_cell + at);
        self.sets(piece, "CellData", n_cells, &mut mesh.cell_sets, position)
    }

    fn points(&self, piece: Node<'_, '_>, n_points: usize, mesh: &mut Mesh) -> Result<()> {
        let points = child(piece, "Points", || self.at(piece))?;
        let array = child(points, "DataArray", || self.at(points))?;
        let at = self.at(array);
        let components = array.attribute("NumberOfComponents").unwrap_or("1");
        if components != "3" {
            return Err(syntax(at, "NumberOfComponents 3", components));
        }
        let numbers = floats(values(array, &self.encoding, &at)?);
        check_count(&at, "points", n_points, numbers.len(), 3)?;
        if let Some(k) = numbers.iter().position(|x| !x.is_finite()) {
            let value = format!("{} (node {})", numbers[k], mesh.n_nodes() + k / 3);
            return Err(MeshFileError::new(at, MeshFileErrorKind::NotFinite { value }));
        }
        mesh.points.extend(numbers.chunks_exact(3).map(Vec3::from_column_slice));
        Ok(())
    }

    /// Adds the volume cells and returns their positions among all cells of the piece.
    fn cells(
        &self,
        piece: Node<'_, '_>,
        n_points: usize,
        n_cells: usize,
        mesh: &mut Mesh,
    ) -> Result<Vec<usize>> {
        let cells = child(piece, "Cells", || self.at(piece))?;
        let array = |name: &str| {
            let found = cells.children().find(|n| n.attribute("Name") == Some(name));
            let array = found.ok_or_else(|| syntax(self.at(cells), &format!("array {name}"), "none"))?;
            let at = self.at(array);
            match values(array, &self.encoding, &at)? {
                Values::Int(v) => Ok((v, at)),
                Values::Float(_) => Err(syntax(at, "an integer type", "a Float type")),
            }
        };
        let (connectivity, at) = array("connectivity")?;
        let (offsets, at_offsets) = array("offsets")?;
        let (types, at_types) = array("types")?;
        check_count(&at_offsets, "cells", n_cells, offsets.len(), 1)?;
        check_count(&at_types, "cells", n_cells, types.len(), 1)?;
        let first_node = mesh.n_nodes() - n_points;
        let (mut kept, mut start) = (Vec::new(), 0);
        for (k, (&end, &vtk)) in offsets.iter().zip(&types).enumerate() {
            let Some(nodes) = usize::try_from(end).ok().and_then(|end| connectivity.get(start..end)) else {
                let expected = format!("offset {start} to {} for cell {k}", connectivity.len());
                return Err(syntax(at_offsets, &expected, &end.to_string()));
            };
            start += nodes.len();
            let kind = match cell_kind(vtk) {
                Ok(Some(kind)) => kind,
                Ok(None) => continue,
                Err(name) => {
                    let kind = MeshFileErrorKind::UnsupportedElement { id: k.to_string(), name };
                    return Err(MeshFileError::new(at_types, kind));
                }
            };
            if nodes.len() != kind.n_nodes() {
                let expected = format!("{} nodes in cell {k} of type {vtk}", kind.n_nodes());
                return Err(syntax(at_offsets, &expected, &nodes.len().to_string()));
            }
            let mut of_cell = Vec::with_capacity(nodes.len());
            for &node in nodes {
                let id = text::id(node, "node", || at.clone())? as usize;
                if id >= n_points {
                    let (what, id, node) = ("element", k.to_string(), node.to_string());
                    return Err(MeshFileError::new(at, MeshFileErrorKind::MissingNode { what, id, node }));
                }
                of_cell.push(first_node + id);
            }
            mesh.cells.push(Cell::new(kind, &of_cell));
            kept.push(k);
        }
        if start != connectivity.len() {
            let (declared, found) = (start as u64, connectivity.len() as u64);
            let kind = MeshFileErrorKind::CountMismatch { what: "cell nodes".into(), declared, found };
            return Err(MeshFileError::new(at, kind));
        }
        Ok(kept)
    }

    /// Turns arrays of zeros and ones into sets of that name, other small whole numbers into sets
    /// `name=value`, and leaves the rest.
    fn sets(
        &self,
        piece: Node<'_, '_>,
        section: &str,
        n: usize,
        sets: &mut BTreeMap<String, Vec<usize>>,
        position: impl Fn(usize) -> Option<usize>,
    ) -> Result<()> {
        let Some(section) = piece.children().find(|c| c.has_tag_name(section)) else { return Ok(()) };
        for array in section.children().filter(|c| c.has_tag_name("DataArray")) {
            let at = self.at(array);
            let components = array.attribute("NumberOfComponents").unwrap_or("1");
            let Some(name) = array.attribute("Name") else { continue };
            if components != "1" {
                continue;
            }
            let data = values(array, &self.encoding, &at)?;
            check_count(&at, "values", n, data.len(), 1)?;
            let Some(labels) = labels(&data) else { continue };
            let flags = labels.iter().all(|v| *v == 0 || *v == 1);
            if flags {
                sets.entry(name.to_owned()).or_default();
            }
            for (k, label) in labels.into_iter().enumerate() {
                let Some(position) = position(k).filter(|_| !flags || label == 1) else { continue };
                let name = if flags { name.to_owned() } else { format!("{name}={label}") };
                sets.entry(name).or_default().push(position);
            }
        }
        Ok(())
    }
}

/// Few whole numbers, one an entry, or `None`; a float array counts only as zeros and ones.
fn labels(values: &Values) -> Option<Vec<i128>> {
    let labels = match values {
        Values::Int(v) => v.clone(),
        Values::Float(v) => {
            let flag = |x: &f64| (*x == 0. || *x == 1.).then_some(i128::from(*x == 1.));
            v.iter().map(flag).collect::<Option<_>>()?
        }
    };
    let mut distinct = labels.clone();
    distinct.sort_unstable();
    distinct.dedup();
    (distinct.len() <= MAX_LABELS).then_some(labels)
}

fn floats(values: Values) -> Vec<f64> {
    match values {
        Values::Float(v) => v,
        Values::Int(v) => v.into_iter().map(|x| x as f64).collect(),
    }
}

fn check_count(at: &Location, what: &str, declared: usize, values: usize, each: usize) -> Result<()> {
    if declared.checked_mul(each) == Some(values) {
        return Ok(());
    }
    let what = if each == 1 { what.to_owned() } else { format!("{what} ({each} numbers each)") };
    let (declared, found) = (declared as u64, (values / each) as u64);
    Err(MeshFileError::new(at.clone(), MeshFileErrorKind::CountMismatch { what, declared, found }))
}

/// The kind of VTK cell type `vtk`, `None` for points, lines and faces, or the name of what is not read.
fn cell_kind(vtk: i128) -> std::result::Result<Option<CellKind>, String> {
    let name = match vtk {
        10 => return Ok(Some(CellKind::Tet4)),
        12 => return Ok(Some(CellKind::Hex8)),
        13 => return Ok(Some(CellKind::Wedge6)),
        24 => return Ok(Some(CellKind::Tet10)),
        0..=9 | 21..=23 | 28 | 30 | 34..=36 => return Ok(None),
        11 => "voxel",
        14 => "5-node pyramid",
        25 => "20-node hexahedron",
        26 => "15-node wedge",
        27 => "13-node pyramid",
        29 => "27-node hexahedron",
        42 => "polyhedron",
        _ => "unknown",
    };
    Err(format!("{name} (VTK type {vtk})"))
}
