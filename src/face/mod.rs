//! What a face is: tissue, bones, muscles, teeth and landmarks on one mesh.

mod bundle;
mod carried;
mod check;
mod contact_load;
mod contacts;
mod curve;
mod embed;
mod error;
mod jaw;
mod landmark;
mod mirror_image;
mod muscle;
mod overlap;
mod pose;
mod rigid_motion;
mod sides;
mod similarity;
mod skin_normal;
pub mod standard;
mod support;
mod surgical_plan;
mod symmetry;
mod teeth;
mod tissue;

pub use bundle::{join_ring, spread};
pub use contact_load::ContactLoad;
pub use contacts::{ContactReach, ContactSearch, RestOverlap, TouchedSurfaces};
pub use curve::{polyline_length, smooth_curve};
pub use embed::{Projected, TooFar, embed};
pub use error::{FaceError, FaceWarning};
pub use jaw::{Jaw, JawRange};
pub use landmark::Landmark;
pub use muscle::{Fibre, Muscle};
pub use overlap::{Inside, Overlap, OverlapSearch, overlap};
pub use pose::{LargeTurn, Pose};
pub use rigid_motion::RigidMotion;
pub use sides::without_side;
pub use similarity::Similarity;
pub use skin_normal::SkinNormal;
pub use standard::standard;
pub use support::Support;
pub use surgical_plan::{About, Cut, CutBy, Motion, Move, PlanError, PreparedPlan, SurgicalPlan};
pub use symmetry::{PairSymmetry, Symmetry, opposite_skin};
pub use teeth::Teeth;
pub use tissue::{MuscleLaw, MuscleTissue, Tissue};

use crate::mesh::Mesh;

/// A face at rest. Lengths mm, forces N, moduli kPa; frame +x the subject's left, +y up, +z anterior.
#[derive(Clone, Debug, PartialEq)]
pub struct Face {
    /// What the face is called in reports.
    pub name: String,
    /// Soft tissue between skin and skull.
    pub mesh: Mesh,
    /// Passive tissue.
    pub tissue: Tissue,
    /// Muscle tissue, the same for every muscle.
    pub muscle_tissue: MuscleTissue,
    /// Node sets fixed to bone segments.
    pub supports: Vec<Support>,
    /// The jaw joint, where it is known.
    pub jaw: Option<Jaw>,
    /// Muscles: the unknowns of the inverse, in this order.
    pub muscles: Vec<Muscle>,
    /// Tooth surfaces, closed and outward oriented.
    pub teeth: Vec<Teeth>,
    /// Nodes (0-based, ascending) of the free inner surface that may touch teeth.
    pub mucosa: Vec<usize>,
    /// Nodes (0-based, ascending) of the upper lip that may touch the lower lip.
    pub upper_lip: Vec<usize>,
    /// Nodes (0-based, ascending) of the lower lip that may touch the upper lip.
    pub lower_lip: Vec<usize>,
    /// Nodes (0-based, ascending) of the skin.
    pub skin: Vec<usize>,
    /// Named points.
    pub landmarks: Vec<Landmark>,
}

impl Face {
    /// The landmark called `name`.
    pub fn landmark(&self, name: &str) -> Option<&Landmark> {
        self.landmarks.iter().find(|l| l.name == name)
    }

    /// The same face with muscles `factor` times as strong: 2.5 brings the standard face from 0.1 to 0.25 N/mm² of
    /// cross-section, about the specific tension of human skeletal muscle in vivo, 26.8 N/cm² (Persad et al. 2024,
    /// 10.1152/japplphysiol.00296.2024, a systematic review).
    #[must_use]
    pub fn with_strength(mut self, factor: f64) -> Self {
        self.muscles.iter_mut().for_each(|muscle| muscle.max_force_n *= factor);
        self
    }

    /// Position in [`muscles`](Self::muscles) of the muscle called `name`.
    pub fn muscle_index(&self, name: &str) -> Option<usize> {
        self.muscles.iter().position(|m| m.name == name)
    }
}
