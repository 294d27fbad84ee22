//! Forces of a fibre under tension.

use crate::face::Fibre;
use crate::units::Vec3;

/// Forces (N) at the points of a fibre of tension `tension_n`.
///
/// A fibre loads the tissue by `d(T t)/ds`: at constant tension a line load `T` times curvature
/// along the body and `T t` at an extremity (the seed, section 4: force at the extremity, residual
/// forces in proportion to curvature along the body; a sphincter has only curvature). Discretely
/// `f_i = T_{i+1/2} t_{i+1/2} - T_{i-1/2} t_{i-1/2}`, which sums to zero. Over the last
/// `insertion_mm` before the insertion (the last point) `T` ramps to zero, so that the muscle hands
/// its force over along a length instead of at a point; a closed fibre has no insertion.
///
/// Segments of zero length carry nothing.
pub fn fibre_forces(fibre: &Fibre, tension_n: f64, insertion_mm: f64) -> Vec<Vec3> {
    let n = fibre.points.len();
    let mut forces = vec![Vec3::zeros(); n];
    for (i, share) in fibre.tension_shares(insertion_mm).into_iter().enumerate() {
        let d = fibre.points[(i + 1) % n] - fibre.points[i];
        let length = d.norm();
        if length == 0. {
            continue;
        }
        let pull = d * (tension_n * share / length);
        forces[i] += pull;
        forces[(i + 1) % n] -= pull;
    }
    forces
}

#[cfg(test)]
mod tests {
    use super::*;
    use std::f64::consts::TAU;

    fn line(n: usize, length: f64) -> Fibre {
        let points = (0..=n).map(|i| Vec3::new(length * i as f64 / n as f64, 0., 0.)).collect();
        Fibre { points, closed: false }
    }

    #[test]
    fn a_ring_is_pressed_toward_its_centre_by_tension_over_radius() {
        for n in [5, 12, 97] {
            let (radius, tension) = (20., 3.);
            let at = |i: usize| {
                radius * Vec3::new((TAU * i as f64 / n as f64).cos(), (TAU * i as f64 / n as f64).sin(), 0.)
            };
            let ring = Fibre { points: (0..n).map(at).collect(), closed: true };
            let side = (at(1) - at(0)).norm();
            for (i, f) in fibre_forces(&ring, tension, 8.).iter().enumerate() {
                let per_length = f / side;
                assert!((per_length + at(i) / radius * tension / radius).norm() < 1e-12, "n = {n}");
            }
        }
    }

    #[test]
    fn a_straight_fibre_pulls_only_at_its_ends() {
        let forces = fibre_forces(&line(10, 30.), 2., 0.);
        assert!((forces[0] - Vec3::new(2., 0., 0.)).norm() < 1e-12);
        assert!((forces[10] + Vec3::new(2., 0., 0.)).norm() < 1e-12);
        assert!(forces[1..10].iter().all(|f| f.norm() < 1e-12));
    }

    #[test]
    fn the_ramp_spreads_the_end_force_over_the_insertion() {
        let forces = fibre_forces(&line(30, 30.), 2., 8.);
        assert!((forces[0].x - 2.).abs() < 1e-12, "full tension at the origin");
        assert!(forces[1..22].iter().all(|f| f.norm() < 1e-12), "none along the body");
        let spread: f64 = forces[22..].iter().map(|f| f.x).sum();
        assert!((spread + 2.).abs() < 1e-12, "the insertion takes it all: {spread}");
        assert!(forces[22..].iter().all(|f| f.x.abs() < 0.26), "2 N over 8 mm is 0.25 N a millimetre");
    }

    #[test]
    fn forces_sum_to_zero_and_approach_tension_times_curvature() {
        // Quarter of an ellipse: curvature known in closed form.
        let (a, b) = (30., 18.);
        let curve = |t: f64| Vec3::new(a * t.cos(), b * t.sin(), 0.);
        let worst = |n: usize| {
            let points = (0..=n).map(|i| curve(TAU / 4. * i as f64 / n as f64)).collect();
            let fibre = Fibre { points, closed: false };
            let forces = fibre_forces(&fibre, 1., 0.);
            assert!(forces.iter().sum::<Vec3>().norm() < 1e-12);
            (1..n)
                .map(|i| {
                    let t = TAU / 4. * i as f64 / n as f64;
                    let half = |k: usize| (fibre.points[k + 1] - fibre.points[k]).norm() / 2.;
                    let speed = (a * a * t.sin().powi(2) + b * b * t.cos().powi(2)).sqrt();
                    let curvature = a * b / speed.powi(3);
                    (forces[i].norm() / (half(i - 1) + half(i)) - curvature).abs()
                })
                .fold(0., f64::max)
        };
        let rate = (worst(20) / worst(40)).log2();
        assert!(rate > 1.9, "rate {rate}");
    }
}
