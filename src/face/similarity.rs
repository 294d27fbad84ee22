//! From the measure of one head to that of another.

use nalgebra::{Matrix3, Rotation3};

use crate::units::Vec3;

/// Share of the largest spread below which points lie on a line.
const FLAT: f64 = 1e-3;
/// Rounds of reweighting.
const ROUNDS: usize = 60;

/// A similarity `p -> s R p + t`: scale, rotation, translation.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Similarity {
    /// `s`, positive.
    pub scale: f64,
    /// `R`.
    pub rotation: Rotation3<f64>,
    /// `t`, mm.
    pub translation: Vec3,
}

impl Similarity {
    /// No change.
    pub const fn identity() -> Self {
        let one = Matrix3::new(1., 0., 0., 0., 1., 0., 0., 0., 1.);
        Self {
            scale: 1.,
            rotation: Rotation3::from_matrix_unchecked(one),
            translation: Vec3::new(0., 0., 0.),
        }
    }

    /// The one that brings the first of each pair of points closest to the second, in the sum of squares with `weights`
    /// (Umeyama 1991, IEEE PAMI 13:376); with `scale` given, of that scale. `None` for fewer than three points, or points on
    /// a line.
    pub fn fit(pairs: &[[Vec3; 2]], weights: &[f64], scale: Option<f64>) -> Option<Self> {
        let total: f64 = weights.iter().sum();
        if pairs.len() < 3 || total.is_nan() || total <= 0. {
            return None;
        }
        let weighted = || pairs.iter().zip(weights);
        let mean = |k: usize| weighted().map(|(p, w)| p[k] * *w).sum::<Vec3>() / total;
        let [from, to] = [mean(0), mean(1)];
        let (mut across, mut spread, mut own) = (Matrix3::zeros(), 0., Matrix3::zeros());
        for (p, w) in weighted() {
            let (a, b) = (p[0] - from, p[1] - to);
            across += *w * b * a.transpose();
            own += *w * a * a.transpose();
            spread += w * a.norm_squared();
        }
        let mut spreads = own.symmetric_eigenvalues();
        spreads.as_mut_slice().sort_by(f64::total_cmp);
        if spreads[1] <= FLAT * FLAT * spreads[2] || spreads[2].is_nan() {
            return None;
        }
        let svd = across.svd(true, true);
        let (u, v) = (svd.u?, svd.v_t?.transpose());
        let mut sign = Matrix3::identity();
        // The least singular value turns where the best orthogonal map is a reflection.
        let last = svd.singular_values.imin();
        sign[(last, last)] = if (u * v.transpose()).determinant() < 0. { -1. } else { 1. };
        let rotation = Rotation3::from_matrix_unchecked(u * sign * v.transpose());
        let stretched: f64 = (0..3).map(|k| svd.singular_values[k] * sign[(k, k)]).sum();
        let scale = scale.unwrap_or(stretched / spread);
        (scale > 0. && scale.is_finite()).then(|| Self {
            scale,
            rotation,
            translation: to - rotation * from * scale,
        })
    }

    /// The same, pairs that end far from each other counting little: the least sum of `d^2 / (d^2 + width_mm^2)` over the
    /// distances `d` that is found from the least squares (Geman and `McClure` 1987).
    pub fn robust(pairs: &[[Vec3; 2]], scale: Option<f64>, width_mm: f64) -> Option<Self> {
        let mut weights = vec![1.; pairs.len()];
        let mut best = Self::fit(pairs, &weights, scale)?;
        // The width shrinks, so that a few that are far off do not hold the start.
        let far = pairs.iter().map(|p| (best.apply(p[0]) - p[1]).norm()).fold(width_mm, f64::max);
        for round in 0..ROUNDS {
            let share = (2. * round as f64 / ROUNDS as f64).min(1.);
            let width = far.powf(1. - share) * width_mm.powf(share);
            for (weight, p) in weights.iter_mut().zip(pairs) {
                let d = (best.apply(p[0]) - p[1]).norm() / width;
                *weight = 1. / (1. + d * d).powi(2);
            }
            best = Self::fit(pairs, &weights, scale)?;
        }
        Some(best)
    }

    /// Where it brings the point `p`, mm.
    pub fn apply(&self, p: Vec3) -> Vec3 {
        self.rotation * p * self.scale + self.translation
    }

    /// Where it brings the difference `d` of two points, mm.
    pub fn turn(&self, d: Vec3) -> Vec3 {
        self.rotation * d * self.scale
    }

    /// The one that undoes it.
    #[must_use]
    pub fn inverse(&self) -> Self {
        let rotation = self.rotation.inverse();
        let scale = 1. / self.scale;
        Self { scale, rotation, translation: -(rotation * self.translation * scale) }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn points() -> Vec<Vec3> {
        let rows = [
            [0., 71., -5.],
            [-44., 68., -26.],
            [44., 68., -26.],
            [0., 38., 18.],
            [25., -2., -11.],
            [-25., -2., -11.],
        ];
        rows.iter().map(|p| Vec3::from(*p)).collect()
    }

    fn moved() -> Similarity {
        let rotation = Rotation3::from_euler_angles(0.3, -0.5, 1.1);
        Similarity { scale: 1.07, rotation, translation: Vec3::new(3., 1470., -20.) }
    }

    #[test]
    fn a_similarity_is_found_again_and_undone() {
        let pairs: Vec<[Vec3; 2]> = points().iter().map(|p| [*p, moved().apply(*p)]).collect();
        let found = Similarity::fit(&pairs, &[1.; 6], None).expect("not on a line");
        for [p, q] in &pairs {
            assert!((found.apply(*p) - q).norm() < 1e-9 && (found.inverse().apply(*q) - p).norm() < 1e-9);
        }
        assert!((found.scale - 1.07).abs() < 1e-12);
        let held = Similarity::fit(&pairs, &[1.; 6], Some(1.)).expect("not on a line");
        assert!(held.scale == 1. && (held.rotation.matrix() - moved().rotation.matrix()).norm() < 1e-9);
    }

    #[test]
    fn one_that_is_far_off_does_not_count() {
        let mut pairs: Vec<[Vec3; 2]> = points().iter().map(|p| [*p, moved().apply(*p)]).collect();
        pairs[3][1] += Vec3::new(30., -40., 0.);
        let found = Similarity::robust(&pairs, None, 2.).expect("not on a line");
        assert!((found.scale - 1.07).abs() < 1e-3, "{}", found.scale);
        let plain = Similarity::fit(&pairs, &[1.; 6], None).expect("not on a line");
        assert!((plain.scale - 1.07).abs() > 1e-2);
    }

    #[test]
    fn a_reflection_is_none_and_a_line_is_refused() {
        let mirrored: Vec<[Vec3; 2]> = points().iter().map(|p| [*p, Vec3::new(-p.x, p.y, p.z)]).collect();
        let found = Similarity::fit(&mirrored, &[1.; 6], Some(1.)).expect("not on a line");
        assert!((found.rotation.matrix().determinant() - 1.).abs() < 1e-12);
        let line: Vec<[Vec3; 2]> = (0..5).map(|k| [Vec3::new(f64::from(k), 2., 3.); 2]).collect();
        assert_eq!(Similarity::fit(&line, &[1.; 5], None), None);
        assert_eq!(Similarity::fit(&mirrored[..2], &[1.; 2], None), None);
    }
}
