//! What smooths the distance of edges that are nearly parallel.

use nalgebra::{Matrix3, SMatrix, SVector};

use crate::units::Vec3;

/// Squared sine below which edges count less, at their lengths at rest (Li et al. 2020, 5.2).
const NEARLY_PARALLEL: f64 = 1e-3;

/// `m(c) = c / e (2 - c / e)` below `e`, else 1, with `c = |u x v|^2` of edges `u`, `v` and `e = 1e-3 |U|^2 |V|^2` of
/// their lengths at rest: closest points of parallel edges jump, and `m` is zero there.
#[derive(Clone, Copy, Debug)]
pub(super) struct Mollifier {
    threshold: f64,
}

/// Value, gradient and second derivative for the four corners of two edges.
pub(super) struct Mollified {
    pub(super) value: f64,
    pub(super) gradient: SVector<f64, 12>,
    pub(super) hessian: SMatrix<f64, 12, 12>,
}

impl Mollifier {
    /// The mollifier of edges with the corners `rest`, and whether it is less than one at `x`.
    pub(super) fn new(rest: &[Vec3; 4], x: &[Vec3; 4]) -> Option<Self> {
        let [u, v] = edges(rest);
        let threshold = NEARLY_PARALLEL * u.norm_squared() * v.norm_squared();
        let [u, v] = edges(x);
        (u.cross(&v).norm_squared() < threshold).then_some(Self { threshold })
    }

    pub(super) fn value(&self, x: &[Vec3; 4]) -> f64 {
        let [u, v] = edges(x);
        let c = u.cross(&v).norm_squared() / self.threshold;
        c * (2. - c)
    }

    /// `m` and its gradient by corner.
    pub(super) fn slope(&self, x: &[Vec3; 4]) -> (f64, [Vec3; 4]) {
        let [u, v] = edges(x);
        let c = u.cross(&v).norm_squared() / self.threshold;
        let factor = 2. * (1. - c) / self.threshold;
        let [gu, gv] = cross_gradient(u, v).map(|g| factor * g);
        (c * (2. - c), [-gu, gu, -gv, gv])
    }

    pub(super) fn derivatives(&self, x: &[Vec3; 4]) -> Mollified {
        let [u, v] = edges(x);
        let (value, slope) = self.slope(x);
        let c = u.cross(&v).norm_squared() / self.threshold;
        let [gu, gv] = cross_gradient(u, v);
        let uv = 2. * (2. * u * v.transpose() - v * u.transpose() - u.dot(&v) * Matrix3::identity());
        let of_self = |w: Vec3| 2. * (w.norm_squared() * Matrix3::identity() - w * w.transpose());
        let blocks = [[of_self(v), uv], [uv.transpose(), of_self(u)]];
        let gradients = [gu, gv];
        let (first, second) = (2. * (1. - c) / self.threshold, -2. / (self.threshold * self.threshold));
        let mut hessian = SMatrix::<f64, 12, 12>::zeros();
        for i in 0..4 {
            for j in 0..4 {
                let sign = if i % 2 == j % 2 { 1. } else { -1. };
                let (a, b) = (i / 2, j / 2);
                let block = first * blocks[a][b] + second * gradients[a] * gradients[b].transpose();
                hessian.fixed_view_mut::<3, 3>(3 * i, 3 * j).copy_from(&(sign * block));
            }
        }
        let gradient = SVector::from_fn(|k, _| slope[k / 3][k % 3]);
        Mollified { value, gradient, hessian }
    }
}

fn edges(x: &[Vec3; 4]) -> [Vec3; 2] {
    [x[1] - x[0], x[3] - x[2]]
}

/// Gradient of `|u x v|^2` by `u` and by `v`.
fn cross_gradient(u: Vec3, v: Vec3) -> [Vec3; 2] {
    let uv = u.dot(&v);
    [2. * (v.norm_squared() * u - uv * v), 2. * (u.norm_squared() * v - uv * u)]
}
