//! How a face that was moved goes on from there.

use rayon::prelude::*;

use super::MovedFace;
use crate::forward::FixedStiffness;

/// A face that was moved, and the displacement field that each muscle adds from there.
#[derive(Clone, Debug)]
pub struct MovedTangent {
    /// Where the face is.
    pub moved: MovedFace,
    /// `du/da_m` (m x 3n, node-major xyz), mm per unit activation: to first order the muscle's activation changed by
    /// `d` adds `d du/da_m`. What touches stays in touch and nothing else begins to.
    pub fields: Vec<Vec<f64>>,
}

/// The fields of [`MovedTangent`] at the stiffness `fixed`, without contact.
///
/// `T_m = K^-1 (f_m - dK/da_m u)`, the second part where the stiffness follows the activations `follows` (m).
pub(super) fn free_fields(fixed: &FixedStiffness<'_>, follows: Option<&[f64]>, u: &[f64]) -> Vec<Vec<f64>> {
    let mut fields = fixed.map();
    if let Some(a) = follows {
        let model = fixed.model();
        let stretched: Vec<Vec<f64>> =
            (0..fields.len()).into_par_iter().map(|muscle| model.stiffening(muscle, a[muscle], u)).collect();
        for (field, softened) in fields.iter_mut().zip(fixed.cholesky().displacements(&stretched)) {
            field.iter_mut().zip(softened).for_each(|(t, s)| *t -= s);
        }
    }
    fields
}
