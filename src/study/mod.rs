//! What a user does, once for every front end: a face is moved by its muscles and its bones.

mod at_once;
mod calibrate;
mod comparison;
mod error;
mod fit;
mod held_stiffness;
mod key_states;
mod mechanics;
mod mirror;
mod moved;
mod mover;
mod muscle_length;
mod rest_states;
mod tangent;
mod track;
mod tracked_face;
mod verdict;

pub use at_once::at_once;
pub use calibrate::{CalibratedFace, calibrate};
pub use comparison::{Comparison, MovedLandmark, Pair, Posed, Sides, matched};
pub use error::StudyError;
pub use fit::{Fit, LinearAnswer, fit};
pub use held_stiffness::HeldStiffness;
pub use mechanics::{Mechanics, Stiffness, Strain};
pub use moved::{MovedContact, MovedFace};
pub use mover::Mover;
pub use muscle_length::{MuscleForce, muscle_force, muscle_stretches};
pub use rest_states::RestRound;
pub use tangent::MovedTangent;
pub use track::{Checked, CheckedFrame, FrameIntervals, Track, TrackError, recorded_markers};
pub use tracked_face::{TrackedFace, TrackedMoment};
pub use verdict::{Verdict, residual_rms_mm};
