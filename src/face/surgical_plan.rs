//! Osteotomies and how their pieces move.

use std::collections::BTreeSet;

use thiserror::Error;

use super::{Face, Pose, RigidMotion, Support};
use crate::mesh::Extent;
use crate::units::Vec3;

/// Least and greatest movement of a bone that is planned, mm: below the error of placing one by a wafer (0.1 mm at
/// best), and beyond any advancement.
const LEAST_MM: f64 = 0.05;
const MOST_MM: f64 = 100.;
/// A point whose coordinates stay below this, mm, is in metres, but for the origin itself.
const IN_METRES: f64 = 0.2;

/// What a surgeon would do to the bones: cuts in order, then one motion a bone or piece.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct SurgicalPlan {
    /// Name, one word.
    pub name: String,
    /// Cuts.
    pub cuts: Vec<Cut>,
    /// Motions, mm.
    pub moves: Vec<Move>,
}

/// An osteotomy: it splits a piece off a bone.
#[derive(Clone, Debug, PartialEq)]
pub struct Cut {
    /// The bone.
    pub bone: String,
    /// Name of the piece.
    pub piece: String,
    /// What belongs to the piece.
    pub by: CutBy,
    /// Arches that go with the piece, `true` for the upper one.
    pub teeth: Vec<bool>,
}

/// Which of a bone's nodes a cut takes.
#[derive(Clone, Debug, PartialEq)]
pub enum CutBy {
    /// Those on the side of a plane to which its normal points.
    Plane {
        /// A point of the plane, mm.
        point: Vec3,
        /// Its normal, of any length but zero.
        normal: Vec3,
        /// Distance from the plane up to which the tissue is stripped off the bone, mm: it follows the bones only
        /// from farther off, and grows on again where it comes to lie.
        stripped_mm: f64,
    },
    /// Those of a node set of the mesh.
    Set(String),
}

/// How a bone or piece moves from where it is; a piece that is not moved itself goes with its bone.
#[derive(Clone, Debug, PartialEq)]
pub struct Move {
    /// The bone or piece.
    pub bone: String,
    /// Its motion.
    pub motion: Motion,
}

/// A motion as it is planned: the rotation first, then the translation.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Motion {
    /// Translation, mm.
    pub translation: Vec3,
    /// Rotation, degrees, right-handed.
    pub rotation_deg: f64,
    /// What the rotation is about.
    pub about: About,
}

/// The axis of a planned rotation.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum About {
    /// The line through the condyles, from right to left.
    Condyles,
    /// A line through the incisal point of the teeth that the bone carries, as orthognathic movements are planned.
    Incisor {
        /// Its direction, of any length but zero.
        direction: Vec3,
    },
    /// Another line.
    Line {
        /// A point of it, mm.
        point: Vec3,
        /// Its direction, of any length but zero.
        direction: Vec3,
    },
}

