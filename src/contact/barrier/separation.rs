//! The offset between the closest points of two simplices as a function of their corners.

use crate::contact::closest_on_triangle;
use crate::units::Vec3;

/// Barycentric shares below this are zero: a closest point that lies on the border of two regions belongs to the
/// lesser feature on both sides of a mirror, whatever rounding says.
const TIE: f64 = 1e-10;
/// Squared sine below which edges are parallel.
const PARALLEL: f64 = 1e-14;

/// `r = sum_i a_i(beta) x_i` between the closest points of two simplices with the corners `x_i`, where `beta` are the
/// parameters (none, one or two) that minimise `|r|` over the feature that the points lie on.
///
/// The envelope theorem gives `grad d = a_i r / d`; what `beta` gives way by gives the second derivative.
#[derive(Clone, Copy, Debug)]
pub(super) struct Separation {
    /// `r`, mm.
    pub(super) offset: Vec3,
    /// `a_i` of each corner; zero for a corner that the feature has not. They sum to zero.
    pub(super) shares: [f64; 4],
    /// `d a_i / d beta_k`.
    pub(super) slopes: [[f64; 4]; 2],
    /// `d r / d beta_k`, mm.
    pub(super) tangents: [Vec3; 2],
    /// Number of parameters.
    pub(super) n_free: usize,
}

impl Separation {
    fn new(x: &[Vec3; 4], shares: [f64; 4], slopes: [[f64; 4]; 2], n_free: usize) -> Self {
        // Taken from a corner, so that coordinates far from the origin do not round the offset.
        let combined = |c: &[f64; 4]| (1..4).map(|i| c[i] * (x[i] - x[0])).sum::<Vec3>();
        Self {
            offset: combined(&shares),
            shares,
            slopes,
            tangents: [combined(&slopes[0]), combined(&slopes[1])],
            n_free,
        }
    }

    /// Of corner `i` from corner `j`.
    fn corner_corner(x: &[Vec3; 4], i: usize, j: usize) -> Self {
        let mut shares = [0.; 4];
        (shares[i], shares[j]) = (1., -1.);
        Self::new(x, shares, [[0.; 4]; 2], 0)
    }

    /// Of corner `i` from the line through corners `j` and `k`.
    fn corner_line(x: &[Vec3; 4], i: usize, [j, k]: [usize; 2]) -> Self {
        let along = x[k] - x[j];
        let beta = (x[i] - x[j]).dot(&along) / along.norm_squared();
        let (mut shares, mut slope) = ([0.; 4], [0.; 4]);
        (shares[i], shares[j], shares[k]) = (1., beta - 1., -beta);
        (slope[j], slope[k]) = (1., -1.);
        Self::new(x, shares, [slope, [0.; 4]], 1)
    }

    /// Of corner 0 from the simplex of the next `n - 1` corners, whose inside has its closest point.
    pub(super) fn of_vertex(x: &[Vec3; 4], n: usize) -> Self {
        match n {
            2 => Self::corner_corner(x, 0, 1),
            3 => Self::corner_line(x, 0, [1, 2]),
            _ => Self::corner_plane(x),
        }
    }

    /// Of corner 0 from the plane of the others.
    fn corner_plane(x: &[Vec3; 4]) -> Self {
        let (e, f, p) = (x[2] - x[1], x[3] - x[1], x[0] - x[1]);
        let (ee, ef, ff) = (e.norm_squared(), e.dot(&f), f.norm_squared());
        let (pe, pf) = (p.dot(&e), p.dot(&f));
        let determinant = e.cross(&f).norm_squared();
        let (s, t) = ((ff * pe - ef * pf) / determinant, (ee * pf - ef * pe) / determinant);
        Self::new(x, [1., s + t - 1., -s, -t], [[0., 1., -1., 0.], [0., 1., 0., -1.]], 2)
    }

