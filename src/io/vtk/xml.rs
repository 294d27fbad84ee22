//! Reads VTK's XML: `.vtu` and `.vtp`.

use std::cell::Cell;
use std::path::Path;

use roxmltree::{Document, Node};

use super::super::lines::Lines;
use super::super::mesh_document::MeshDocument;
use super::super::mesh_file_error::{MeshFileError, MeshFileErrorKind};
use super::super::{Location, text};
use super::array::{
    ARRAYS, ARRAYS_PER_BYTE, Appended, Encoding, Expected, Values, attribute, values, written,
};
use super::cell_type::{POLYGON, STRIP};
use super::compression::Compression;
use super::grid::Grid;
use super::labels::Labels;
use crate::mesh::Surface;
use crate::units::Vec3;

type Result<T> = std::result::Result<T, MeshFileError>;

/// The volume mesh in the VTU file `file` whose content is `bytes`, in the file's unit.
pub(in super::super) fn parse(file: &Path, bytes: &[u8]) -> Result<MeshDocument> {
    with_document(file, bytes, |reader, root| {
        let data_set = reader.data_set(root, &["UnstructuredGrid"])?;
        let (grid, at) = reader.grid(data_set)?;
        grid.mesh(&at.types, &at.offsets)
    })
}

/// The polygons of the VTP or VTU file `file` whose content is `bytes`, in the file's unit.
pub(in super::super) fn polygons(file: &Path, bytes: &[u8]) -> Result<Surface> {
    with_document(file, bytes, |reader, root| {
        let data_set = reader.data_set(root, &["PolyData", "UnstructuredGrid"])?;
        let (grid, at) = reader.grid(data_set)?;
        grid.surface(&at.offsets)
    })
}

/// The vectors (3n, node-major xyz) of the point array `name` in the VTU file `file` whose content is `bytes`.
pub(in super::super) fn point_vectors(file: &Path, bytes: &[u8], name: &str) -> Result<Vec<f64>> {
    with_document(file, bytes, |reader, root| {
        let data_set = reader.data_set(root, &["UnstructuredGrid"])?;
        let mut vectors = Vec::new();
        for piece in data_set.children().filter(|n| n.has_tag_name("Piece")) {
            let section = child(piece, "PointData", || reader.at(piece))?;
            let named = |n: &Node<'_, '_>| n.has_tag_name("DataArray") && n.attribute("Name") == Some(name);
            let array = section
                .children()
                .find(named)
                .ok_or_else(|| syntax(reader.at(section), &format!("a point array called {name}"), "none"))?;
            let n = reader.declared(piece, "NumberOfPoints")?;
            let numbers = reader.triples(array, "vectors", n, vectors.len() / 3)?;
            vectors.extend(numbers);
        }
        Ok(vectors)
    })
}

/// The scalars (n) of the point array `name` in the VTU file `file` whose content is `bytes`; `None` where a piece has
/// no such array.
pub(in super::super) fn point_scalars(file: &Path, bytes: &[u8], name: &str) -> Result<Option<Vec<f64>>> {
    with_document(file, bytes, |reader, root| {
        let data_set = reader.data_set(root, &["UnstructuredGrid"])?;
        let mut scalars = Vec::new();
        for piece in data_set.children().filter(|n| n.has_tag_name("Piece")) {
            let section = child(piece, "PointData", || reader.at(piece))?;
            let named = |n: &Node<'_, '_>| n.has_tag_name("DataArray") && n.attribute("Name") == Some(name);
            let Some(array) = section.children().find(named) else { return Ok(None) };
            let n = reader.declared(piece, "NumberOfPoints")?;
            scalars.extend(reader.numbers(
                array,
                Expected { what: "scalars", entries: n, each: 1 },
                scalars.len(),
            )?);
        }
        Ok(Some(scalars))
    })
}

