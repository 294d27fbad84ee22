//! A patient's face: the standard face matched to a scan.
//!
//! 1. [`Similarity`]: landmarks tell where the face is and how large; what is wrong with them shows here.
//! 2. The standard face's proportions are fitted to landmarks and skin.
//! 3. The tissue is pulled to the scan by springs that stiffen while correspondences are found anew; its potential at finite
//!    strain is the regulariser, which keeps every cell upright.
//! 4. Muscles, landmarks and the jaw come along; teeth and bones that are given take the place of the standard's.
//! 5. [`RegistrationQuality`]: how far it can be trusted.

mod bones;
mod correspondence;
mod dentition;
mod depth;
mod error;
mod placement;
mod proportions;
mod quality;
mod register;
mod scan;
mod sheet;
mod similarity;
mod tissue;

pub use error::{RegistrationError, RegistrationWarning};
pub use placement::GivenLandmark;
pub use quality::{
    Distances, LandmarkDepth, LandmarkError, LandmarkUse, MuscleLength, PairAsymmetry, RegistrationQuality,
};
pub use register::{Registration, Subject, Template, register};
pub use similarity::Similarity;
