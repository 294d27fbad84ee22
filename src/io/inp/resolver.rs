//! What the sets of an INP file hold.

use std::collections::{HashMap, HashSet};
use std::rc::Rc;

use super::super::mesh_file_error::{MAX_MEMBERS, MeshFileError, MeshFileErrorKind};
use super::super::{InputFile, text};
use super::assembly::Place;
use super::reader::{at, is_number};
use super::scope::{Element, Entry, Member, Scope, SetKind, Spot};
use crate::mesh::{Facet, Mesh, boundary_facets};

type Result<T> = std::result::Result<T, MeshFileError>;

/// A set: the position of its place, its kind and its name in capitals.
type Key = (usize, SetKind, String);

/// Numbers in ascending order, with their positions.
type Ascending = Vec<(u64, usize)>;

/// What a word of a set means.
enum Meaning {
    Set(Key),
    /// A number in a place.
    Id(usize, u64),
}

/// Sets of nodes as nodes of the mesh, sets of elements as positions among the elements of all places;
/// each is worked out once.
pub(super) struct Resolver<'a> {
    files: &'a [InputFile],
    places: &'a [Place<'a>],
    /// Places by their names in capitals, without the model.
    instance_of: HashMap<String, usize>,
    mentions: &'a [std::result::Result<usize, String>],
    mesh: &'a Mesh,
    cell_of: &'a [Option<usize>],
    /// Faces on the boundary by cell, once they are asked for.
    boundary: Option<HashMap<usize, Vec<Facet>>>,
    /// Ascending numbers of nodes and of elements with their positions, by place, once they are asked for.
    ascending: HashMap<(usize, SetKind), Rc<Ascending>>,
    done: HashMap<Key, Rc<Vec<usize>>>,
    /// How many members may still be listed.
    left: usize,
}