fn with_document<T>(
    file: &Path,
    bytes: &[u8],
    read: impl FnOnce(&Reader<'_>, Node<'_, '_>) -> Result<T>,
) -> Result<T> {
    let (head, appended) = split_appended(text::without_bom(bytes));
    let head = text::text(file, &head)?;
    let document = Document::parse(&head).map_err(|e| not_xml(file, &e))?;
    let lines = Lines::new(&head);
    let root = document.root_element();
    let encoding = encoding(file, root, appended, bytes.len())?;
    let left = Cell::new(bytes.len());
    read(&Reader { file, lines, left, encoding }, root)
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

fn child<'a, 'd>(node: Node<'a, 'd>, name: &str, at: impl FnOnce() -> Location) -> Result<Node<'a, 'd>> {
    node.children()
        .find(|n| n.has_tag_name(name))
        .ok_or_else(|| syntax(at(), &format!("a {name} element"), node.tag_name().name()))
}

fn encoding<'a>(
    file: &Path,
    root: Node<'_, '_>,
    appended: Option<(usize, &'a [u8])>,
    n_bytes: usize,
) -> Result<Encoding<'a>> {
    let at = |field: &str| {
        let line = root.document().text_pos_at(root.range().start).row as usize;
        Location::file(file).at_line(line).in_field(field)
    };
    if !root.has_tag_name("VTKFile") {
        return Err(syntax(at("root"), "a VTKFile element", &text::shown(root.tag_name().name())));
    }
    let compressor = attribute(root, "compressor").filter(|name| !name.is_empty());
    let compression = match compressor {
        None => None,
        Some(name) => match Compression::NAMES.iter().find(|(known, _)| *known == name) {
            Some((_, compression)) => Some(*compression),
            None => {
                let what = format!("compression by {}", text::shown(name));
                let fix = "export with zlib compression or with none";
                let kind = MeshFileErrorKind::UnsupportedFormat { what, fix };
                return Err(MeshFileError::new(at("compressor"), kind));
            }
        },
    };
    let one_of = |field: &str, default: &str, names: [&str; 2]| {
        let name = attribute(root, field).unwrap_or(default);
        match names.iter().position(|n| *n == name) {
            Some(k) => Ok(k == 1),
            None => Err(syntax(at(field), &names.join(" or "), &text::shown(name))),
        }
    };
    let section = root.children().find(|n| n.has_tag_name("AppendedData"));
    let base64 = section.and_then(|n| attribute(n, "encoding")).unwrap_or("raw") == "base64";
    Ok(Encoding {
        big_endian: one_of("byte_order", "LittleEndian", ["LittleEndian", "BigEndian"])?,
        wide_header: one_of("header_type", "UInt32", ["UInt32", "UInt64"])?,
        compression,
        left: Cell::new(ARRAYS.saturating_add(n_bytes.saturating_mul(ARRAYS_PER_BYTE))),
        appended: appended.map(|(start, bytes)| {
            let end = if base64 { bytes.iter().position(|b| *b == b'<') } else { None };
            Appended { bytes: &bytes[..end.unwrap_or(bytes.len())], base64, start }
        }),
    })
}

/// Where the arrays of cells are, for what is wrong with cells.
#[derive(Default)]
struct CellPlaces {
    offsets: Location,
    types: Location,
}

struct Reader<'a> {
    file: &'a Path,
    lines: Lines,
    /// How many points and cells the pieces may still declare.
    left: Cell<usize>,
    encoding: Encoding<'a>,
}

