//! Effort.

use nalgebra::DVector;

use crate::inverse::term::{Row, State, Term};

/// `r_m = sqrt(w c_m) a_m`: the effort `w/2 sum c_m a_m^2`, which decides between equally good fits. The jaw's opening costs
/// none.
#[derive(Clone, Debug, PartialEq)]
pub struct Effort {
    /// `w`, dimensionless, not negative.
    pub weight: f64,
    /// `c` (m), what a muscle costs relative to the others, not negative.
    pub cost: DVector<f64>,
}

impl Effort {
    /// That of `muscles` muscles which cost the same.
    pub fn even(muscles: usize, weight: f64) -> Self {
        Self { weight, cost: DVector::from_element(muscles, 1.) }
    }
}

impl Term for Effort {
    fn rows(&self, state: &State) -> Vec<Row> {
        let of = |(muscle, (a, cost)): (usize, (&f64, &f64))| {
            let root = (self.weight * cost).sqrt();
            Row { value: root * a, observed: Vec::new(), activation: vec![(muscle, root)] }
        };
        state.activation.iter().zip(self.cost.iter()).enumerate().map(of).collect()
    }
}
