//! How a face that was moved goes on from there.

use nalgebra::DVector;
use rayon::prelude::*;

use super::MovedFace;
use crate::contact::Pair;
use crate::forward::{FixedStiffness, Touching};

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

/// Holds the gaps of the `touching` pairs in each of the `fields`: `T_m - K^-1 G' S^-1 G T_m`, with `S = G K^-1 G'`.
pub(super) fn hold(fixed: &FixedStiffness<'_>, touching: &[Pair], fields: &mut [Vec<f64>]) {
    let Some(contact) = fixed.response_with(&[], touching).contact else { return };
    let held = Touching::new(&contact.compliance, 0..touching.len());
    let push = |field: &Vec<f64>| {
        let gap = DVector::from_iterator(touching.len(), touching.iter().map(|pair| pair.change_mm(field)));
        let mut force = vec![0.; field.len()];
        for (pair, lambda) in touching.iter().zip(&held.forces(&gap)) {
            for (node, g) in &pair.row {
                (0..3).for_each(|axis| force[3 * node + axis] += lambda * g[axis]);
            }
        }
        force
    };
    let pushes: Vec<Vec<f64>> = fields.par_iter().map(push).collect();
    for (field, back) in fields.iter_mut().zip(fixed.cholesky().displacements(&pushes)) {
        field.iter_mut().zip(back).for_each(|(t, b)| *t += b);
    }
}
