//! A mesh under construction from a file that numbers its nodes and elements.

use std::collections::{BTreeMap, HashMap, HashSet};
use std::path::Path;

use super::Location;
use super::mesh_file_error::{MeshFileError, MeshFileErrorKind};
use crate::mesh::{Cell, CellKind, MAX_NODES, Mesh};
use crate::units::Vec3;

type Result<T> = std::result::Result<T, MeshFileError>;

/// A place in the file.
#[derive(Clone, Copy, Debug)]
pub(super) enum Place {
    Line(usize),
    Byte(usize),
}

impl Place {
    pub(super) fn of(self, file: &Path) -> Location {
        match self {
            Self::Line(line) => Location::file(file).at_line(line),
            Self::Byte(byte) => Location::file(file).at_byte(byte),
        }
    }
}

struct Element {
    place: Place,
    id: u64,
    kind: CellKind,
    nodes: [u64; MAX_NODES],
}

/// Nodes and elements by their numbers, in file order, and sets of those numbers.
pub(super) struct NumberedMesh<'a> {
    file: &'a Path,
    points: Vec<Vec3>,
    node_ids: Vec<u64>,
    node_of: HashMap<u64, usize>,
    elements: Vec<Element>,
    /// Every element's number, with its position among the volume elements if it is one.
    element_of: HashMap<u64, Option<usize>>,
    node_sets: BTreeMap<String, Vec<(u64, Place)>>,
    element_sets: BTreeMap<String, Vec<(u64, Place)>>,
}

impl<'a> NumberedMesh<'a> {
    pub(super) fn new(file: &'a Path) -> Self {
        Self {
            file,
            points: Vec::new(),
            node_ids: Vec::new(),
            node_of: HashMap::new(),
            elements: Vec::new(),
            element_of: HashMap::new(),
            node_sets: BTreeMap::new(),
            element_sets: BTreeMap::new(),
        }
    }

    fn fail<T>(&self, place: Place, field: &str, kind: MeshFileErrorKind) -> Result<T> {
        Err(MeshFileError::new(place.of(self.file).in_field(field), kind))
    }

    pub(super) fn n_nodes(&self) -> usize {
        self.points.len()
    }

    pub(super) fn n_elements(&self) -> usize {
        self.element_of.len()
    }

    pub(super) fn node(&mut self, id: u64, point: Vec3, place: Place) -> Result<()> {
        if self.node_of.insert(id, self.points.len()).is_some() {
            return self.fail(place, "node", MeshFileErrorKind::DuplicateId { what: "node", id });
        }
        self.points.push(point);
        self.node_ids.push(id);
        Ok(())
    }

    /// Adds a volume element, `nodes` in the order of `kind`.
    ///
    /// # Panics
    /// If there are more nodes than any kind has.
    pub(super) fn element(&mut self, id: u64, kind: CellKind, nodes: &[u64], place: Place) -> Result<()> {
        let mut all = [0; MAX_NODES];
        all[..nodes.len()].copy_from_slice(nodes);
        self.number(id, Some(self.elements.len()), place)?;
        self.elements.push(Element { place, id, kind, nodes: all });
        Ok(())
    }

    /// Adds a point, line or face, which is no cell but has a number.
    pub(super) fn lower_element(&mut self, id: u64, place: Place) -> Result<()> {
        self.number(id, None, place)
    }

    fn number(&mut self, id: u64, position: Option<usize>, place: Place) -> Result<()> {
        match self.element_of.insert(id, position) {
            None => Ok(()),
            Some(_) => self.fail(place, "element", MeshFileErrorKind::DuplicateId { what: "element", id }),
        }
    }

    pub(super) fn add_to_node_set(&mut self, name: &str, nodes: &[u64], place: Place) {
        let set = self.node_sets.entry(name.to_owned()).or_default();
        set.extend(nodes.iter().map(|&id| (id, place)));
    }

    pub(super) fn add_to_element_set(&mut self, name: &str, elements: &[u64], place: Place) {
        let set = self.element_sets.entry(name.to_owned()).or_default();
        set.extend(elements.iter().map(|&id| (id, place)));
    }

    /// The mesh, with every number resolved.
    pub(super) fn finish(self) -> Result<Mesh> {
        let mut cells = Vec::with_capacity(self.elements.len());
        for element in &self.elements {
            let mut nodes = [0; MAX_NODES];
            let n = element.kind.n_nodes();
            for (node, id) in nodes[..n].iter_mut().zip(element.nodes) {
                let Some(&position) = self.node_of.get(&id) else {
                    let (what, id, node) = ("element", element.id.to_string(), id.to_string());
                    let kind = MeshFileErrorKind::MissingNode { what, id, node };
                    return self.fail(element.place, "nodes", kind);
                };
                *node = position;
            }
            cells.push(Cell::new(element.kind, &nodes[..n]));
        }
        let mut node_sets = BTreeMap::new();
        for (name, members) in &self.node_sets {
            let mut nodes = Vec::with_capacity(members.len());
            for (id, place) in members {
                let Some(&position) = self.node_of.get(id) else {
                    let (what, id, node) = ("set", name.clone(), id.to_string());
                    return self.fail(*place, name, MeshFileErrorKind::MissingNode { what, id, node });
                };
                nodes.push(position);
            }
            node_sets.insert(name.clone(), sorted(nodes));
        }
        let mut cell_sets = BTreeMap::new();
        for (name, members) in &self.element_sets {
            let mut set = Vec::with_capacity(members.len());
            for (element, place) in members {
                match self.element_of.get(element) {
                    Some(Some(position)) => set.push(*position),
                    // A set of faces or lines says nothing about cells.
                    Some(None) => {}
                    None => {
                        let (set, element) = (name.clone(), *element);
                        return self.fail(*place, name, MeshFileErrorKind::MissingElement { set, element });
                    }
                }
            }
            if !set.is_empty() || members.is_empty() {
                cell_sets.insert(name.clone(), sorted(set));
            }
        }
        Ok(Mesh {
            points: self.points,
            cells,
            node_ids: self.node_ids,
            cell_ids: self.elements.iter().map(|e| e.id).collect(),
            node_sets,
            cell_sets,
        })
    }
}

fn sorted(members: Vec<usize>) -> Vec<usize> {
    let mut members: Vec<usize> = members.into_iter().collect::<HashSet<_>>().into_iter().collect();
    members.sort_unstable();
    members
}
