//! How far a linearisation is believed.

use nalgebra::DVector;

use crate::inverse::limit::{Constraints, Limit};

/// `|a_m - centre_m| <= radius` for every muscle.
#[derive(Clone, Debug, PartialEq)]
pub struct TrustRegion {
    /// Activations about which the model was linearised (m).
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
