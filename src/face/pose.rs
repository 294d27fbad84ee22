//! Where the bones are.

use std::collections::BTreeMap;
use std::fmt;

use super::{Face, Jaw, RigidMotion, Teeth};
use crate::contact::Pair;
use crate::units::Vec3;

/// Rotation beyond which linear elasticity is out of its range, degrees: 10 degrees already fake a strain of
/// `1 - cos` = 1.5 %.
const LARGEST_TURN_DEG: f64 = 10.;

/// The bones that are moved, each by a rigid motion; the others rest.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Pose {
    motions: BTreeMap<String, RigidMotion>,
}

/// A bone that turns farther than the linear model describes.
#[derive(Clone, Debug, PartialEq)]
pub struct LargeTurn {
    /// The bone.
    pub bone: String,
    /// Its rotation, degrees.
    pub angle_deg: f64,
}

impl fmt::Display for LargeTurn {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(
            f,
            "{} turns by {:.1} degrees, more than the {LARGEST_TURN_DEG} up to which linear elasticity holds; \
             move it less, or read directions and proportions rather than millimetres",
            self.bone, self.angle_deg
        )
    }
}

impl Pose {
    /// Every bone at rest.
    pub fn rest() -> Self {
        Self::default()
    }

    /// The jaw opened by `opening_mm`, mm at the lower incisal point.
    pub fn opened(jaw: &Jaw, opening_mm: f64) -> Self {
        Self::rest().with(&jaw.bone, jaw.motion(opening_mm))
    }

    /// This pose with `bone` moved by `motion` from rest, in place of what it did before.
    pub fn with(mut self, bone: &str, motion: RigidMotion) -> Self {
        if motion.is_rest() {
            self.motions.remove(bone);
        } else {
            self.motions.insert(bone.to_owned(), motion);
        }
        self
    }

    /// The pose the `share` of the way to `other`, each bone on its own way.
    pub fn towards(&self, other: &Self, share: f64) -> Self {
        let bones = self.motions.keys().chain(other.motions.keys());
        let of = |pose: &Self, bone: &str| pose.motions.get(bone).copied().unwrap_or_default();
        bones
            .fold(Self::rest(), |pose, bone| pose.with(bone, of(self, bone).towards(&of(other, bone), share)))
    }

    /// Whether every bone rests.
    pub fn is_rest(&self) -> bool {
        self.motions.is_empty()
    }

    /// Bones that turn too far for the linear model.
    pub fn large_turns(&self) -> Vec<LargeTurn> {
        let turns =
            self.motions.iter().map(|(bone, m)| LargeTurn { bone: bone.clone(), angle_deg: m.angle_deg() });
        turns.filter(|turn| turn.angle_deg > LARGEST_TURN_DEG).collect()
    }

    /// The motion of `bone` on `face`: its own, or that of the bone whose piece it is.
    pub fn motion(&self, face: &Face, bone: &str) -> RigidMotion {
        let own = self.motions.get(bone);
        let whole = || self.motions.get(face.whole_of(bone)?);
        own.or_else(whole).copied().unwrap_or_default()
    }
}

impl Face {
    /// The bone of which `bone` is a piece, if it is one.
    pub fn whole_of(&self, bone: &str) -> Option<&str> {
        self.supports.iter().find(|s| s.bone == bone)?.part_of.as_deref()
    }

    /// The bones that hold the tissue, pieces and the bones that they are pieces of, each once.
    pub fn bones(&self) -> Vec<String> {
        let mut bones: Vec<String> = Vec::new();
        for name in self.supports.iter().flat_map(|s| [Some(&s.bone), s.part_of.as_ref()]).flatten() {
            if !bones.contains(name) {
                bones.push(name.clone());
            }
        }
        bones
    }

    /// Whether a support is fixed to `bone`, or to a piece of it.
    pub fn has_bone(&self, bone: &str) -> bool {
        self.supports.iter().any(|s| s.bone == bone || s.part_of.as_deref() == Some(bone))
    }

    /// Displacement (3n, node-major xyz, mm) of the nodes that are fixed to bones; zero elsewhere.
    pub fn bone_displacement(&self, pose: &Pose) -> Vec<f64> {
        self.bone_field(|bone, p| pose.motion(self, bone).displacement(p))
    }

    /// Displacement (3n, node-major xyz) of the nodes that are fixed to bones per millimetre of jaw opening,
    /// at the opening `opening_mm`; zero on other bones, and without a jaw.
    pub fn bone_slope(&self, opening_mm: f64) -> Vec<f64> {
        self.bone_field(|bone, p| self.jaw_slope(bone, opening_mm, p))
    }

    /// How the point of `bone` that rests at `p` moves per millimetre of jaw opening.
    pub fn jaw_slope(&self, bone: &str, opening_mm: f64, p: Vec3) -> Vec3 {
        match &self.jaw {
            Some(jaw) if self.is_of_jaw(bone) => jaw.slope(opening_mm, p),
            _ => Vec3::zeros(),
        }
    }

    /// Whether `bone` is the jaw, or a piece of it.
    pub fn is_of_jaw(&self, bone: &str) -> bool {
        self.jaw.as_ref().is_some_and(|jaw| jaw.bone == bone || self.whole_of(bone) == Some(&jaw.bone))
    }

    /// The field (3n, node-major xyz) that is `of(bone, p)` at each node that is fixed to a bone and rests at `p`; zero elsewhere.
    pub fn bone_field(&self, of: impl Fn(&str, Vec3) -> Vec3) -> Vec<f64> {
        let mut u = vec![0.; 3 * self.mesh.n_nodes()];
        for support in &self.supports {
            for &node in &support.nodes {
                u[3 * node..3 * node + 3]
                    .copy_from_slice(of(&support.bone, self.mesh.points[node]).as_slice());
            }
        }
        u
    }

    /// Change of the gap of each of `pairs` (c), mm, by the movement of its tooth.
    pub fn tooth_changes(&self, pairs: &[Pair], pose: &Pose) -> Vec<f64> {
        self.on_teeth(pairs, |bone, p| pose.motion(self, bone).displacement(p))
    }

    /// Change of the gap of each of `pairs` (c) by the movement of its tooth, per millimetre of jaw opening.
    pub fn tooth_slopes(&self, pairs: &[Pair], opening_mm: f64) -> Vec<f64> {
        self.on_teeth(pairs, |bone, p| self.jaw_slope(bone, opening_mm, p))
    }

    fn on_teeth(&self, pairs: &[Pair], of: impl Fn(&str, Vec3) -> Vec3) -> Vec<f64> {
        let change = |pair: &Pair| {
            let tooth = pair.tooth?;
            Some(pair.tooth_change_mm(of(&self.teeth.get(tooth.surface)?.bone, tooth.at)))
        };
        pairs.iter().map(|pair| change(pair).unwrap_or(0.)).collect()
    }

    /// The teeth where `pose` brings them.
    pub fn teeth_at(&self, pose: &Pose) -> Vec<Teeth> {
        let moved = |teeth: &Teeth| {
            let motion = pose.motion(self, &teeth.bone);
            let mut teeth = teeth.clone();
            if !motion.is_rest() {
                teeth.surface.points.iter_mut().for_each(|p| *p = motion.apply(*p));
            }
            teeth
        };
        self.teeth.iter().map(moved).collect()
    }
}