/// A plan that cannot be carried out on a face; `field` is the path of the field, `cut[0].bone`.
#[derive(Clone, Debug, Error, PartialEq)]
#[non_exhaustive]
pub enum PlanError {
    /// A bone that the face has not.
    #[error("{field}: no bone or piece is called `{bone}`; there are: {}", .known.join(", "))]
    UnknownBone {
        /// Path of the field.
        field: String,
        /// The bone.
        bone: String,
        /// Those there are, pieces of earlier cuts included.
        known: Vec<String>,
    },
    /// A node set that the mesh has not.
    #[error("{field}: the mesh has no node set `{set}`; it has: {}", .known.join(", "))]
    UnknownSet {
        /// Path of the field.
        field: String,
        /// The set.
        set: String,
        /// Those it has.
        known: Vec<String>,
    },
    /// A cut with the whole bone, or nothing of it, on the piece's side.
    #[error(
        "{field}: the cut takes {taken} of the {nodes} nodes of `{bone}`, so that it splits nothing; move it, or turn \
         its normal"
    )]
    CutsNothing {
        /// Path of the field.
        field: String,
        /// The bone.
        bone: String,
        /// Nodes on the piece's side.
        taken: usize,
        /// Nodes of the bone.
        nodes: usize,
    },
    /// A name that is taken.
    #[error("{field}: `{name}` is there already; give another name")]
    Taken {
        /// Path of the field.
        field: String,
        /// The name.
        name: String,
    },
    /// An arch that the bone does not carry.
    #[error("{field}: `{bone}` carries no {arch} teeth; leave them out, or cut the bone that does")]
    NoTeeth {
        /// Path of the field.
        field: String,
        /// The bone.
        bone: String,
        /// `upper` or `lower`.
        arch: &'static str,
    },
    /// A length that cannot be millimetres on a face.
    #[error("{field}: {value_mm} mm {problem}; metres, or another unit? Convert to mm")]
    Scale {
        /// Path of the field.
        field: String,
        /// The length, mm.
        value_mm: f64,
        /// Why it is implausible.
        problem: &'static str,
    },
    /// A point far from the face.
    #[error(
        "{field}: the point lies {gap_mm:.0} mm away from the mesh, which measures {mesh_mm:.0} mm; give it in mm in the \
         face's frame"
    )]
    Elsewhere {
        /// Path of the field.
        field: String,
        /// Distance from the box around the mesh, mm.
        gap_mm: f64,
        /// Its longest side, mm.
        mesh_mm: f64,
    },
    /// An axis or a normal without direction, or a number that is not finite.
    #[error("{field}: {problem}")]
    Value {
        /// Path of the field.
        field: String,
        /// What is wrong, and what to give.
        problem: &'static str,
    },
}

impl PlanError {
    /// Path of the field, `cut[0].bone`, for a file reader that knows its line.
    pub fn field(&self) -> &str {
        match self {
            Self::UnknownBone { field, .. }
            | Self::UnknownSet { field, .. }
            | Self::CutsNothing { field, .. }
            | Self::Taken { field, .. }
            | Self::NoTeeth { field, .. }
            | Self::Scale { field, .. }
            | Self::Elsewhere { field, .. }
            | Self::Value { field, .. } => field,
        }
    }
}

/// A plan held against a face, before anything moves.
#[derive(Clone, Debug)]
pub struct PreparedPlan {
    /// The face with its bones cut, at rest.
    pub face: Face,
    /// The pose into which the plan brings the bones.
    pub pose: Pose,
    /// Nodes stripped off the bone about the cuts, ascending.
    pub stripped: BTreeSet<usize>,
}

impl SurgicalPlan {
    /// The bones of `face` cut, and the pose into which the plan brings them.
    ///
    /// # Errors
    /// [`PlanError`] for bones, sets and arches that are not there, cuts that split nothing and motions without
    /// an axis.
    pub fn prepare(&self, face: &Face) -> Result<PreparedPlan, PlanError> {
        let (mut face, mut stripped) = (face.clone(), BTreeSet::new());
        for (k, cut) in self.cuts.iter().enumerate() {
            stripped.extend(cut.split(&mut face, &format!("cut[{k}]"))?);
        }
        let mut pose = Pose::rest();
        for (k, step) in self.moves.iter().enumerate() {
            let at = format!("move[{k}]");
            if !face.has_bone(&step.bone) {
                return Err(unknown(&face, format!("{at}.bone"), &step.bone));
            }
            if self.moves[..k].iter().any(|other| other.bone == step.bone) {
                return Err(PlanError::Taken { field: format!("{at}.bone"), name: step.bone.clone() });
            }
            pose = pose.with(&step.bone, step.motion.of(&step.bone, &face, &at)?);
        }
        Ok(PreparedPlan { face, pose, stripped })
    }
}

fn unknown(face: &Face, field: String, bone: &str) -> PlanError {
    PlanError::UnknownBone { field, bone: bone.to_owned(), known: face.bones() }
}

