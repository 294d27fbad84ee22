//! Opaque bodies: teeth, fibres as tubes, forces as arrows.

use std::f64::consts::TAU;

use super::colour::Rgb;
use crate::mesh::Surface;
use crate::units::Vec3;

/// Sides of a tube.
const SIDES: usize = 8;
/// Head of an arrow: length and radius in radii of the shaft.
const HEAD: (f64, f64) = (5., 2.4);

/// Triangles with a normal at each corner and one colour each.
#[derive(Clone, Debug, Default)]
pub(super) struct Solid {
    pub(super) corners: Vec<[Vec3; 3]>,
    pub(super) normals: Vec<[Vec3; 3]>,
    pub(super) colours: Vec<Rgb>,
}

impl Solid {
    fn push(&mut self, corners: [Vec3; 3], normals: [Vec3; 3], colour: Rgb) {
        self.corners.push(corners);
        self.normals.push(normals);
        self.colours.push(colour);
    }

    /// A flat panel with these corners in order.
    pub(super) fn quad(&mut self, [a, b, c, d]: [Vec3; 4], colour: Rgb) {
        let normal = (c - a).cross(&(d - b)).try_normalize(0.).unwrap_or_else(Vec3::z);
        self.push([a, b, c], [normal; 3], colour);
        self.push([a, c, d], [normal; 3], colour);
    }

    /// A surface, smooth where its normals turn less than about 50 degrees, as crowns are.
    pub(super) fn surface(&mut self, surface: &Surface, colour: Rgb) {
        let area = |t: &[usize; 3]| {
            let [a, b, c] = t.map(|v| surface.points[v]);
            (b - a).cross(&(c - a))
        };
        let mut around: Vec<Vec<usize>> = vec![Vec::new(); surface.points.len()];
        for (k, t) in surface.triangles.iter().enumerate() {
            t.iter().for_each(|&v| around[v].push(k));
        }
        for t in &surface.triangles {
            let own = area(t).try_normalize(0.).unwrap_or_else(Vec3::z);
            let near = |v: usize| {
                let like = |k: &&usize| {
                    let n = area(&surface.triangles[**k]);
                    n.dot(&own) > 0.65 * n.norm()
                };
                let sum: Vec3 = around[v].iter().filter(like).map(|&k| area(&surface.triangles[k])).sum();
                sum.try_normalize(0.).unwrap_or(own)
            };
            self.push(t.map(|v| surface.points[v]), t.map(near), colour);
        }
    }

    /// A round tube of `radius_mm` along `points`.
    pub(super) fn tube(&mut self, points: &[Vec3], closed: bool, radius_mm: f64, colour: Rgb) {
        let n = points.len();
        if n < 2 {
            return;
        }
        let along = |k: usize| {
            let (a, b) = if closed {
                ((k + n - 1) % n, (k + 1) % n)
            } else {
                (k.saturating_sub(1), (k + 1).min(n - 1))
            };
            (points[b] - points[a]).try_normalize(0.)
        };
        let mut side = Vec3::zeros();
        let rings: Vec<[Vec3; SIDES]> = (0..n)
            .map(|k| {
                let t = along(k).unwrap_or_else(Vec3::x);
                // Carried along the tube, so that it does not twist.
                side = (side - side.dot(&t) * t).try_normalize(1e-6).unwrap_or_else(|| across(t));
                let other = t.cross(&side);
                std::array::from_fn(|j| {
                    let (sin, cos) = (TAU * j as f64 / SIDES as f64).sin_cos();
                    cos * side + sin * other
                })
            })
            .collect();
        let at = |k: usize, j: usize| points[k] + radius_mm * rings[k][j];
        for k in 0..if closed { n } else { n - 1 } {
            let next = (k + 1) % n;
            // A ring closes on itself turned: the nearest side is taken.
            let turn = (0..SIDES).max_by(|&a, &b| {
                let fit = |j: usize| rings[k][0].dot(&rings[next][j]);
                fit(a).total_cmp(&fit(b))
            });
            let turn = turn.unwrap_or(0);
            for j in 0..SIDES {
                let (i, p, q) = ((j + 1) % SIDES, (j + turn) % SIDES, (j + 1 + turn) % SIDES);
                let normals = [rings[k][j], rings[k][i], rings[next][q], rings[next][p]];
                let corners = [at(k, j), at(k, i), at(next, q), at(next, p)];
                self.push([corners[0], corners[1], corners[2]], [normals[0], normals[1], normals[2]], colour);
                self.push([corners[0], corners[2], corners[3]], [normals[0], normals[2], normals[3]], colour);
            }
        }
        if !closed {
            for (k, out) in [(0, -1.), (n - 1, 1.)] {
                let t = out * along(k).unwrap_or_else(Vec3::x);
                for j in 0..SIDES {
                    self.push([points[k], at(k, j), at(k, (j + 1) % SIDES)], [t; 3], colour);
                }
            }
        }
    }

