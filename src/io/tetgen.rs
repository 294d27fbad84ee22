//! TetGen: `.node` and `.ele`, and the marked faces of `.face`.

use std::collections::BTreeMap;
use std::path::{Path, PathBuf};

use super::mesh_document::MeshDocument;
use super::mesh_file_error::{MeshFileError, MeshFileErrorKind};
use super::numbered::{NumberedMesh, Place};
use super::{InputFile, Location, text};
use crate::mesh::CellKind;
use crate::units::Vec3;

type Result<T> = std::result::Result<T, MeshFileError>;

/// Most distinct markers or regions that become sets: a column of numbers is no label.
const MAX_LABELS: usize = 64;

/// The mesh of which `file`, whose content is `bytes`, is the `.node` or the `.ele`, in the file's unit; the others
/// lie beside it under the same name. Markers of nodes and faces are node sets `marker=1`, `face=1`, ...; the
/// regions of tetrahedra cell sets `region=1`, ...
pub(super) fn parse(file: &Path, bytes: &[u8]) -> Result<MeshDocument> {
    let [nodes, elements, faces] = ["node", "ele", "face"].map(|ending| file.with_extension(ending));
    let mut files = vec![InputFile::new(file, bytes)];
    let mut content = |path: &Path| {
        if path == file {
            return Ok(bytes.to_vec());
        }
        let bytes = text::read_bytes(path)?;
        files.push(InputFile::new(path, &bytes));
        Ok(bytes)
    };
    let mut markers = Labels::default();
    let node_rows = Table::read(&nodes, &content(&nodes)?)?;
    let mut mesh = NumberedMesh::new(&nodes);
    let [dimension, attributes, marked] = node_rows.head([1, 2, 3])?;
    if dimension != 3 {
        return node_rows.fail(0, "dimension", "3", &dimension.to_string());
    }
    for row in &node_rows.rows {
        let place = Place::Line(row.line);
        let id = node_rows.id(row, 0, "node")?;
        let mut p = Vec3::zeros();
        for (k, field) in ["x", "y", "z"].into_iter().enumerate() {
            p[k] = text::number(node_rows.word(row, 1 + k, field)?, || node_rows.at(row.line, field))?;
        }
        mesh.node(id, p, place)?;
        let column = 4 + usize::try_from(attributes).unwrap_or(0);
        if marked > 0 && row.words.len() > column {
            markers.add(node_rows.integer(row, column, "marker")?, [(id, place)]);
        }
    }
    mesh.set_file(&elements);
    let element_rows = Table::read(&elements, &content(&elements)?)?;
    let [corners, regions] = element_rows.head([1, 2])?;
    let kind = match corners {
        4 => CellKind::Tet4,
        10 => CellKind::Tet10,
        other => return element_rows.fail(0, "nodes", "4 or 10 nodes a tetrahedron", &other.to_string()),
    };
    let mut of_region = Labels::default();
    for row in &element_rows.rows {
        let place = Place::Line(row.line);
        let id = element_rows.id(row, 0, "element")?;
        let mut nodes =
            (0..kind.n_nodes()).map(|k| element_rows.id(row, 1 + k, "node")).collect::<Result<Vec<u64>>>()?;
        if kind == CellKind::Tet10 {
            in_our_order(&mesh, &mut nodes);
        }
        mesh.element(id, kind, "", &nodes, place)?;
        if regions > 0 && row.words.len() > 1 + kind.n_nodes() {
            let word = element_rows.word(row, 1 + kind.n_nodes(), "region")?;
            // Some versions write regions as floats.
            let value = text::number(word, || element_rows.at(row.line, "region"))?;
            of_region.add(value as i128, [(id, place)]);
        }
    }
    let mut of_face = Labels::default();
    if faces.is_file() {
        let face_rows = Table::read(&faces, &content(&faces)?)?;
        let [marked] = face_rows.head([1])?;
        for row in face_rows.rows.iter().filter(|_| marked > 0) {
            let corners = (1..4).map(|k| face_rows.id(row, k, "node")).collect::<Result<Vec<u64>>>()?;
            if let Some(node) = corners.iter().find(|node| !mesh.has_node(**node)) {
                let (what, id, node) = ("face", row.words[0].clone(), node.to_string());
                let at = face_rows.at(row.line, "nodes");
                return Err(MeshFileError::new(at, MeshFileErrorKind::MissingNode { what, id, node }));
            }
            let marker = face_rows.integer(row, row.words.len() - 1, "marker")?;
            of_face.add(marker, corners.into_iter().map(|node| (node, Place::Line(row.line))));
        }
    }
    for (name, members) in markers.sets("marker").chain(of_face.sets("face")) {
        mesh.add_to_node_set(&name, &members)?;
    }
    for (name, members) in of_region.sets("region") {
        mesh.add_to_element_set(&name, &members)?;
    }
    let mut document = mesh.finish()?;
    document.files = files;
    Ok(document)
}

