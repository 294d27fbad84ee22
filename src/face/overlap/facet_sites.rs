//! Dense samples of the outside of the tissue.

use std::collections::{BTreeSet, HashSet};

use crate::face::Face;
use crate::mesh::{Facet, Mesh, Site, boundary_facets};
use crate::units::Vec3;

/// Intervals along an edge of a facet: 6 x 6 samples of a quadrilateral, its edges and corners among them.
const INTERVALS: u16 = 5;

/// How far beyond the mucosa, the lips and the teeth, mm, the outside is sampled.
const AROUND_MM: f64 = 10.;

/// The samples of one facet. Those on edges and corners belong to the first facet that has them.
#[derive(Clone, Debug)]
pub(super) struct FacetSites {
    /// Number of the first of them in the whole list.
    pub(super) first: usize,
    /// The facet's nodes (0-based).
    pub(super) nodes: Vec<usize>,
    pub(super) sites: Vec<Site>,
}

/// The samples of the outside of `face` about its mouth, in the order of the cells: on facets no farther than 10 mm from
/// the box of mucosa, lips and teeth, but not where only nodes that are `fixed` to bone carry them.
pub(super) fn facet_sites(face: &Face, fixed: &HashSet<usize>) -> Vec<FacetSites> {
    let mesh = &face.mesh;
    let nodes = face.mucosa.iter().chain(&face.upper_lip).chain(&face.lower_lip).map(|&n| mesh.points[n]);
    let teeth = face.teeth.iter().flat_map(|t| t.surface.points.iter().copied());
    let empty = (Vec3::repeat(f64::INFINITY), Vec3::repeat(f64::NEG_INFINITY));
    let (lo, hi) = nodes.chain(teeth).fold(empty, |(lo, hi), p| (lo.inf(&p), hi.sup(&p)));
    let (lo, hi) = (lo - Vec3::repeat(AROUND_MM), hi + Vec3::repeat(AROUND_MM));
    let is_near = |p: Vec3| (0..3).all(|k| lo[k] <= p[k] && p[k] <= hi[k]);
    let sampled = |facet: &Facet| {
        facet.corners().iter().any(|node| !fixed.contains(node))
            && facet.corners().iter().any(|&node| is_near(mesh.points[node]))
    };
    let (mut all, mut first, mut known) = (Vec::new(), 0, BTreeSet::new());
    for facet in boundary_facets(mesh).iter().filter(|f| sampled(f)) {
        let nodes = facet.nodes().to_vec();
        let sites: Vec<Site> = lattice(facet.corners().len())
            .filter(|w| w.iter().all(|w| *w > 0) || known.insert(shared(facet.corners(), *w)))
            .map(|w| site(mesh, facet, w))
            .filter(|site| site.weights.iter().any(|(node, _)| !fixed.contains(node)))
            .collect();
        let next = first + sites.len();
        all.push(FacetSites { first, nodes, sites });
        first = next;
    }
    all
}

/// Weights of a facet's corners at its samples: whole numbers, which tell edges and corners exactly.
fn lattice(n_corners: usize) -> impl Iterator<Item = [u16; 4]> {
    let n = INTERVALS;
    let weights = move |i: u16, j: u16| match n_corners {
        3 => (i + j <= n).then(|| [(n - i - j) * n, i * n, j * n, 0]),
        _ => Some([(n - i) * (n - j), i * (n - j), i * j, (n - i) * j]),
    };
    (0..=n).flat_map(move |i| (0..=n).filter_map(move |j| weights(i, j)))
}

/// The corners that carry a sample and their weights: equal for two facets that share it.
fn shared(corners: &[usize], weights: [u16; 4]) -> Vec<(usize, u16)> {
    let mut carried: Vec<_> = corners.iter().copied().zip(weights).filter(|(_, w)| *w > 0).collect();
    carried.sort_unstable();
    carried
}

fn site(mesh: &Mesh, facet: &Facet, weights: [u16; 4]) -> Site {
    let cell = &mesh.cells[facet.cell];
    let reference = cell.kind().node_positions();
    let corners = cell.kind().faces()[facet.face];
    let whole = f64::from(INTERVALS * INTERVALS);
    let xi = corners.iter().zip(weights).map(|(&c, w)| f64::from(w) / whole * Vec3::from(reference[c])).sum();
    Site::in_cell(cell, xi, &mesh.points)
}
