//! Why the face finds no rest.

use thiserror::Error;

use crate::contact::BarrierError;
use crate::forward::ForwardError;

/// Why a finite-strain face cannot be built or does not come to rest.
#[derive(Clone, Debug, PartialEq, Error)]
#[non_exhaustive]
pub enum FiniteError {
    /// The face cannot be modelled.
    #[error(transparent)]
    Forward(#[from] ForwardError),
    /// Surfaces cross at rest.
    #[error("contact at finite strain needs surfaces that are apart at rest: {0}")]
    Contact(#[from] BarrierError),
    /// The muscle law has no potential.
    #[error(
        "muscle law {law} has no potential, which finite strain needs; \
         set muscle_tissue.law = \"reinforced\", or use linear strain"
    )]
    LawWithoutPotential {
        /// The law's name in files.
        law: &'static str,
    },
    /// The face was not found at rest.
    #[error(
        "the face comes to rest up to {:.0} % of these activations and of the movement of the bones, and no farther; \
         ask for less, or refine the mesh where it is squeezed", 100. * reached
    )]
    NoRest {
        /// Share of the load at which it was last at rest.
        reached: f64,
    },
}
