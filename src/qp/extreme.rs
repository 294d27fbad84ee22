//! The extremes of a linear function over a ball cut by half spaces: a second-order cone program.

use nalgebra::{DMatrix, DVector};

use super::clarabel;

/// A set in `n` variables: `|B x - c| <= 1`, `G x <= h`, `lo <= x <= hi`.
#[derive(Clone, Debug, PartialEq)]
pub struct BallSection {
    /// `B` (k x n).
    pub ball: DMatrix<f64>,
    /// `c` (k).
    pub centre: DVector<f64>,
    /// `G` (rows x n).
    pub inequality: DMatrix<f64>,
    /// `h`.
    pub inequality_limit: DVector<f64>,
    /// `lo` (n), finite.
    pub lower: DVector<f64>,
    /// `hi` (n), finite.
    pub upper: DVector<f64>,
}

/// Where a linear function is least.
#[derive(Clone, Debug, PartialEq)]
pub struct Extreme {
    /// The point (n).
    pub x: DVector<f64>,
    /// The value there.
    pub value: f64,
    /// A value that it cannot go below, by the multipliers; the extreme lies between the two.
    pub bound: f64,
    /// How far the point is out of the set, dimensionless.
    pub primal: f64,
}

impl BallSection {
    /// The least value of `f'x`; `None` when the set is empty or the solver finds nothing that holds.
    pub fn least(&self, f: &DVector<f64>) -> Option<Extreme> {
        let size = f.amax();
        if size == 0. {
            return None;
        }
        let f = f / size;
        let (x, multipliers) = clarabel::least(self, &f)?;
        let bound = size * multipliers.bound(self, &f);
        Some(Extreme { value: size * f.dot(&x), bound, primal: self.primal(&x), x })
    }

    /// How far `x` is out of the set.
    pub fn primal(&self, x: &DVector<f64>) -> f64 {
        let ball = (&self.ball * x - &self.centre).norm() - 1.;
        let rows = &self.inequality * x - &self.inequality_limit;
        let rows = rows.iter().zip(self.inequality.row_iter()).map(|(v, row)| v / row.norm().max(1.));
        let bounds =
            x.iter().zip(self.lower.iter().zip(self.upper.iter())).map(|(x, (lo, hi))| (lo - x).max(x - hi));
        rows.chain(bounds).fold(ball.max(0.), f64::max)
    }
}

/// Multipliers of a section's ball (k) and of its rows, which are not negative.
pub(super) struct Multipliers {
    pub(super) ball: DVector<f64>,
    pub(super) rows: DVector<f64>,
}

impl Multipliers {
    /// What `f'x` cannot go below in `set`, whatever the multipliers: `v'(B x - c) >= -|v|` in the ball and
    /// `z'(G x - h) <= 0` within the rows, so that `f'x >= (f - B'v + G'z)'x + v'c - |v| - z'h`, whose first summand is least
    /// at a corner of the box.
    fn bound(&self, set: &BallSection, f: &DVector<f64>) -> f64 {
        let rest = f - set.ball.tr_mul(&self.ball) + set.inequality.tr_mul(&self.rows);
        let corners = set.lower.iter().zip(set.upper.iter());
        let corner: f64 = rest.iter().zip(corners).map(|(r, (lo, hi))| (r * lo).min(r * hi)).sum();
        corner + self.ball.dot(&set.centre) - self.ball.norm() - self.rows.dot(&set.inequality_limit)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn section(half_space: f64) -> BallSection {
        BallSection {
            ball: DMatrix::identity(2, 2) * 2.,
            centre: DVector::from_vec(vec![1., 1.]),
            inequality: DMatrix::from_row_slice(1, 2, &[-1., 0.]),
            inequality_limit: DVector::from_vec(vec![-half_space]),
            lower: DVector::from_vec(vec![0., 0.]),
            upper: DVector::from_vec(vec![1., 0.8]),
        }
    }

    /// The circle about (1/2, 1/2) of radius 1/2, right of a line and below 0.8.
    #[test]
    fn extremes_of_a_cut_disc() {
        let down = section(0.).least(&DVector::from_vec(vec![0., 1.])).expect("the disc");
        assert!(down.value.abs() < 1e-7 && down.bound.abs() < 1e-7 && down.primal < 1e-8, "{down:?}");
        let up = section(0.).least(&DVector::from_vec(vec![0., -3.])).expect("the disc");
        assert!((up.value + 2.4).abs() < 1e-7 && (up.bound + 2.4).abs() < 1e-6, "{up:?}");
        // Right of x = 0.9 the disc is lowest on that line.
        let low = 0.5 - (0.25f64 - 0.16).sqrt();
        let cut = section(0.9).least(&DVector::from_vec(vec![0., 1.])).expect("what is left of the disc");
        assert!((cut.value - low).abs() < 1e-7 && (cut.bound - low).abs() < 1e-6, "{cut:?}");
        assert_eq!(section(1.1).least(&DVector::from_vec(vec![0., 1.])), None);
    }
}