/// Puts the nodes between corners in our order, by where they lie: TetGen 1.5 and later have them on the edges 2-3, 0-3,
/// 0-1, 1-2, 1-3, 0-2 (which stands where places do not tell), earlier versions on 0-1, 0-2, 1-2, 1-3, 0-3, 2-3.
///
/// Source: TetGen's `edge2ver`, `orgpivot`, `destpivot` and `outelements()`.
fn in_our_order(mesh: &NumberedMesh<'_>, nodes: &mut [u64]) {
    let (corners, between) = nodes.split_at(4);
    let of_version_5 = [2, 3, 5, 1, 4, 0].map(|k| between[k]);
    let nearest = |&[a, b]: &[usize; 2]| {
        let middle = (mesh.point(corners[a])? + mesh.point(corners[b])?) / 2.;
        let off = |id: &u64| mesh.point(*id).map_or(f64::INFINITY, |p| (p - middle).norm());
        between.iter().copied().min_by(|a, b| off(a).total_cmp(&off(b)))
    };
    let mut found: Vec<u64> = CellKind::Tet10.edges().iter().filter_map(nearest).collect();
    if (0..6).any(|k| found.get(k).is_none_or(|id| found[..k].contains(id))) {
        found = of_version_5.to_vec();
    }
    nodes[4..].copy_from_slice(&found);
}

/// Members by label.
#[derive(Default)]
struct Labels(BTreeMap<i128, Vec<(u64, Place)>>);

impl Labels {
    fn add(&mut self, label: i128, members: impl IntoIterator<Item = (u64, Place)>) {
        self.0.entry(label).or_default().extend(members);
    }

    fn sets(self, name: &'static str) -> impl Iterator<Item = (String, Vec<(u64, Place)>)> {
        let few = self.0.len() <= MAX_LABELS;
        self.0
            .into_iter()
            .filter(move |_| few)
            .map(move |(label, members)| (format!("{name}={label}"), members))
    }
}

struct Row {
    line: usize,
    words: Vec<String>,
}

/// A file of rows of numbers: a first one of counts, then as many as it says.
struct Table {
    file: PathBuf,
    head: Row,
    rows: Vec<Row>,
}

impl Table {
    fn read(file: &Path, bytes: &[u8]) -> Result<Self> {
        let text = text::text(file, bytes)?;
        let mut rows = text.lines().enumerate().filter_map(|(k, line)| {
            let words: Vec<String> = line.split('#').next()?.split_whitespace().map(str::to_owned).collect();
            (!words.is_empty()).then_some(Row { line: k + 1, words })
        });
        let Some(head) = rows.next() else {
            return Err(MeshFileError::new(Location::file(file), MeshFileErrorKind::Empty));
        };
        let rows: Vec<Row> = rows.collect();
        let at = || Location::file(file).at_line(head.line).in_field("count");
        let declared = text::integer(&head.words[0], at)?;
        let (what, found) = ("rows".to_owned(), rows.len() as u64);
        if declared != i128::from(found) {
            let declared = u64::try_from(declared).unwrap_or(u64::MAX);
            return Err(MeshFileError::new(at(), MeshFileErrorKind::CountMismatch { what, declared, found }));
        }
        Ok(Self { file: file.to_owned(), head, rows })
    }

    fn at(&self, line: usize, field: &str) -> Location {
        Location::file(&self.file).at_line(line).in_field(field)
    }

    fn fail<T>(&self, line: usize, field: &str, expected: &str, found: &str) -> Result<T> {
        let line = if line == 0 { self.head.line } else { line };
        let kind = MeshFileErrorKind::Syntax { expected: expected.to_owned(), found: text::shown(found) };
        Err(MeshFileError::new(self.at(line, field), kind))
    }

    /// Numbers of the first row, 0 where it is shorter.
    fn head<const N: usize>(&self, columns: [usize; N]) -> Result<[i128; N]> {
        let mut numbers = [0; N];
        for (number, column) in numbers.iter_mut().zip(columns) {
            if let Some(word) = self.head.words.get(column) {
                *number = text::integer(word, || self.at(self.head.line, "head"))?;
            }
        }
        Ok(numbers)
    }

    fn word<'a>(&self, row: &'a Row, column: usize, field: &str) -> Result<&'a str> {
        match row.words.get(column) {
            Some(word) => Ok(word),
            None => self.fail(row.line, field, field, "the end of the row"),
        }
    }

    fn integer(&self, row: &Row, column: usize, field: &str) -> Result<i128> {
        text::integer(self.word(row, column, field)?, || self.at(row.line, field))
    }

    fn id(&self, row: &Row, column: usize, what: &'static str) -> Result<u64> {
        text::id(self.integer(row, column, what)?, what, || self.at(row.line, what))
    }
}
