//! The closest point of a facet: flat or quadratic triangle, bilinear quadrilateral.

use nalgebra::{Matrix2, Vector2};

use crate::units::Vec3;

const MAX_STEPS: usize = 30;

/// A point of a facet by its own coordinates: `r, s >= 0, r + s <= 1` on a triangle, `[-1, 1]²` on a
/// quadrilateral.
#[derive(Clone, Copy, Debug)]
pub(super) struct FacetPoint {
    pub(super) r: f64,
    pub(super) s: f64,
    pub(super) position: Vec3,
    pub(super) distance: f64,
}

/// The point closest to `p` of the facet whose nodes lie at `x` (3, 4 or 6, as
/// [`Facet::nodes`](super::Facet::nodes)).
pub(super) fn closest_on_facet(x: &[Vec3], p: Vec3) -> FacetPoint {
    let n_corners = if x.len() == 4 { 4 } else { 3 };
    let mut best = inner(x, p);
    for k in 0..n_corners {
        let next = (k + 1) % n_corners;
        let t = match x.len() {
            6 => on_arc(x[k], x[3 + k], x[next], p),
            _ => on_segment(x[k], x[next], p),
        };
        let (a, b) = (corner(n_corners, k), corner(n_corners, next));
        let q = a + t * (b - a);
        let candidate = at(x, q, p);
        if best.is_none_or(|best| candidate.distance < best.distance) {
            best = Some(candidate);
        }
    }
    best.unwrap_or_else(|| at(x, corner(n_corners, 0), p))
}

/// Shape functions of the facet's corners at `(r, s)`: the map from facet to face coordinates.
pub(super) fn corner_weights(n_corners: usize, r: f64, s: f64) -> [f64; 4] {
    match n_corners {
        4 => [(1. - r) * (1. - s), (1. + r) * (1. - s), (1. + r) * (1. + s), (1. - r) * (1. + s)]
            .map(|w| 0.25 * w),
        _ => [1. - r - s, r, s, 0.],
    }
}

fn corner(n_corners: usize, k: usize) -> Vector2<f64> {
    match n_corners {
        4 => [[-1., -1.], [1., -1.], [1., 1.], [-1., 1.]][k].into(),
        _ => [[0., 0.], [1., 0.], [0., 1.]][k].into(),
    }
}

fn at(x: &[Vec3], q: Vector2<f64>, p: Vec3) -> FacetPoint {
    let [position, ..] = derivatives(x, q);
    FacetPoint { r: q.x, s: q.y, position, distance: (position - p).norm() }
}

/// `X, X_r, X_s, X_rr, X_rs, X_ss`.
fn derivatives(x: &[Vec3], q: Vector2<f64>) -> [Vec3; 6] {
    let (r, s, zero) = (q.x, q.y, Vec3::zeros());
    match *x {
        [a, b, c] => [a + r * (b - a) + s * (c - a), b - a, c - a, zero, zero, zero],
        [a, b, c, d] => {
            let mean = 0.25 * (a + b + c + d);
            let (dr, ds) = (0.25 * (b + c - a - d), 0.25 * (c + d - a - b));
            let twist = 0.25 * (a + c - b - d);
            [mean + r * dr + s * ds + r * s * twist, dr + s * twist, ds + r * twist, zero, twist, zero]
        }
        [a, b, c, ab, bc, ca] => {
            let (rr, ss) = (4. * (a + b - 2. * ab), 4. * (a + c - 2. * ca));
            let rs = 4. * (a + bc - ab - ca);
            let (r0, s0) = (4. * ab - 3. * a - b, 4. * ca - 3. * a - c);
            let position = a + r * r0 + s * s0 + 0.5 * (r * r * rr + s * s * ss) + r * s * rs;
            [position, r0 + r * rr + s * rs, s0 + s * ss + r * rs, rr, rs, ss]
        }
        _ => [zero; 6],
    }
}

