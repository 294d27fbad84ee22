//! Parts put in their places, numbers and names resolved.

use std::collections::{BTreeMap, HashMap, HashSet};
use std::rc::Rc;

use nalgebra::{Rotation3, Unit};

use super::super::InputFile;
use super::super::mesh_document::{Corners, MeshDocument, NoSet};
use super::super::mesh_file_error::{MeshFileError, MeshFileErrorKind};
use super::element::ElementKind;
use super::reader::at;
use super::resolver::Resolver;
use super::scope::{Scope, SetKind};
use crate::mesh::{Cell, Mesh};
use crate::units::Vec3;

type Result<T> = std::result::Result<T, MeshFileError>;

/// A part in its place.
pub(super) struct Instance {
    pub(super) name: String,
    /// Position of what it defines among the scopes.
    pub(super) scope: usize,
    shift: Vec3,
    /// Two points of an axis, and the angle about it in radians.
    turn: Option<(Vec3, Vec3, f64)>,
    lines: usize,
}

impl Instance {
    pub(super) fn new(name: &str, scope: usize) -> Self {
        Self { name: name.to_owned(), scope, shift: Vec3::zeros(), turn: None, lines: 0 }
    }

    /// Takes a line of its placing; returns whether it is one.
    pub(super) fn place(&mut self, numbers: &[f64]) -> bool {
        match (self.lines, numbers) {
            (0, [_] | [_, _] | [_, _, _]) => {
                self.shift.iter_mut().zip(numbers).for_each(|(x, value)| *x = *value);
            }
            (0 | 1, &[ax, ay, az, bx, by, bz, degrees]) => {
                let (a, b) = (Vec3::new(ax, ay, az), Vec3::new(bx, by, bz));
                if (b - a).norm() <= 0. {
                    return false;
                }
                self.turn = Some((a, b, degrees.to_radians()));
                self.lines = 1;
            }
            _ => return false,
        }
        self.lines += 1;
        true
    }

    /// Where its point `p` is in the assembly: shifted first, then turned.
    fn at(&self, p: Vec3) -> Vec3 {
        let p = p + self.shift;
        match self.turn {
            None => p,
            Some((a, b, angle)) => {
                a + Rotation3::from_axis_angle(&Unit::new_normalize(b - a), angle) * (p - a)
            }
        }
    }
}

/// An instance, or the model itself, in the mesh.
pub(super) struct Place<'a> {
    pub(super) name: String,
    pub(super) scope: &'a Scope,
    /// Nodes of the mesh by position in the scope; `None` for reference points, which are left out.
    pub(super) nodes: Vec<Option<usize>>,
    /// Number of its first element among those of all places.
    pub(super) first_element: usize,
}

/// The mesh of the instances of `scopes`, the first of which is the model; without any, one of each part.
/// `mentions` are the instances that sets name, or names that no instance has.
pub(super) fn assemble(
    files: Vec<InputFile>,
    scopes: &[Scope],
    mut instances: Vec<Instance>,
    mentions: &[std::result::Result<usize, String>],
) -> Result<MeshDocument> {
    if instances.is_empty() {
        let parts = scopes.iter().enumerate().skip(1);
        instances = parts.map(|(k, part)| Instance::new(&part.name, k)).collect();
    }
    let flat = instances.is_empty();
    instances.push(Instance::new(&scopes[0].name, 0));
    let mut mesh = Mesh::default();
    let mut corners = Corners::default();
    let mut places: Vec<Place<'_>> = Vec::with_capacity(instances.len());
    let mut cell_of: Vec<Option<usize>> = Vec::new();
    let (mut node_ids, mut cell_ids) = (Numbers::default(), Numbers::default());
    for instance in &instances {
        let scope = &scopes[instance.scope];
        let model = instance.scope == 0 && !flat;
        let used: HashSet<u64> = if model { cell_nodes(scope).collect() } else { HashSet::new() };
        let kept = |id: &u64| !model || used.contains(id);
        let offset = node_ids.offset(scope.node_ids.iter().copied().filter(kept));
        let mut nodes = Vec::with_capacity(scope.points.len());
        for (id, p) in scope.node_ids.iter().zip(&scope.points) {
            nodes.push(kept(id).then_some(mesh.points.len()));
            if kept(id) {
                mesh.points.push(instance.at(*p));
                mesh.node_ids.push(id + offset);
            }
        }
        let is_cell = |kind| matches!(kind, ElementKind::Cell(..));
        let offset = cell_ids.offset(scope.elements.iter().filter(|e| is_cell(e.kind)).map(|e| e.id));
        let first_element = cell_of.len();
        for (k, element) in scope.elements.iter().enumerate() {
            let ElementKind::Cell(kind, n) = element.kind else {
                cell_of.push(None);
                continue;
            };
            let mut of_cell = Vec::with_capacity(n);
            for id in scope.nodes_of(k) {
                let Some(node) = scope.node_of.get(id).and_then(|&local| nodes[local]) else {
                    let (what, element_id, node) = ("element", element.id.to_string(), id.to_string());
                    let at = at(&files, element.spot).in_field("nodes");
                    return Err(MeshFileError::new(
                        at,
                        MeshFileErrorKind::MissingNode { what, id: element_id, node },
                    ));
                };
                of_cell.push(node);
            }
            let (corner, between) = of_cell.split_at(kind.n_nodes());
            if !between.is_empty() {
                corners.add(&format!("C3D{n}"), element.id + offset, between.iter().copied());
            }
            cell_of.push(Some(mesh.cells.len()));
            mesh.cells.push(Cell::new(kind, corner));
            mesh.cell_ids.push(element.id + offset);
        }
        places.push(Place { name: instance.name.clone(), scope, nodes, first_element });
    }
    let sets = named_sets(Resolver::new(&files, &places, mentions, &mesh, &cell_of))?;
    let mut document = MeshDocument { mesh, files, no_sets: sets.no_sets, ..MeshDocument::default() };
    document.mesh.node_sets = sets.nodes;
    document.mesh.cell_sets = sets.cells;
    corners.finish(&mut document);
    Ok(document)
}

