//! A target on a face whose muscles stiffen as they act.

use nalgebra::DVector;

use super::piece::Piece;
use super::pivot::Found;
use super::problem::{ContactMode, InverseError, Problem};
use super::program::{Linearisation, Objective};
use super::report;
use super::solution::{Solution, Status};
use super::term::{State, objective};
use super::{JawOpening, Observations, Target};
use crate::face::{JawRange, Pose};
use crate::forward::{FixedStiffness, ForwardError, Model};
use crate::qp::{Certificate, Point};

/// Openings of the jaw about which the linear problem is solved before giving up.
const OPENINGS: usize = 20;
/// Change of the share of the jaw's opening at which the linearisation has settled.
const SETTLED: f64 = 1e-9;

/// A target posed on a forward model whose stiffness follows the activations: `u(a)` solves
/// `K(a) u = F a + G' lambda` and is no longer linear in `a`.
#[derive(Clone, Copy, Debug)]
pub struct ActivatedProblem<'a> {
    model: &'a Model,
    target: &'a Target,
    observations: &'a Observations,
    mode: ContactMode,
    /// Contacts that touch near the start.
    touching: &'a [usize],
}

/// The problem about one activation: where the face is there, and how it goes on.
#[derive(Debug)]
pub(super) struct Iterate {
    /// Observed displacements and activations.
    pub(super) state: State,
    /// Contact forces (c), N.
    pub(super) forces: DVector<f64>,
    /// That of the nonlinear model at the state.
    pub(super) objective: f64,
    /// The target on the tangent at the state.
    pub(super) tangent: Problem,
    /// The terms linearised at the state.
    pub(super) terms: Linearisation,
    /// The objective over the unknowns, the contacts that press held closed.
    pub(super) reduced: Objective,
}

impl<'a> ActivatedProblem<'a> {
    /// Poses `target`, whose points on the face are `observations`, on `model`.
    pub fn new(
        model: &'a Model,
        target: &'a Target,
        observations: &'a Observations,
        mode: ContactMode,
    ) -> Self {
        Self { model, target, observations, mode, touching: &[] }
    }

    /// The same problem, the contacts of its start sought from `touching`, those of a face nearby.
    pub(super) fn near(self, touching: &'a [usize]) -> Self {
        Self { touching, ..self }
    }

