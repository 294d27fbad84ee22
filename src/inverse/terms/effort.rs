//! Effort.

use nalgebra::DVector;

use crate::inverse::target::EffortNorm;
use crate::inverse::term::{Row, State, Term};

/// What activations cost, which decides between fits. The jaw's opening costs none.
///
/// With [`EffortNorm::L2`], `w/2 sum c_m a_m^2`: the residuals `r_m = sqrt(w c_m) a_m`. With [`EffortNorm::L1`],
/// `w sum c_m a_m`, activations being not negative: slopes `w c_m`, and no residual.
#[derive(Clone, Debug, PartialEq)]
pub struct Effort {
    /// `w`, dimensionless, not negative.
    pub weight: f64,
    /// `c` (m), what a muscle costs relative to the others, not negative.
    pub cost: DVector<f64>,
    /// Which sum.
    pub norm: EffortNorm,
}

impl Effort {
    /// That of `muscles` muscles which cost the same.
    pub fn even(muscles: usize, weight: f64, norm: EffortNorm) -> Self {
        Self { weight, cost: DVector::from_element(muscles, 1.), norm }
    }
}

impl Term for Effort {
    fn rows(&self, state: &State) -> Vec<Row> {
        if self.norm == EffortNorm::L1 {
            return Vec::new();
        }
        let of = |(muscle, (a, cost)): (usize, (&f64, &f64))| {
            let root = (self.weight * cost).sqrt();
            Row { value: root * a, observed: Vec::new(), activation: vec![(muscle, root)] }
        };
        state.activation.iter().zip(self.cost.iter()).enumerate().map(of).collect()
    }

    fn slopes(&self) -> Vec<(usize, f64)> {
        match self.norm {
            EffortNorm::L1 => self.cost.iter().map(|cost| self.weight * cost).enumerate().collect(),
            EffortNorm::L2 => Vec::new(),
        }
    }
}
