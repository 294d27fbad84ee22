//! What a part, an instance or the model itself defines: numbers and names hold within it.

use std::collections::{BTreeMap, HashMap};

use super::element::ElementKind;
use crate::units::Vec3;

/// A line of one of the files.
#[derive(Clone, Copy, Debug, Default)]
pub(super) struct Spot {
    pub(super) file: u32,
    pub(super) line: u32,
}

/// An element by the numbers of its nodes.
#[derive(Clone, Copy)]
pub(super) struct Element {
    pub(super) id: u64,
    pub(super) kind: ElementKind,
    /// The place of its first node in [`Scope::connectivity`], and how many there are.
    pub(super) first: usize,
    pub(super) n: usize,
    pub(super) spot: Spot,
}

/// What a set may hold.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash, PartialOrd, Ord)]
pub(super) enum SetKind {
    Nodes,
    Elements,
    /// Nodes too, but under names of their own.
    Surface,
}

/// What a line of a set lists.
#[derive(Clone, Debug)]
pub(super) enum Member {
    /// A node or element.
    Id(u64),
    /// Those that exist of `first`, `first + step`, ... up to `last`.
    Range { first: u64, last: u64, step: u64 },
    /// Another set of the same kind, or `instance.number`, or `instance.set`.
    Named(Box<str>),
    /// The nodes of an element set.
    NodesOf(Box<str>),
    /// Face `face` (from 0) of an element or of those of a set; without one, the faces on the boundary.
    Faces { of: Box<str>, face: Option<usize> },
    /// A node or node set as a surface.
    NodeOrSet(Box<str>),
}

/// A line of a set: what, in which instance if it is said, and where.
#[derive(Clone, Debug)]
pub(super) struct Entry {
    pub(super) member: Member,
    /// Position in the reader's list of the names of instances.
    pub(super) instance: Option<u32>,
    pub(super) spot: Spot,
}

/// A set as it is written.
#[derive(Clone, Default)]
pub(super) struct Named {
    pub(super) name: String,
    pub(super) entries: Vec<Entry>,
}

/// Nodes, elements and sets of one part, instance or model.
#[derive(Clone, Default)]
pub(super) struct Scope {
    pub(super) name: String,
    pub(super) node_ids: Vec<u64>,
    pub(super) points: Vec<Vec3>,
    pub(super) node_of: HashMap<u64, usize>,
    pub(super) elements: Vec<Element>,
    pub(super) element_of: HashMap<u64, usize>,
    pub(super) connectivity: Vec<u64>,
    /// By kind and by the name in capitals.
    pub(super) sets: BTreeMap<(SetKind, String), Named>,
}

impl Scope {
    /// The nodes of element `element` (a position), as the file numbers them.
    pub(super) fn nodes_of(&self, element: usize) -> &[u64] {
        let Element { first, n, .. } = self.elements[element];
        &self.connectivity[first..first + n]
    }

    pub(super) fn set(&mut self, kind: SetKind, name: &str) -> &mut Named {
        let key = (kind, name.to_ascii_uppercase());
        self.sets.entry(key).or_insert_with(|| Named { name: name.to_owned(), entries: Vec::new() })
    }
}
