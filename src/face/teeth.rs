//! Teeth.

use crate::mesh::Surface;

/// A tooth surface: closed, outward oriented.
#[derive(Clone, Debug, PartialEq)]
pub struct Teeth {
    /// True for the upper arch.
    pub upper: bool,
    /// The bone that carries it.
    pub bone: String,
    /// The surface, mm.
    pub surface: Surface,
}
