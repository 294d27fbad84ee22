//! Muscles that act together.

use nalgebra::DVector;

use crate::inverse::limit::{Constraint, Constraints, Limit, LimitName};

/// `a_i - a_j = 0` for every pair.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct TiedPairs {
    /// Muscles `[i, j]`, from 0.
    pub pairs: Vec<[usize; 2]>,
}

impl Limit for TiedPairs {
    fn restrict(&self, constraints: &mut Constraints) {
        for &[i, j] in &self.pairs {
            let mut coefficients = DVector::zeros(constraints.n_unknowns());
            coefficients[i] = 1.0;
            coefficients[j] = -1.0;
            constraints.equality.push(Constraint { coefficients, value: 0.0, name: LimitName::Tied(i, j) });
        }
    }
}
