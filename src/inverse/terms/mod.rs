//! The terms of the objective.

mod activation_prior;
mod damping;
mod effort;
mod feature;
mod huber_marker;
mod marker_displacement;
mod marker_position;
mod mirrored_pair;

pub use activation_prior::ActivationPrior;
pub(super) use damping::Damping;
pub use effort::Effort;
pub use feature::{Component, Distance};
pub use huber_marker::HuberMarker;
pub use marker_displacement::MarkerDisplacement;
pub use marker_position::MarkerPosition;
pub use mirrored_pair::MirroredPoints;
