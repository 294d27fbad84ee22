//! Tissue fixed to bone.

/// Nodes fixed to one bone segment.
#[derive(Clone, Debug, PartialEq)]
pub struct Support {
    /// Bone segment: `skull`, `maxilla` or `mandible`.
    pub bone: String,
    /// Nodes, 0-based and ascending.
    pub nodes: Vec<usize>,
}