/// Numbers that instances share are told apart: a later instance is numbered on from the greatest so far.
#[derive(Default)]
struct Numbers {
    taken: HashSet<u64>,
    greatest: u64,
}

impl Numbers {
    /// What is added to the numbers `ids`.
    fn offset(&mut self, ids: impl Iterator<Item = u64> + Clone) -> u64 {
        let offset = if ids.clone().any(|id| self.taken.contains(&id)) { self.greatest } else { 0 };
        for id in ids.map(|id| id + offset) {
            self.taken.insert(id);
            self.greatest = self.greatest.max(id);
        }
        offset
    }
}

fn cell_nodes(scope: &Scope) -> impl Iterator<Item = u64> {
    let cells = scope.elements.iter().enumerate().filter(|(_, e)| matches!(e.kind, ElementKind::Cell(..)));
    cells.flat_map(|(k, _)| scope.nodes_of(k).iter().copied())
}

#[derive(Default)]
struct Sets {
    nodes: BTreeMap<String, Vec<usize>>,
    cells: BTreeMap<String, Vec<usize>>,
    no_sets: Vec<NoSet>,
}

/// A set in the making: the place that defines it, its name, its members.
struct Candidate {
    place: usize,
    name: String,
    members: Rc<Vec<usize>>,
}

/// Every set under the name that stands for it alone: its own, or `place.name` where several places have
/// different sets of that name. A surface or a set of faces whose place has a node set of its name is
/// `surface=name` or `faces=name`.
fn named_sets(mut resolver: Resolver<'_>) -> Result<Sets> {
    let mut sets = Sets::default();
    let (mut of_nodes, mut of_cells): (Vec<Candidate>, Vec<Candidate>) = (Vec::new(), Vec::new());
    let mut taken: HashMap<(usize, String), Rc<Vec<usize>>> = HashMap::new();
    for kind in [SetKind::Nodes, SetKind::Surface, SetKind::Elements] {
        for (place, upper, name) in resolver.names(kind) {
            let members = resolver.resolve(place, kind, &upper)?;
            let mut name = name;
            let nodes = if kind == SetKind::Elements {
                let cells = resolver.cells_among(&members);
                if !cells.is_empty() || members.is_empty() {
                    of_cells.push(Candidate { place, name: name.clone(), members: Rc::new(cells) });
                    continue;
                }
                Rc::new(resolver.nodes_of_elements(place, &name, &members)?)
            } else {
                members
            };
            if nodes.is_empty() && resolver.is_listed(place, kind, &upper) {
                let why =
                    "it has reference points, springs, connectors or masses only, which are left out".into();
                sets.no_sets.push(NoSet { name, why });
                continue;
            }
            match taken.get(&(place, upper.clone())) {
                Some(same) if *same == nodes => continue,
                Some(_) if kind == SetKind::Surface => name = format!("surface={name}"),
                Some(_) => name = format!("faces={name}"),
                None => {
                    taken.insert((place, upper), nodes.clone());
                }
            }
            of_nodes.push(Candidate { place, name, members: nodes });
        }
    }
    drop(taken);
    let places = resolver.finish();
    sets.nodes = told_apart(of_nodes, places);
    sets.cells = told_apart(of_cells, places);
    Ok(sets)
}

fn told_apart(candidates: Vec<Candidate>, places: &[Place<'_>]) -> BTreeMap<String, Vec<usize>> {
    let mut by_name: BTreeMap<String, Vec<Candidate>> = BTreeMap::new();
    for candidate in candidates {
        by_name.entry(candidate.name.to_ascii_uppercase()).or_default().push(candidate);
    }
    let mut sets = BTreeMap::new();
    for same_name in by_name.into_values() {
        let one = same_name.iter().all(|c| c.members == same_name[0].members);
        for Candidate { place, name, members } in same_name {
            let name = if one { name } else { format!("{}.{name}", places[place].name) };
            sets.insert(name, Rc::unwrap_or_clone(members));
            if one {
                break;
            }
        }
    }
    sets
}
