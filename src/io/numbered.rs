//! A mesh under construction from a file that numbers its nodes and elements.

use std::collections::{BTreeMap, HashMap};
use std::path::Path;

use super::Location;
use super::mesh_document::{Corners, MeshDocument};
use super::mesh_file_error::{MAX_MEMBERS, MeshFileError, MeshFileErrorKind};
use super::text::shown;
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
    /// How many members sets may still get.
    left: usize,
    /// Kind, number and the nodes between the corners of quadratic elements that become linear.
    quadratic: Vec<(&'static str, u64, Vec<u64>)>,
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
            left: MAX_MEMBERS,
            quadratic: Vec::new(),
        }
    }

    fn fail<T>(&self, place: Place, field: &str, kind: MeshFileErrorKind) -> Result<T> {
        Err(MeshFileError::new(place.of(self.file).in_field(field), kind))
    }

    /// From here on places are those of `file`.
    pub(super) fn set_file(&mut self, file: &'a Path) {
        self.file = file;
    }

    pub(super) fn has_node(&self, id: u64) -> bool {
        self.node_of.contains_key(&id)
    }

    /// Where node `id` lies, in the file's unit.
    pub(super) fn point(&self, id: u64) -> Option<Vec3> {
        self.node_of.get(&id).map(|&node| self.points[node])
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

    /// Adds a volume element, `nodes` in the order of `kind`; those past its own lie between the corners of a
    /// quadratic element that the file calls `name`, and are left out.
    ///
    /// # Panics
    /// If there are fewer nodes than `kind` has.
    pub(super) fn element(
        &mut self,
        id: u64,
        kind: CellKind,
        name: &'static str,
        nodes: &[u64],
        place: Place,
    ) -> Result<()> {
        let (own, between) = nodes.split_at(kind.n_nodes());
        let mut all = [0; MAX_NODES];
        all[..own.len()].copy_from_slice(own);
        if !between.is_empty() {
            self.quadratic.push((name, id, between.to_vec()));
        }
        self.number(id, Some(self.elements.len()), place)?;
        self.elements.push(Element { place, id, kind, nodes: all });
        Ok(())
    }

    /// Adds a point, line or face, which is no cell but has a number.
    pub(super) fn lower_element(&mut self, id: u64, place: Place) -> Result<()> {
        self.number(id, None, place)
    }

    /// Whether `id` is the number of a point, line or face.
    pub(super) fn is_lower(&self, id: u64) -> bool {
        self.element_of.get(&id) == Some(&None)
    }

    fn number(&mut self, id: u64, position: Option<usize>, place: Place) -> Result<()> {
        match self.element_of.insert(id, position) {
            None => Ok(()),
            Some(_) => self.fail(place, "element", MeshFileErrorKind::DuplicateId { what: "element", id }),
        }
    }

    pub(super) fn add_to_node_set(&mut self, name: &str, nodes: &[(u64, Place)]) -> Result<()> {
        self.spend(name, nodes)?;
        self.node_sets.entry(name.to_owned()).or_default().extend(nodes);
        Ok(())
    }

    pub(super) fn add_to_element_set(&mut self, name: &str, elements: &[(u64, Place)]) -> Result<()> {
        self.spend(name, elements)?;
        self.element_sets.entry(name.to_owned()).or_default().extend(elements);
        Ok(())
    }

    fn spend(&mut self, name: &str, members: &[(u64, Place)]) -> Result<()> {
        match (self.left.checked_sub(members.len()), members.first()) {
            (Some(left), _) => self.left = left,
            (None, Some((_, place))) => {
                let (what, most) = ("members of all sets together".to_owned(), MAX_MEMBERS as u64);
                return self.fail(*place, &shown(name), MeshFileErrorKind::TooMuch { what, most });
            }
            (None, None) => {}
        }
        Ok(())
    }

    /// The mesh, with every number resolved.
    pub(super) fn finish(self) -> Result<MeshDocument> {
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
                    let (what, id, node) = ("set", shown(name), id.to_string());
                    return self.fail(
                        *place,
                        &shown(name),
                        MeshFileErrorKind::MissingNode { what, id, node },
                    );
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
                        let (set, element) = (shown(name), *element);
                        return self.fail(
                            *place,
                            &shown(name),
                            MeshFileErrorKind::MissingElement { set, element },
                        );
                    }
                }
            }
            if !set.is_empty() || members.is_empty() {
                cell_sets.insert(name.clone(), sorted(set));
            }
        }
        let mut corners = Corners::default();
        for (name, id, between) in &self.quadratic {
            corners.add(name, *id, between.iter().filter_map(|node| self.node_of.get(node).copied()));
        }
        let mesh = Mesh {
            points: self.points,
            cells,
            node_ids: self.node_ids,
            cell_ids: self.elements.iter().map(|e| e.id).collect(),
            node_sets,
            cell_sets,
        };
        let mut document = MeshDocument { mesh, ..MeshDocument::default() };
        corners.finish(&mut document);
        Ok(document)
    }
}

fn sorted(mut members: Vec<usize>) -> Vec<usize> {
    members.sort_unstable();
    members.dedup();
    members
}
