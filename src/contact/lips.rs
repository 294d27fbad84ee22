//! Upper lip against lower lip.

use std::cell::OnceCell;
use std::collections::{BTreeMap, BTreeSet};

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

/// Depth, mm, up to which the closest part of a lip tells whether a node is inside it.
const SHALLOW_MM: f64 = 0.5;
/// What a node is lifted off its own tissue, mm, to ask what it is inside of: more than folds of its own surface,
/// less than a lip is thick.
const LIFT_MM: f64 = 0.5;

/// How far beyond its nodes the surface of a lip is met, mm: a lip that slides past the rim of the other, or into
/// the corner of the mouth, presses on what lies there.
const RIM_MM: f64 = 6.;

/// A lip as the other one meets it.
#[derive(Clone, Debug, PartialEq)]
pub struct Lip {
    nodes: Vec<usize>,
    surface: Facets,
}

impl Lip {
    /// Both lips of `mesh`, the outside of which is `facets`, from their nodes `upper` and `lower` (0-based). The
    /// surface of a lip is that between its nodes and what is no farther from one of them than 6 mm along the edges of
    /// facets, without the nodes of the other lip. Nodes of both lips meet neither.
    pub fn both(mesh: &Mesh, facets: &Facets, upper: &[usize], lower: &[usize]) -> [Self; 2] {
        [(upper, lower), (lower, upper)].map(|(own, other)| {
            let own: BTreeSet<usize> = own.iter().copied().collect();
            let nodes: Vec<usize> = own.iter().filter(|node| !other.contains(node)).copied().collect();
            let not_met: BTreeSet<usize> = other.iter().filter(|node| !own.contains(node)).copied().collect();
            let around = facets.around(mesh, &own, &not_met, RIM_MM);
            Self { nodes, surface: facets.within(&around) }
        })
    }

    /// The nodes (0-based) that meet the other lip or carry the surface that it meets.
    pub fn touched(&self) -> impl Iterator<Item = usize> + '_ {
        self.nodes.iter().chain(self.surface.corners().iter().flatten()).copied()
    }
}

/// The pairs of two lips, the nodes of either against the surface of the other one.
///
/// For a node `p` whose closest point `c = sum w_k x_k` on a facing facet has the unit normal `n`
/// towards the node: row `+n` at the node and `-w_k n` at the facet's nodes, gap `n . (p - c)`; a
/// negative gap is taken as zero and recorded as rest overlap. Closest points that tie share the row
/// equally, so that a mirror-symmetric face has mirror-symmetric pairs. Nodes farther than
/// `cutoff_mm`, beside the other lip, or facing away have none. Overlaps are looked for no deeper
/// than `cutoff_mm`, and inside of what `facets`, the outside of the mesh, winds round: the back of a lip also faces
/// the back of the other one, through both. A moved node within `near_mm` of the other lip has further pairs, with
/// its other feet on it and with the facets that adjoin these, as of [teeth](super::Solid::planes). Nodes are 0-based.
pub fn lip_pairs(
    mesh: &Mesh,
    facets: &Facets,
    lips: &[Lip; 2],
    cutoff_mm: f64,
    near_mm: Option<f64>,
) -> Vec<Pair> {
    let [upper, lower] = lips;
    let outside = OnceCell::new();
    let is_inside = |p| outside.get_or_init(|| Patch::new(facets, mesh)).nearest().winding(p) > 0;
    let mut pairs = against(mesh, upper, lower, cutoff_mm, near_mm, is_inside);
    pairs.extend(against(mesh, lower, upper, cutoff_mm, near_mm, is_inside));
    pairs
}

fn against(
    mesh: &Mesh,
    lip: &Lip,
    other: &Lip,
    cutoff_mm: f64,
    near_mm: Option<f64>,
    is_inside: impl Fn(Vec3) -> bool,
) -> Vec<Pair> {
    let patch = Patch::new(&other.surface, mesh);
    let normals = lip.surface.node_normals(mesh);
    let pair = |&node: &usize| {
        let (p, tissue) = (mesh.points[node], *normals.get(&node)?);
        let first = one(p, node, tissue, &patch, cutoff_mm, &is_inside)?;
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
    lip.nodes.iter().filter_map(pair).flatten().collect()
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

/// The pair of the node at `p` with its closest point before it, if it has one.
fn one(
    p: Vec3,
    node: usize,
    tissue: Vec3,
    patch: &Patch,
    cutoff_mm: f64,
    is_inside: impl Fn(Vec3) -> bool,
) -> Option<Pair> {
    let nearest = patch.nearest();
    let facing = |triangle: usize| nearest.face_normal(triangle).dot(&tissue) <= OPPOSED;
    let overlaps = |depth: f64| match depth {
        ..SHALLOW_MM => behind(p, patch),
        _ => is_inside(p + LIFT_MM * tissue),
    };
    let mut hits = nearest.hits(p, cutoff_mm, facing);
    let is_through = hits
        .first()
        .is_some_and(|hit| directed(p, tissue, hit).is_some_and(|(_, gap, _)| gap < 0. && !overlaps(-gap)));
    if is_through {
        hits = nearest.hits(p, cutoff_mm, |triangle| facing(triangle) && nearest.is_before(p, triangle));
    }
    let directed: Vec<(Vec3, f64, &Hit)> = hits.iter().filter_map(|h| directed(p, tissue, h)).collect();
    let gap = directed.first()?.1;
    if gap < 0. && is_through {
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

/// Whether `p` lies inside or on the lip of `patch`, which it is close to.
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
