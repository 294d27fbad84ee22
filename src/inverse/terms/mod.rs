//! The terms of the objective.

mod damping;
mod effort;
mod feature;
mod marker_displacement;
mod marker_position;
mod mirrored_pair;

pub(super) use damping::Damping;
pub use effort::Effort;
pub use feature::{Component, Distance};
pub use marker_displacement::MarkerDisplacement;
pub use marker_position::MarkerPosition;
pub use mirrored_pair::MirroredPoints;