    /// An arrow from `tail` by `v` (mm), its shaft of `radius_mm`; a short one is all head.
    pub(super) fn arrow(&mut self, tail: Vec3, v: Vec3, radius_mm: f64, colour: Rgb) {
        let Some(t) = v.try_normalize(1e-9) else { return };
        let length = v.norm();
        let head = (HEAD.0 * radius_mm).min(length);
        let width = HEAD.1 * radius_mm * head / (HEAD.0 * radius_mm);
        let (neck, tip) = (tail + (length - head) * t, tail + v);
        if length > head {
            self.tube(&[tail, neck], false, radius_mm, colour);
        }
        let side = across(t);
        let other = t.cross(&side);
        let round = |j: usize| {
            let (sin, cos) = (TAU * j as f64 / SIDES as f64).sin_cos();
            cos * side + sin * other
        };
        for j in 0..SIDES {
            let (a, b) = (round(j), round(j + 1));
            let lean = |n: Vec3| (n + t * (width / head)).normalize();
            let rim = [neck + width * a, neck + width * b];
            self.push([rim[0], rim[1], tip], [lean(a), lean(b), lean(a + b)], colour);
            self.push([neck, rim[1], rim[0]], [-t; 3], colour);
        }
    }
}

/// A unit vector square to `t`.
fn across(t: Vec3) -> Vec3 {
    let axis = if t.x.abs() < 0.6 { Vec3::x() } else { Vec3::y() };
    (axis - axis.dot(&t) * t).normalize()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_ring_is_a_closed_tube_of_its_radius() {
        let ring: Vec<Vec3> = (0..60)
            .map(|k| TAU * f64::from(k) / 60.)
            .map(|a| Vec3::new(20. * a.cos(), 12. * a.sin(), 5. * (2. * a).sin()))
            .collect();
        let mut solid = Solid::default();
        solid.tube(&ring, true, 1., [1.; 3]);
        assert_eq!(solid.corners.len(), 2 * SIDES * 60);
        let volume: f64 = solid.corners.iter().map(|[a, b, c]| a.dot(&b.cross(c)) / 6.).sum();
        let length: f64 = (0..60).map(|k| (ring[(k + 1) % 60] - ring[k]).norm()).sum();
        let section = 0.5 * SIDES as f64 * (TAU / SIDES as f64).sin();
        assert!((volume / (length * section) - 1.).abs() < 0.02, "{}", volume / (length * section));
    }

    #[test]
    fn an_arrow_reaches_from_tail_to_tip() {
        let mut solid = Solid::default();
        solid.arrow(Vec3::new(1., 2., 3.), Vec3::new(0., 10., 0.), 0.5, [0.; 3]);
        let y = solid.corners.iter().flatten().map(|p| p.y);
        let (lo, hi) = y.fold((f64::MAX, f64::MIN), |(lo, hi), y| (lo.min(y), hi.max(y)));
        assert!((lo - 2.).abs() < 1e-12 && (hi - 12.).abs() < 1e-12);
        let before = solid.corners.len();
        solid.arrow(Vec3::zeros(), Vec3::zeros(), 0.5, [0.; 3]);
        assert_eq!(solid.corners.len(), before);
    }
}
