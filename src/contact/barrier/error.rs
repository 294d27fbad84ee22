//! Why surfaces cannot be kept apart by a barrier.

use std::fmt;

use thiserror::Error;

use super::Body;
use crate::units::Vec3;

/// How many places a message lists before it says how many more there are.
const LISTED: usize = 6;

/// An edge that passes through a triangle, or parts of the surface that touch.
#[derive(Clone, Debug, PartialEq)]
pub struct Crossing {
    /// Where, mm.
    pub at: Vec3,
    /// How far the nearer end of the edge is behind the triangle, mm; 0 where surfaces touch.
    pub depth_mm: f64,
    /// What the edge and the triangle belong to.
    pub bodies: [Body; 2],
    /// The vertices of the surface (0-based) that either has; of a vertex or an edge that touches, its own.
    pub vertices: [Vec<usize>; 2],
}

/// Why there is no barrier contact.
#[derive(Clone, Debug, Error, PartialEq)]
#[non_exhaustive]
pub enum BarrierError {
    /// Surfaces cross or touch at rest.
    #[error(
        "the surfaces cross or touch at rest in {} places, by up to {:.3} mm: {}; move them apart, or leave \
         the facets out that cross", crossings.len(), deepest(crossings), list(crossings)
    )]
    Intersecting {
        /// Every place.
        crossings: Vec<Crossing>,
    },
    /// A constant of the barrier.
    #[error("{name} of the barrier is {value}; it must be positive and finite")]
    Constant {
        /// The field.
        name: &'static str,
        /// Its value.
        value: f64,
    },
    /// A position at rest is NaN or infinite.
    #[error("vertex {vertex} (from 0) of the contact surface is not finite at rest: {value:?}")]
    NotFinite {
        /// The vertex, 0-based.
        vertex: usize,
        /// Its coordinates.
        value: [f64; 3],
    },
}

impl fmt::Display for Crossing {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let [first, second] = self.bodies;
        let p = self.at;
        write!(f, "{first} and {second} at ({:.2}, {:.2}, {:.2})", p.x, p.y, p.z)
    }
}

impl fmt::Display for Body {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::Tissue => write!(f, "tissue"),
            Self::Obstacle(k) => write!(f, "obstacle {}", k + 1),
        }
    }
}

fn deepest(crossings: &[Crossing]) -> f64 {
    crossings.iter().map(|c| c.depth_mm).fold(0., f64::max)
}

fn list(crossings: &[Crossing]) -> String {
    let mut text: Vec<String> = crossings.iter().take(LISTED).map(ToString::to_string).collect();
    if crossings.len() > LISTED {
        text.push(format!("and {} more", crossings.len() - LISTED));
    }
    text.join("; ")
}
