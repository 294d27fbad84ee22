//! Recordings: measured markers over time, and the activations behind them.
//!
//! [`Recording`] and [`MarkerMap`] -> [`Subject`] (each marker a point of the face) -> [`Movement`] (the head held still) ->
//! [`Tracker`] (activations and jaw of every frame).

mod error;
mod head;
mod marker_map;
mod mechanism;
mod mechanisms;
mod movement;
#[expect(clippy::module_inception, reason = "one noun a file")]
mod recording;
mod region;
mod subject;
mod track;
mod tracker;

pub use error::{OffSkinMarker, SubjectError};
pub use head::HeadMotion;
pub use marker_map::{Dynamics, JawFreedom, MappedMarker, MarkerMap, MarkerPlace, Neutral, OffSkin};
pub use mechanism::{JAW_UNKNOWNS, Mechanism};
pub use mechanisms::Mechanisms;
pub use movement::{LabelSwap, Movement};
pub use recording::{FrameChoice, Recording, RecordingError};
pub use subject::{BoundMarker, OFF_SKIN_MM, Subject, SubjectWarning};
pub use track::{Met, Outlier, TrackSummary};
pub use tracker::{FrameStatus, Touched, TrackedFrame, Tracker};
