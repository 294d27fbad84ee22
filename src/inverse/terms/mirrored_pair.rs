//! Symmetry of two points.

use crate::inverse::term::{Row, State, Term};

/// `r = (u_l - M u_r) / sigma`, `M = diag(-1, 1, 1)` the mirror in the mid-sagittal plane.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct MirroredPoints {
    /// Observed point on the subject's left, from 0.
    pub left: usize,
    /// Observed point on the subject's right, from 0.
    pub right: usize,
    /// Standard deviation of the difference, mm.
    pub sigma_mm: f64,
}

impl Term for MirroredPoints {
    fn rows(&self, state: &State) -> Vec<Row> {
        let weight = 1.0 / self.sigma_mm;
        [-1.0, 1.0, 1.0]
            .into_iter()
            .enumerate()
            .map(|(axis, mirror)| {
                let (left, right) = (3 * self.left + axis, 3 * self.right + axis);
                Row {
                    value: (state.observed[left] - mirror * state.observed[right]) * weight,
                    observed: vec![(left, weight), (right, -mirror * weight)],
                    activation: Vec::new(),
                }
            })
            .collect()
    }
}
