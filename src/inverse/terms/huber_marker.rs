//! A marker that may be an outlier.

use super::MarkerDisplacement;
use crate::inverse::term::{Row, State, Term};

/// The residual `v` of a marker, in standard deviations, as a residual `g` with `1/2 |g|^2 = rho(|v|)`, Huber's loss:
/// `s^2 / 2` up to `k`, `k s - k^2 / 2` beyond. All components of a marker count as one.
///
/// Source: Huber, Robust estimation of a location parameter, Ann Math Stat 35:73 (1964).
#[derive(Clone, Debug, PartialEq)]
pub struct HuberMarker {
    /// The marker.
    pub marker: MarkerDisplacement,
    /// `k`, standard deviations.
    pub sigmas: f64,
}

impl Term for HuberMarker {
    fn rows(&self, state: &State) -> Vec<Row> {
        let rows = self.marker.rows(state);
        let size = rows.iter().map(|row| row.value * row.value).sum::<f64>().sqrt();
        if size <= self.sigmas {
            return rows;
        }
        // g = v phi(s) / s with phi = sqrt(2 rho), phi' = k / phi.
        let length = (self.sigmas * (2. * size - self.sigmas)).sqrt();
        let scale = length / size;
        let turn = (self.sigmas / length - scale) / (size * size);
        let of = |i: usize| Row {
            value: rows[i].value * scale,
            observed: rows
                .iter()
                .enumerate()
                .flat_map(|(j, row)| {
                    let by = turn * rows[i].value * row.value + if i == j { scale } else { 0. };
                    row.observed.iter().map(move |&(k, weight)| (k, by * weight))
                })
                .collect(),
            activation: Vec::new(),
        };
        (0..rows.len()).map(of).collect()
    }

    fn is_linear(&self) -> bool {
        false
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use nalgebra::DVector;

    #[test]
    fn the_loss_and_its_derivative_are_huber_s() {
        let marker = MarkerDisplacement { point: 0, target_mm: [Some(0.), None, Some(0.)], sigma_mm: 0.5 };
        let term = HuberMarker { marker, sigmas: 2. };
        let at = |x: f64, z: f64| State {
            observed: DVector::from_vec(vec![x, 9., z]),
            activation: DVector::zeros(0),
        };
        let loss = |x: f64, z: f64| term.rows(&at(x, z)).iter().map(|r| 0.5 * r.value * r.value).sum::<f64>();
        assert!((loss(0.3, 0.4) - 0.5).abs() < 1e-12, "squares within");
        // |v| = 10 standard deviations: 2 x 10 - 2.
        assert!((loss(3., 4.) - 18.).abs() < 1e-12, "a line beyond");
        let h = 1e-6;
        for (k, step) in [(0, [h, 0.]), (2, [0., h])] {
            let rows = term.rows(&at(3., 4.));
            let ahead = term.rows(&at(3. + step[0], 4. + step[1]));
            let behind = term.rows(&at(3. - step[0], 4. - step[1]));
            for i in 0..2 {
                let slope = (ahead[i].value - behind[i].value) / (2. * h);
                let by: f64 = rows[i].observed.iter().filter(|(row, _)| *row == k).map(|(_, w)| w).sum();
                assert!((slope - by).abs() < 1e-7, "{i} {k}: {slope} {by}");
            }
        }
    }
}
