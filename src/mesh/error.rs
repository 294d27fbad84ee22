//! What makes a mesh unusable, and what makes it doubtful.

use std::fmt;

use thiserror::Error;

use super::FreeMode;
use crate::units::counted;

/// A mesh that cannot be computed with. Nodes and cells go by the numbers of their file.
#[derive(Clone, Debug, Error, PartialEq)]
#[non_exhaustive]
pub enum MeshError {
    /// No volume cells.
    #[error("the mesh has no cells; give it at least one hexahedron, wedge or tetrahedron")]
    NoCells,
    /// NaN or infinity.
    #[error("node {node}: coordinate {axis} is {value}; remove the node or give it a position")]
    NotFinite {
        /// The node.
        node: u64,
        /// `x`, `y` or `z`.
        axis: char,
        /// The coordinate.
        value: f64,
    },
    /// A cell on a node that does not exist.
    #[error("cell {cell} uses node {node} (0-based), but there are {n_nodes}; add it or correct the cell")]
    MissingNode {
        /// The cell.
        cell: u64,
        /// The node's position.
        node: usize,
        /// How many there are.
        n_nodes: usize,
    },
    /// A supported node that does not exist.
    #[error("support node {node} (0-based) does not exist, there are {n_nodes}; correct the node set")]
    MissingSupportNode {
        /// The node's position.
        node: usize,
        /// How many there are.
        n_nodes: usize,
    },
    /// A size that no face has.
    #[error(
        "the mesh measures {} mm across, but a face lies between {} mm and {} mm: are its \
         coordinates metres, or its unit misstated? State the unit they are in",
        (1e4 * extent_mm).round() / 1e4,
        super::validate::MIN_EXTENT_MM,
        super::validate::MAX_EXTENT_MM
    )]
    Extent {
        /// Longest side of the box around the mesh, mm.
        extent_mm: f64,
    },
    /// A node twice in a cell.
    #[error(
        "cell {cell} has node {node} more than once; use a wedge or tetrahedron instead of a collapsed cell"
    )]
    RepeatedNode {
        /// The cell.
        cell: u64,
        /// The node.
        node: u64,
    },
    /// A cell without volume.
    #[error("cell {cell} has no volume (greatest Jacobian {jacobian:.3e} mm3); remove it or move its nodes")]
    ZeroVolume {
        /// The cell.
        cell: u64,
        /// Greatest determinant in absolute value, mm³.
        jacobian: f64,
    },
    /// Cells turned inside out.
    #[error(
        "{} (least Jacobian {jacobian:.3e} mm3 in the first): {}; {}",
        counted(*count, "inverted cell"), List(cells, *count),
        if *everywhere {
            "the Jacobian is negative throughout: reorder their nodes so that the normal of \
             the first face points into the cell"
        } else {
            "the Jacobian changes sign inside: move the nodes, or reorder them if two are swapped"
        }
    )]
    Inverted {
        /// The first few.
        cells: Vec<u64>,
        /// How many there are.
        count: usize,
        /// Least determinant of the first, mm³.
        jacobian: f64,
        /// Whether the first is inside out everywhere, as by node order, not only at a corner.
        everywhere: bool,
    },
    /// A mid-edge node too far from the middle.
    #[error(
        "cell {cell}: mid-edge node {node} lies {offset_mm:.4} mm from the middle of its edge of \
         {edge_mm:.4} mm; move it within a quarter of the edge, or check the node order"
    )]
    MidEdgeNode {
        /// The cell.
        cell: u64,
        /// The node.
        node: u64,
        /// How far it is from the middle, mm.
        offset_mm: f64,
        /// Length of the edge, mm.
        edge_mm: f64,
    },
    /// More than two cells on one face.
    #[error("cells {} share one face; remove the duplicates", List(cells, cells.len()))]
    SharedFace {
        /// The cells.
        cells: Vec<u64>,
    },
    /// Neighbours of different order or shape on one face.
    #[error(
        "the faces of cells {first} and {second} meet but do not match ({first_nodes} and {second_nodes} \
         nodes, or other mid-edge nodes); use one kind of face where cells meet"
    )]
    MismatchedFaces {
        /// One cell.
        first: u64,
        /// The other cell.
        second: u64,
        /// Nodes of the face of the first.
        first_nodes: usize,
        /// Nodes of the face of the second.
        second_nodes: usize,
    },
    /// A node in the middle of a neighbour's face or edge.
    #[error(
        "node {node} hangs on a face of cell {cell} without being one of its nodes; refine the neighbour \
         too, so that faces match"
    )]
    HangingNode {
        /// The node.
        node: u64,
        /// The cell whose face it lies on.
        cell: u64,
    },
    /// Nothing holds the mesh.
    #[error("no node is fixed: the face can float away by {}; fix the nodes attached to bone", Modes(modes))]
    NoSupports {
        /// The rigid motions.
        modes: Vec<FreeMode>,
    },
    /// A part without supports.
    #[error(
        "a part of {} ({}) is joined to nothing that is fixed; merge coincident nodes, remove \
         the part or fix some of its nodes",
        counted(*n_cells, "cell"), List(cells, *n_cells)
    )]
    Disconnected {
        /// The first few cells.
        cells: Vec<u64>,
        /// How many there are.
        n_cells: usize,
    },
    /// Too few supports.
    #[error("the supports leave {} free; fix more nodes, not all on one line", Modes(modes))]
    UnderConstrained {
        /// The rigid motions left.
        modes: Vec<FreeMode>,
    },
    /// Parts joined by too little.
    #[error(
        "a part of {} ({}) hangs on {} ({}) only and is free in {}; join it by whole faces",
        counted(*n_cells, "cell"),
        List(cells, *n_cells),
        counted(nodes.len(), "node"),
        List(nodes, nodes.len()),
        Modes(modes)
    )]
    Hinge {
        /// Nodes of the joint.
        nodes: Vec<u64>,
        /// The first few cells of the part.
        cells: Vec<u64>,
        /// How many there are.
        n_cells: usize,
        /// Motions of the part.
        modes: Vec<FreeMode>,
    },
}

