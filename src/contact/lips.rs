//! Upper lip against lower lip.

use std::collections::BTreeMap;

use super::facet::{Facets, Patch};
use super::nearest::{Hit, TOUCHING_MM};
use super::solid::{ADJOINING_MM, NEARER_MM, SAME, holds};
use super::{Pair, PairKind};
use crate::mesh::Mesh;
use crate::units::Vec3;

/// Cosine between the normals of two surfaces that face each other, at most.
const OPPOSED: f64 = -0.25;

/// Cosine between the contact direction and the normal of the surface met, at least: less is a
/// point beside the surface, not before it.
const BEFORE: f64 = 0.5;

/// The pairs of two lips, the nodes `upper` against the facets of `lower` and the other way round.
///
/// For a node `p` whose closest point `c = sum w_k x_k` on a facing facet has the unit normal `n`
/// towards the node: row `+n` at the node and `-w_k n` at the facet's nodes, gap `n . (p - c)`; a
/// negative gap is taken as zero and recorded as rest overlap. Closest points that tie share the row
/// equally, so that a mirror-symmetric face has mirror-symmetric pairs. Nodes farther than
/// `cutoff_mm`, beside the other lip, or facing away have none. Overlaps are looked for no deeper
/// than `cutoff_mm`. A moved node within `near_mm` of the other lip has further pairs, with its other feet on it
/// and with the facets that adjoin these, as of [teeth](super::Solid::planes). Nodes are 0-based.
pub fn lip_pairs(
    mesh: &Mesh,
    facets: &Facets,
    upper: &[usize],
    lower: &[usize],
    cutoff_mm: f64,
    near_mm: Option<f64>,
) -> Vec<Pair> {
    let mut pairs = against(mesh, facets, upper, lower, cutoff_mm, near_mm);
    pairs.extend(against(mesh, facets, lower, upper, cutoff_mm, near_mm));
    pairs
}

fn against(
    mesh: &Mesh,
    facets: &Facets,
    nodes: &[usize],
    others: &[usize],
    cutoff_mm: f64,
    near_mm: Option<f64>,
) -> Vec<Pair> {
    let patch = Patch::new(&facets.within(others), mesh);
    let normals = facets.within(nodes).node_normals(mesh);
    let pair = |&node: &usize| {
        let (p, tissue) = (mesh.points[node], *normals.get(&node)?);
        let first = one(p, node, tissue, &patch, cutoff_mm)?;
        let distance_mm = first.gap_mm - first.rest_overlap_mm;
        let mut pairs = match near_mm {
            Some(near) if distance_mm.abs() <= near => {
                planes(p, tissue, &first, &patch, distance_mm.abs() + near)
            }
            _ => Vec::new(),
        };
        pairs.push(first);
        Some(pairs)
    };
    nodes.iter().filter(|node| !others.contains(node)).filter_map(pair).flatten().collect()
}

/// Beside the pair `first` of a moved node at `p` those with the other feet of `p` on the facing parts of the
/// patch and with the facets that adjoin a foot, as of [teeth](super::Solid::planes).
fn planes(p: Vec3, tissue: Vec3, first: &Pair, patch: &Patch, reach: f64) -> Vec<Pair> {
    let nearest = patch.nearest();
    let distance_mm = first.gap_mm - first.rest_overlap_mm;
    let mut found: Vec<(Vec3, f64)> = vec![(first.normal(), distance_mm)];
    let mut pairs = Vec::new();
    let mut add = |normal: Vec3, gap: f64, hit: &Hit| {
        let is_new = found.iter().all(|(n, d)| n.dot(&normal) < SAME || (d - gap).abs() > NEARER_MM);
        if is_new && holds(distance_mm, gap) && normal.dot(&tissue) <= OPPOSED {
            found.push((normal, gap));
            let mut row = BTreeMap::from([(first.node, normal)]);
            for (other, w) in patch.carriers(hit) {
                *row.entry(other).or_insert_with(Vec3::zeros) -= w * normal;
            }
            let (gap_mm, rest_overlap_mm) = (gap.max(0.), (-gap).max(0.));
            pairs.push(Pair { row: row.into_iter().collect(), gap_mm, rest_overlap_mm, ..first.clone() });
        }
    };
    for foot in nearest.feet(p, reach) {
        if nearest.face_normal(foot.triangle).dot(&tissue) > OPPOSED {
            continue;
        }
        if let Some((normal, gap, hit)) = directed(p, tissue, &foot)
            && (gap >= 0. || gap >= distance_mm - NEARER_MM)
        {
            add(normal, gap, hit);
        }
        for hit in nearest.adjoining(&foot, ADJOINING_MM) {
            let normal = nearest.face_normal(hit.triangle);
            add(normal, (p - hit.at.point).dot(&normal), &hit);
        }
    }
    pairs
}

fn one(p: Vec3, node: usize, tissue: Vec3, patch: &Patch, cutoff_mm: f64) -> Option<Pair> {
    let facing = |triangle| patch.nearest().face_normal(triangle).dot(&tissue) <= OPPOSED;
    let hits = patch.nearest().hits(p, cutoff_mm, facing);
    let directed: Vec<(Vec3, f64, &Hit)> = hits.iter().filter_map(|h| directed(p, tissue, h)).collect();
    let gap = directed.first()?.1;
    if gap < 0. && !behind(p, patch) {
        return None;
    }
    let share = 1. / directed.len() as f64;
    let mut row: BTreeMap<usize, Vec3> = BTreeMap::new();
    // Each tie pushes along its own normal, so that the forces on the facets mirror too; their
    // resultant on the node keeps the pair in balance.
    for (normal, _, hit) in &directed {
        *row.entry(node).or_insert_with(Vec3::zeros) += share * normal;
        for (other, w) in patch.carriers(hit) {
            *row.entry(other).or_insert_with(Vec3::zeros) -= share * w * normal;
        }
    }
    Some(Pair {
        kind: PairKind::Lips,
        node,
        row: row.into_iter().collect(),
        tooth: None,
        gap_mm: gap.max(0.),
        rest_overlap_mm: (-gap).max(0.),
    })
}

/// Whether `p` lies inside or on the lip of `patch`: the back of a lip also faces the back of the other
/// one, through both lips, and must not pass for an overlap.
fn behind(p: Vec3, patch: &Patch) -> bool {
    let hits = patch.nearest().hits(p, f64::MAX, |_| true);
    hits.first().is_some_and(|h| (p - h.at.point).dot(&h.normal) <= TOUCHING_MM)
}

/// Contact normal and signed gap of one closest point, or `None` when the surfaces do not meet there.
fn directed(p: Vec3, tissue: Vec3, hit: &Hit) -> Option<(Vec3, f64, &Hit)> {
    let away = p - hit.at.point;
    let side = if away.dot(&hit.normal) < 0. { -1. } else { 1. };
    let normal = if hit.distance > TOUCHING_MM { side * away / hit.distance } else { hit.normal };
    let meets = normal.dot(&hit.normal) >= BEFORE && normal.dot(&tissue) <= OPPOSED;
    meets.then_some((normal, side * hit.distance, hit))
}
