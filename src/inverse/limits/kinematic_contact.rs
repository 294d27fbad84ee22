//! Contact without reactions.

use std::sync::Arc;

use nalgebra::DVector;

use crate::forward::ContactResponse;
use crate::inverse::limit::{Constraint, Constraints, Limit, LimitName};

/// `g0 + V a >= 0`: forbids every activation that would press on a contact.
#[derive(Clone, Debug)]
pub struct KinematicContact {
    /// The contacts.
    pub contact: Arc<ContactResponse>,
}

impl Limit for KinematicContact {
    fn restrict(&self, constraints: &mut Constraints) {
        let m = self.contact.approach.ncols();
        for i in 0..self.contact.gap.len() {
            let mut coefficients = DVector::zeros(constraints.n_unknowns());
            coefficients.rows_mut(0, m).copy_from(&(-self.contact.approach.row(i).transpose()));
            let value = self.contact.gap[i];
            constraints.inequality.push(Constraint { coefficients, value, name: LimitName::Gap(i) });
        }
    }
}
