//! A contact candidate.

use crate::units::Vec3;

/// What a contact pair keeps apart.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash, PartialOrd, Ord)]
pub enum PairKind {
    /// Lip or cheek against the upper teeth.
    UpperTeeth,
    /// Lip or cheek against the lower teeth.
    LowerTeeth,
    /// Upper against lower lip.
    Lips,
}

/// The place on a tooth that a pair keeps its node from.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct ToothPoint {
    /// Which of the face's tooth surfaces, from 0.
    pub surface: usize,
    /// The place when the tooth is at rest, mm.
    pub at: Vec3,
}

/// A contact candidate: one row of `G` with its gap at rest.
///
/// The gap after a displacement `u` is `gap_mm + sum_k coefficient_k . u_k`; it must not be negative.
/// A unit contact force pushes node `k` by `coefficient_k` (N).
#[derive(Clone, Debug, PartialEq)]
pub struct Pair {
    /// What is kept apart.
    pub kind: PairKind,
    /// The node (0-based) whose gap this is.
    pub node: usize,
    /// The row of `G`: nodes (0-based) and their coefficients; for a tooth the node and the unit
    /// outward normal of the tooth.
    pub row: Vec<(usize, Vec3)>,
    /// Where on a tooth; `None` between the lips. The tooth may move with its bone.
    pub tooth: Option<ToothPoint>,
    /// Gap at rest, mm, never negative for a pair found at rest: a rest overlap counts as touching. Of a
    /// pair found where the tissue has moved, the gap that its linearisation has at rest.
    pub gap_mm: f64,
    /// Depth of the rest overlap, mm, 0 where there is none.
    pub rest_overlap_mm: f64,
}

impl Pair {
    /// The coefficient of the node itself: the normal that it is pushed along.
    pub fn normal(&self) -> Vec3 {
        self.row.iter().find(|(node, _)| *node == self.node).map_or(Vec3::zeros(), |(_, g)| *g)
    }

    /// Change of the gap, mm, as its place on the tooth moves by `t`, mm: `-n . t`.
    pub fn tooth_change_mm(&self, t: Vec3) -> f64 {
        self.row.iter().map(|(_, normal)| -normal.dot(&t)).sum()
    }
    /// Change of the gap, mm, under the displacement field `u` (3n, node-major xyz, mm).
    pub fn change_mm(&self, u: &[f64]) -> f64 {
        self.row.iter().map(|(n, g)| g.x * u[3 * n] + g.y * u[3 * n + 1] + g.z * u[3 * n + 2]).sum()
    }
}
