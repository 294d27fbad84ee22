//! Effort.

use crate::inverse::term::{Row, State, Term};

/// `r_m = sqrt(w) a_m`: the effort `w/2 sum a^2`, which decides between equally good fits.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Effort {
    /// Number `m` of muscles: the jaw's opening costs none.
    pub muscles: usize,
    /// `w`, dimensionless, not negative.
    pub weight: f64,
}

impl Term for Effort {
    fn rows(&self, state: &State) -> Vec<Row> {
        let root = self.weight.sqrt();
        state
            .activation
            .iter()
            .take(self.muscles)
            .enumerate()
            .map(|(muscle, a)| Row {
                value: root * a,
                observed: Vec::new(),
                activation: vec![(muscle, root)],
            })
            .collect()
    }
}
