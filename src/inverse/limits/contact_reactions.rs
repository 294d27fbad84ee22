//! Contact with reactions: teeth and lips push back.

use std::sync::Arc;

use nalgebra::DVector;

use crate::forward::ContactResponse;
use crate::inverse::limit::{Constraint, Constraints, Limit, LimitName};

/// `g = g0 + V a + S lambda` over the unknowns `(a, lambda_forces)`: `g = 0` where touching, `g >= 0`
/// where open, `lambda >= 0`, and no force but on `forces`.
///
/// With `forces = touching` and the others open this is one piece of the problem with
/// complementarity; with every contact open and forced it is the relaxation without it.
#[derive(Clone, Debug)]
pub struct ContactReactions {
    /// The contacts.
    pub contact: Arc<ContactResponse>,
    /// Contacts whose forces are the unknowns after the `m` activations, in this order.
    pub forces: Vec<usize>,
    /// Contacts with `g = 0`.
    pub touching: Vec<usize>,
    /// Contacts with `g >= 0`.
    pub open: Vec<usize>,
}

impl ContactReactions {
    /// The piece on which the contacts `touching` touch with forces and all others are open.
    pub fn piece(contact: &Arc<ContactResponse>, touching: &[usize]) -> Self {
        Self {
            contact: Arc::clone(contact),
            forces: touching.to_vec(),
            touching: touching.to_vec(),
            open: (0..contact.gap.len()).filter(|i| !touching.contains(i)).collect(),
        }
    }

    fn gap(&self, i: usize, n: usize) -> DVector<f64> {
        let m = self.contact.approach.ncols();
        let mut row = DVector::zeros(n);
        row.rows_mut(0, m).copy_from(&self.contact.approach.row(i).transpose());
        for (k, &j) in self.forces.iter().enumerate() {
            row[m + k] = self.contact.compliance[(i, j)];
        }
        row
    }
}

impl Limit for ContactReactions {
    fn restrict(&self, constraints: &mut Constraints) {
        let (m, n) = (self.contact.approach.ncols(), constraints.n_unknowns());
        constraints.lower.rows_mut(m, self.forces.len()).fill(0.0);
        for &i in &self.touching {
            let (coefficients, value) = (self.gap(i, n), -self.contact.gap[i]);
            constraints.equality.push(Constraint { coefficients, value, name: LimitName::Touching(i) });
        }
        for &i in &self.open {
            let (coefficients, value) = (-self.gap(i, n), self.contact.gap[i]);
            constraints.inequality.push(Constraint { coefficients, value, name: LimitName::Gap(i) });
        }
    }
}
