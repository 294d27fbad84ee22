//! A marker's displacement.

use crate::inverse::term::{Row, State, Term};

/// `r_i = (u_i - d_i) / sigma` over the observed components `i` of one point.
#[derive(Clone, Debug, PartialEq)]
pub struct MarkerDisplacement {
    /// Observed point, from 0.
    pub point: usize,
    /// Displacement asked for, mm; `None` is unobserved.
    pub target_mm: [Option<f64>; 3],
    /// Standard deviation, mm.
    pub sigma_mm: f64,
}

impl Term for MarkerDisplacement {
    fn rows(&self, state: &State) -> Vec<Row> {
        let weight = 1.0 / self.sigma_mm;
        (0..3)
            .filter_map(|axis| self.target_mm[axis].map(|target| (3 * self.point + axis, target)))
            .map(|(row, target)| Row {
                value: (state.observed[row] - target) * weight,
                observed: vec![(row, weight)],
                activation: Vec::new(),
            })
            .collect()
    }
}