impl Reader<'_> {
    fn at(&self, node: Node<'_, '_>) -> Location {
        let name = node.attribute("Name").unwrap_or(node.tag_name().name());
        Location::file(self.file).at_line(self.lines.of(node.range().start)).in_field(text::shown(name))
    }

    /// The element of the data set, whose type is one of `types`.
    fn data_set<'n, 'd>(&self, root: Node<'n, 'd>, types: &[&str]) -> Result<Node<'n, 'd>> {
        let found = attribute(root, "type").unwrap_or("none");
        if types.contains(&found) {
            return child(root, found, || self.at(root));
        }
        let what = format!("a VTK file of type {}", text::shown(found));
        let fix = match types {
            ["PolyData", ..] => "save the surface as polygons (.vtp)",
            _ => "save the volume as an unstructured grid (.vtu)",
        };
        let at = Location::file(self.file).at_line(self.lines.of(root.range().start)).in_field("type");
        Err(MeshFileError::new(at, MeshFileErrorKind::UnsupportedFormat { what, fix }))
    }

    /// A count of the piece. Each entry takes a byte of the file at the very least, however it is compressed.
    fn declared(&self, piece: Node<'_, '_>, field: &str) -> Result<usize> {
        let at = || Location::file(self.file).at_line(self.lines.of(piece.range().start)).in_field(field);
        let declared = text::integer(attribute(piece, field).unwrap_or("0"), at)?;
        let declared = text::count(declared, field, self.left.get(), 1, at)?;
        self.left.set(self.left.get().saturating_sub(declared));
        Ok(declared)
    }

    fn values(&self, array: Node<'_, '_>, expected: Expected<'_>, at: &Location) -> Result<Values> {
        values(array, &self.encoding, &self.lines, expected, at)
    }

    fn grid(&self, data_set: Node<'_, '_>) -> Result<(Grid, CellPlaces)> {
        let mut grid = Grid::default();
        let mut places = CellPlaces::default();
        let mut first = true;
        for piece in data_set.children().filter(|n| n.has_tag_name("Piece")) {
            let (points, cells) = (grid.points.len(), grid.cells.len());
            let n_points = self.declared(piece, "NumberOfPoints")?;
            self.points(piece, n_points, &mut grid)?;
            if data_set.has_tag_name("PolyData") {
                for (section, count, kind) in
                    [("Strips", "NumberOfStrips", STRIP), ("Polys", "NumberOfPolys", POLYGON)]
                {
                    let n = self.declared(piece, count)?;
                    if n > 0 {
                        self.cells(piece, section, n_points, n, Some(kind), &mut grid, &mut places)?;
                    }
                }
            } else {
                let n_cells = self.declared(piece, "NumberOfCells")?;
                self.cells(piece, "Cells", n_points, n_cells, None, &mut grid, &mut places)?;
                let of_points = self.labels(piece, "PointData", n_points);
                Grid::add_labels(&mut grid.point_labels, points, of_points, first);
                let of_cells = self.labels(piece, "CellData", n_cells);
                Grid::add_labels(&mut grid.cell_labels, cells, of_cells, first);
            }
            first = false;
        }
        if first {
            return Err(syntax(self.at(data_set), "a Piece element", "none"));
        }
        Ok((grid, places))
    }

    fn points(&self, piece: Node<'_, '_>, n_points: usize, grid: &mut Grid) -> Result<()> {
        let points = child(piece, "Points", || self.at(piece))?;
        let array = child(points, "DataArray", || self.at(points))?;
        let numbers = self.triples(array, "points", n_points, grid.points.len())?;
        grid.points.extend(numbers.chunks_exact(3).map(Vec3::from_column_slice));
        Ok(())
    }

    /// The `n` finite triples of an array; `before` others came before, for messages.
    fn triples(&self, array: Node<'_, '_>, what: &str, n: usize, before: usize) -> Result<Vec<f64>> {
        let at = self.at(array);
        let components = attribute(array, "NumberOfComponents").unwrap_or("1");
        if components != "3" {
            return Err(syntax(at, "NumberOfComponents 3", &text::shown(components)));
        }
        self.numbers(array, Expected { what, entries: n, each: 3 }, before)
    }

    /// The finite numbers of an array, entry by entry; `before` entries came before, for messages.
    fn numbers(&self, array: Node<'_, '_>, expected: Expected<'_>, before: usize) -> Result<Vec<f64>> {
        let (at, each) = (self.at(array), expected.each);
        let numbers = match self.values(array, expected, &at)? {
            Values::Float(v) => v,
            Values::Int(v) => v.into_iter().map(|x| x as f64).collect(),
        };
        if let Some(k) = numbers.iter().position(|x| !x.is_finite()) {
            let (at, value) = match written(array, &self.lines, k) {
                Some((line, word)) => (at.at_line(line), word),
                None => (at, format!("{} (node {})", numbers[k], before + k / each)),
            };
            return Err(MeshFileError::new(at, MeshFileErrorKind::NotFinite { value }));
        }
        Ok(numbers)
    }

    /// Adds the cells of a section, all of type `kind` unless the section has an array of types.
    #[allow(clippy::too_many_arguments, reason = "what a piece declares, and where it goes")]
    fn cells(
        &self,
        piece: Node<'_, '_>,
        section: &str,
        n_points: usize,
        n_cells: usize,
        kind: Option<i64>,
        grid: &mut Grid,
        places: &mut CellPlaces,
    ) -> Result<()> {
        let cells = child(piece, section, || self.at(piece))?;
        let array = |name: &str, what: &str, entries: usize| {
            let found = cells.children().find(|n| n.attribute("Name") == Some(name));
            let array = found.ok_or_else(|| syntax(self.at(cells), &format!("array {name}"), "none"))?;
            let at = self.at(array);
            match self.values(array, Expected { what, entries, each: 1 }, &at)? {
                Values::Int(v) => Ok((v, at)),
                Values::Float(_) => Err(syntax(at, "an integer type", "a Float type")),
            }
        };
        let (offsets, at_offsets) = array("offsets", "cells", n_cells)?;
        let (types, at_types) = match kind {
            Some(kind) => (vec![kind; n_cells], at_offsets.clone()),
            None => array("types", "cells", n_cells)?,
        };
        let n_nodes = offsets.last().copied().unwrap_or(0);
        // Far more nodes than cells, in a small file, are a bomb and no mesh.
        let most = self.encoding.left.get() / 8;
        let n_nodes = text::count(i128::from(n_nodes), "cell nodes", most, 1, || at_offsets.clone())?;
        let (connectivity, at) = array("connectivity", "cell nodes", n_nodes)?;
        let first_node = grid.points.len() - n_points;
        let mut start = 0;
        for (k, (&end, &kind)) in offsets.iter().zip(&types).enumerate() {
            let Some(nodes) = usize::try_from(end).ok().and_then(|end| connectivity.get(start..end)) else {
                let expected = format!("offset {start} to {} for cell {k}", connectivity.len());
                return Err(syntax(at_offsets, &expected, &end.to_string()));
            };
            start += nodes.len();
            for &node in nodes {
                let id = text::id(i128::from(node), "node", || at.clone())? as usize;
                if id >= n_points {
                    let (what, id, node) = ("element", k.to_string(), node.to_string());
                    return Err(MeshFileError::new(at, MeshFileErrorKind::MissingNode { what, id, node }));
                }
                grid.connectivity.push(first_node + id);
            }
            grid.cells.push((kind, grid.connectivity.len()));
        }
        (places.offsets, places.types) = (at_offsets, at_types);
        Ok(())
    }

    /// The labels of the arrays of a section. What is wrong with an array matters only to who asks for it.
    fn labels(&self, piece: Node<'_, '_>, section: &str, n: usize) -> Vec<(String, Labels)> {
        let Some(section) = piece.children().find(|c| c.has_tag_name(section)) else { return Vec::new() };
        let array = |array: Node<'_, '_>| {
            let name = array.attribute("Name")?.to_owned();
            let labels = match attribute(array, "NumberOfComponents").unwrap_or("1") {
                "1" | "" => {
                    let expected = Expected { what: "values", entries: n, each: 1 };
                    match self.values(array, expected, &self.at(array)) {
                        Ok(values) => Labels::new(&values),
                        Err(e) => Labels::No(format!("it cannot be read: {}", e.kind)),
                    }
                }
                components => Labels::No(format!("it has {} components", text::shown(components))),
            };
            Some((name, labels))
        };
        section.children().filter(|c| c.has_tag_name("DataArray")).filter_map(array).collect()
    }
}
