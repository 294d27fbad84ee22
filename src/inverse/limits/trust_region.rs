//! How far a linearisation is believed.

use nalgebra::DVector;

use crate::inverse::limit::{Constraints, Limit};

/// `|x_k - centre_k| <= radius` for every activation, and for the share of the jaw's opening.
#[derive(Clone, Debug, PartialEq)]
pub struct TrustRegion {
    /// Unknowns about which the model was linearised (n).
    pub centre: DVector<f64>,
    /// Half width of the box, in units of activation.
    pub radius: f64,
}

impl Limit for TrustRegion {
    fn restrict(&self, constraints: &mut Constraints) {
        for (k, centre) in self.centre.iter().enumerate() {
            constraints.lower[k] = constraints.lower[k].max(centre - self.radius);
            constraints.upper[k] = constraints.upper[k].min(centre + self.radius);
        }
    }
}