/// Refuses a length of a plan, mm, that no surgeon would plan.
fn check_length(value_mm: f64, field: impl Fn() -> String) -> Result<(), PlanError> {
    let problem = match value_mm {
        v if v > 0. && v < LEAST_MM => "is less than a bone can be placed by",
        v if v > MOST_MM => "is more than a bone of the face can be moved",
        _ => return Ok(()),
    };
    Err(PlanError::Scale { field: field(), value_mm, problem })
}

/// Refuses a point of a plan that is not in the millimetres of the face.
fn check_place(face: &Face, point: Vec3, field: impl Fn() -> String) -> Result<(), PlanError> {
    let value_mm = point.amax();
    if value_mm > 0. && value_mm < IN_METRES {
        let problem = "is the largest coordinate of the point";
        return Err(PlanError::Scale { field: field(), value_mm, problem });
    }
    let mesh = face.mesh.extent();
    let (gap_mm, mesh_mm) = (Extent::of(&[point]).gap_mm(&mesh), mesh.longest_mm());
    if gap_mm > mesh_mm {
        return Err(PlanError::Elsewhere { field: field(), gap_mm, mesh_mm });
    }
    Ok(())
}

impl Cut {
    /// Splits the piece off its bone and returns the nodes stripped off it; `at` is the path of the cut.
    fn split(&self, face: &mut Face, at: &str) -> Result<Vec<usize>, PlanError> {
        if face.bones().contains(&self.piece) || self.piece.trim().is_empty() {
            return Err(PlanError::Taken { field: format!("{at}.piece"), name: self.piece.clone() });
        }
        if face.mesh.node_sets.contains_key(&self.piece) {
            // The piece's nodes become a set of its name when the face is written.
            return Err(PlanError::Taken { field: format!("{at}.piece"), name: self.piece.clone() });
        }
        let Some(own) = face.supports.iter().position(|s| s.bone == self.bone) else {
            return Err(unknown(face, format!("{at}.bone"), &self.bone));
        };
        let support = &face.supports[own];
        // Distance of each of the bone's nodes into the piece.
        let (depth, stripped_mm): (Vec<f64>, f64) = match &self.by {
            CutBy::Plane { point, normal, stripped_mm } => {
                let finite = point.iter().chain(normal.iter()).all(|x| x.is_finite());
                let unit = normal.try_normalize(1e-12).filter(|_| finite);
                let (Some(unit), true) = (unit, *stripped_mm >= 0. && stripped_mm.is_finite()) else {
                    let problem = "a plane needs a finite point, a normal that is not zero, and a `stripped_mm` that is \
                                   0 or a length";
                    return Err(PlanError::Value { field: format!("{at}.plane"), problem });
                };
                check_place(face, *point, || format!("{at}.plane.point_mm"))?;
                check_length(*stripped_mm, || format!("{at}.plane.stripped_mm"))?;
                let depth = |&node: &usize| (face.mesh.points[node] - point).dot(&unit);
                (support.nodes.iter().map(depth).collect(), *stripped_mm)
            }
            CutBy::Set(name) => match face.mesh.node_sets.get(name) {
                Some(set) => {
                    let side = |node: &usize| if set.contains(node) { 1. } else { -1. };
                    (support.nodes.iter().map(side).collect(), 0.)
                }
                None => {
                    let known = face.mesh.node_sets.keys().cloned().collect();
                    return Err(PlanError::UnknownSet {
                        field: format!("{at}.set"),
                        set: name.clone(),
                        known,
                    });
                }
            },
        };
        let nodes_where = |keep: &dyn Fn(f64) -> bool| -> Vec<usize> {
            support.nodes.iter().zip(&depth).filter(|(_, d)| keep(**d)).map(|(node, _)| *node).collect()
        };
        let (taken, left) = (nodes_where(&|d| d > 0.), nodes_where(&|d| d <= 0.));
        let stripped = nodes_where(&|d| d.abs() < stripped_mm);
        if taken.is_empty() || left.is_empty() {
            let (bone, nodes) = (self.bone.clone(), support.nodes.len());
            return Err(PlanError::CutsNothing { field: at.to_owned(), bone, taken: taken.len(), nodes });
        }
        for &upper in &self.teeth {
            let mut found = false;
            for teeth in face.teeth.iter_mut().filter(|t| t.upper == upper && t.bone == self.bone) {
                teeth.bone.clone_from(&self.piece);
                found = true;
            }
            if !found {
                let arch = if upper { "upper" } else { "lower" };
                let (field, bone) = (format!("{at}.teeth"), self.bone.clone());
                return Err(PlanError::NoTeeth { field, bone, arch });
            }
        }
        // A piece of a piece belongs to the whole bone.
        let whole = face.supports[own].part_of.clone().unwrap_or_else(|| self.bone.clone());
        face.supports[own].nodes = left;
        face.supports.push(Support { bone: self.piece.clone(), part_of: Some(whole), nodes: taken });
        Ok(stripped)
    }
}

