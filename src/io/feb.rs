//! FEBio: the mesh of a `.feb` file, versions 1 to 4.

use std::collections::HashMap;
use std::path::Path;

use roxmltree::{Document, Node};

use super::lines::Lines;
use super::mesh_document::MeshDocument;
use super::mesh_file_error::{MeshFileError, MeshFileErrorKind};
use super::numbered::{NumberedMesh, Place};
use super::{Location, text};
use crate::mesh::CellKind;
use crate::units::Vec3;

type Result<T> = std::result::Result<T, MeshFileError>;

/// Members of a set, with their places.
type Members = Vec<(u64, Place)>;

/// The mesh in the FEBio file `file` whose content is `bytes`, in the file's unit: nodes, solid elements, node sets,
/// element sets, and surfaces and named shells as node sets.
pub(super) fn parse(file: &Path, bytes: &[u8]) -> Result<MeshDocument> {
    let text = text::text(file, bytes)?;
    let lines = Lines::new(&text);
    let document = Document::parse(&text).map_err(|e| {
        let at = Location::file(file).at_line(e.pos().row as usize);
        let kind = MeshFileErrorKind::Syntax { expected: "XML".to_owned(), found: e.to_string() };
        MeshFileError::new(at, kind)
    })?;
    let root = document.root_element();
    let mut reader =
        Reader { file, lines, mesh: NumberedMesh::new(file), node_sets: Vec::new(), faces: Vec::new() };
    let sections = ["Mesh", "Geometry"];
    for section in root.children().filter(|n| sections.contains(&n.tag_name().name())) {
        if let Some(from) = section.attribute("from") {
            let what = format!("a mesh that another file holds ({})", text::shown(from));
            let kind = MeshFileErrorKind::UnsupportedFormat { what, fix: "name that file as the mesh" };
            return Err(MeshFileError::new(reader.at(section), kind));
        }
        for part in section.children().filter(Node::is_element) {
            reader.part(part)?;
        }
    }
    reader.finish()
}

struct Reader<'a> {
    file: &'a Path,
    lines: Lines,
    mesh: NumberedMesh<'a>,
    /// Node sets, and the node sets that they name.
    node_sets: Vec<(String, Members)>,
    /// Surfaces and shells.
    faces: Vec<(String, Members)>,
}

