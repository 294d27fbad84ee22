//! How far a step may go.

use super::separation::{edges_squared_distance, nearest_on_triangle};
use crate::units::Vec3;

/// Share of its distance at the start that every pair keeps.
const KEPT: f64 = 0.1;
/// Times what is kept at which a pair is done.
const NEARLY: f64 = 1.1;
/// A pair that is not done after so many advances stops where it is; each of them is safe.
const MAX_ADVANCES: usize = 1000;

/// How much of the step from `start` to `start + steps`, at most `limit`, keeps a tenth of the distance at its start.
///
/// `distance` is that of two simplices with these four corners, of which the first `n_first` are the first simplex. No
/// point of either moves faster than its fastest corner, so that no distance is lost sooner than that takes; taken again
/// and again, such times approach the end from below.
///
/// Source: Li, Kaufman and Jiang (2021), Codimensional Incremental Potential Contact, algorithm 1.
pub(super) fn additive_ccd(
    start: [Vec3; 4],
    steps: [Vec3; 4],
    n_first: usize,
    distance: impl Fn([Vec3; 4]) -> f64,
    limit: f64,
) -> f64 {
    let mean = steps.iter().sum::<Vec3>() / 4.;
    let steps = steps.map(|p| p - mean);
    let fastest = |of: &[Vec3]| of.iter().map(Vec3::norm).fold(0., f64::max);
    let speed = fastest(&steps[..n_first]) + fastest(&steps[n_first..]);
    let mut left = distance(start);
    let kept = KEPT * left;
    if speed * limit <= left - kept {
        return limit;
    }
    let mut t = 0.;
    for _ in 0..MAX_ADVANCES {
        if left <= NEARLY * kept {
            break;
        }
        t += (left - kept) / speed;
        if t >= limit {
            return limit;
        }
        left = distance(std::array::from_fn(|k| start[k] + t * steps[k]));
    }
    t
}

/// Distance of corner 0 from the triangle of the others, mm.
pub(super) fn vertex_triangle_distance([p, a, b, c]: [Vec3; 4]) -> f64 {
    nearest_on_triangle(p, [a, b, c]).1.sqrt()
}

/// Distance of the edge of corners 0 and 1 from that of corners 2 and 3, mm.
pub(super) fn edge_edge_distance(x: [Vec3; 4]) -> f64 {
    edges_squared_distance(&x).sqrt()
}
