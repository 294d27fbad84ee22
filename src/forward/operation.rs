//! A surgical plan carried out: the face that heals in the new place.

use thiserror::Error;

use super::finite::{FaceContact, FiniteError, FiniteModel, FiniteState};
use super::{ContactError, ForwardError, Model, SettledContact};
use crate::face::{
    ContactReach, ContactSearch, Face, FaceError, Jaw, LargeTurn, PlanError, Pose, PreparedPlan, SurgicalPlan,
};
use crate::mesh::Quality;
use crate::units::{Vec3, counted};

/// Why a plan cannot be carried out.
#[derive(Clone, Debug, Error, PartialEq)]
#[non_exhaustive]
pub enum OperationError {
    /// The plan does not fit the face.
    #[error(transparent)]
    Plan(#[from] PlanError),
    /// The tissue cannot be solved.
    #[error(transparent)]
    Forward(#[from] ForwardError),
    /// The tissue cannot be modelled at finite strain, or comes to no rest.
    #[error(transparent)]
    Finite(#[from] FiniteError),
    /// No contact forces hold it.
    #[error(transparent)]
    Contact(#[from] ContactError),
    /// The motion turns elements inside out.
    #[error(
        "{} would be turned inside out, cell {cell} at ({:.0}, {:.0}, {:.0}) mm first: more than the mesh can \
         follow; move the bones less, or cut where more tissue can stretch", counted(*cells, "cell"), at.x, at.y, at.z
    )]
    Inverted {
        /// How many.
        cells: usize,
        /// Id of the first in the mesh's file.
        cell: u64,
        /// Where it was, mm.
        at: Vec3,
    },
    /// The new face cannot be computed with.
    #[error("the face that comes out cannot be used: {0}")]
    Face(FaceError),
}

/// A plan carried out on a face, by either strain model: `M` is how the tissue followed, its muscles at rest.
#[derive(Clone, Debug)]
pub struct Operation<M = SettledContact> {
    /// The face afterwards: at rest where its bones were brought, without stress.
    pub face: Face,
    /// Where the plan brought the bones.
    pub pose: Pose,
    /// How the tissue followed: displacement (3n, mm) and contact.
    pub movement: M,
    /// Bones that were turned too far for the linear model.
    pub large_turns: Vec<LargeTurn>,
}

/// Cuts and moves the bones of `face` as the `plan` says; the tissue follows, its muscles at rest, against teeth
/// and lips: `K_ff(0) u_f = G' lambda - K_fb(0) u_b`. Tissue that is stripped off the bone about a cut is free
/// meanwhile and fixed again in the new face. In the new face mesh, landmarks and muscles are where `u` brings
/// them, teeth and jaw where their bones are, and nothing is under stress, as after healing. A plan that moves
/// nothing gives the same face to the bit; one that moves bones gives a face of another name, `FACE_PLAN`.
///
/// # Errors
/// [`OperationError`] for a plan that does not fit the face, tissue that cannot be solved, cells that turn inside
/// out and a new face that cannot be used.
pub fn operate(plan: &SurgicalPlan, face: &Face) -> Result<Operation, OperationError> {
    let Prepared { cut, loose, pose } = Prepared::new(plan, face)?;
    let search = ContactSearch::new(&loose, ContactReach::default());
    let model = Model::new(&loose, search.rest().to_vec())?;
    let rest = vec![0.; cut.muscles.len()];
    let movement = model.at_pose(&rest, &pose)?.settle(&loose, &search, &rest, None)?;
    let healed = healed(cut, &pose, &movement.equilibrium.displacement, (face, plan))?;
    Ok(Operation { face: healed, large_turns: pose.large_turns(), pose, movement })
}

/// [`operate`] at finite strain: the tissue rests at a minimum of its potential with the bones moved, its muscles at rest, and
/// nothing crosses teeth or lips on the way. Turns may be as large as they are.
///
/// # Errors
/// As [`operate`], and [`OperationError::Finite`] where the tissue comes to no rest.
pub fn operate_at_finite_strain(
    plan: &SurgicalPlan,
    face: &Face,
) -> Result<Operation<FiniteState>, OperationError> {
    let Prepared { cut, loose, pose } = Prepared::new(plan, face)?;
    let model = FiniteModel::new(&loose, Some(FaceContact::new(&loose)?))?;
    let movement = model.settle(&vec![0.; cut.muscles.len()], &pose)?;
    let healed = healed(cut, &pose, movement.displacement(), (face, plan))?;
    Ok(Operation { face: healed, large_turns: Vec::new(), pose, movement })
}

/// A face ready for its bones to move.
struct Prepared {
    /// With its bones cut,
    cut: Face,
    /// and with the tissue stripped off them about the cuts.
    loose: Face,
    pose: Pose,
}

impl Prepared {
    fn new(plan: &SurgicalPlan, face: &Face) -> Result<Self, PlanError> {
        let PreparedPlan { face: cut, pose, stripped } = plan.prepare(face)?;
        let mut loose = cut.clone();
        for support in &mut loose.supports {
            support.nodes.retain(|node| !stripped.contains(node));
        }
        Ok(Self { cut, loose, pose })
    }
}

/// The face that heals where `pose` brings the bones of `cut` and `u` (3n, mm) its tissue.
fn healed(
    cut: Face,
    pose: &Pose,
    u: &[f64],
    (before, plan): (&Face, &SurgicalPlan),
) -> Result<Face, OperationError> {
    if pose.is_rest() {
        return Ok(cut);
    }
    let name = format!("{}_{}", before.name, plan.name);
    let healed = Face { name, ..carried(&cut, pose, u) };
    inside_out(&healed, before)?;
    match healed.check().0.into_iter().next() {
        Some(error) => Err(OperationError::Face(error)),
        None => Ok(healed),
    }
}

/// `face` where `pose` brings its bones and `u` (3n, mm) its tissue.
fn carried(face: &Face, pose: &Pose, u: &[f64]) -> Face {
    let jaw = face.jaw.as_ref().map(|jaw| {
        let hinge = pose.motion(face, &jaw.bone);
        // The incisors are on whatever piece carries the lower teeth.
        let carrier = face.teeth.iter().find(|t| !t.upper).map_or(&jaw.bone, |t| &t.bone);
        let incisor = pose.motion(face, carrier).apply(jaw.incisor);
        Jaw { bone: jaw.bone.clone(), condyles: jaw.condyles.map(|c| hinge.apply(c)), incisor }
    });
    Face { jaw, teeth: face.teeth_at(pose), ..face.with_tissue_moved(u) }
}

fn inside_out(moved: &Face, before: &Face) -> Result<(), OperationError> {
    let mesh = &moved.mesh;
    let inverted: Vec<usize> =
        (0..mesh.cells.len()).filter(|&c| Quality::new(&mesh.cells[c], &mesh.points).is_inverted()).collect();
    let Some(&first) = inverted.first() else { return Ok(()) };
    let corners: Vec<Vec3> = before.mesh.cell_points(first).collect();
    let at = corners.iter().sum::<Vec3>() / corners.len() as f64;
    Err(OperationError::Inverted { cells: inverted.len(), cell: mesh.cell_ids[first], at })
}
