//! A closed surface as a solid: signed distance, closest point and outward normal.

use super::closed_surface::{part, pieces};
use super::nearest::{Hit, Nearest, TOUCHING_MM};
use crate::mesh::Surface;
use crate::units::Vec3;

/// Cosine between a facing triangle's normal and the direction it must face, at most.
const FACING: f64 = -0.25;

/// Triangles this close to a foot touch what touches the foot, mm.
pub(super) const ADJOINING_MM: f64 = 0.05;

/// How much nearer than the solid the plane of an adjoining triangle may be, mm.
pub(super) const NEARER_MM: f64 = 0.01;

/// Up to this distance, mm, from an edge both its sides hold a point that is about above it,
const PINCH_MM: f64 = 0.3;
/// which is when their planes are nearer by at most this share of the distance.
const PINCH: f64 = 0.3;

/// Cosine between normals of planes that are one.
pub(super) const SAME: f64 = 0.999;

/// Where a point is with respect to a solid.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Projection {
    /// Closest point of the surface, mm; the mean of them where several are equally close.
    pub point: Vec3,
    /// Unit outward normal there: the gradient of the signed distance.
    pub normal: Vec3,
    /// Signed distance, mm, negative inside.
    pub distance_mm: f64,
}

impl Projection {
    /// The same point with `p` on the other side.
    fn turned(self) -> Self {
        Self { normal: -self.normal, distance_mm: -self.distance_mm, ..self }
    }
}

/// The union of the solids that the pieces of a closed, outward-oriented surface enclose.
#[derive(Clone, Debug)]
pub struct Solid {
    pieces: Vec<Nearest>,
}

impl Solid {
    /// The solid inside `surface`, which must be closed and outward oriented
    /// ([`closed_surface`](super::closed_surface) makes it so); an open one gives wrong signs near
    /// its rim.
    pub fn new(surface: &Surface) -> Self {
        let pieces = pieces(surface).iter().map(|t| Nearest::new(part(surface, t))).collect();
        Self { pieces }
    }

    /// Signed distance of `p` with its closest point and outward normal; `None` for a solid without
    /// triangles or a point that is not finite.
    ///
    /// `d(p) = min over pieces of s |p - c|`, with `s` the side of the angle-weighted pseudo-normal.
    /// Exact outside; inside overlapping pieces its size is a lower bound of the depth. Where that side
    /// contradicts the number of times that the surfaces wind round `p`, real surfaces cross themselves there: then
    /// the closest sheet with nothing outside it is the surface, and the winding says on which side of it `p` lies.
    pub fn project(&self, p: Vec3) -> Option<Projection> {
        let nearest = |piece: &Nearest| blend(p, &piece.hits(p, f64::MAX, |_| true));
        let found = self.closest(nearest, |d| d)?;
        let inside = self.winding(p) > 0;
        if inside == (found.distance_mm < 0.) || found.distance_mm.abs() <= TOUCHING_MM {
            return Some(found);
        }
        let exposed = |piece: &Nearest| {
            let hits = piece.hits(p, f64::MAX, |triangle| self.is_exposed(piece, triangle));
            blend(p, &hits)
                .map(|found| if (found.distance_mm < 0.) == inside { found } else { found.turned() })
        };
        self.closest(exposed, f64::abs).or(Some(found))
    }

    /// The closest point of `p` among the parts of the surface that face against the unit vector
    /// `tissue`, the outward normal of the tissue at `p`: where a point deep inside a thin solid
    /// should leave it, when the nearest way out is through the far side.
    ///
    /// The normal is the direction from `p` to that point, or the surface's where that direction
    /// does not face the tissue.
    pub fn project_facing(&self, p: Vec3, tissue: Vec3) -> Option<Projection> {
        let nearest = |piece: &Nearest| {
            let hits = piece.hits(p, f64::MAX, |triangle| piece.face_normal(triangle).dot(&tissue) <= FACING);
            let blended = blend(p, &hits)?;
            if blended.normal.dot(&tissue) <= FACING {
                return Some(blended);
            }
            let faces: Vec3 = hits.iter().map(|h| piece.face_normal(h.triangle)).sum();
            Some(Projection { normal: faces.try_normalize(0.)?, ..blended })
        };
        self.closest(nearest, f64::abs)
    }

