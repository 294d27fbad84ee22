//! A marker's position.

use super::MarkerDisplacement;
use crate::inverse::term::{Row, State, Term};
use crate::units::Vec3;

/// `r_i = (x_i + u_i - p_i) / sigma` over the observed components `i` of one point at rest at `x`.
#[derive(Clone, Debug, PartialEq)]
pub struct MarkerPosition {
    /// Observed point, from 0.
    pub point: usize,
    /// Its rest position, mm.
    pub rest_mm: Vec3,
    /// Position asked for, mm; `None` is unobserved.
    pub target_mm: [Option<f64>; 3],
    /// Standard deviation, mm.
    pub sigma_mm: f64,
}

impl MarkerPosition {
    /// The same wish as a displacement from rest.
    pub fn displacement(&self) -> MarkerDisplacement {
        let mut target_mm = self.target_mm;
        for (target, rest) in target_mm.iter_mut().zip(self.rest_mm.iter()) {
            *target = target.map(|t| t - rest);
        }
        MarkerDisplacement { point: self.point, target_mm, sigma_mm: self.sigma_mm }
    }
}

impl Term for MarkerPosition {
    fn rows(&self, state: &State) -> Vec<Row> {
        self.displacement().rows(state)
    }
}
