//! The similarity that brings one set of points nearest to another.

use nalgebra::Matrix3;

use crate::units::Vec3;

/// Rounds of reweighting.
const ROUNDS: usize = 50;

/// Turning, scaling and shifting: `y = s R x + t`.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Similarity {
    /// Scale `s`, above zero.
    pub scale: f64,
    /// Rotation `R`; with the determinant -1 a reflection.
    pub rotation: Matrix3<f64>,
    /// Translation `t`, mm.
    pub translation: Vec3,
}

impl Similarity {
    /// The one that minimises `sum_k w_k |y_k - s R x_k - t|²` over the pairs `(x_k, y_k)`, mm; with `reflects` over
    /// reflections in place of rotations. `None` where the points do not fix it: fewer than three, or all in a line.
    ///
    /// Source: Umeyama, IEEE Trans. Pattern Anal. Mach. Intell. 13 (1991) 376.
    pub fn fit(pairs: &[[Vec3; 2]], weights: &[f64], reflects: bool) -> Option<Self> {
        let total: f64 = weights.iter().sum();
        let all = || pairs.iter().zip(weights);
        let [from, to] = [0, 1].map(|k| all().map(|(pair, w)| *w * pair[k]).sum::<Vec3>() / total);
        let (mut spread, mut covariance) = (0., Matrix3::zeros());
        for (&[x, y], w) in all() {
            spread += w * (x - from).norm_squared();
            covariance += *w * (y - to) * (x - from).transpose();
        }
        let svd = covariance.svd(true, true);
        let (u, vt) = (svd.u?, svd.v_t?);
        let mut order = [0, 1, 2];
        order.sort_by(|&a, &b| svd.singular_values[b].total_cmp(&svd.singular_values[a]));
        let least_known = svd.singular_values[order[1]];
        if !(spread > 0. && least_known > 1e-9 * svd.singular_values[order[0]]) {
            return None;
        }
        // Where the best orthogonal matrix is of the other kind, the least of the singular directions turns round.
        let side = if (u * vt).determinant() < 0. { -1. } else { 1. };
        let wanted = if reflects { -1. } else { 1. };
        let mut signs = Vec3::repeat(1.);
        signs[order[2]] = side * wanted;
        let rotation = u * Matrix3::from_diagonal(&signs) * vt;
        let scale = svd.singular_values.dot(&signs) / spread;
        let is_one = scale.is_finite() && scale > 0.;
        is_one.then(|| Self { scale, rotation, translation: to - scale * (rotation * from) })
    }

    /// The same, robust: pairs that are off count by Geman and `McClure`'s weight `(c² / (c² + r²))²` with `c` the
    /// `tolerance`, mm in the second frame. Returns the last weights, too.
    pub fn robust(pairs: &[[Vec3; 2]], tolerance: f64) -> Option<(Self, Vec<f64>)> {
        let mut weights = vec![1.; pairs.len()];
        let mut found = Self::fit(pairs, &weights, false)?;
        for _ in 0..ROUNDS {
            let residual = |pair: &[Vec3; 2]| (found.apply(pair[0]) - pair[1]).norm_squared();
            let square = tolerance * tolerance;
            weights = pairs.iter().map(|pair| (square / (square + residual(pair))).powi(2)).collect();
            found = Self::fit(pairs, &weights, false)?;
        }
        Some((found, weights))
    }

    /// Where the point `x` goes.
    pub fn apply(&self, x: Vec3) -> Vec3 {
        self.scale * (self.rotation * x) + self.translation
    }

    /// Where a point comes from, but for the scale: `R' (y - t)`.
    pub fn unmoved(&self, y: Vec3) -> Vec3 {
        self.rotation.transpose() * (y - self.translation)
    }

    /// Angle of the rotation, degrees, 0 to 180.
    pub fn angle_deg(&self) -> f64 {
        ((self.rotation.trace() - 1.) / 2.).clamp(-1., 1.).acos().to_degrees()
    }

    /// Root mean square of what it leaves of the pairs, mm.
    pub fn rms(&self, pairs: &[[Vec3; 2]]) -> f64 {
        let squares: f64 = pairs.iter().map(|&[x, y]| (self.apply(x) - y).norm_squared()).sum();
        (squares / pairs.len().max(1) as f64).sqrt()
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use nalgebra::Rotation3;

    fn pairs(reflect: f64) -> (Vec<[Vec3; 2]>, Matrix3<f64>) {
        let turn = Rotation3::from_euler_angles(0.4, -1.1, 2.6).into_inner()
            * Matrix3::from_diagonal(&Vec3::new(reflect, 1., 1.));
        let place = |k: usize| {
            let t = k as f64;
            Vec3::new((1.7 * t).sin() * 30., (0.9 * t).cos() * 40., (2.3 * t).sin() * 12.)
        };
        let to = |x: Vec3| 1.13 * (turn * x) + Vec3::new(4., -250., 17.);
        ((0..12).map(place).map(|x| [x, to(x)]).collect(), turn)
    }

    #[test]
    fn a_known_similarity_is_found_and_told_from_a_reflection() {
        for reflect in [1., -1.] {
            let (pairs, turn) = pairs(reflect);
            let found = Similarity::fit(&pairs, &[1.; 12], reflect < 0.).expect("points that fix it");
            assert!((found.scale - 1.13).abs() < 1e-12 && (found.rotation - turn).norm() < 1e-12);
            assert!(found.rms(&pairs) < 1e-12);
            let other = Similarity::fit(&pairs, &[1.; 12], reflect > 0.).expect("points that fix it");
            assert!((other.rotation.determinant() * turn.determinant() + 1.).abs() < 1e-12);
            assert!(other.rms(&pairs) > 5., "{}", other.rms(&pairs));
            assert!((found.unmoved(pairs[3][1]) - 1.13 * pairs[3][0]).norm() < 1e-10);
        }
    }

    #[test]
    fn one_false_pair_does_not_move_the_robust_one() {
        let (mut pairs, turn) = pairs(1.);
        pairs[5][1] += Vec3::new(40., 0., 10.);
        let (found, weights) = Similarity::robust(&pairs, 4.).expect("points that fix it");
        assert!((found.rotation - turn).norm() < 2e-3 && (found.scale - 1.13).abs() < 2e-3, "{found:?}");
        assert!(weights[5] < 1e-3);
    }

    #[test]
    fn points_in_a_line_fix_nothing() {
        let line: Vec<[Vec3; 2]> = (0..9).map(|k| [Vec3::new(f64::from(k), 0., 0.); 2]).collect();
        assert_eq!(Similarity::fit(&line, &[1.; 9], false), None);
    }
}
