//! The tangent of a response where the same contacts keep touching.

use modiolus::forward::Response;
use nalgebra::{DMatrix, DVector};

/// Derivative (d x m) of what is observed by the unknowns on the piece of the contact `forces` (c):
/// `du = J da + R dlambda` with `dg = 0` on the touching set.
pub fn jacobian_on_piece(tangent: &Response, forces: &DVector<f64>) -> DMatrix<f64> {
    let Some(contact) = &tangent.contact else { return tangent.map.clone() };
    let touching: Vec<usize> = (0..forces.len()).filter(|&i| forces[i] > 0.).collect();
    let s = contact.compliance.select_rows(&touching).select_columns(&touching);
    let push = -s.cholesky().unwrap().solve(&contact.approach.select_rows(&touching));
    &tangent.map + contact.reach.select_columns(&touching) * push
}

/// What the `tangent` says is observed (d) at the unknowns `x` (m) under the contact `forces` (c).
pub fn observed_at(tangent: &Response, x: &[f64], forces: &DVector<f64>) -> DVector<f64> {
    let free = &tangent.map * DVector::from_column_slice(x) + &tangent.offset;
    tangent.contact.as_ref().map_or(free.clone(), |contact| free + &contact.reach * forces)
}
