//! Tissue fixed to bone.

/// Nodes fixed to one bone segment.
#[derive(Clone, Debug, PartialEq)]
pub struct Support {
    /// Bone segment: `skull`, `maxilla`, `mandible`, or a piece of one.
    pub bone: String,
    /// The bone of which this is a piece, cut off and healed again: what moves that one moves this too.
    pub part_of: Option<String>,
    /// Nodes, 0-based and ascending.
    pub nodes: Vec<usize>,
}
