//! How far a step may go.

use super::separation::{Separation, vertex_triangle_offset};
use crate::units::Vec3;

/// Share of its distance at the start that every pair keeps.
const KEPT: f64 = 0.1;
/// Times what is kept at which a pair is done.
const NEARLY: f64 = 1.1;
/// A pair that is not done after so many advances stops where it is; each of them is safe.
const MAX_ADVANCES: usize = 1000;

/// How much of the step from `start` to `start + steps`, at most `limit`, keeps a tenth of the distance at its start.
///
/// `offset` is that between the closest points of two simplices with these four corners, of which the first `n_first`
/// are the first simplex. A plane across it parts the two for as long as no corner has come through: what they move
/// along each other brings them no nearer. Taken again and again, such times approach the end from below.
///
/// Source: conservative advancement (Mirtich 1996) with the directional bound of motion of Zhang, Lee and Kim (2006).
pub(super) fn advance(
    start: [Vec3; 4],
    steps: [Vec3; 4],
    n_first: usize,
    offset: impl Fn(&[Vec3; 4]) -> Vec3,
    limit: f64,
) -> f64 {
    let mut across = offset(&start);
    let kept = KEPT * across.norm();
    let mut t = 0.;
    for _ in 0..MAX_ADVANCES {
        let Some(n) = across.try_normalize(0.) else { break };
        let at = |k: usize| n.dot(&(start[k] + t * steps[k]));
        let ahead = |of: &dyn Fn(usize) -> f64| {
            let least = (0..n_first).map(of).fold(f64::INFINITY, f64::min);
            (n_first..4).map(of).fold(f64::NEG_INFINITY, f64::max) - least
        };
        let left = -ahead(&at);
        if left <= NEARLY * kept {
            break;
        }
        let closing = ahead(&|k| n.dot(&steps[k]));
        if closing * (limit - t) <= left - kept {
            return limit;
        }
        t += (left - kept) / closing;
        across = offset(&std::array::from_fn(|k| start[k] + t * steps[k]));
    }
    t
}

/// Of corner 0 from the triangle of the others, mm.
pub(super) fn of_vertex_triangle([p, a, b, c]: &[Vec3; 4]) -> Vec3 {
    vertex_triangle_offset(*p, [*a, *b, *c])
}

/// Of the edge of corners 0 and 1 from that of corners 2 and 3, mm.
pub(super) fn of_edges(x: &[Vec3; 4]) -> Vec3 {
    let Separation { offset, shares, .. } = Separation::of_edges(x);
    if shares[0] + shares[1] > 0. { offset } else { -offset }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::contact::barrier::testing::Random;

    #[test]
    fn a_step_ends_where_a_pair_has_a_tenth_of_its_distance_left_and_never_beyond() {
        let mut random = Random(7);
        let mut cut = 0;
        for (n_first, offset) in
            [(1, of_vertex_triangle as fn(&[Vec3; 4]) -> Vec3), (2, of_edges as fn(&[Vec3; 4]) -> Vec3)]
        {
            for _ in 0..500 {
                let start: [Vec3; 4] = std::array::from_fn(|_| random.point());
                let steps: [Vec3; 4] = std::array::from_fn(|_| 2. * random.point());
                let share = advance(start, steps, n_first, offset, 1.);
                let left = |t: f64| offset(&std::array::from_fn(|k| start[k] + t * steps[k])).norm();
                let kept = KEPT * left(0.);
                for k in 0..=200 {
                    assert!(left(share * f64::from(k) / 200.) >= kept * (1. - 1e-9), "{k}: {share}");
                }
                if share < 1. {
                    cut += 1;
                    assert!(left(share) <= 1.2 * kept, "{share}: {} of {kept}", left(share));
                }
            }
        }
        assert!(cut > 100, "{cut}");
    }

    #[test]
    fn what_slides_along_a_surface_is_not_held_however_near_it_is() {
        // Turned, so that no coordinate is the one across.
        let turn = nalgebra::Rotation3::from_euler_angles(0.3, -0.5, 0.8);
        let slid = |corners: [Vec3; 4], n_first: usize, offset: fn(&[Vec3; 4]) -> Vec3| {
            let steps =
                std::array::from_fn(
                    |k| if k < n_first { turn * Vec3::new(3., 1., 0.) } else { Vec3::zeros() },
                );
            advance(corners.map(|p| turn * p), steps, n_first, offset, 1.)
        };
        let floor = [Vec3::new(-9., -9., 0.), Vec3::new(9., -9., 0.), Vec3::new(0., 9., 0.)];
        for gap in [1e-2, 1e-5] {
            let vertex = [Vec3::new(0., 0., gap), floor[0], floor[1], floor[2]];
            assert_eq!(slid(vertex, 1, of_vertex_triangle), 1., "{gap}");
            let edges = [Vec3::new(0., -1., gap), Vec3::new(0., 1., gap), Vec3::x() * -9., Vec3::x() * 9.];
            assert_eq!(slid(edges, 2, of_edges), 1., "{gap}");
        }
    }
}
