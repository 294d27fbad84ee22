//! Lip and cheek nodes against an arch.

use std::collections::BTreeMap;

use super::{Pair, PairKind, Projection, Solid, ToothPoint};
use crate::units::Vec3;

/// Depth, mm, up to which a node came into a tooth through its closest part, whatever its tissue faces.
const SHALLOW_MM: f64 = 0.1;

/// The pairs of the nodes `nodes` (positions `points`, n x 3, mm) with the teeth `solid`, which is tooth
/// surface `surface` of the face, in the order of `nodes`: one a node that lies inside or within `cutoff_mm` outside.
///
/// The row is the outward unit normal of the tooth at the node's closest point, the gap the signed
/// distance, a negative one taken as zero and recorded as rest overlap. A node deeper than 0.1 mm inside a tooth leaves
/// it through the closest part that faces its tissue (`normals`: unit outward tissue normal at a
/// node): the closest part of all may be the far side of the arch, and pushing there would draw the
/// lip through the teeth. Nodes without a normal leave by the closest part.
pub fn teeth_pairs(
    kind: PairKind,
    surface: usize,
    solid: &Solid,
    points: &[Vec3],
    nodes: &[usize],
    normals: &BTreeMap<usize, Vec3>,
    cutoff_mm: f64,
) -> Vec<Pair> {
    let pair = |&node: &usize| {
        let p = points[node];
        let closest = solid.project(p)?;
        if closest.distance_mm > cutoff_mm {
            return None;
        }
        let tissue = normals.get(&node).filter(|_| closest.distance_mm < -SHALLOW_MM);
        let way_out = tissue.and_then(|t| solid.project_facing(p, *t)).unwrap_or(closest);
        Some(Pair {
            kind,
            node,
            row: vec![(node, way_out.normal)],
            tooth: Some(ToothPoint { surface, at: way_out.point }),
            gap_mm: closest.distance_mm.max(0.),
            rest_overlap_mm: (-closest.distance_mm).max(0.),
        })
    };
    nodes.iter().filter_map(pair).collect()
}

/// The pairs of moved nodes with the teeth `solid`: as [`teeth_pairs`], and beside the closest point of a
/// node that is no deeper inside than `near_mm` every other [plane](Solid::planes) that it may reach
/// within `near_mm`.
pub fn teeth_planes(
    kind: PairKind,
    surface: usize,
    solid: &Solid,
    points: &[Vec3],
    nodes: &[usize],
    normals: &BTreeMap<usize, Vec3>,
    [cutoff_mm, near_mm]: [f64; 2],
) -> Vec<Pair> {
    let mut pairs = Vec::new();
    for first in teeth_pairs(kind, surface, solid, points, nodes, normals, cutoff_mm) {
        let p = points[first.node];
        let distance_mm = first.gap_mm - first.rest_overlap_mm;
        let closest = Projection { point: p, normal: first.row[0].1, distance_mm };
        if distance_mm.abs() <= near_mm {
            let others = solid.planes(p, closest, distance_mm.abs() + near_mm);
            pairs.extend(others[1..].iter().map(|plane| Pair {
                row: vec![(first.node, plane.normal)],
                tooth: Some(ToothPoint { surface, at: plane.point }),
                gap_mm: plane.distance_mm.max(0.),
                rest_overlap_mm: (-plane.distance_mm).max(0.),
                ..first.clone()
            }));
        }
        pairs.push(first);
    }
    pairs
}
