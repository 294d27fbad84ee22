//! What can be wrong with a tooth surface.

use std::fmt;

use thiserror::Error;

use crate::units::{Vec3, counted};

/// How many places a message lists before it says how many more there are.
const LISTED: usize = 6;

/// A hole of a surface: a closed chain of edges that have one triangle only.
#[derive(Clone, Debug, PartialEq)]
pub struct BoundaryLoop {
    /// Mean of its vertices, mm.
    pub centre: Vec3,
    /// Number of edges.
    pub edges: usize,
    /// Length, mm.
    pub length_mm: f64,
}

/// A connected piece of a surface.
#[derive(Clone, Debug, PartialEq)]
pub struct Piece {
    /// Mean of its vertices, mm.
    pub centre: Vec3,
    /// Number of triangles.
    pub triangles: usize,
    /// Volume enclosed, mm³; negative when the normals point inward.
    pub volume_mm3: f64,
}

/// An edge by its two ends, mm.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct EdgeAt(pub Vec3, pub Vec3);

/// Why a surface is no solid.
#[derive(Clone, Debug, Error, PartialEq)]
#[non_exhaustive]
pub enum TeethError {
    /// No triangle.
    #[error("the tooth surface has no triangle; give a closed surface or leave the teeth out")]
    Empty,
    /// A coordinate is NaN or infinite.
    #[error("vertex {vertex} (from 1) of the tooth surface is not finite: {value:?}")]
    NotFinite {
        /// The vertex, from 1.
        vertex: usize,
        /// Its coordinates.
        value: [f64; 3],
    },
    /// A triangle names a vertex that does not exist.
    #[error("triangle {triangle} (from 1) names vertex {vertex}, but there are {n_vertices}")]
    MissingVertex {
        /// The triangle, from 1.
        triangle: usize,
        /// The vertex, from 1.
        vertex: usize,
        /// How many there are.
        n_vertices: usize,
    },
    /// Edges of three triangles or more.
    #[error(
        "the tooth surface has {} of more than two triangles, and so no inside: {}; \
         remove the doubled or inner triangles", counted(edges.len(), "edge"), list(edges)
    )]
    NonManifold {
        /// The edges.
        edges: Vec<EdgeAt>,
    },
    /// Neighbours whose normals point to opposite sides.
    #[error(
        "triangles of the tooth surface are oriented against each other at {}: {}; \
         make the orientation consistent, or set `orient = true`", counted(edges.len(), "edge"), list(edges)
    )]
    Inconsistent {
        /// The edges.
        edges: Vec<EdgeAt>,
    },
    /// Holes.
    #[error(
        "the tooth surface is open, {}: {}; close them or set `cap_holes = true`",
        counted(loops.len(), "hole"), list(loops)
    )]
    Open {
        /// Its boundary.
        loops: Vec<BoundaryLoop>,
    },
    /// Pieces turned inside out.
    #[error(
        "the tooth surface has {} with normals that point inward: {}; reverse their triangles, or set `orient = true`",
         counted(pieces.len(), "piece"), list(pieces)
    )]
    Inward {
        /// The pieces.
        pieces: Vec<Piece>,
    },
    /// Nothing is enclosed.
    #[error("the tooth surface encloses no volume; give a closed surface or leave the teeth out")]
    Flat,
}

/// What was mended in a surface to make it a solid.
#[derive(Clone, Debug, Error, PartialEq)]
#[non_exhaustive]
pub enum TeethWarning {
    /// Holes were closed, as asked for.
    #[error("{} of the tooth surface capped: {}", counted(loops.len(), "hole"), list(loops))]
    Capped {
        /// What was closed.
        loops: Vec<BoundaryLoop>,
    },
    /// Triangles were turned to face outward, as asked for.
    #[error("{triangles} triangles of the tooth surface were turned to face outward")]
    Turned {
        /// How many.
        triangles: usize,
    },
    /// Pieces that enclose nothing were left out.
    #[error("{} of the tooth surface left out for enclosing nothing: {}", counted(pieces.len(), "piece"), list(pieces))]
    Debris {
        /// What was left out.
        pieces: Vec<Piece>,
    },
}

impl fmt::Display for BoundaryLoop {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "{}, {:.1} mm, at {}", counted(self.edges, "edge"), self.length_mm, place(self.centre))
    }
}

impl fmt::Display for Piece {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let triangles = counted(self.triangles, "triangle");
        write!(f, "{triangles}, {:.3} mm³, at {}", self.volume_mm3, place(self.centre))
    }
}

impl fmt::Display for EdgeAt {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "{} to {}", place(self.0), place(self.1))
    }
}

fn place(p: Vec3) -> String {
    format!("({:.2}, {:.2}, {:.2})", p.x, p.y, p.z)
}

fn list<T: fmt::Display>(items: &[T]) -> String {
    let mut text: Vec<String> = items.iter().take(LISTED).map(ToString::to_string).collect();
    if items.len() > LISTED {
        text.push(format!("and {} more", items.len() - LISTED));
    }
    text.join("; ")
}
