//! Why a face cannot be calibrated.

use thiserror::Error;

use crate::forward::{ContactError, ForwardError};
use crate::inverse::TargetError;

/// Why a face cannot be calibrated.
#[derive(Clone, Debug, PartialEq, Error)]
#[non_exhaustive]
pub enum CalibrationError {
    /// Nothing was given.
    #[error("no expression is given; give one target at least whose activations are known")]
    NoExpression,
    /// A target whose activations are not known, or are all zero.
    #[error(
        "{expression}: no muscle is known to be active; state what was measured, by electromyography or stimulation, as [[prior]] with `muscle`, `activation` and `sigma`"
    )]
    NoActivation {
        /// Name of the target.
        expression: String,
    },
    /// A target that observes nothing.
    #[error("{expression}: nothing is observed; give it [[marker]] entries, or [[feature]] lengths")]
    NoObservation {
        /// Name of the target.
        expression: String,
    },
    /// A target with an open jaw.
    #[error("{expression}: the jaw is open; calibrate by expressions with `jaw_opening_mm` left out")]
    OpenJaw {
        /// Name of the target.
        expression: String,
    },
    /// Two targets of one name.
    #[error("{expression} is given twice; keep one, or give each its own `name`")]
    GivenTwice {
        /// Name of the target.
        expression: String,
    },
    /// A target that does not fit the face.
    #[error("{expression}: {error}")]
    Target {
        /// Name of the target.
        expression: String,
        /// What is wrong.
        error: Box<TargetError>,
    },
    /// A prior of something else.
    #[error("nothing that is calibrated is called {name}; the face has: {known}")]
    UnknownParameter {
        /// The name.
        name: String,
        /// The valid names.
        known: String,
    },
    /// A prior that is no distribution.
    #[error("{name}: a median must be from {} to {} times the face's value, and the spread of its logarithm from 0 to {}", .range[0], .range[1], .widest)]
    Prior {
        /// The parameter.
        name: String,
        /// Medians that are accepted.
        range: [f64; 2],
        /// Greatest spread that is accepted.
        widest: f64,
    },
    /// Everything is held.
    #[error("every parameter is held by a spread of 0; leave one free")]
    NothingFree,
    /// The face cannot be solved.
    #[error(transparent)]
    Forward(#[from] ForwardError),
    /// No forces keep the surfaces apart.
    #[error(
        "{expression}: {error}; leave it out, or calibrate without contact by movements that press little"
    )]
    Contact {
        /// Name of the target.
        expression: String,
        /// What is wrong.
        error: ContactError,
    },
    /// The search stopped.
    #[error("the search stopped: {0}")]
    Search(String),
}