    /// Of the edge of corners 0 and 1 from that of corners 2 and 3.
    pub(super) fn of_edges(x: &[Vec3; 4]) -> Self {
        match nearest_on_edges(x).0 {
            OnEdges::Inside(s, t) => {
                Self::new(x, [1. - s, s, t - 1., -t], [[-1., 1., 0., 0.], [0., 0., 1., -1.]], 2)
            }
            OnEdges::CornerInside(i, edge) => Self::corner_line(x, i, edge),
            OnEdges::Corners(i, j) => Self::corner_corner(x, i, j),
        }
    }

    /// Distance, mm.
    pub(super) fn distance(&self) -> f64 {
        self.offset.norm()
    }
}

/// Where on two edges, of corners 0 and 1 and of corners 2 and 3, their closest points lie.
#[derive(Clone, Copy)]
enum OnEdges {
    /// Between the corners of either, at these shares.
    Inside(f64, f64),
    /// At a corner of one, between those of the other one.
    CornerInside(usize, [usize; 2]),
    /// At a corner of either.
    Corners(usize, usize),
}

/// Where the closest points of two edges lie, and their squared distance, mm².
fn nearest_on_edges(x: &[Vec3; 4]) -> (OnEdges, f64) {
    let (u, v, w) = (x[1] - x[0], x[3] - x[2], x[0] - x[2]);
    let (uu, uv, vv) = (u.norm_squared(), u.dot(&v), v.norm_squared());
    let determinant = u.cross(&v).norm_squared();
    if determinant > PARALLEL * uu * vv {
        let (uw, vw) = (u.dot(&w), v.dot(&w));
        let (s, t) = ((uv * vw - vv * uw) / determinant, (uu * vw - uv * uw) / determinant);
        if [s, t].iter().all(|beta| (TIE..=1. - TIE).contains(beta)) {
            return (OnEdges::Inside(s, t), (w + s * u - t * v).norm_squared());
        }
    }
    let of_corner = |(i, edge): (usize, [usize; 2])| {
        let [p, a, b] = [x[i], x[edge[0]], x[edge[1]]];
        match nearest_on_edge(p, [a, b]) {
            OnEdge::End(k) => (OnEdges::Corners(i, edge[k]), (p - x[edge[k]]).norm_squared()),
            OnEdge::Inside(beta) => (OnEdges::CornerInside(i, edge), (p - a - beta * (b - a)).norm_squared()),
        }
    };
    let others = [(1, [2, 3]), (2, [0, 1]), (3, [0, 1])].map(of_corner);
    others.into_iter().fold(of_corner((0, [2, 3])), |best, next| if next.1 < best.1 { next } else { best })
}

/// Squared distance of the edge of corners 0 and 1 from that of corners 2 and 3, mm².
pub(super) fn edges_squared_distance(x: &[Vec3; 4]) -> f64 {
    nearest_on_edges(x).1
}

/// Where on an edge its closest point lies.
#[derive(Clone, Copy)]
pub(super) enum OnEdge {
    /// At end 0 or 1.
    End(usize),
    /// Between, at this share.
    Inside(f64),
}

/// Where on the edge `[a, b]` the point closest to `p` lies.
pub(super) fn nearest_on_edge(p: Vec3, [a, b]: [Vec3; 2]) -> OnEdge {
    let along = b - a;
    let (reached, whole) = ((p - a).dot(&along), along.norm_squared());
    if reached <= TIE * whole {
        OnEdge::End(0)
    } else if reached >= (1. - TIE) * whole {
        OnEdge::End(1)
    } else {
        OnEdge::Inside(reached / whole)
    }
}

/// Which corners of the triangle `t` carry the point of it that is closest to `p`, and its squared distance, mm².
pub(super) fn nearest_on_triangle(p: Vec3, t: [Vec3; 3]) -> ([bool; 3], f64) {
    let hit = closest_on_triangle(p, t);
    (hit.weights.map(|w| w > TIE), (p - hit.point).norm_squared())
}

