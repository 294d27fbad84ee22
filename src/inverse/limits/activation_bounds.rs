//! Bounds of the unknowns.

use nalgebra::DVector;

use crate::inverse::limit::{Constraints, Limit};

/// `min <= x <= max` for the activations and the share of the jaw's opening where that is unknown (n each, within
/// 0 and 1); equal bounds fix a muscle.
#[derive(Clone, Debug, PartialEq)]
pub struct ActivationBounds {
    /// Least values (n).
    pub min: DVector<f64>,
    /// Greatest values (n).
    pub max: DVector<f64>,
}

impl ActivationBounds {
    /// 0 to 1 for `n` unknowns.
    pub fn unit(n: usize) -> Self {
        Self { min: DVector::zeros(n), max: DVector::from_element(n, 1.0) }
    }
}

impl Limit for ActivationBounds {
    fn restrict(&self, constraints: &mut Constraints) {
        let n = self.min.len();
        constraints.lower.rows_mut(0, n).copy_from(&self.min);
        constraints.upper.rows_mut(0, n).copy_from(&self.max);
    }
}
