//! Interpolating curves through knots.

/// A piecewise cubic `y(x)`, constant beyond its end knots.
#[derive(Clone, Debug)]
pub(super) struct Curve {
    x: Vec<f64>,
    y: Vec<f64>,
    slope: Vec<f64>,
}

impl Curve {
    /// The natural cubic through `(x, y)`: continuous curvature, zero at both ends. Shapes of the
    /// head use it because a jump of curvature shows as a crease.
    pub(super) fn natural(knots: &[(f64, f64)]) -> Self {
        let (x, y): (Vec<f64>, Vec<f64>) = knots.iter().copied().unzip();
        let n = x.len();
        let (mut diagonal, mut right) = (vec![2.0; n], vec![0.0; n]);
        let h = |k: usize| x[k + 1] - x[k];
        let d = |k: usize| (y[k + 1] - y[k]) / h(k);
        (right[0], right[n - 1]) = (3.0 * d(0), 3.0 * d(n - 2));
        for k in 1..n - 1 {
            diagonal[k] = 2.0 * (h(k - 1) + h(k));
            right[k] = 3.0 * (h(k) * d(k - 1) + h(k - 1) * d(k));
        }
        // Rows are (h_k, 2 (h_{k-1} + h_k), h_{k-1}) inside and (2, 1), (1, 2) at the ends.
        let upper = |k: usize| if k == 0 { 1.0 } else { h(k - 1) };
        let lower = |k: usize| if k == n - 1 { 1.0 } else { h(k) };
        for k in 1..n {
            let factor = lower(k) / diagonal[k - 1];
            diagonal[k] -= factor * upper(k - 1);
            right[k] -= factor * right[k - 1];
        }
        let mut slope = vec![0.0; n];
        slope[n - 1] = right[n - 1] / diagonal[n - 1];
        for k in (0..n - 1).rev() {
            slope[k] = (right[k] - upper(k) * slope[k + 1]) / diagonal[k];
        }
        Self { x, y, slope }
    }

    /// The monotone cubic through `(x, y)` (Fritsch and Butland 1984): it never overshoots its
    /// knots, which spacings and thicknesses need.
    pub(super) fn monotone(knots: &[(f64, f64)]) -> Self {
        let (x, y): (Vec<f64>, Vec<f64>) = knots.iter().copied().unzip();
        let n = x.len();
        let d: Vec<f64> = (0..n - 1).map(|k| (y[k + 1] - y[k]) / (x[k + 1] - x[k])).collect();
        let mut slope = vec![0.0; n];
        (slope[0], slope[n - 1]) = (d[0], d[n - 2]);
        for k in 1..n - 1 {
            if d[k - 1] * d[k] > 0.0 {
                let (before, after) = (x[k] - x[k - 1], x[k + 1] - x[k]);
                let weight = (before + 2.0 * after) / (3.0 * (before + after));
                slope[k] = d[k - 1] * d[k] / (weight * d[k] + (1.0 - weight) * d[k - 1]);
            }
        }
        Self { x, y, slope }
    }

    /// The curve at `at`.
    pub(super) fn at(&self, at: f64) -> f64 {
        let last = self.x.len() - 1;
        let at = at.clamp(self.x[0], self.x[last]);
        let k = self.x.partition_point(|&x| x <= at).clamp(1, last) - 1;
        let h = self.x[k + 1] - self.x[k];
        let t = (at - self.x[k]) / h;
        let (t2, t3) = (t * t, t * t * t);
        (2.0 * t3 - 3.0 * t2 + 1.0) * self.y[k]
            + (t3 - 2.0 * t2 + t) * h * self.slope[k]
            + (3.0 * t2 - 2.0 * t3) * self.y[k + 1]
            + (t3 - t2) * h * self.slope[k + 1]
    }
}

/// The cubic step from 0 at `from` to 1 at `to`, flat at both.
pub(super) fn step(x: f64, from: f64, to: f64) -> f64 {
    let t = ((x - from) / (to - from)).clamp(0.0, 1.0);
    t * t * (3.0 - 2.0 * t)
}

/// The bell `exp(-(d/width)^2)`.
pub(super) fn bell(d: f64, width: f64) -> f64 {
    (-(d / width) * (d / width)).exp()
}

/// The larger of `a` and `b`, rounded over about `radius`; never less than either.
pub(super) fn smooth_max(a: f64, b: f64, radius: f64) -> f64 {
    0.5 * (a + b + (a - b).hypot(radius))
}

#[cfg(test)]
mod tests {
    use super::*;

    const KNOTS: [(f64, f64); 5] = [(0., 0.), (1., 2.), (3., 2.5), (4., 7.), (6., 7.5)];

    #[test]
    fn both_pass_through_their_knots() {
        for curve in [Curve::natural(&KNOTS), Curve::monotone(&KNOTS)] {
            for (x, y) in KNOTS {
                assert!((curve.at(x) - y).abs() < 1e-13);
            }
        }
    }

    #[test]
    fn natural_has_continuous_curvature_and_straight_ends() {
        let curve = Curve::natural(&KNOTS);
        let h = 1e-4;
        let curvature = |x: f64| (curve.at(x + h) - 2. * curve.at(x) + curve.at(x - h)) / (h * h);
        for x in [1., 3., 4.] {
            assert!((curvature(x - 1.1 * h) - curvature(x + 1.1 * h)).abs() < 0.02);
        }
        assert!(curvature(2. * h).abs() < 0.02 && curvature(6. - 2. * h).abs() < 0.02);
    }

    #[test]
    fn monotone_never_turns_back() {
        let curve = Curve::monotone(&KNOTS);
        let values: Vec<f64> = (0..=600).map(|k| curve.at(f64::from(k) * 0.01)).collect();
        assert!(values.windows(2).all(|w| w[1] >= w[0]));
    }
}
