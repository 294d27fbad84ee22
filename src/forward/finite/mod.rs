//! The face at finite strain: it rests at a minimum of one potential, affine in the activations,
//!
//! `Pi(u; a) = Pi_0(u) + sum_m a_m Pi_m(u) + contact`, hence `du/da_m = -H^-1 grad Pi_m` with `H = hess_u Pi`.
//!
//! `Pi_0` is the passive tissue, `Pi_m` the stiffening and the tension of muscle `m`. Its quadratic expansion at rest
//! is the linear model of [`Model`](super::Model).

mod body;
mod conjugate_gradients;
mod contact;
mod corner;
mod error;
mod hessian;
mod material;
mod model;
mod newton;
mod patch;
mod potential;
mod response;
mod state;

pub use body::FiniteBody;
pub use contact::{FaceContact, TouchedContact};
pub use error::FiniteError;
pub use material::{PointFibre, PointMaterial};
pub use model::FiniteModel;
use newton::Place;
pub use newton::{Minimum, SettlingCost};
pub use patch::{Patch, PatchDerivatives, PatchForces, PatchPoint};
pub use potential::Potential;
pub use response::Tangent;
pub use state::FiniteState;
