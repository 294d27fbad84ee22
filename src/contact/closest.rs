//! The point of a triangle closest to a point.

use crate::units::Vec3;

/// The part of a triangle on which its closest point lies.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Feature {
    /// Corner `k`.
    Vertex(usize),
    /// The side from corner `k` to corner `k + 1`.
    Edge(usize),
    /// The interior.
    Face,
}

/// A point of a triangle.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct TrianglePoint {
    /// Position, mm.
    pub point: Vec3,
    /// Barycentric weights of the corners: not negative, sum one.
    pub weights: [f64; 3],
    /// The part of the triangle it lies on.
    pub feature: Feature,
}

/// The point of triangle `t` closest to `p`, by the Voronoi regions of its corners, sides and interior.
///
/// Source: Ericson, Real-Time Collision Detection (2005), 5.1.5. A triangle without area is treated
/// as the side or corner that it has shrunk to.
pub fn closest_on_triangle(p: Vec3, t: [Vec3; 3]) -> TrianglePoint {
    let [a, b, c] = t;
    let (ab, ac, ap) = (b - a, c - a, p - a);
    let (d1, d2) = (ab.dot(&ap), ac.dot(&ap));
    if d1 <= 0. && d2 <= 0. {
        return vertex(t, 0);
    }
    let bp = p - b;
    let (d3, d4) = (ab.dot(&bp), ac.dot(&bp));
    if d3 >= 0. && d4 <= d3 {
        return vertex(t, 1);
    }
    let cp = p - c;
    let (d5, d6) = (ab.dot(&cp), ac.dot(&cp));
    if d6 >= 0. && d5 <= d6 {
        return vertex(t, 2);
    }
    let vc = d1 * d4 - d3 * d2;
    if vc <= 0. && d1 >= 0. && d3 <= 0. {
        return edge(t, 0, d1 / (d1 - d3));
    }
    let vb = d5 * d2 - d1 * d6;
    if vb <= 0. && d2 >= 0. && d6 <= 0. {
        return edge(t, 2, 1. - d2 / (d2 - d6));
    }
    let va = d3 * d6 - d5 * d4;
    if va <= 0. && d4 >= d3 && d5 >= d6 {
        return edge(t, 1, (d4 - d3) / ((d4 - d3) + (d5 - d6)));
    }
    let sum = va + vb + vc;
    let weights = [va / sum, vb / sum, vc / sum];
    TrianglePoint { point: weights[0] * a + weights[1] * b + weights[2] * c, weights, feature: Feature::Face }
}

fn vertex(t: [Vec3; 3], k: usize) -> TrianglePoint {
    let mut weights = [0.; 3];
    weights[k] = 1.;
    TrianglePoint { point: t[k], weights, feature: Feature::Vertex(k) }
}

fn edge(t: [Vec3; 3], k: usize, s: f64) -> TrianglePoint {
    let mut weights = [0.; 3];
    weights[k] = 1. - s;
    weights[(k + 1) % 3] = s;
    TrianglePoint { point: t[k] + s * (t[(k + 1) % 3] - t[k]), weights, feature: Feature::Edge(k) }
}

#[cfg(test)]
mod tests {
    use super::*;

    const T: [Vec3; 3] = [Vec3::new(0., 0., 0.), Vec3::new(4., 0., 0.), Vec3::new(0., 3., 0.)];

    fn check(p: [f64; 3], expect: [f64; 3], feature: Feature) {
        let hit = closest_on_triangle(Vec3::from(p), T);
        assert!((hit.point - Vec3::from(expect)).norm() < 1e-14, "{p:?} {hit:?}");
        assert_eq!(hit.feature, feature, "{p:?}");
        let carried: Vec3 = hit.weights.iter().zip(T).map(|(w, q)| *w * q).sum();
        assert!((carried - hit.point).norm() < 1e-14 && (hit.weights.iter().sum::<f64>() - 1.).abs() < 1e-14);
        assert!(hit.weights.iter().all(|w| *w >= 0.));
    }

    #[test]
    fn every_region_has_its_closed_form() {
        for z in [-2., 0., 5.] {
            check([-1., -1., z], [0., 0., 0.], Feature::Vertex(0));
            check([6., -1., z], [4., 0., 0.], Feature::Vertex(1));
            check([-1., 5., z], [0., 3., 0.], Feature::Vertex(2));
            check([1., -2., z], [1., 0., 0.], Feature::Edge(0));
            check([-2., 1., z], [0., 1., 0.], Feature::Edge(2));
            // (3, 4) is normal to the long side: start at its middle and step outward.
            check([2. + 3., 1.5 + 4., z], [2., 1.5, 0.], Feature::Edge(1));
            check([1., 1., z], [1., 1., 0.], Feature::Face);
        }
    }

    #[test]
    fn corners_and_sides_of_the_triangle_itself_are_their_own_closest_points() {
        check([0., 0., 0.], [0., 0., 0.], Feature::Vertex(0));
        check([4., 0., 0.], [4., 0., 0.], Feature::Vertex(1));
        check([0., 3., 0.], [0., 3., 0.], Feature::Vertex(2));
        check([2., 1.5, 0.], [2., 1.5, 0.], Feature::Edge(1));
    }

    #[test]
    fn a_triangle_without_area_answers_its_segment() {
        let flat = [Vec3::zeros(), Vec3::new(2., 0., 0.), Vec3::new(1., 0., 0.)];
        let hit = closest_on_triangle(Vec3::new(0.5, 1., 0.), flat);
        assert!((hit.point - Vec3::new(0.5, 0., 0.)).norm() < 1e-14, "{hit:?}");
    }

    #[test]
    fn the_distance_has_the_unit_direction_as_its_gradient() {
        let h = 1e-6;
        for p in [[-1., -1., 2.], [6., -1., 1.], [1., -2., 1.], [5., 5.5, -1.], [1., 1., 2.]] {
            let p = Vec3::from(p);
            let distance = |q: Vec3| (q - closest_on_triangle(q, T).point).norm();
            let direction = (p - closest_on_triangle(p, T).point).normalize();
            for axis in 0..3 {
                let mut step = Vec3::zeros();
                step[axis] = h;
                let slope = (distance(p + step) - distance(p - step)) / (2. * h);
                assert!((slope - direction[axis]).abs() < 1e-8, "{p} {axis}");
            }
        }
    }
}
