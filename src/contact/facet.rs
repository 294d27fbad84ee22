//! The outer facets of a volume mesh and the normals of its nodes.

use std::collections::{BTreeMap, BTreeSet, HashSet};

use super::nearest::{Hit, Nearest};
use crate::mesh::{Mesh, Site, Surface, boundary_facets};
use crate::units::Vec3;

/// Weights below this are rounding, and would make a row of one side longer than its mirror image.
const NO_WEIGHT: f64 = 1e-12;

/// The cell faces on the outside of a mesh, by their corner nodes (0-based, counter-clockwise seen
/// from outside), in the order of the cells.
#[derive(Clone, Debug, PartialEq)]
pub struct Facets {
    corners: Vec<Vec<usize>>,
}

impl Facets {
    /// The facets that bound `mesh`; of quadratic ones the corners.
    pub fn of(mesh: &Mesh) -> Self {
        let corners = boundary_facets(mesh).iter().map(|f| f.corners().to_vec()).collect();
        Self { corners }
    }

    /// The facets all of whose corners are among `nodes`.
    #[must_use]
    pub fn within(&self, nodes: &[usize]) -> Self {
        let nodes: HashSet<usize> = nodes.iter().copied().collect();
        let corners = self.corners.iter().filter(|f| f.iter().all(|v| nodes.contains(v))).cloned().collect();
        Self { corners }
    }

    /// `nodes` and those no farther than `reach_mm` from one of them along the edges of facets, on ways that touch
    /// none of `barred`; 0-based, ascending.
    pub fn around(
        &self,
        mesh: &Mesh,
        nodes: &BTreeSet<usize>,
        barred: &BTreeSet<usize>,
        reach_mm: f64,
    ) -> Vec<usize> {
        let mut way: BTreeMap<usize, f64> = nodes.iter().map(|&node| (node, 0.)).collect();
        loop {
            let mut shorter = false;
            for facet in &self.corners {
                for (k, &from) in facet.iter().enumerate() {
                    for to in [facet[(k + 1) % facet.len()], facet[(k + facet.len() - 1) % facet.len()]] {
                        let Some(walked) = way.get(&from) else { continue };
                        let walked = walked + (mesh.points[to] - mesh.points[from]).norm();
                        let is_shorter = way.get(&to).is_none_or(|known| walked < *known);
                        if walked <= reach_mm && is_shorter && !barred.contains(&to) {
                            way.insert(to, walked);
                            shorter = true;
                        }
                    }
                }
            }
            if !shorter {
                return way.into_keys().collect();
            }
        }
    }

    /// Number of facets.
    pub fn len(&self) -> usize {
        self.corners.len()
    }

    /// Whether there is none.
    pub fn is_empty(&self) -> bool {
        self.corners.is_empty()
    }

    /// The corner nodes of each facet.
    pub fn corners(&self) -> &[Vec<usize>] {
        &self.corners
    }

    /// Unit outward normal of the tissue at each node that has one: the mean over its facets,
    /// weighted by their areas.
    pub fn node_normals(&self, mesh: &Mesh) -> BTreeMap<usize, Vec3> {
        let mut normals: BTreeMap<usize, Vec3> = BTreeMap::new();
        for facet in &self.corners {
            let area = area_vector(facet, mesh);
            for node in facet {
                *normals.entry(*node).or_insert_with(Vec3::zeros) += area;
            }
        }
        normals.into_iter().filter_map(|(node, n)| Some((node, n.try_normalize(0.)?))).collect()
    }

    /// Area that belongs to each node, mm²: the integral of its shape function over its facets, so that a
    /// uniform pressure `p` loads node `i` with `p A_i`.
    pub fn node_areas(&self, mesh: &Mesh) -> BTreeMap<usize, f64> {
        let mut areas = BTreeMap::new();
        for facet in &self.corners {
            let corners: Vec<Vec3> = facet.iter().map(|&node| mesh.points[node]).collect();
            for (node, area) in facet.iter().zip(corner_areas(&corners)) {
                *areas.entry(*node).or_insert(0.) += area;
            }
        }
        areas
    }
}