/// Offset of `p` from the point of the triangle `t` that is closest to it, mm.
pub(super) fn vertex_triangle_offset(p: Vec3, t: [Vec3; 3]) -> Vec3 {
    p - closest_on_triangle(p, t).point
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::contact::barrier::testing::Random;

    /// The least distance over both parameters by a grid that closes in on the best.
    fn least(distance: impl Fn(f64, f64) -> f64) -> f64 {
        let (mut s, mut t, mut size) = (0.5, 0.5, 0.5);
        for _ in 0..60 {
            let mut best = (distance(s, t), s, t);
            for i in -4..=4 {
                for j in -4..=4 {
                    let near = (s + size * f64::from(i) / 4., t + size * f64::from(j) / 4.);
                    let near = (near.0.clamp(0., 1.), near.1.clamp(0., 1.));
                    let d = distance(near.0, near.1);
                    if d < best.0 {
                        best = (d, near.0, near.1);
                    }
                }
            }
            (s, t, size) = (best.1, best.2, 0.6 * size);
        }
        distance(s, t)
    }

    #[test]
    fn edges_are_as_far_apart_as_the_best_of_all_their_points() {
        let mut random = Random(1);
        let mut regions = [0; 3];
        for _ in 0..300 {
            let x: [Vec3; 4] = std::array::from_fn(|_| random.point());
            let separation = Separation::of_edges(&x);
            let expected = least(|s, t| (x[0].lerp(&x[1], s) - x[2].lerp(&x[3], t)).norm());
            assert!((separation.distance() - expected).abs() < 1e-7, "{separation:?} {expected}");
            regions[separation.n_free] += 1;
        }
        assert!(regions.iter().all(|n| *n > 10), "{regions:?}");
    }

    #[test]
    fn parallel_edges_are_as_far_apart_as_their_lines_or_their_ends() {
        let x = |shift: f64| {
            [Vec3::zeros(), Vec3::x(), Vec3::new(shift, 0.25, 0.), Vec3::new(shift + 2., 0.25, 0.)]
        };
        assert!((Separation::of_edges(&x(0.5)).distance() - 0.25).abs() < 1e-15);
        assert!((Separation::of_edges(&x(-1.5)).distance() - 0.25).abs() < 1e-15);
        assert!((Separation::of_edges(&x(1.6)).distance() - 0.6f64.hypot(0.25)).abs() < 1e-15);
    }

    #[test]
    fn the_offset_stands_on_the_tangents_and_the_shares_sum_to_nothing() {
        let mut random = Random(2);
        for _ in 0..100 {
            let x: [Vec3; 4] = std::array::from_fn(|_| random.point());
            for s in
                [2, 3, 4].map(|n| Separation::of_vertex(&x, n)).into_iter().chain([Separation::of_edges(&x)])
            {
                for k in 0..s.n_free {
                    let cosine = s.offset.dot(&s.tangents[k]) / (s.distance() * s.tangents[k].norm());
                    assert!(cosine.abs() < 1e-9, "{s:?}");
                }
                assert!(s.shares.iter().sum::<f64>().abs() < 1e-12, "{s:?}");
            }
        }
    }

    #[test]
    fn a_point_on_the_border_of_regions_belongs_to_the_lesser_feature_on_both_sides() {
        let t = [Vec3::zeros(), Vec3::new(2., 0., 0.), Vec3::new(0., 2., 0.)];
        for off in [-1e-12, 0., 1e-12] {
            assert_eq!(nearest_on_triangle(Vec3::new(1., off, 0.5), t).0, [true, true, false]);
            assert_eq!(nearest_on_triangle(Vec3::new(off, -1., 0.5), t).0, [true, false, false]);
            let end = nearest_on_edge(Vec3::new(off, 1., 0.), [t[0], t[1]]);
            assert!(matches!(end, OnEdge::End(0)));
        }
    }
}
