//! The face at rest under activations.

use super::Potential;
use super::contact::TouchedContact;
use super::hessian::Hessian;
use super::newton::{Minimum, Place, SettlingCost};
use crate::face::{Face, Pose};
use crate::forward::Cholesky;
use crate::units::Vec3;

/// The face at a stable rest, a minimum of the potential, under activations and with its bones at a pose.
#[derive(Clone, Debug)]
pub struct FiniteState {
    activation: Vec<f64>,
    pose: Pose,
    displacement: Vec<f64>,
    minimum: Minimum,
    load_steps: usize,
    contact: Option<TouchedContact>,
}

impl FiniteState {
    pub(super) fn new(
        (face, potential): (&Face, &Potential),
        minimum: Minimum,
        a: &[f64],
        pose: &Pose,
        load_steps: usize,
    ) -> Self {
        let contact = potential.contact().map(|contact| contact.touched(&minimum.place));
        let moved = minimum.positions().iter().zip(&face.mesh.points);
        let displacement = moved.flat_map(|(x, p)| <[f64; 3]>::from(x - p)).collect();
        Self { activation: a.to_vec(), pose: pose.clone(), displacement, minimum, load_steps, contact }
    }

    /// The activations (m).
    pub fn activation(&self) -> &[f64] {
        &self.activation
    }

    /// Where the bones are.
    pub fn pose(&self) -> &Pose {
        &self.pose
    }

    /// Displacement (3n, node-major xyz), mm.
    pub fn displacement(&self) -> &[f64] {
        &self.displacement
    }

    /// Nodes (n), mm.
    pub fn positions(&self) -> &[Vec3] {
        self.minimum.positions()
    }

    /// The factor of the Hessian of the potential: the tangent stiffness.
    pub fn factor(&self) -> &Cholesky {
        self.minimum.factor()
    }

    /// Whether the Hessian of the potential is positive definite there; where it is not, contact holds against a
    /// curvature that would let the tissue slip, and the tangent is that of the nearest stable one.
    pub fn is_stable(&self) -> bool {
        self.minimum.is_stable()
    }

    /// What it took to find it.
    pub fn cost(&self) -> SettlingCost {
        self.minimum.cost()
    }

    /// Steps of the load that led to it from where it started.
    pub fn load_steps(&self) -> usize {
        self.load_steps
    }

    /// What touches; `None` when contact is off.
    pub fn contact(&self) -> Option<&TouchedContact> {
        self.contact.as_ref()
    }

    pub(super) fn place(&self) -> &Place {
        &self.minimum.place
    }

    pub(super) fn hessian(&self) -> &Hessian {
        &self.minimum.hessian
    }
}
