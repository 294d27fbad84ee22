//! An activation that was observed.

use crate::inverse::term::{Row, State, Term};

/// `r = (a_m - value) / sigma`.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct ActivationPrior {
    /// Muscle, from 0.
    pub muscle: usize,
    /// Activation.
    pub value: f64,
    /// Standard deviation, in units of activation.
    pub sigma: f64,
}

impl Term for ActivationPrior {
    fn rows(&self, state: &State) -> Vec<Row> {
        let weight = 1.0 / self.sigma;
        let value = (state.activation[self.muscle] - self.value) * weight;
        vec![Row { value, observed: Vec::new(), activation: vec![(self.muscle, weight)] }]
    }
}
