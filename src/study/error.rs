//! Why a face cannot be moved.

use thiserror::Error;

use crate::forward::finite::FiniteError;
use crate::forward::{ContactError, ForwardError};

/// Why a face cannot be moved.
#[derive(Clone, Debug, PartialEq, Error)]
#[non_exhaustive]
pub enum StudyError {
    /// It cannot be modelled.
    #[error(transparent)]
    Forward(#[from] ForwardError),
    /// No contact forces hold it.
    #[error("contact: {0}; --contact off leaves it out")]
    Contact(#[from] ContactError),
    /// It does not come to rest at finite strain.
    #[error(transparent)]
    Finite(#[from] FiniteError),
    /// At finite strain the stiffness follows the activation by itself.
    #[error("stiffness fixed={share} is of the linear model: use linear strain, or stiffness activated")]
    FixedAtFiniteStrain {
        /// The activation at which the stiffness was to be held.
        share: f64,
    },
}

impl StudyError {
    /// Whether the input is good and the face was not found at rest.
    pub fn is_without_rest(&self) -> bool {
        matches!(self, Self::Contact(_) | Self::Finite(FiniteError::NoRest { .. }))
    }
}