/// What each corner of a facet has of its area, mm²: the integral of its linear or bilinear shape function,
/// exact for triangles and plane quadrilaterals (2 x 2 Gauss points).
fn corner_areas(corners: &[Vec3]) -> Vec<f64> {
    let &[a, b, c, d] = corners else {
        let area = (1..corners.len().saturating_sub(1))
            .map(|k| (corners[k] - corners[0]).cross(&(corners[k + 1] - corners[0])).norm() / 2.)
            .sum::<f64>();
        return vec![area / corners.len() as f64; corners.len()];
    };
    let mut areas = vec![0.; 4];
    let g = 0.5 / 3f64.sqrt();
    for (x, y) in [(0.5 - g, 0.5 - g), (0.5 + g, 0.5 - g), (0.5 + g, 0.5 + g), (0.5 - g, 0.5 + g)] {
        let along_x = (1. - y) * (b - a) + y * (c - d);
        let along_y = (1. - x) * (d - a) + x * (c - b);
        let area = along_x.cross(&along_y).norm() / 4.;
        let shape = [(1. - x) * (1. - y), x * (1. - y), x * y, (1. - x) * y];
        areas.iter_mut().zip(shape).for_each(|(sum, n)| *sum += n * area);
    }
    areas
}

/// Area times unit normal, mm²: the sum over a fan about the middle of the facet.
fn area_vector(facet: &[usize], mesh: &Mesh) -> Vec3 {
    let at = |k: usize| mesh.points[facet[k % facet.len()]];
    (0..facet.len()).map(|k| at(k).cross(&at(k + 1))).sum::<Vec3>() / 2.
}

/// Facets as triangles for nearest-point queries, each vertex carried by nodes.
///
/// A quadrilateral becomes four triangles about its middle: a diagonal would not mirror.
#[derive(Clone, Debug)]
pub struct Patch {
    nearest: Nearest,
    carriers: Vec<Vec<(usize, f64)>>,
}

impl Patch {
    /// A patch of `facets` of `mesh`.
    pub fn new(facets: &Facets, mesh: &Mesh) -> Self {
        let mut vertex = BTreeMap::new();
        let (mut surface, mut carriers) = (Surface::default(), Vec::new());
        for facet in facets.corners() {
            let mut rim = Vec::with_capacity(facet.len());
            for &node in facet {
                rim.push(*vertex.entry(node).or_insert_with(|| {
                    surface.points.push(mesh.points[node]);
                    carriers.push(vec![(node, 1.)]);
                    carriers.len() - 1
                }));
            }
            if let &[a, b, c] = rim.as_slice() {
                surface.triangles.push([a, b, c]);
                continue;
            }
            let share = 1. / facet.len() as f64;
            surface.points.push(facet.iter().map(|&v| mesh.points[v]).sum::<Vec3>() * share);
            carriers.push(facet.iter().map(|&v| (v, share)).collect());
            let hub = carriers.len() - 1;
            for k in 0..rim.len() {
                surface.triangles.push([rim[k], rim[(k + 1) % rim.len()], hub]);
            }
        }
        Self { nearest: Nearest::new(surface), carriers }
    }

    /// The material point of the patch closest to `p` (the first of several) and its distance, mm; `None` for
    /// an empty patch or a point that is not finite.
    pub fn project(&self, p: Vec3) -> Option<(Site, f64)> {
        let hits = self.nearest.hits(p, f64::MAX, |_| true);
        let hit = hits.first()?;
        let weights = self.carriers(hit).into_iter().collect();
        Some((Site { position: hit.at.point, weights }, hit.distance))
    }

    pub(super) fn nearest(&self) -> &Nearest {
        &self.nearest
    }

    /// Nodes and weights that carry the closest point of `hit`.
    pub(super) fn carriers(&self, hit: &Hit) -> BTreeMap<usize, f64> {
        let mut weights = BTreeMap::new();
        let corners = self.nearest.surface().triangles[hit.triangle];
        for (vertex, w) in corners.into_iter().zip(hit.at.weights).filter(|(_, w)| *w > NO_WEIGHT) {
            for &(node, share) in &self.carriers[vertex] {
                *weights.entry(node).or_insert(0.) += w * share;
            }
        }
        weights
    }
}
