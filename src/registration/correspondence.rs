//! Points of the skin and of the scan that correspond.

use rayon::prelude::*;

use super::sheet::{Foot, Sheet};
use crate::contact::Facets;
use crate::face::Face;
use crate::mesh::{Facet, Skin, boundary_facets};
use crate::units::Vec3;

/// A point of the face held to a place.
#[derive(Clone, Debug)]
pub(super) struct Tie {
    /// Nodes and weights of the point of the face.
    pub(super) carriers: Vec<(usize, f64)>,
    /// The place, mm.
    pub(super) target: Vec3,
    /// Unit normal of the surfaces there.
    pub(super) normal: Vec3,
    /// Area that it stands for, mm².
    pub(super) area: f64,
    /// How far apart the two are, mm.
    pub(super) distance_mm: f64,
}

/// The skin of a face: its triangles and which node each vertex is.
#[derive(Clone, Debug)]
pub(super) struct FaceSkin {
    facets: Vec<Facet>,
}

/// The skin of a face somewhere.
pub(super) struct SkinAt {
    pub(super) sheet: Sheet,
    /// The mesh node of each vertex.
    pub(super) nodes: Vec<usize>,
}

impl FaceSkin {
    pub(super) fn of(face: &Face) -> Self {
        let is_skin = |facet: &Facet| facet.corners().iter().all(|n| face.skin.binary_search(n).is_ok());
        Self { facets: boundary_facets(&face.mesh).into_iter().filter(is_skin).collect() }
    }

    /// The skin with the nodes of `face` at `x` (n, mm).
    pub(super) fn at(&self, face: &Face, x: &[Vec3]) -> SkinAt {
        let mut mesh = face.mesh.clone();
        mesh.points = x.to_vec();
        let Skin { surface, nodes, .. } = Skin::new(&mesh, &self.facets);
        SkinAt { sheet: Sheet::new(surface), nodes }
    }
}

/// How much farther from a point of the scan than the skin the scan's own point nearest to that skin may be, mm: the depth
/// of a nostril has no skin of its own.
const MUTUAL_MM: f64 = 1.;

/// The point of `sheet` that corresponds to `p` with the unit normal `normal` within `reach` (mm): the nearest that faces the
/// same way, unless the sheet ends before it.
pub(super) fn counterpart(sheet: &Sheet, p: Vec3, normal: Vec3, reach: f64) -> Option<Foot> {
    let foot = sheet.nearest(p, Some(normal), reach).filter(|foot| !foot.is_rim)?;
    let ends_before = sheet.nearest(p, None, foot.distance_mm).is_some_and(|nearest| nearest.is_rim);
    (!ends_before).then_some(foot)
}

/// What corresponds between `skin` and `scan` within `reach` (mm): from each vertex of the skin to the scan and from
/// each of the scan's `vertices` to the skin.
///
/// The normal of a tie is the mean of both surfaces' (Rusinkiewicz, ACM Trans. Graph. 38 (2019) 85).
pub(super) fn correspond(skin: &SkinAt, scan: &Sheet, vertices: &[usize], reach: f64) -> Vec<Tie> {
    let from_skin = (0..skin.nodes.len()).into_par_iter().filter_map(|v| {
        let (x, normal) = (skin.sheet.surface.points[v], skin.sheet.normals[v]);
        let foot = counterpart(scan, x, normal, reach)?;
        Some(Tie {
            carriers: vec![(skin.nodes[v], 1.)],
            target: foot.point,
            normal: (normal + foot.normal).try_normalize(0.)?,
            area: skin.sheet.areas[v],
            distance_mm: foot.distance_mm,
        })
    });
    let from_scan = vertices.par_iter().filter_map(|&v| {
        let (y, normal) = (scan.surface.points[v], scan.normals[v]);
        if scan.on_rim[v] || normal == Vec3::zeros() {
            return None;
        }
        let foot = counterpart(&skin.sheet, y, normal, reach)?;
        let back = scan.nearest(foot.point, Some(foot.normal), reach)?;
        if (back.point - y).norm() > foot.distance_mm + MUTUAL_MM {
            return None;
        }
        Some(Tie {
            carriers: foot.carriers.iter().map(|&(v, w)| (skin.nodes[v], w)).collect(),
            target: y,
            normal: (normal + foot.normal).try_normalize(0.)?,
            area: scan.areas[v],
            distance_mm: foot.distance_mm,
        })
    });
    let mut ties: Vec<Tie> = from_skin.collect();
    ties.par_extend(from_scan);
    ties
}

/// Nodes on the inside of `face`, those on bones and the mucosa, that are not skin; ascending.
pub(super) fn inner_nodes(face: &Face) -> Vec<usize> {
    let on_bones = face.supports.iter().flat_map(|support| &support.nodes);
    let mut nodes: Vec<usize> = on_bones.chain(&face.mucosa).copied().collect();
    nodes.sort_unstable();
    nodes.dedup();
    nodes.retain(|n| face.skin.binary_search(n).is_err());
    nodes
}

/// Area of the inner surface at each of `nodes`, mm²; a mean one where the node is not on it.
pub(super) fn inner_areas(face: &Face, nodes: &[usize]) -> Vec<f64> {
    let areas = Facets::of(&face.mesh).within(nodes).node_areas(&face.mesh);
    let mean = areas.values().sum::<f64>() / areas.len().max(1) as f64;
    nodes.iter().map(|n| areas.get(n).copied().unwrap_or(mean)).collect()
}
