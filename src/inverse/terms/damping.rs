//! The pull towards the last iterate.

use nalgebra::DVector;

use crate::inverse::term::{Row, State, Term};

/// `r_m = sqrt(w) (a_m - centre_m)`: keeps a step where the linearisation holds (Levenberg 1944).
#[derive(Clone, Debug, PartialEq)]
pub(in crate::inverse) struct Damping {
    /// `w`, dimensionless, not negative.
    pub(in crate::inverse) weight: f64,
    /// The last iterate (m).
    pub(in crate::inverse) centre: DVector<f64>,
}

impl Term for Damping {
    fn rows(&self, state: &State) -> Vec<Row> {
        if self.weight == 0.0 {
            return Vec::new();
        }
        let root = self.weight.sqrt();
        (0..self.centre.len())
            .map(|muscle| Row {
                value: root * (state.activation[muscle] - self.centre[muscle]),
                observed: Vec::new(),
                activation: vec![(muscle, root)],
            })
            .collect()
    }
}
