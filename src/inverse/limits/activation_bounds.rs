//! Bounds of the activations.

use nalgebra::DVector;

use crate::inverse::limit::{Constraints, Limit};

/// `min <= a <= max` (m each, within 0 and 1); equal bounds fix a muscle.
#[derive(Clone, Debug, PartialEq)]
pub struct ActivationBounds {
    /// Least activations (m).
    pub min: DVector<f64>,
    /// Greatest activations (m).
    pub max: DVector<f64>,
}

impl ActivationBounds {
    /// 0 to 1 for `m` muscles.
    pub fn unit(m: usize) -> Self {
        Self { min: DVector::zeros(m), max: DVector::from_element(m, 1.0) }
    }
}

impl Limit for ActivationBounds {
    fn restrict(&self, constraints: &mut Constraints) {
        let m = self.min.len();
        constraints.lower.rows_mut(0, m).copy_from(&self.min);
        constraints.upper.rows_mut(0, m).copy_from(&self.max);
    }
}