impl Reader<'_> {
    fn line(&self, node: Node<'_, '_>) -> usize {
        self.lines.of(node.range().start)
    }

    fn at(&self, node: Node<'_, '_>) -> Location {
        let name = node.attribute("name").unwrap_or(node.tag_name().name());
        Location::file(self.file).at_line(self.line(node)).in_field(text::shown(name))
    }

    fn fail<T>(&self, node: Node<'_, '_>, kind: MeshFileErrorKind) -> Result<T> {
        Err(MeshFileError::new(self.at(node), kind))
    }

    fn part(&mut self, part: Node<'_, '_>) -> Result<()> {
        let name = part.attribute("name").or(part.attribute("elset")).map(str::to_owned);
        let own = part.children().filter(Node::is_element);
        match part.tag_name().name() {
            "Nodes" => {
                let mut all = Vec::new();
                for node in own {
                    let (id, place) = (self.id(node)?, Place::Line(self.line(node)));
                    let numbers = words(node);
                    let [x, y, z] = numbers[..] else {
                        let kind = MeshFileErrorKind::Syntax {
                            expected: "x, y, z".to_owned(),
                            found: format!("{} numbers", numbers.len()),
                        };
                        return self.fail(node, kind);
                    };
                    let mut p = Vec3::zeros();
                    for (k, word) in [x, y, z].into_iter().enumerate() {
                        p[k] = text::number(word, || self.at(node))?;
                    }
                    self.mesh.node(id, p, place)?;
                    all.push((id, place));
                }
                self.node_sets.extend(name.map(|name| (name, all)));
            }
            "Elements" => self.elements(part, name)?,
            "NodeSet" => {
                let members = self.members(part, "node")?;
                self.node_sets.extend(name.map(|name| (name, members)));
            }
            "ElementSet" => {
                let members = self.members(part, "element")?;
                if let Some(name) = name {
                    self.mesh.add_to_element_set(&name, &members)?;
                }
            }
            "Surface" => {
                let mut members = Vec::new();
                for face in own {
                    let place = Place::Line(self.line(face));
                    for word in words(face) {
                        members.push((self.number(face, word, "node")?, place));
                    }
                }
                self.faces.extend(name.map(|name| (name, members)));
            }
            "Part" | "Instance" => {
                let what = "a mesh of parts and instances".to_owned();
                let fix = "save the model as one mesh";
                return self.fail(part, MeshFileErrorKind::UnsupportedFormat { what, fix });
            }
            // Edges, discrete sets, pairs of surfaces: not of nodes or cells.
            _ => {}
        }
        Ok(())
    }

    fn elements(&mut self, part: Node<'_, '_>, name: Option<String>) -> Result<()> {
        let (mut cells, mut shell): (Members, Members) = (Vec::new(), Vec::new());
        for element in part.children().filter(Node::is_element) {
            // Version 1 says the type of each element, later ones that of all.
            let kind = part.attribute("type").unwrap_or(element.tag_name().name()).to_ascii_lowercase();
            let (id, place) = (self.id(element)?, Place::Line(self.line(element)));
            let nodes = words(element)
                .into_iter()
                .map(|w| self.number(element, w, "node"))
                .collect::<Result<Vec<_>>>()?;
            let Some((cell, n, known)) = cell(&kind) else {
                if !["tri", "quad", "line", "truss", "beam", "q4ans", "q4eas"]
                    .iter()
                    .any(|k| kind.starts_with(k))
                {
                    let (id, name) = (id.to_string(), text::shown(&kind));
                    return self.fail(element, MeshFileErrorKind::UnsupportedElement { id, name });
                }
                self.mesh.lower_element(id, place)?;
                shell.extend(nodes.into_iter().map(|node| (node, place)));
                continue;
            };
            if nodes.len() != n {
                let (expected, found) = (format!("{n} nodes of {known}"), nodes.len().to_string());
                return self.fail(element, MeshFileErrorKind::Syntax { expected, found });
            }
            self.mesh.element(id, cell, known, &nodes, place)?;
            cells.push((id, place));
        }
        if let Some(name) = name {
            if !cells.is_empty() {
                self.mesh.add_to_element_set(&name, &cells)?;
            }
            if !shell.is_empty() {
                self.faces.push((name, shell));
            }
        }
        Ok(())
    }

    /// The members of a set: elements with an `id`, or numbers as text.
    fn members(&self, set: Node<'_, '_>, what: &'static str) -> Result<Members> {
        let mut members = Vec::new();
        for child in set.children() {
            let place = Place::Line(self.line(child));
            if child.is_element() {
                if let Some(id) = child.attribute("id") {
                    members.push((self.number(child, id, what)?, place));
                } else if let Some(other) = child.attribute("node_set") {
                    let known = self.node_sets.iter().find(|(name, _)| name == other);
                    let Some((_, nodes)) = known else {
                        let name = text::shown(other);
                        let known = text::listed(self.node_sets.iter().map(|(name, _)| name.as_str()));
                        return self.fail(child, MeshFileErrorKind::UnknownSet { name, known });
                    };
                    members.extend(nodes.iter().map(|(node, _)| (*node, place)));
                }
                continue;
            }
            for word in words(child) {
                members.push((self.number(set, word, what)?, place));
            }
            if members.len() > super::mesh_file_error::MAX_MEMBERS {
                let (what, most) =
                    ("members of a set".to_owned(), super::mesh_file_error::MAX_MEMBERS as u64);
                return self.fail(set, MeshFileErrorKind::TooMuch { what, most });
            }
        }
        Ok(members)
    }

    fn number(&self, node: Node<'_, '_>, word: &str, what: &'static str) -> Result<u64> {
        let value = text::integer(word, || self.at(node))?;
        text::id(value, what, || self.at(node))
    }

    fn id(&self, node: Node<'_, '_>) -> Result<u64> {
        self.number(node, node.attribute("id").unwrap_or("none"), "node or element")
    }

    /// A node set goes before a surface of its name with other nodes, which is then `surface=name`.
    fn finish(mut self) -> Result<MeshDocument> {
        let numbers = |members: &Members| {
            let mut all: Vec<u64> = members.iter().map(|(id, _)| *id).collect();
            all.sort_unstable();
            all.dedup();
            all
        };
        let taken: HashMap<&str, &Members> =
            self.node_sets.iter().map(|(name, m)| (name.as_str(), m)).collect();
        for (name, members) in &self.faces {
            match taken.get(name.as_str()) {
                Some(same) if numbers(same) == numbers(members) => {}
                Some(_) => self.mesh.add_to_node_set(&format!("surface={name}"), members)?,
                None => self.mesh.add_to_node_set(name, members)?,
            }
        }
        for (name, members) in &self.node_sets {
            self.mesh.add_to_node_set(name, members)?;
        }
        self.mesh.finish()
    }
}

/// The numbers in the text of `node`, which commas or blanks part.
fn words<'a>(node: Node<'a, '_>) -> Vec<&'a str> {
    let text = node.text().unwrap_or_default();
    text.split(|c: char| c == ',' || c.is_whitespace()).filter(|word| !word.is_empty()).collect()
}

/// What FEBio's element type `kind` is here, how many nodes it has there, and its name.
fn cell(kind: &str) -> Option<(CellKind, usize, &'static str)> {
    Some(match kind {
        "hex8" => (CellKind::Hex8, 8, "hex8"),
        "hex20" => (CellKind::Hex8, 20, "hex20"),
        "hex27" => (CellKind::Hex8, 27, "hex27"),
        "penta6" => (CellKind::Wedge6, 6, "penta6"),
        "penta15" => (CellKind::Wedge6, 15, "penta15"),
        "tet4" => (CellKind::Tet4, 4, "tet4"),
        "tet10" => (CellKind::Tet10, 10, "tet10"),
        _ => return None,
    })
}
