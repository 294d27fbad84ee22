//! Smooth curves through a few points.

use crate::units::Vec3;

/// Points between two given points from which the arc length is measured.
const FINE: usize = 64;

/// A smooth curve through `points` as a polyline of equal steps of at most `step_mm`, mm; open, or
/// `closed` from the last point back to the first, which is not repeated.
///
/// Centripetal Catmull-Rom spline, which neither overshoots nor loops between unevenly spaced points;
/// reversing or mirroring the points reverses or mirrors the curve. Points that repeat their neighbour
/// are left out; fewer than two distinct points, or a `step_mm` that is not positive, come back as
/// they are.
pub fn smooth_curve(points: &[Vec3], closed: bool, step_mm: f64) -> Vec<Vec3> {
    let mut knots: Vec<Vec3> = Vec::with_capacity(points.len());
    for p in points {
        if knots.last().is_none_or(|q| (p - q).norm() > 1e-9) {
            knots.push(*p);
        }
    }
    while closed && knots.len() > 1 && (knots[knots.len() - 1] - knots[0]).norm() <= 1e-9 {
        knots.pop();
    }
    if knots.len() < 2 || step_mm.is_nan() || step_mm <= 0. {
        return knots;
    }
    resample(&fine(&knots, closed), closed, step_mm)
}

/// Length of a polyline, mm.
pub fn polyline_length(points: &[Vec3], closed: bool) -> f64 {
    let open: f64 = points.windows(2).map(|p| (p[1] - p[0]).norm()).sum();
    match (points.first(), points.last()) {
        (Some(first), Some(last)) if closed => open + (first - last).norm(),
        _ => open,
    }
}

fn fine(knots: &[Vec3], closed: bool) -> Vec<Vec3> {
    let n = knots.len();
    let at = |k: isize| -> Vec3 {
        if closed {
            return knots[k.rem_euclid(n as isize) as usize];
        }
        // Past an end the curve goes on straight: the end point mirrored.
        match k {
            -1 => 2. * knots[0] - knots[1],
            k if k == n as isize => 2. * knots[n - 1] - knots[n - 2],
            k => knots[k as usize],
        }
    };
    let spans = if closed { n } else { n - 1 };
    let mut curve = vec![knots[0]];
    for span in 0..spans as isize {
        let p = [at(span - 1), at(span), at(span + 1), at(span + 2)];
        curve.extend((1..=FINE).map(|k| catmull_rom(p, k as f64 / FINE as f64)));
    }
    curve
}

/// The point at `s` in [0, 1] between `p[1]` and `p[2]`.
/// Source: Barry and Goldman, SIGGRAPH 1988; centripetal knots: Yuksel et al., CAD 43 (2011) 747.
fn catmull_rom(p: [Vec3; 4], s: f64) -> Vec3 {
    let gap = |a: Vec3, b: Vec3| (b - a).norm().sqrt().max(1e-12);
    let t1 = gap(p[0], p[1]);
    let t2 = t1 + gap(p[1], p[2]);
    let t3 = t2 + gap(p[2], p[3]);
    let t = t1 + s * (t2 - t1);
    let mix = |a: Vec3, b: Vec3, from: f64, to: f64| ((to - t) * a + (t - from) * b) / (to - from);
    let (a1, a2, a3) = (mix(p[0], p[1], 0., t1), mix(p[1], p[2], t1, t2), mix(p[2], p[3], t2, t3));
    mix(mix(a1, a2, 0., t2), mix(a2, a3, t1, t3), t1, t2)
}

/// Points at equal steps of at most `step_mm` along the polyline `curve`, whose last point of a `closed` one is
/// its first.
pub(super) fn resample(curve: &[Vec3], closed: bool, step_mm: f64) -> Vec<Vec3> {
    let length = polyline_length(curve, false);
    let steps = ((length / step_mm - 1e-9).ceil() as usize).max(if closed { 3 } else { 1 });
    let mut points = Vec::with_capacity(steps + 1);
    let (mut k, mut passed) = (0, 0.);
    for step in 0..steps {
        let wanted = length * step as f64 / steps as f64;
        let mut piece = (curve[k + 1] - curve[k]).norm();
        while passed + piece < wanted && k + 2 < curve.len() {
            passed += piece;
            k += 1;
            piece = (curve[k + 1] - curve[k]).norm();
        }
        let s = if piece > 0. { (wanted - passed) / piece } else { 0. };
        points.push(curve[k] + s * (curve[k + 1] - curve[k]));
    }
    if !closed {
        points.extend(curve.last());
    }
    points
}

#[cfg(test)]
mod tests {
    use super::*;

    fn circle(n: usize, radius: f64) -> Vec<Vec3> {
        let angle = |k: usize| std::f64::consts::TAU * k as f64 / n as f64;
        (0..n).map(|k| radius * Vec3::new(angle(k).cos(), angle(k).sin(), 0.)).collect()
    }

    #[test]
    fn a_straight_line_stays_straight_with_equal_steps() {
        let points = [Vec3::zeros(), Vec3::new(2., 0., 0.), Vec3::new(10., 0., 0.)];
        let curve = smooth_curve(&points, false, 1.);
        assert_eq!(curve.len(), 11);
        for (k, p) in curve.iter().enumerate() {
            assert!((p - Vec3::new(k as f64, 0., 0.)).norm() < 1e-9, "{k} {p}");
        }
    }

    #[test]
    fn a_ring_through_twelve_points_is_nearly_a_circle() {
        let ring = smooth_curve(&circle(12, 20.), true, 1.);
        assert!(ring.iter().all(|p| (p.norm() - 20.).abs() < 0.1), "a polygon would err by 0.7 mm");
        let steps: Vec<f64> =
            (0..ring.len()).map(|k| (ring[(k + 1) % ring.len()] - ring[k]).norm()).collect();
        assert!(steps.iter().all(|s| *s <= 1. && (s - steps[0]).abs() < 1e-3), "{steps:?}");
    }

    #[test]
    fn reversing_the_points_reverses_the_curve() {
        let points = [Vec3::zeros(), Vec3::new(5., 3., 1.), Vec3::new(6., 9., -2.), Vec3::new(16., 8., 0.)];
        let back: Vec<Vec3> = points.iter().rev().copied().collect();
        let (there, mut back) = (smooth_curve(&points, false, 0.7), smooth_curve(&back, false, 0.7));
        back.reverse();
        assert_eq!(there.len(), back.len());
        assert!(there.iter().zip(&back).all(|(a, b)| (a - b).norm() < 1e-9));
        assert_eq!((there[0], there[there.len() - 1]), (points[0], points[3]));
    }

    #[test]
    fn repeated_points_and_single_points_do_no_harm() {
        let p = Vec3::new(1., 2., 3.);
        assert_eq!(smooth_curve(&[p, p, p], false, 1.), [p]);
        assert!(smooth_curve(&[], true, 1.).is_empty());
        let doubled = [Vec3::zeros(), Vec3::zeros(), Vec3::new(3., 0., 0.), Vec3::new(3., 0., 0.)];
        assert_eq!(smooth_curve(&doubled, false, 1.).len(), 4);
    }
}