    /// The contacts that touch near the start; empty where they are not known.
    pub(super) fn touching(&self) -> &'a [usize] {
        self.touching
    }

    /// What contact does.
    pub fn mode(&self) -> ContactMode {
        self.mode
    }

    /// The linear problem at the stiffness of the uniform activation `share`, with the jaw at its least opening.
    ///
    /// # Errors
    /// [`InverseError`] when the model cannot be factorised or the target is not of this face.
    pub fn at_fixed_stiffness(&self, share: f64) -> Result<Problem, InverseError> {
        self.linearised(&self.uniform(share, 0.))
    }

    /// The answer at the stiffness of the uniform activation `share`; where the jaw's opening is unknown, about
    /// the opening that it finds.
    ///
    /// # Errors
    /// As [`at_fixed_stiffness`](Self::at_fixed_stiffness).
    pub fn solve_at_fixed_stiffness(&self, share: f64) -> Result<Solution, InverseError> {
        let mut opened = 0.;
        let mut solution = self.at_fixed_stiffness(share)?.solve(self.mode)?;
        for _ in 0..OPENINGS {
            let Some(next) = self.opened_share(&solution) else { return Ok(solution) };
            if (next - opened).abs() <= SETTLED {
                return Ok(solution);
            }
            opened = next;
            solution = self.linearised(&self.uniform(share, opened))?.solve(self.mode)?;
        }
        if solution.status.is_optimum() {
            solution.status = Status::NotConverged;
        }
        Ok(solution)
    }

    /// The unknowns of an answer, to start from.
    pub fn start(&self, solution: &Solution) -> DVector<f64> {
        let a = &solution.activations.values;
        let share = self.range().map(|_| self.opened_share(solution).unwrap_or(0.));
        DVector::from_iterator(a.len() + usize::from(share.is_some()), a.iter().copied().chain(share))
    }

    /// No activation, and the jaw at its least opening.
    pub fn rest(&self) -> DVector<f64> {
        self.uniform(0., 0.)
    }

    /// The model at the stiffness of the activations `a` (m), its bones at the pose of the unknowns `x` (n).
    ///
    /// # Errors
    /// As [`Model::at`].
    pub fn model_at(&self, a: &[f64], x: &[f64]) -> Result<FixedStiffness<'a>, InverseError> {
        let opening = match self.target.jaw_opening {
            None => None,
            Some(JawOpening::Held(opening)) => Some(opening),
            Some(JawOpening::Within(range)) => x.last().map(|&share| range.at(share)),
        };
        let jaw = self.model.face().jaw.as_ref();
        let pose = jaw.zip(opening).map(|(jaw, opening)| Pose::opened(jaw, opening));
        Ok(self.model.at_pose(a, &pose.unwrap_or_default())?)
    }

    fn range(&self) -> Option<JawRange> {
        match self.target.jaw_opening {
            Some(JawOpening::Within(range)) => Some(range),
            _ => None,
        }
    }

    fn opened_share(&self, solution: &Solution) -> Option<f64> {
        let range = self.range().filter(|range| range.width_mm() > 0.)?;
        Some(((solution.jaw_opening_mm? - range.min_mm) / range.width_mm()).clamp(0., 1.))
    }

    fn uniform(&self, share: f64, opened: f64) -> DVector<f64> {
        let m = self.model.muscles().len();
        let jaw = self.range().map(|_| opened);
        DVector::from_iterator(m + usize::from(jaw.is_some()), std::iter::repeat_n(share, m).chain(jaw))
    }

    /// The model at the stiffness and the pose of the unknowns `x` (n).
    fn stiff(&self, x: &DVector<f64>) -> Result<FixedStiffness<'a>, InverseError> {
        let m = self.model.muscles().len();
        let a = &x.as_slice()[..m.min(x.len())];
        Ok(match self.target.jaw_opening {
            None => self.model.at(a)?,
            Some(JawOpening::Held(opening)) => {
                let jaw = self.model.face().jaw.as_ref().ok_or(ForwardError::NoJaw)?;
                self.model.at_pose(a, &Pose::opened(jaw, opening))?
            }
            Some(JawOpening::Within(range)) => self.model.at_opening(a, range, x[m])?,
        })
    }

    fn linearised(&self, x: &DVector<f64>) -> Result<Problem, InverseError> {
        let response = self.stiff(x)?.response(&self.observations.sites);
        Ok(Problem::new(self.target, self.observations, &response)?)
    }

    /// The face at rest under the unknowns `a` (n) and its tangent there, its contact forces sought from the
    /// contacts `touching` of a face nearby.
    pub(super) fn iterate(&self, a: &DVector<f64>, touching: &[usize]) -> Result<Iterate, InverseError> {
        let stiff = self.stiff(a)?;
        let sites = &self.observations.sites;
        let response = stiff.response(sites);
        let contact = response.contact.as_ref().filter(|_| self.mode == ContactMode::Reactions);
        let equilibrium = stiff.equilibrium_near(contact, touching)?;
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
        let forces = equilibrium.contact_forces;
        let reduced = match &tangent.contact {
            Some(contact) if self.mode == ContactMode::Reactions => {
                terms.over(&Piece::new(&tangent.space, contact, self::touching(&forces)).space)
            }
            _ => terms.over(&tangent.space),
        };
        Ok(Iterate { state, forces, objective, tangent, terms, reduced })
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
        touching(&self.forces)
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

/// The contacts that press with `forces` (c), ascending.
pub(super) fn touching(forces: &DVector<f64>) -> Vec<usize> {
    (0..forces.len()).filter(|&i| forces[i] > 0.).collect()
}
