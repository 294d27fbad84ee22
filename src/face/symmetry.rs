//! How far the two sides of a moved face are from mirror images.

use std::collections::HashSet;

use super::Face;
use super::mirror_image::mirrored;
use crate::mesh::{Locator, Site};
use crate::units::Vec3;

/// How far the skin may be from the mirror image of a point of the other side, mm, for the two to be compared.
const PARTNER_MM: f64 = 5.;

/// How far the two sides of a moved face are from mirror images in the mid-sagittal plane `x = 0`.
#[derive(Clone, Debug, PartialEq)]
pub struct Symmetry {
    /// Landmarks that there are on both sides.
    pub pairs: Vec<PairSymmetry>,
    /// Landmarks in the middle and their movement to the subject's left, mm.
    pub middle: Vec<(String, f64)>,
    /// Root mean square over the pairs of [`PairSymmetry::difference_mm`], mm: the mirror RMS.
    pub mirror_rms_mm: f64,
    /// Of every node (n): how far its movement is from the mirror image of that of the skin opposite, mm; NaN where it is not
    /// on the skin or has no skin opposite.
    pub map_mm: Vec<f64>,
}

/// A landmark of both sides.
#[derive(Clone, Debug, PartialEq)]
pub struct PairSymmetry {
    /// Its name without the side.
    pub name: String,
    /// Distance at rest between the one and the mirror image of the other, mm.
    pub rest_mm: f64,
    /// Movement of the left one, mm.
    pub left_mm: Vec3,
    /// Movement of the right one, mm.
    pub right_mm: Vec3,
    /// Height of the left one above the right one when moved, mm, less that at rest.
    pub height_mm: f64,
}

impl PairSymmetry {
    /// Length of the difference between the left movement and the mirror image of the right one, mm.
    pub fn difference_mm(&self) -> f64 {
        (self.left_mm - mirrored(self.right_mm)).norm()
    }

    /// Lengths of the movements, left first, mm: the excursions.
    pub fn excursion_mm(&self) -> [f64; 2] {
        [self.left_mm.norm(), self.right_mm.norm()]
    }

    /// The lesser excursion divided by the greater, 0 to 1; `None` where neither moves.
    pub fn excursion_ratio(&self) -> Option<f64> {
        let [left, right] = self.excursion_mm();
        (left.max(right) > 0.).then(|| left.min(right) / left.max(right))
    }

    /// Directions of the movements as seen from the front, left first, degrees above the horizontal that leads outward;
    /// `None` where one does not move there.
    pub fn direction_deg(&self) -> [Option<f64>; 2] {
        let of = |u: Vec3| (u.x.hypot(u.y) > 0.).then(|| u.y.atan2(u.x).to_degrees());
        [of(self.left_mm), of(mirrored(self.right_mm))]
    }
}

impl Symmetry {
    /// That of `face` moved by `displacement` (3n, mm).
    pub fn of(face: &Face, displacement: &[f64]) -> Self {
        let mut pairs = Vec::new();
        let mut middle = Vec::new();
        for landmark in &face.landmarks {
            if let Some(stem) = landmark.name.strip_suffix("_l") {
                let Some(other) = face.landmark(&format!("{stem}_r")) else { continue };
                let [left, right] = [landmark, other].map(|l| &l.site);
                let [left_mm, right_mm] = [left, right].map(|site| site.displacement(displacement));
                pairs.push(PairSymmetry {
                    name: stem.to_owned(),
                    rest_mm: (left.position - mirrored(right.position)).norm(),
                    left_mm,
                    right_mm,
                    height_mm: left_mm.y - right_mm.y,
                });
            } else if !landmark.name.ends_with("_r") {
                middle.push((landmark.name.clone(), landmark.site.displacement(displacement).x));
            }
        }
        let squares: f64 = pairs.iter().map(|pair| pair.difference_mm().powi(2)).sum();
        let mirror_rms_mm = (squares / pairs.len().max(1) as f64).sqrt();
        Self { mirror_rms_mm, map_mm: map(face, displacement), pairs, middle }
    }

    /// The pair that is farthest from a mirror image.
    pub fn worst(&self) -> Option<&PairSymmetry> {
        self.pairs.iter().max_by(|a, b| a.difference_mm().total_cmp(&b.difference_mm()))
    }
}

/// For each node of the skin of `face`, in their order: the point of the skin that its mirror image in `x = 0` is nearest
/// to; `None` where that is farther away than the two sides may be compared over.
pub fn opposite_skin(face: &Face) -> Vec<Option<Site>> {
    let locator = Locator::new(&face.mesh);
    let skin: HashSet<usize> = face.skin.iter().copied().collect();
    let is_skin = |nodes: &[usize]| nodes.iter().all(|n| skin.contains(n));
    let opposite = |node: &usize| {
        let image = mirrored(face.mesh.points[*node]);
        let found = locator.closest_among(image, |facet| is_skin(facet.nodes()));
        found.filter(|found| found.distance_mm <= PARTNER_MM).map(|found| found.site)
    };
    face.skin.iter().map(opposite).collect()
}

fn map(face: &Face, displacement: &[f64]) -> Vec<f64> {
    let at = |n: usize| Vec3::new(displacement[3 * n], displacement[3 * n + 1], displacement[3 * n + 2]);
    let mut map = vec![f64::NAN; face.mesh.n_nodes()];
    for (&node, site) in face.skin.iter().zip(opposite_skin(face)) {
        let Some(site) = site else { continue };
        map[node] = (at(node) - mirrored(site.displacement(displacement))).norm();
    }
    map
}
