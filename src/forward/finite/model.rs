//! The face at finite strain.

use std::sync::Arc;

use nalgebra::DVector;

use super::contact::{FaceContact, teeth_at};
use super::error::FiniteError;
use super::hessian::Hessian;
use super::newton::{Newton, Place};
use super::{FiniteBody, FiniteState, Potential, Tangent};
use crate::face::{Face, MuscleLaw, Pose};
use crate::forward::ForwardError;
use crate::forward::model::fixed_dofs;
use crate::units::Vec3;

/// Least step of the load, as a share of the whole,
const LEAST_STEP: f64 = 1. / 256.;
/// and where another state is near, from which a shorter way may be asked for.
const LEAST_STEP_BESIDE: f64 = 1. / 4.;

/// The finite-strain model of a face: everything that does not depend on activations and pose.
///
/// Shapes: `n` nodes, `m` muscles.
#[derive(Clone, Debug)]
pub struct FiniteModel {
    face: Arc<Face>,
    potential: Arc<Potential>,
    /// The Hessian at rest, without activation: the metric of steps.
    rest: Arc<Hessian>,
}

impl FiniteModel {
    /// The model of `face`, its `contact` being that of the same face; `None` lets surfaces pass through each other.
    ///
    /// # Errors
    /// [`FiniteError`] for tissue that cannot be modelled and a muscle law without a potential.
    pub fn new(face: &Face, contact: Option<FaceContact>) -> Result<Self, FiniteError> {
        let law = face.muscle_tissue.law;
        if law != MuscleLaw::Reinforced {
            return Err(FiniteError::LawWithoutPotential { law: law.name() });
        }
        let no_load = vec![Vec3::zeros(); face.mesh.n_nodes()];
        let potential = Potential::new(FiniteBody::of_face(face)?, fixed_dofs(face), no_load);
        let rest = potential.tissue_at(&face.mesh.points, &vec![0.; face.muscles.len()])?;
        let potential = match contact {
            Some(contact) => potential.with_contact(contact),
            None => potential,
        };
        Ok(Self { face: Arc::new(face.clone()), potential: Arc::new(potential), rest: Arc::new(rest) })
    }

    /// The face.
    pub fn face(&self) -> &Face {
        &self.face
    }

    /// What it rests at a minimum of.
    pub fn potential(&self) -> &Potential {
        &self.potential
    }

    /// The face at rest under the activations `a` (m) with its bones at `pose`, reached from rest along the loading
    /// path `s a`, `s pose` in as few steps of `s` as will do.
    ///
    /// # Errors
    /// [`ForwardError::Activation`] outside [0, 1], [`FiniteError::NoRest`].
    pub fn settle(&self, a: &[f64], pose: &Pose) -> Result<FiniteState, FiniteError> {
        let none = vec![0.; a.len()];
        let newton = self.newton((*self.rest).clone());
        self.along(newton, self.bones_at(&Pose::rest()), (&none, &Pose::rest()), (a, pose), LEAST_STEP)
    }

    /// The face at rest under the activations `a` (m) with its bones at `pose`, reached from `state`.
    ///
    /// # Errors
    /// As [`settle`](Self::settle).
    pub fn settle_from(
        &self,
        state: &FiniteState,
        a: &[f64],
        pose: &Pose,
    ) -> Result<FiniteState, FiniteError> {
        self.from(state, a, pose, LEAST_STEP)
    }

    /// The face at rest under the activations `a` (m) with its bones at `pose`, sought first where the `tangent` of
    /// `state` predicts it as the unknowns change by `step`, then in no more than a few steps of the load.
    ///
    /// # Errors
    /// As [`settle`](Self::settle); [`FiniteError::NoRest`] sooner.
    pub fn settle_beside(
        &self,
        state: &FiniteState,
        (tangent, step): (&Tangent, &DVector<f64>),
        a: &[f64],
        pose: &Pose,
    ) -> Result<FiniteState, FiniteError> {
        let mut newton = self.newton(state.hessian().clone());
        let bones = self.bones_at(pose);
        let predicted =
            Place { x: tangent.predict(state.positions(), step), obstacles: bones.obstacles.clone() };
        let is_apart = self.potential.way(state.place(), &predicted).limit == 1.;
        let found = if is_apart { newton.rest(&predicted, &bones, a)? } else { None };
        match found {
            Some(found) => {
                Ok(FiniteState::new((&self.face, &self.potential), newton.minimum(found), a, pose, 1))
            }
            None => self.from(state, a, pose, LEAST_STEP_BESIDE),
        }
    }

    fn from(
        &self,
        state: &FiniteState,
        a: &[f64],
        pose: &Pose,
        least_step: f64,
    ) -> Result<FiniteState, FiniteError> {
        let newton = self.newton(state.hessian().clone());
        let from = (state.activation(), state.pose());
        self.along(newton, state.place().clone(), from, (a, pose), least_step)
    }

    /// From one load to another, all at once where that comes to rest, else by halves.
    fn along(
        &self,
        mut newton: Newton<'_>,
        mut place: Place,
        from: (&[f64], &Pose),
        to: (&[f64], &Pose),
        least_step: f64,
    ) -> Result<FiniteState, FiniteError> {
        for (muscle, &value) in self.face.muscles.iter().zip(to.0) {
            if !(0. ..=1.).contains(&value) {
                return Err(ForwardError::Activation { muscle: muscle.name.clone(), value }.into());
            }
        }
        let (mut done, mut step, mut load_steps) = (0., 1., 0);
        while done < 1. {
            let next = f64::min(done + step, 1.);
            let a: Vec<f64> = from.0.iter().zip(to.0).map(|(a, b)| a + next * (b - a)).collect();
            let pose = from.1.towards(to.1, next);
            match newton.rest(&place, &self.bones_at(&pose), &a)? {
                Some(found) => {
                    (place, done) = (found, next);
                    load_steps += 1;
                }
                None if step > least_step => step *= 0.5,
                None => return Err(FiniteError::NoRest { reached: done }),
            }
        }
        Ok(FiniteState::new((&self.face, &self.potential), newton.minimum(place), to.0, to.1, load_steps))
    }

    fn newton(&self, hessian: Hessian) -> Newton<'_> {
        Newton::new(&self.potential, &self.face.mesh.points, &self.rest, hessian)
    }

    /// The face undeformed, but with its nodes on bones and its teeth where `pose` brings them.
    fn bones_at(&self, pose: &Pose) -> Place {
        let u = self.face.bone_displacement(pose);
        let points = self.face.mesh.points.iter().zip(u.as_chunks::<3>().0);
        Place { x: points.map(|(p, u)| p + Vec3::from(*u)).collect(), obstacles: teeth_at(&self.face, pose) }
    }
}