/// Distance from the mid-line of the arch, and behind its foremost point there, within which incisors are, mm.
const INCISORS_MM: [f64; 2] = [5., 6.];

/// The edge of the incisors that `bone` carries, in the middle: their highest point in the lower arch, the lowest in the upper.
fn incisal_point(face: &Face, bone: &str) -> Option<Vec3> {
    let teeth = face.teeth.iter().find(|teeth| teeth.bone == bone)?;
    let points = &teeth.surface.points;
    let extent = Extent::of(points);
    let middle = (extent.lo.x + extent.hi.x) / 2.;
    let near = || points.iter().filter(|p| (p.x - middle).abs() <= INCISORS_MM[0]);
    let foremost = near().map(|p| p.z).fold(f64::NEG_INFINITY, f64::max);
    let side = if teeth.upper { 1. } else { -1. };
    let edge = near()
        .filter(|p| p.z >= foremost - INCISORS_MM[1])
        .min_by(|a, b| (side * a.y).total_cmp(&(side * b.y)))?;
    Some(Vec3::new(middle, edge.y, edge.z))
}

impl Motion {
    /// The motion of `bone`; `at` is the path of the move.
    fn of(&self, bone: &str, face: &Face, at: &str) -> Result<RigidMotion, PlanError> {
        let wrong = |key: &str, problem| Err(PlanError::Value { field: format!("{at}{key}"), problem });
        if !self.translation.iter().chain([&self.rotation_deg]).all(|x| x.is_finite()) {
            return wrong("", "a translation in mm and a rotation in degrees must be finite");
        }
        check_length(self.translation.amax(), || format!("{at}.translation_mm"))?;
        if self.rotation_deg.abs() > 180. {
            return wrong(
                ".rotation_deg",
                "a bone turns by at most 180 degrees either way; give the rest of full turns",
            );
        }
        if self.rotation_deg == 0. {
            return Ok(RigidMotion::translation(self.translation));
        }
        let (point, direction) = match (self.about, &face.jaw) {
            (About::Line { point, direction }, _) => (point, direction),
            (About::Incisor { direction }, _) => match incisal_point(face, bone) {
                Some(point) => (point, direction),
                None => {
                    return wrong(
                        ".axis",
                        "the bone carries no teeth; let the cut take an arch along with `teeth`, or give the axis as a point \
                         and a direction",
                    );
                }
            },
            (About::Condyles, Some(jaw)) => (jaw.condyles[1], jaw.axis()),
            (About::Condyles, None) => {
                return wrong(".axis", "the face has no jaw joint; give the axis as a point and a direction");
            }
        };
        if matches!(self.about, About::Line { .. }) && point.iter().all(|x| x.is_finite()) {
            check_place(face, point, || format!("{at}.axis.point_mm"))?;
        }
        let turned = RigidMotion::rotation(point, direction, self.rotation_deg);
        match turned.filter(|_| point.iter().chain(direction.iter()).all(|x| x.is_finite())) {
            Some(turned) => Ok(turned.then_by(self.translation)),
            None => wrong(".axis", "an axis needs a finite point and a direction that is not zero"),
        }
    }
}
