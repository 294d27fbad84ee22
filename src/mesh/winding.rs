//! How often a surface winds round a point.

use std::f64::consts::PI;

use super::Surface;
use crate::units::Vec3;

const LEAF_SIZE: usize = 8;

/// A cluster whose centre is farther than this many of its radii counts as a dipole there. The winding numbers
/// that matter are whole; what this leaves off is below 0.02, also between two surfaces, where both sums are short
/// (2.5 radii leave off 0.036 there).
const FAR: f64 = 3.5;

/// The winding number of an oriented triangle surface round any point.
///
/// `w(p) = 1/(4 pi) sum_t Omega_t(p)`, with `Omega_t` the solid angle of triangle `t` seen from `p`: 1 inside a
/// closed surface, 0 outside, 2 where it overlaps itself; near holes a fraction. Clusters of triangles that are far
/// from `p` are one dipole `A . (c - p) / |c - p|^3` of their area vector `A` at their centre `c`.
///
/// Sources: Jacobson, Kavan and Sorkine-Hornung, ACM Trans. Graph. 32 (2013) 33; Barill et al., ACM Trans. Graph. 37
/// (2018) 43.
#[derive(Clone, Debug)]
pub struct Winding {
    /// Corners of the triangles, those of a cluster side by side.
    triangles: Vec<[Vec3; 3]>,
    clusters: Vec<Cluster>,
}

#[derive(Clone, Debug)]
struct Cluster {
    centre: Vec3,
    radius: f64,
    area: Vec3,
    /// Range of `triangles`.
    first: usize,
    end: usize,
    /// The two halves; none of a leaf.
    halves: Option<[usize; 2]>,
}

impl Winding {
    /// The winding number of `surface`, whose vertices all exist.
    pub fn new(surface: &Surface) -> Self {
        let triangles = surface.triangles.iter().map(|t| t.map(|v| surface.points[v])).collect();
        let mut winding = Self { triangles, clusters: Vec::new() };
        if !winding.triangles.is_empty() {
            winding.split(0, winding.triangles.len());
        }
        winding
    }

    /// The winding number round `p` (mm), to about 0.02.
    pub fn number(&self, p: Vec3) -> f64 {
        let mut sum = 0.;
        let mut stack: Vec<usize> = (0..self.clusters.len().min(1)).collect();
        while let Some(cluster) = stack.pop().map(|k| &self.clusters[k]) {
            let away = cluster.centre - p;
            let distance = away.norm();
            if distance > FAR * cluster.radius {
                sum += cluster.area.dot(&away) / distance.powi(3);
            } else if let Some(halves) = cluster.halves {
                stack.extend(halves);
            } else {
                let of = &self.triangles[cluster.first..cluster.end];
                sum += of.iter().map(|t| solid_angle(t.map(|x| x - p))).sum::<f64>();
            }
        }
        sum / (4. * PI)
    }

    fn split(&mut self, first: usize, end: usize) -> usize {
        let own = &mut self.triangles[first..end];
        let (mut area, mut centre, mut size) = (Vec3::zeros(), Vec3::zeros(), 0.);
        let middle = |t: &[Vec3; 3]| (t[0] + t[1] + t[2]) / 3.;
        for t in own.iter() {
            let a = (t[1] - t[0]).cross(&(t[2] - t[0])) / 2.;
            area += a;
            centre += a.norm() * middle(t);
            size += a.norm();
        }
        centre =
            if size > 0. { centre / size } else { own.iter().map(middle).sum::<Vec3>() / own.len() as f64 };
        let corners = || own.iter().flatten();
        let radius = corners().fold(0f64, |r, x| r.max((x - centre).norm()));
        let lo = corners().fold(Vec3::repeat(f64::INFINITY), |lo, x| lo.inf(x));
        let hi = corners().fold(Vec3::repeat(f64::NEG_INFINITY), |hi, x| hi.sup(x));
        let me = self.clusters.len();
        if end - first > LEAF_SIZE {
            let (axis, half) = ((hi - lo).imax(), (end - first) / 2);
            own.select_nth_unstable_by(half, |a, b| middle(a)[axis].total_cmp(&middle(b)[axis]));
            self.clusters.push(Cluster { centre, radius, area, first, end, halves: None });
            let halves = [self.split(first, first + half), self.split(first + half, end)];
            self.clusters[me].halves = Some(halves);
        } else {
            self.clusters.push(Cluster { centre, radius, area, first, end, halves: None });
        }
        me
    }
}

/// Solid angle of the triangle `a, b, c` seen from the origin, positive from behind it.
/// Source: van Oosterom and Strackee, IEEE Trans. Biomed. Eng. 30 (1983) 125.
fn solid_angle([a, b, c]: [Vec3; 3]) -> f64 {
    let (la, lb, lc) = (a.norm(), b.norm(), c.norm());
    let below = la * lb * lc + a.dot(&b) * lc + b.dot(&c) * la + c.dot(&a) * lb;
    2. * a.dot(&b.cross(&c)).atan2(below)
}

#[cfg(test)]
mod tests {
    use super::*;

    /// A sphere of radius `r` about `centre`, 2 n^2 triangles.
    fn sphere(centre: Vec3, r: f64, n: usize) -> Surface {
        let at = |i: usize, j: usize| {
            let (s, t) = (PI * i as f64 / n as f64, 2. * PI * j as f64 / n as f64);
            centre + r * Vec3::new(s.sin() * t.cos(), s.sin() * t.sin(), s.cos())
        };
        let points = (0..=n).flat_map(|i| (0..n).map(move |j| at(i, j))).collect();
        let quad = |i: usize, j: usize| {
            let k = |i: usize, j: usize| i * n + j % n;
            [[k(i, j), k(i + 1, j), k(i + 1, j + 1)], [k(i, j), k(i + 1, j + 1), k(i, j + 1)]]
        };
        Surface { points, triangles: (0..n).flat_map(|i| (0..n).flat_map(move |j| quad(i, j))).collect() }
    }

    #[test]
    fn whole_numbers_inside_outside_and_where_spheres_overlap() {
        let mut both = sphere(Vec3::zeros(), 3., 60);
        let other = sphere(Vec3::new(2., 0., 0.), 3., 60);
        let n = both.points.len();
        both.points.extend(other.points);
        both.triangles.extend(other.triangles.iter().map(|t| t.map(|v| v + n)));
        let winding = Winding::new(&both);
        for i in 0..2000 {
            let p =
                Vec3::new(f64::from(i % 20) - 8.3, f64::from(i / 20 % 10) - 4.6, f64::from(i / 200) - 4.55);
            let distances = [p.norm(), (p - Vec3::new(2., 0., 0.)).norm()];
            if distances.iter().all(|d| (d - 3.).abs() > 0.02) {
                let expected = distances.iter().filter(|d| **d < 3.).count() as f64;
                let found = winding.number(p);
                assert!((found - expected).abs() < 0.02, "{p:?}: {found} for {expected}");
            }
        }
    }

    #[test]
    fn nothing_winds_round_nothing() {
        assert_eq!(Winding::new(&Surface::default()).number(Vec3::zeros()), 0.);
    }
}