/// Something doubtful about a mesh that does not stop the work.
#[derive(Clone, Debug, PartialEq)]
#[non_exhaustive]
pub enum MeshWarning {
    /// Nearly flat cells.
    Slivers {
        /// The worst few, worst first.
        cells: Vec<u64>,
        /// How many there are.
        count: usize,
        /// The least scaled Jacobian.
        worst: f64,
    },
    /// Cells whose Jacobian varies by more than ten times.
    Distorted {
        /// The worst few, worst first.
        cells: Vec<u64>,
        /// How many there are.
        count: usize,
        /// The least ratio of least and greatest Jacobian.
        worst: f64,
    },
    /// Cells far thinner than they are wide.
    Thin {
        /// The worst few, worst first.
        cells: Vec<u64>,
        /// How many there are.
        count: usize,
        /// The least ratio of thickness and width.
        worst: f64,
    },
    /// Different nodes at one place.
    CoincidentNodes {
        /// The first few pairs.
        pairs: Vec<[u64; 2]>,
        /// How many there are.
        count: usize,
    },
    /// Nodes of no cell.
    OrphanNodes {
        /// The first few.
        nodes: Vec<u64>,
        /// How many there are.
        count: usize,
    },
}

impl fmt::Display for MeshWarning {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::Slivers { cells, count, worst } => write!(
                f,
                "{} (scaled Jacobian down to {worst:.3}): {}; stresses there are poor, \
                 remesh or smooth",
                counted(*count, "sliver cell"),
                List(cells, *count)
            ),
            Self::Distorted { cells, count, worst } => write!(
                f,
                "{} (least over greatest Jacobian down to {worst:.3}): {}; stresses \
                 there are poor, remesh or smooth",
                counted(*count, "distorted cell"),
                List(cells, *count)
            ),
            Self::Thin { cells, count, worst } => write!(
                f,
                "{} (thickness over width down to {worst:.4}): {}; a layer that thin is mostly a fault of the mesh: merge it \
                 with its neighbour, or refine along it",
                counted(*count, "thin cell"),
                List(cells, *count)
            ),
            Self::CoincidentNodes { pairs, count } => {
                let shown: Vec<String> = pairs.iter().map(|[a, b]| format!("{a}-{b}")).collect();
                let more = if *count > pairs.len() { ", ..." } else { "" };
                write!(
                    f,
                    "{} of nodes at one place: {}{more}; merge them unless the surfaces are \
                     meant to slide",
                    counted(*count, "pair"),
                    shown.join(", ")
                )
            }
            Self::OrphanNodes { nodes, count } => write!(
                f,
                "{} of no cell, without effect: {}; remove them, or give them cells",
                counted(*count, "node"),
                List(nodes, *count)
            ),
        }
    }
}

/// The first few of `.1` numbers.
struct List<'a>(&'a [u64], usize);

impl fmt::Display for List<'_> {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let shown: Vec<String> = self.0.iter().map(u64::to_string).collect();
        write!(f, "{}{}", shown.join(", "), if self.1 > self.0.len() { ", ..." } else { "" })
    }
}

struct Modes<'a>(&'a [FreeMode]);

impl fmt::Display for Modes<'_> {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let all: Vec<String> = self.0.iter().map(FreeMode::to_string).collect();
        f.write_str(&all.join(", "))
    }
}