    /// The planes that bound the way of `p`, which lies outside or hardly inside: the tangent plane at its
    /// closest point `first`, those at every other foot of `p` on the solid that is no farther than `reach`, and
    /// those of the triangles that adjoin a foot.
    ///
    /// Near `p` the solid is the union of what lies behind these planes as long as each of its parts is convex:
    /// `d(p) = min over feet of |p - c|`, one foot on either flank of a groove. At an edge the planes of both
    /// sides hold `p` exactly there, with a force anywhere between their normals; one is left out as soon as it
    /// lies nearer than the solid itself by more than 0.01 mm, which would hold `p` off.
    pub fn planes(&self, p: Vec3, first: Projection, reach: f64) -> Vec<Projection> {
        let mut planes = vec![first];
        let mut add = |plane: Projection| {
            let is_new = planes.iter().all(|old| {
                old.normal.dot(&plane.normal) < SAME
                    || (old.distance_mm - plane.distance_mm).abs() > NEARER_MM
            });
            if is_new && holds(first.distance_mm, plane.distance_mm) {
                planes.push(plane);
            }
        };
        for piece in &self.pieces {
            let mut feet = piece.feet(p, reach.max(first.distance_mm.abs() + ADJOINING_MM));
            feet.retain(|foot| (p - foot.at.point).dot(&foot.normal) >= 0. || foot.distance <= ADJOINING_MM);
            for foot in &feet {
                if foot.distance > TOUCHING_MM && (p - foot.at.point).dot(&foot.normal) > 0. {
                    let normal = (p - foot.at.point) / foot.distance;
                    add(Projection { point: foot.at.point, normal, distance_mm: foot.distance });
                }
                for hit in piece.adjoining(foot, ADJOINING_MM) {
                    let normal = piece.face_normal(hit.triangle);
                    let distance_mm = (p - hit.at.point).dot(&normal);
                    add(Projection { point: p - distance_mm * normal, normal, distance_mm });
                }
            }
        }
        planes
    }

    /// The answer of the piece whose distance is least by `size`.
    fn closest(
        &self,
        answer: impl Fn(&Nearest) -> Option<Projection>,
        size: impl Fn(f64) -> f64,
    ) -> Option<Projection> {
        let by_size = |a: &Projection, b: &Projection| size(a.distance_mm).total_cmp(&size(b.distance_mm));
        self.pieces.iter().filter_map(answer).min_by(by_size)
    }

    fn winding(&self, p: Vec3) -> i32 {
        self.pieces.iter().map(|piece| piece.winding(p)).sum()
    }

    /// Whether a triangle bounds the whole solid and not only a part inside it.
    fn is_exposed(&self, piece: &Nearest, triangle: usize) -> bool {
        self.winding(piece.just_outside(triangle)) <= 0
    }
}

/// Whether a plane at `plane_mm` from a point still bounds a surface at `distance_mm`.
pub(super) fn holds(distance_mm: f64, plane_mm: f64) -> bool {
    plane_mm
        >= distance_mm - f64::max(NEARER_MM, if distance_mm < PINCH_MM { PINCH * distance_mm } else { 0. })
}

/// One answer from tied hits: their mean direction, so that a mirror-symmetric solid answers
/// mirror-symmetrically; where the directions cancel, the first one.
fn blend(p: Vec3, hits: &[Hit]) -> Option<Projection> {
    let first = hits.first()?;
    let side = if (p - first.at.point).dot(&first.normal) < 0. { -1. } else { 1. };
    let normal =
        |h: &Hit| if h.distance > TOUCHING_MM { side * (p - h.at.point) / h.distance } else { h.normal };
    let mean: Vec3 = hits.iter().map(normal).sum();
    let mean = if mean.norm() > 1e-6 { mean.normalize() } else { normal(first) };
    let point = hits.iter().map(|h| h.at.point).sum::<Vec3>() / hits.len() as f64;
    Some(Projection { point, normal: mean, distance_mm: side * first.distance })
}
