//! What a user does, once for every front end: a face is moved by its muscles and its bones.

mod error;
mod fit;
mod mechanics;
mod moved;
mod mover;

pub use error::StudyError;
pub use fit::{Fit, LinearAnswer, fit};
pub use mechanics::{Mechanics, Stiffness, Strain};
pub use moved::{MovedContact, MovedFace};
pub use mover::Mover;
