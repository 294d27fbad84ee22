//! A target on a face whose muscles stiffen as they act.

use nalgebra::DVector;

use super::pivot::Found;
use super::problem::{ContactMode, InverseError, Problem};
use super::program::Linearisation;
use super::report;
use super::solution::{Solution, Status};
use super::term::{State, objective};
use super::{Observations, Target};
use crate::forward::Model;
use crate::qp::{Certificate, Point};

/// A target posed on a forward model whose stiffness follows the activations: `u(a)` solves
/// `K(a) u = F a + G' lambda` and is no longer linear in `a`.
#[derive(Clone, Copy, Debug)]
pub struct ActivatedProblem<'a> {
    model: &'a Model,
    target: &'a Target,
    observations: &'a Observations,
    mode: ContactMode,
}

/// The problem about one activation: where the face is there, and how it goes on.
#[derive(Debug)]
pub(super) struct Iterate {
    /// Observed displacements and activations.
    pub(super) state: State,
    /// Contact forces (c), N.
    pub(super) forces: DVector<f64>,
    /// `1/2 sum r^2` at the state, of the nonlinear model.
    pub(super) objective: f64,
    /// The target on the tangent at the state.
    pub(super) tangent: Problem,
    /// The terms linearised at the state.
    pub(super) terms: Linearisation,
}

impl<'a> ActivatedProblem<'a> {
    /// Poses `target`, whose points on the face are `observations`, on `model`.
    pub fn new(
        model: &'a Model,
        target: &'a Target,
        observations: &'a Observations,
        mode: ContactMode,
    ) -> Self {
        Self { model, target, observations, mode }
    }

    /// What contact does.
    pub fn mode(&self) -> ContactMode {
        self.mode
    }

    /// The linear problem at the stiffness of the uniform activation `share`.
    ///
    /// # Errors
    /// [`InverseError`] when the model cannot be factorised or the target is not of this face.
    pub fn at_fixed_stiffness(&self, share: f64) -> Result<Problem, InverseError> {
        let stiff = self.model.at(&vec![share; self.model.muscles().len()])?;
        Ok(Problem::new(self.target, self.observations, &stiff.response(&self.observations.sites))?)
    }

    /// The face at rest under the activations `a` (m) and its tangent there.
    pub(super) fn iterate(&self, a: &DVector<f64>) -> Result<Iterate, InverseError> {
        let stiff = self.model.at(a.as_slice())?;
        let sites = &self.observations.sites;
        let response = stiff.response(sites);
        let contact = response.contact.as_ref().filter(|_| self.mode == ContactMode::Reactions);
        let equilibrium = stiff.equilibrium(contact)?;
        let observed = sites.iter().flat_map(|site| {
            let u = site.displacement(&equilibrium.displacement);
            [u.x, u.y, u.z]
        });
        let state =
            State { observed: DVector::from_iterator(3 * sites.len(), observed), activation: a.clone() };
        let tangent = stiff.tangent(sites, &response, &equilibrium.displacement);
        let tangent = Problem::new(self.target, self.observations, &tangent)?;
        let objective = objective(tangent.terms(), &state);
        let terms = tangent.linearise(&state);
        Ok(Iterate { state, forces: equilibrium.contact_forces, objective, tangent, terms })
    }
}

impl Iterate {
    /// This state as a point of its own tangent program, with the multipliers of the optimum `found` on
    /// that tangent, and how well it satisfies the optimality conditions of the nonlinear problem.
    pub(super) fn optimality(&self, mode: ContactMode, found: &Found) -> (Point, Certificate) {
        let touching = found.piece.touching.contacts();
        let mut point = match mode {
            ContactMode::Reactions => found.piece.lifted(&self.terms, &found.optimum),
            ContactMode::Kinematic | ContactMode::Off => found.optimum.point.clone(),
        };
        let m = self.state.activation.len();
        point.x.rows_mut(0, m).copy_from(&self.state.activation);
        for (k, &i) in touching.iter().enumerate().take(point.x.len() - m) {
            point.x[m + k] = self.forces[i];
        }
        let program = self.tangent.build_from(&self.terms, mode, touching);
        let certificate = Certificate::of(&program.problem, &point);
        (point, certificate)
    }

    /// The contacts that press, ascending.
    pub(super) fn touching(&self) -> Vec<usize> {
        (0..self.forces.len()).filter(|&i| self.forces[i] > 0.).collect()
    }

    /// This state as an answer; its relaxation gap is that of the tangent: what another contact state could
    /// gain if the face went on as it does here.
    pub(super) fn solution(
        &self,
        mode: ContactMode,
        status: Status,
        found: &Found,
    ) -> Result<Solution, InverseError> {
        let (point, certificate) = self.optimality(mode, found);
        let bound = self.tangent.bound(mode, &self.terms, found)?;
        Ok(report::solution(&self.tangent, mode, status, found, &point, certificate, bound.as_ref()))
    }
}
