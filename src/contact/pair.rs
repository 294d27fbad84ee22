//! A contact candidate.

use std::collections::BTreeMap;

use crate::units::Vec3;

/// Rows that differ by less are one: over a movement of 10 mm their gaps differ by the 0.01 mm that count
/// as none.
const SAME_ROW: f64 = 1e-3;

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

    /// Whether `other` keeps the same points apart along the same normal.
    fn is_repeated_by(&self, other: &Self) -> bool {
        let mut difference: BTreeMap<usize, Vec3> = self.row.iter().copied().collect();
        for &(node, g) in &other.row {
            *difference.entry(node).or_insert_with(Vec3::zeros) -= g;
        }
        difference.values().map(|d| d.norm_squared()).sum::<f64>() <= SAME_ROW * SAME_ROW
    }

    /// Change of the gap, mm, under the displacement field `u` (3n, node-major xyz, mm).
    pub fn change_mm(&self, u: &[f64]) -> f64 {
        self.row.iter().map(|(n, g)| g.x * u[3 * n] + g.y * u[3 * n + 1] + g.z * u[3 * n + 2]).sum()
    }
}

/// `pairs` without those that repeat another of their kind, in the same order.
///
/// Where a node of one lip lies on a node of the other, each has the other in its row, the same row twice; where it
/// comes to two flanks of a tooth that are one plane, it has that plane twice. Nearly the same rows would satisfy both
/// gaps to the last digit only with huge forces. The pair with the lesser gap keeps both apart.
pub fn without_repeats(pairs: Vec<Pair>) -> Vec<Pair> {
    let mut kept: Vec<bool> = vec![true; pairs.len()];
    let mut between: BTreeMap<(PairKind, [usize; 2]), Vec<usize>> = BTreeMap::new();
    for (k, pair) in pairs.iter().enumerate() {
        let others = pair.row.iter().filter(|(node, _)| *node != pair.node);
        let other =
            others.max_by(|a, b| a.1.norm().total_cmp(&b.1.norm())).map_or(pair.node, |(node, _)| *node);
        let nodes = [pair.node.min(other), pair.node.max(other)];
        let alike = between.entry((pair.kind, nodes)).or_default();
        let Some(old) = alike.iter_mut().find(|old| pairs[**old].is_repeated_by(pair)) else {
            alike.push(k);
            continue;
        };
        let is_nearer = pair.gap_mm < pairs[*old].gap_mm;
        kept[if is_nearer { std::mem::replace(old, k) } else { k }] = false;
    }
    pairs.into_iter().zip(kept).filter_map(|(pair, is_kept)| is_kept.then_some(pair)).collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    fn lips(node: usize, row: &[(usize, f64)], gap_mm: f64) -> Pair {
        let row = row.iter().map(|&(n, g)| (n, g * Vec3::y())).collect();
        Pair { kind: PairKind::Lips, node, row, tooth: None, gap_mm, rest_overlap_mm: 0. }
    }

    #[test]
    fn of_two_nodes_that_face_each_other_the_lesser_gap_stays() {
        let upper = lips(4, &[(4, 1.), (7, -1.)], 0.2);
        let slid = lips(7, &[(3, 5e-4), (4, 1. - 5e-4), (7, -1.)], 0.1);
        let apart = lips(7, &[(3, 5e-3), (4, 1. - 5e-3), (7, -1.)], 0.1);
        let of_tooth = Pair { kind: PairKind::UpperTeeth, ..upper.clone() };
        let all = vec![of_tooth.clone(), upper.clone(), slid.clone()];
        assert_eq!(without_repeats(all), [of_tooth, slid.clone()]);
        assert_eq!(without_repeats(vec![slid.clone(), upper.clone()]), [slid]);
        let two = vec![upper, apart];
        assert_eq!(without_repeats(two.clone()), two);
    }

    #[test]
    fn a_plane_of_a_tooth_that_repeats_another_is_left_out() {
        let plane = |normal: Vec3, gap_mm: f64| {
            let row = vec![(2, normal.normalize())];
            Pair { kind: PairKind::UpperTeeth, node: 2, row, tooth: None, gap_mm, rest_overlap_mm: 0. }
        };
        let flat = plane(Vec3::new(0., 0., 1.), 0.3);
        let tilted = plane(Vec3::new(5e-4, 0., 1.), 0.2);
        let other = plane(Vec3::new(5e-2, 0., 1.), 0.2);
        let lower = Pair { kind: PairKind::LowerTeeth, ..flat.clone() };
        let all = vec![flat, tilted.clone(), other.clone(), lower.clone()];
        assert_eq!(without_repeats(all), [tilted, other, lower]);
    }
}
