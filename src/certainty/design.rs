//! Which markers determine the activations best.

use nalgebra::{Cholesky, DMatrix, DVector};

use super::Discrepancy;
use crate::units::Vec3;

/// Variance of an activation of which nothing is known: uniform from 0 to 1.
const UNKNOWN: f64 = 1. / 12.;

/// A marker that was chosen.
#[derive(Clone, Debug, PartialEq)]
pub struct ChosenMarker {
    /// Which of the candidates, from 0.
    pub candidate: usize,
    /// Posterior standard deviation of each activation (m) with this marker and those before it.
    pub sd: DVector<f64>,
}

/// Points that may bear markers, and what muscles do to them.
#[derive(Clone, Debug)]
pub struct MarkerDesign<'a> {
    /// Rest positions (p), mm.
    pub points: &'a [Vec3],
    /// Movement by activation (3p x m), mm.
    pub map: &'a DMatrix<f64>,
    /// Standard deviation of a component of a marker, mm.
    pub sigma_mm: f64,
    /// How far the model may be from the face, with all muscles at a third of their squares: uniform activations.
    pub discrepancy: Discrepancy,
}

impl MarkerDesign<'_> {
    /// The `count` markers, or as many as there are, each the one that brings the mean posterior variance of the
    /// activations down most after those before it (greedy A-optimality), with normal distributions and no limits.
    pub fn choose(&self, count: usize) -> Vec<ChosenMarker> {
        let noise = self.noise();
        let mut chosen: Vec<ChosenMarker> = Vec::new();
        while chosen.len() < count.min(self.points.len()) {
            let before: Vec<usize> = chosen.iter().map(|c| c.candidate).collect();
            let mut best: Option<(f64, ChosenMarker)> = None;
            for candidate in (0..self.points.len()).filter(|k| !before.contains(k)) {
                let with: Vec<usize> = before.iter().copied().chain([candidate]).collect();
                let Some(variance) = self.variance(&noise, &with) else { continue };
                let mean = variance.mean();
                if best.as_ref().is_none_or(|(least, _)| mean < *least) {
                    best = Some((mean, ChosenMarker { candidate, sd: variance.map(f64::sqrt) }));
                }
            }
            let Some((_, next)) = best else { break };
            chosen.push(next);
        }
        chosen
    }

    /// Posterior standard deviation of each activation (m) with all candidates.
    pub fn all(&self) -> Option<DVector<f64>> {
        let everyone: Vec<usize> = (0..self.points.len()).collect();
        Some(self.variance(&self.noise(), &everyone)?.map(f64::sqrt))
    }

    fn noise(&self) -> DMatrix<f64> {
        let squares = DVector::from_element(self.map.ncols(), 1. / 3.);
        let d = self.map.nrows();
        self.discrepancy.covariance(self.points, self.map, &squares)
            + DMatrix::identity(d, d) * self.sigma_mm.powi(2)
    }

    /// Posterior variance of each activation with the markers `chosen`.
    fn variance(&self, noise: &DMatrix<f64>, chosen: &[usize]) -> Option<DVector<f64>> {
        let rows: Vec<usize> = chosen.iter().flat_map(|k| 3 * k..3 * k + 3).collect();
        let seen = self.map.select_rows(&rows);
        let noise = noise.select_rows(&rows).select_columns(&rows);
        // By the rows, of which there are fewer than muscles at first.
        let gain = Cholesky::new(&seen * seen.transpose() * UNKNOWN + noise)?.solve(&seen) * UNKNOWN;
        let known = seen.tr_mul(&gain).diagonal() * UNKNOWN;
        Some(known.map(|known| (UNKNOWN - known).max(0.)))
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Three muscles, each seen by one marker only, at 4, 1 and 0.1 mm; a fourth marker sees nothing.
    #[test]
    fn the_marker_that_moves_most_comes_first() {
        let mut map = DMatrix::zeros(12, 3);
        (map[(0, 0)], map[(3, 2)], map[(10, 1)]) = (0.1, 4., 1.);
        let points: Vec<Vec3> = (0..4).map(|k| Vec3::new(100. * f64::from(k), 0., 0.)).collect();
        let design =
            MarkerDesign { points: &points, map: &map, sigma_mm: 0.5, discrepancy: Discrepancy::NONE };
        let chosen = design.choose(9);
        assert_eq!(chosen.iter().map(|c| c.candidate).collect::<Vec<_>>(), [1, 3, 0, 2]);
        // 1 / (12 + (4 / 0.5)^2).
        assert!((chosen[0].sd[2] - (1f64 / 76.).sqrt()).abs() < 1e-12);
        assert!((chosen[0].sd[0] - UNKNOWN.sqrt()).abs() < 1e-12);
        assert!((design.all().unwrap_or_default() - &chosen[3].sd).amax() < 1e-12);
    }
}
