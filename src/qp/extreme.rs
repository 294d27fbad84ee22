//! The extremes of a linear function over an ellipsoid in a box: a second-order cone program.

use nalgebra::{DMatrix, DVector};

use super::clarabel;

/// A set in `n` variables: `|B x - c| <= 1`, `lo <= x <= hi`.
#[derive(Clone, Debug, PartialEq)]
pub struct EllipsoidInBox {
    /// `B` (k x n).
    pub ball: DMatrix<f64>,
    /// `c` (k).
    pub centre: DVector<f64>,
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

impl EllipsoidInBox {
    /// The least value of `f'x`; `None` when the set is empty or the solver finds nothing that holds.
    pub fn least(&self, f: &DVector<f64>) -> Option<Extreme> {
        let size = f.amax();
        if size == 0. {
            return None;
        }
        let f = f / size;
        let (x, multipliers) = clarabel::least(self, &f)?;
        let bound = size * self.bound(&f, &multipliers);
        Some(Extreme { value: size * f.dot(&x), bound, primal: self.primal(&x), x })
    }

    /// How far `x` is out of the set.
    pub fn primal(&self, x: &DVector<f64>) -> f64 {
        let ball = (&self.ball * x - &self.centre).norm() - 1.;
        let bounds =
            x.iter().zip(self.lower.iter().zip(self.upper.iter())).map(|(x, (lo, hi))| (lo - x).max(x - hi));
        bounds.fold(ball.max(0.), f64::max)
    }

    /// What `f'x` cannot go below, whatever the multipliers `v` (k) of the ball are: `v'(B x - c) >= -|v|` in it, so that
    /// `f'x >= (f - B'v)'x + v'c - |v|`, whose first summand is least at a corner of the box.
    fn bound(&self, f: &DVector<f64>, v: &DVector<f64>) -> f64 {
        let rest = f - self.ball.tr_mul(v);
        let sides = self.lower.iter().zip(self.upper.iter());
        let corner: f64 = rest.iter().zip(sides).map(|(r, (lo, hi))| (r * lo).min(r * hi)).sum();
        corner + v.dot(&self.centre) - v.norm()
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn disc() -> EllipsoidInBox {
        EllipsoidInBox {
            ball: DMatrix::identity(2, 2) * 2.,
            centre: DVector::from_vec(vec![1., 1.]),
            lower: DVector::from_vec(vec![0., 0.]),
            upper: DVector::from_vec(vec![1., 0.8]),
        }
    }

    /// The circle about (1/2, 1/2) of radius 1/2, below 0.8.
    #[test]
    fn extremes_of_a_cut_disc() {
        let down = disc().least(&DVector::from_vec(vec![0., 1.])).expect("the disc");
        assert!(down.value.abs() < 1e-7 && down.bound.abs() < 1e-7 && down.primal < 1e-8, "{down:?}");
        let up = disc().least(&DVector::from_vec(vec![0., -3.])).expect("the disc");
        assert!((up.value + 2.4).abs() < 1e-7 && (up.bound + 2.4).abs() < 1e-6, "{up:?}");
        // Right of x = 0.9 the disc is lowest on that line.
        let low = 0.5 - (0.25f64 - 0.16).sqrt();
        let right = |from: f64| EllipsoidInBox { lower: DVector::from_vec(vec![from, 0.]), ..disc() };
        let cut = right(0.9).least(&DVector::from_vec(vec![0., 1.])).expect("what is left of the disc");
        assert!((cut.value - low).abs() < 1e-7 && (cut.bound - low).abs() < 1e-6, "{cut:?}");
        let empty = EllipsoidInBox { centre: DVector::from_vec(vec![9., 1.]), ..disc() };
        assert_eq!(empty.least(&DVector::from_vec(vec![0., 1.])), None);
    }
}