/// The stationary point of the distance inside the facet, if Newton finds one there.
fn inner(x: &[Vec3], p: Vec3) -> Option<FacetPoint> {
    let quad = x.len() == 4;
    let mut q = if quad { Vector2::zeros() } else { Vector2::repeat(1. / 3.) };
    for _ in 0..MAX_STEPS {
        let [position, dr, ds, rr, rs, ss] = derivatives(x, q);
        let gap = position - p;
        let gradient = Vector2::new(dr.dot(&gap), ds.dot(&gap));
        let first = Matrix2::new(dr.dot(&dr), dr.dot(&ds), dr.dot(&ds), ds.dot(&ds));
        let second = Matrix2::new(rr.dot(&gap), rs.dot(&gap), rs.dot(&gap), ss.dot(&gap));
        // Far from a curved facet the full Hessian may be indefinite: then only its first part.
        let hessian = first + second;
        let convex = hessian.m11 > 0. && hessian.determinant() > 1e-3 * first.determinant();
        let step = (if convex { hessian } else { first }).lu().solve(&gradient)?;
        q -= step;
        // A NaN fails every comparison, so the test is for what may go on.
        let near = q.abs().max() < 4.;
        if !near {
            return None;
        }
        if step.abs().max() < 1e-14 {
            break;
        }
    }
    let inside = if quad { q.abs().max() <= 1. } else { q.x >= 0. && q.y >= 0. && q.x + q.y <= 1. };
    inside.then(|| at(x, q, p))
}

fn on_segment(a: Vec3, b: Vec3, p: Vec3) -> f64 {
    let d = b - a;
    let length2 = d.norm_squared();
    if length2 > 0. { ((p - a).dot(&d) / length2).clamp(0., 1.) } else { 0. }
}

/// Parameter in [0, 1] of the point closest to `p` on the quadratic arc `a, mid, b`.
fn on_arc(a: Vec3, mid: Vec3, b: Vec3, p: Vec3) -> f64 {
    let (second, first) = (4. * (a + b - 2. * mid), 4. * mid - 3. * a - b);
    let position = |t: f64| a + t * first + 0.5 * t * t * second;
    let descend = |start: f64| {
        let mut t = start;
        for _ in 0..MAX_STEPS {
            let (gap, slope) = (position(t) - p, first + t * second);
            let curvature = slope.norm_squared() + gap.dot(&second).max(0.);
            let next = if curvature > 0. { (t - gap.dot(&slope) / curvature).clamp(0., 1.) } else { t };
            let done = (next - t).abs() < 1e-14;
            t = next;
            if done {
                break;
            }
        }
        t
    };
    let distance = |t: f64| (position(t) - p).norm();
    [0., 0.5, 1.]
        .into_iter()
        .map(descend)
        .fold(0., |best, t| if distance(t) < distance(best) { t } else { best })
}

#[cfg(test)]
mod tests {
    use super::*;

    /// The least distance over a fine sampling of the facet.
    fn sampled(x: &[Vec3], p: Vec3) -> f64 {
        let n = 200;
        let mut best = f64::INFINITY;
        for i in 0..=n {
            for j in 0..=n {
                let (u, v) = (f64::from(i) / f64::from(n), f64::from(j) / f64::from(n));
                let q = match x.len() {
                    4 => Vector2::new(2. * u - 1., 2. * v - 1.),
                    _ => Vector2::new(u, v * (1. - u)),
                };
                best = best.min(at(x, q, p).distance);
            }
        }
        best
    }

    #[test]
    fn no_sampled_point_is_closer() {
        let a = Vec3::new(0., 0., 0.2);
        let (b, c, d) = (Vec3::new(2., 0.1, 0.), Vec3::new(2.2, 1.9, 0.5), Vec3::new(-0.1, 2., 0.));
        let mid = |p: Vec3, q: Vec3, bulge: f64| 0.5 * (p + q) + Vec3::new(0., 0.02, bulge);
        let facets = [
            vec![a, b, c],
            vec![a, b, c, d],
            vec![a, b, c, mid(a, b, 0.1), mid(b, c, -0.1), mid(c, a, 0.15)],
        ];
        for x in &facets {
            for k in 0..216 {
                let [i, j, k] = [k / 36, (k / 6) % 6, k % 6].map(f64::from);
                let p = Vec3::new(i * 0.9 - 1.2, j * 0.8 - 1., k * 0.5 - 1.1);
                let (found, sampled) = (closest_on_facet(x, p).distance, sampled(x, p));
                assert!(found <= sampled + 1e-12, "{} nodes, {p:?}: {found} {sampled}", x.len());
                assert!(found >= sampled - 0.02);
            }
        }
    }
}