impl<'a> Resolver<'a> {
    pub(super) fn new(
        files: &'a [InputFile],
        places: &'a [Place<'a>],
        mentions: &'a [std::result::Result<usize, String>],
        mesh: &'a Mesh,
        cell_of: &'a [Option<usize>],
    ) -> Self {
        let instances = places.iter().enumerate().take(places.len() - 1);
        Self {
            files,
            places,
            instance_of: instances.map(|(k, place)| (place.name.to_ascii_uppercase(), k)).collect(),
            mentions,
            mesh,
            cell_of,
            boundary: None,
            ascending: HashMap::new(),
            done: HashMap::new(),
            left: MAX_MEMBERS,
        }
    }

    /// The places, once every set is worked out.
    pub(super) fn finish(self) -> &'a [Place<'a>] {
        self.places
    }

    /// Every set of `kind`: its place, its name in capitals and as it is written.
    pub(super) fn names(&self, kind: SetKind) -> Vec<(usize, String, String)> {
        let of_place = |(k, place): (usize, &Place<'a>)| {
            let sets = place.scope.sets.iter().filter(|((of, _), _)| *of == kind);
            sets.map(|((_, upper), set)| (k, upper.clone(), set.name.clone())).collect::<Vec<_>>()
        };
        self.places.iter().enumerate().flat_map(of_place).collect()
    }

    /// Whether the set lists anything.
    pub(super) fn is_listed(&self, place: usize, kind: SetKind, upper: &str) -> bool {
        !self.entries(&(place, kind, upper.to_owned())).is_empty()
    }

    /// The cells (0-based) among `elements`.
    pub(super) fn cells_among(&self, elements: &[usize]) -> Vec<usize> {
        elements.iter().filter_map(|&element| self.cell_of[element]).collect()
    }

    /// The nodes of `elements`, which set `name` lists.
    pub(super) fn nodes_of_elements(
        &mut self,
        place: usize,
        name: &str,
        elements: &[usize],
    ) -> Result<Vec<usize>> {
        let mut nodes = Vec::new();
        for &element in elements {
            self.add_nodes_of(element, name, &mut nodes)?;
        }
        self.spend(nodes.len(), place, name)?;
        nodes.sort_unstable();
        nodes.dedup();
        Ok(nodes)
    }

    /// The members of the set, ascending.
    pub(super) fn resolve(&mut self, place: usize, kind: SetKind, upper: &str) -> Result<Rc<Vec<usize>>> {
        let key = (place, kind, upper.to_owned());
        // Sets may be nested thousands deep, so that no call stack holds them.
        let mut open = vec![(key.clone(), false)];
        let mut entered: HashSet<Key> = HashSet::new();
        while let Some((next, complete)) = open.pop() {
            if self.done.contains_key(&next) {
                continue;
            }
            if complete {
                let members = self.members(&next)?;
                self.done.insert(next, Rc::new(members));
                continue;
            }
            let needed = self.needed(&next)?;
            entered.insert(next.clone());
            open.push((next.clone(), true));
            for (other, spot) in needed {
                if other == next || self.done.contains_key(&other) {
                    continue;
                }
                if entered.contains(&other) {
                    let found = format!("{}, which lists {}", text::shown(&other.2), text::shown(&next.2));
                    let expected = "sets that do not list each other in a circle".to_owned();
                    let at = at(self.files, spot).in_field(text::shown(&next.2));
                    return Err(MeshFileError::new(at, MeshFileErrorKind::Syntax { expected, found }));
                }
                open.push((other, false));
            }
        }
        Ok(self.done.get(&key).cloned().unwrap_or_default())
    }

    fn scope(&self, place: usize) -> &'a Scope {
        self.places[place].scope
    }

    fn entries(&self, key: &Key) -> &'a [Entry] {
        let (place, kind, upper) = key;
        self.scope(*place).sets.get(&(*kind, upper.clone())).map_or(&[], |set| &set.entries)
    }

    fn name(&self, key: &Key) -> String {
        let (place, kind, upper) = key;
        let set = self.scope(*place).sets.get(&(*kind, upper.clone()));
        set.map_or_else(|| upper.clone(), |set| set.name.clone())
    }

    fn fail<T>(&self, key: &Key, entry: &Entry, kind: MeshFileErrorKind) -> Result<T> {
        Err(MeshFileError::new(at(self.files, entry.spot).in_field(text::shown(&self.name(key))), kind))
    }

    /// The sets that the set lists, and where.
    fn needed(&self, key: &Key) -> Result<Vec<(Key, Spot)>> {
        let mut needed = Vec::new();
        for entry in self.entries(key) {
            if let Some(Meaning::Set(other)) = self.meaning(key, entry)? {
                needed.push((other, entry.spot));
            }
        }
        Ok(needed)
    }

    /// What the word of an entry means; a range means nothing by itself.
    fn meaning(&self, key: &Key, entry: &Entry) -> Result<Option<Meaning>> {
        let place = self.place_of(key, entry)?;
        let (kind, word) = match &entry.member {
            Member::Id(id) => return Ok(Some(Meaning::Id(place, *id))),
            Member::Range { .. } => return Ok(None),
            Member::Named(word) => (key.1, word),
            Member::NodesOf(word) | Member::Faces { of: word, .. } => (SetKind::Elements, word),
            Member::NodeOrSet(word) => (SetKind::Nodes, word),
        };
        self.word(key, entry, place, kind, word).map(Some)
    }

    fn place_of(&self, key: &Key, entry: &Entry) -> Result<usize> {
        let model = self.places.len() - 1;
        match entry.instance.map(|k| &self.mentions[k as usize]) {
            Some(Ok(instance)) => Ok(*instance),
            Some(Err(name)) => {
                let known = text::listed(self.places[..model].iter().map(|p| p.name.as_str()));
                let (what, name) = ("instance", text::shown(name));
                self.fail(key, entry, MeshFileErrorKind::Unknown { what, name, known })
            }
            // A model of one instance and nothing else can only mean that one.
            None if key.0 == model && model == 1 && self.scope(model).points.is_empty() => Ok(0),
            None => Ok(key.0),
        }
    }

    fn word(&self, key: &Key, entry: &Entry, place: usize, kind: SetKind, word: &str) -> Result<Meaning> {
        let has = |place: usize, name: &str| {
            let key = (kind, name.to_ascii_uppercase());
            self.scope(place).sets.contains_key(&key).then_some(Meaning::Set((place, kind, key.1)))
        };
        let number = |place: usize, word: &str| match is_number(word).then(|| word.parse()) {
            Some(Ok(id)) => Some(Meaning::Id(place, id)),
            _ => None,
        };
        let qualified = || {
            let (instance, rest) = word.rsplit_once('.')?;
            let place = *self.instance_of.get(&instance.to_ascii_uppercase())?;
            number(place, rest).or_else(|| has(place, rest))
        };
        let found =
            has(place, word).or_else(|| has(key.0, word)).or_else(qualified).or_else(|| number(place, word));
        found.map_or_else(
            || {
                let sets = self.scope(place).sets.iter().filter(|((of, _), _)| *of == kind);
                let known = text::listed(sets.map(|(_, set)| set.name.as_str()));
                let name = text::shown(word);
                self.fail(key, entry, MeshFileErrorKind::UnknownSet { name, known })
            },
            Ok,
        )
    }

    fn members(&mut self, key: &Key) -> Result<Vec<usize>> {
        let mut all = Vec::new();
        let of_elements = key.1 == SetKind::Elements;
        for entry in self.entries(key) {
            let before = all.len();
            let meaning = self.meaning(key, entry)?;
            match (&entry.member, meaning) {
                (Member::Range { first, last, step }, _) => {
                    let place = self.place_of(key, entry)?;
                    self.add_range(place, of_elements, [*first, *last, *step], &mut all);
                }
                (Member::Id(_) | Member::Named(_) | Member::NodeOrSet(_), Some(Meaning::Id(place, id))) => {
                    match of_elements {
                        true => all.push(self.element(key, entry, place, id)?),
                        false => all.extend(self.node(key, entry, place, id)?),
                    }
                }
                (Member::NodesOf(_) | Member::Faces { .. }, Some(meaning)) => {
                    let elements = match meaning {
                        Meaning::Set(other) => self.done.get(&other).cloned().unwrap_or_default(),
                        Meaning::Id(place, id) => Rc::new(vec![self.element(key, entry, place, id)?]),
                    };
                    let name = self.name(key);
                    for &element in elements.iter() {
                        match (&entry.member, self.cell_of[element]) {
                            (Member::Faces { face, .. }, Some(cell)) => {
                                self.add_faces(key, entry, cell, *face, &mut all)?;
                            }
                            _ => self.add_nodes_of(element, &name, &mut all)?,
                        }
                        self.check_left(all.len() - before, key.0, &name)?;
                    }
                }
                (_, Some(Meaning::Set(other))) => {
                    all.extend(self.done.get(&other).into_iter().flat_map(|set| set.iter().copied()));
                }
                (_, None) => {}
            }
            let name = self.name(key);
            self.spend(1 + all.len() - before, key.0, &name)?;
        }
        all.sort_unstable();
        all.dedup();
        Ok(all)
    }

    /// Takes `n` from what may still be listed.
    fn spend(&mut self, n: usize, place: usize, name: &str) -> Result<()> {
        self.check_left(n, place, name)?;
        self.left -= n;
        Ok(())
    }

    fn check_left(&self, n: usize, place: usize, name: &str) -> Result<()> {
        if n <= self.left {
            return Ok(());
        }
        let set = self.scope(place).sets.values().find(|set| set.name == name);
        let spot = set.and_then(|set| set.entries.first()).map_or(Spot::default(), |entry| entry.spot);
        let (what, most) = ("members of all sets together".to_owned(), MAX_MEMBERS as u64);
        let at = at(self.files, spot).in_field(text::shown(name));
        Err(MeshFileError::new(at, MeshFileErrorKind::TooMuch { what, most }))
    }

    fn node(&self, key: &Key, entry: &Entry, place: usize, id: u64) -> Result<Option<usize>> {
        match self.scope(place).node_of.get(&id) {
            Some(&local) => Ok(self.places[place].nodes[local]),
            None => {
                let (what, set, node) = ("set", text::shown(&self.name(key)), id.to_string());
                self.fail(key, entry, MeshFileErrorKind::MissingNode { what, id: set, node })
            }
        }
    }

    fn element(&self, key: &Key, entry: &Entry, place: usize, id: u64) -> Result<usize> {
        match self.scope(place).element_of.get(&id) {
            Some(&local) => Ok(self.places[place].first_element + local),
            None => {
                let set = text::shown(&self.name(key));
                self.fail(key, entry, MeshFileErrorKind::MissingElement { set, element: id })
            }
        }
    }

    /// Adds what exists of a range of numbers, in which there may be gaps.
    fn add_range(
        &mut self,
        place: usize,
        of_elements: bool,
        [first, last, step]: [u64; 3],
        all: &mut Vec<usize>,
    ) {
        let place_of = &self.places[place];
        let (numbers, position): (_, &dyn Fn(usize) -> Option<usize>) = if of_elements {
            (&place_of.scope.element_of, &|local| Some(place_of.first_element + local))
        } else {
            (&place_of.scope.node_of, &|local| place_of.nodes[local])
        };
        let kind = if of_elements { SetKind::Elements } else { SetKind::Nodes };
        let ascending = self.ascending.entry((place, kind)).or_insert_with(|| {
            let mut numbers: Vec<(u64, usize)> = numbers.iter().map(|(id, local)| (*id, *local)).collect();
            numbers.sort_unstable();
            Rc::new(numbers)
        });
        let from = ascending.partition_point(|(id, _)| *id < first);
        let to = ascending.partition_point(|(id, _)| *id <= last);
        if (last - first) / step < (to - from) as u64 {
            let ids = (0..=(last - first) / step).map(|k| first + k * step);
            all.extend(ids.filter_map(|id| numbers.get(&id)).filter_map(|&local| position(local)));
        } else {
            let members = ascending[from..to].iter().filter(|(id, _)| (id - first).is_multiple_of(step));
            all.extend(members.filter_map(|&(_, local)| position(local)));
        }
    }

    /// Adds the nodes of element `element`, a position among those of all places.
    fn add_nodes_of(&self, element: usize, set: &str, all: &mut Vec<usize>) -> Result<()> {
        let place = self.places.partition_point(|place| place.first_element <= element) - 1;
        let Place { scope, nodes, first_element, .. } = &self.places[place];
        let local = element - first_element;
        for id in scope.nodes_of(local) {
            let Some(&node) = scope.node_of.get(id) else {
                let Element { id: element, spot, .. } = scope.elements[local];
                let (what, element, node) = ("element", element.to_string(), id.to_string());
                let at = at(self.files, spot).in_field(text::shown(set));
                return Err(MeshFileError::new(
                    at,
                    MeshFileErrorKind::MissingNode { what, id: element, node },
                ));
            };
            all.extend(nodes[node]);
        }
        Ok(())
    }

    /// Adds the nodes of face `face` of cell `cell`, or of those of its faces that bound the mesh.
    fn add_faces(
        &mut self,
        key: &Key,
        entry: &Entry,
        cell: usize,
        face: Option<usize>,
        all: &mut Vec<usize>,
    ) -> Result<()> {
        let mesh = self.mesh;
        let kind = mesh.cells[cell].kind();
        match face {
            // Abaqus numbers the faces of every kind in our order.
            Some(face) if face < kind.faces().len() => all.extend(Facet::new(mesh, cell, face).nodes()),
            Some(face) => {
                let expected = format!("a face from S1 to S{} of {kind:?}", kind.faces().len());
                let found = format!("S{}", face + 1);
                return self.fail(key, entry, MeshFileErrorKind::Syntax { expected, found });
            }
            None => {
                let boundary = self.boundary.get_or_insert_with(|| {
                    let mut by_cell: HashMap<usize, Vec<Facet>> = HashMap::new();
                    for facet in boundary_facets(mesh) {
                        by_cell.entry(facet.cell).or_default().push(facet);
                    }
                    by_cell
                });
                all.extend(boundary.get(&cell).into_iter().flatten().flat_map(Facet::nodes));
            }
        }
        Ok(())
    }
}
