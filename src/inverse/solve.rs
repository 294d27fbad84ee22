//! From a posed problem to its solution.

use std::collections::BTreeSet;

use nalgebra::DVector;

use super::branching::{Bound, branch};
use super::descent::Landscape;
use super::limit::Limit;
use super::limits::TrustRegion;
use super::piece::{Outcome, Piece};
use super::pivot::{Failure, Found, Search};
use super::problem::{ContactMode, InverseError, Problem};
use super::program::Linearisation;
use super::report;
use super::solution::{Solution, Status};
use super::term::{State, Term, objective};
use super::terms::Damping;
use crate::qp::{self, Answer, Certificate, Point, ProblemError};

/// Relinearisations of nonlinear terms before giving up.
const RELINEARISATIONS: usize = 200;
/// Change of the activations at which the linearisation has settled.
const SETTLED: f64 = 1e-12;
/// Rise of the objective that is rounding: without it, damping would freeze the activations a square root
/// of the rounding short of the optimum.
const LEVEL: f64 = 1e-12;
/// Share of the objective that a step must promise where many activations fit alike and none stays,
const PROMISE: f64 = 1e-14;
/// and share of the objective at rest that is none.
const NOTHING: f64 = 1e-20;
/// Share of the objective by which branching must improve terms that are not linear.
const WORTH: f64 = 1e-6;
/// Activations to start from, as shares of their range, besides the contact-free optimum.
const STARTS: [f64; 3] = [0.0, 0.5, 1.0];

/// The best point of a linearised problem, or why there is none.
pub(super) type Reached = Result<Found, Failure>;

impl Problem {
    /// Finds the activations.
    ///
    /// With contact reactions a search over contact states from a few starts is followed by branch and
    /// bound: [`relaxation_end`](super::ContactReport::relaxation_end) says whether the answer is the best of
    /// all contact states, and [`relaxation_gap`](super::ContactReport::relaxation_gap) how much better
    /// another could be. With terms that are not linear both are about their linearisation at the answer.
    ///
    /// # Errors
    /// [`InverseError`] when the response is malformed. Limits that contradict each other, missing
    /// data and a solver that stops short are no errors: see [`Status`].
    pub fn solve(&self, mode: ContactMode) -> Result<Solution, InverseError> {
        // Symmetry and effort say how, not what.
        if self.features.is_empty()
            && self.markers.iter().all(|marker| marker.target_mm.iter().all(Option::is_none))
        {
            return Ok(report::empty(self, Status::NoData));
        }
        let mode = if self.contact.is_none() { ContactMode::Off } else { mode };
        let rest = self.rest();
        let mut found = match self.minimise(mode, &self.linearise(&rest), None, None)? {
            Ok(found) => found,
            Err(failure) => return Ok(self.failed(failure)),
        };
        let mut settled = true;
        if self.terms.iter().any(|term| !term.is_linear()) {
            (found, settled) = self.relinearise(mode, found)?;
        }
        let local = objective(&self.terms, &found.optimum.state);
        let bound = loop {
            let terms = self.linearise(&found.optimum.state);
            let Some(mut bound) = self.bound(mode, &terms, &found)? else { break None };
            let Some(better) = bound.better.take() else { break Some(bound) };
            if self.terms.iter().all(|term| term.is_linear()) {
                found = better;
                break Some(bound);
            }
            // What the linearised terms promise the terms themselves must keep.
            let value = objective(&self.terms, &found.optimum.state);
            let (next, next_settled) = self.relinearise(mode, better)?;
            if objective(&self.terms, &next.optimum.state) >= value * (1.0 - WORTH) {
                break Some(bound);
            }
            (found, settled) = (next, next_settled);
        };
        let terms = self.linearise(&found.optimum.state);
        let (point, certificate) = self.certify(mode, &terms, &found)?;
        let status = if certificate.passes() && settled && found.settled {
            Status::Solved
        } else {
            Status::NotConverged
        };
        let mut solution = report::solution(self, mode, status, &found, &point, certificate, bound.as_ref());
        solution.contact.branching_gain = (local - solution.objective).max(0.0);
        Ok(solution)
    }

    /// How far the linearised `terms` can go below `found`, where contact makes the problem nonconvex.
    pub(super) fn bound(
        &self,
        mode: ContactMode,
        terms: &Linearisation,
        found: &Found,
    ) -> Result<Option<Bound>, ProblemError> {
        let (ContactMode::Reactions, Some(contact)) = (mode, &self.contact) else { return Ok(None) };
        let limits: [&dyn Limit; 2] = [&self.bounds, &self.tied];
        let landscape = Landscape { space: &self.space, contact, terms, limits: &limits };
        branch(landscape, found, self.rest_objective(terms)).map(Some)
    }

    /// That of the linearised `terms` at least activations, without contact.
    fn rest_objective(&self, terms: &Linearisation) -> f64 {
        terms.over(&self.space).objective(&self.bounds.min)
    }

    pub(super) fn failed(&self, failure: Failure) -> Solution {
        match failure {
            Failure::Infeasible(proof) => {
                let mut solution = report::empty(self, Status::Infeasible);
                // Without a proof of its own the piece only failed to contain its start.
                if proof.is_none() {
                    solution.status = Status::NotConverged;
                }
                solution.infeasible = proof;
                solution
            }
            Failure::NotConverged => report::empty(self, Status::NotConverged),
        }
    }

    /// The best point of the linearised `terms` within `trust`, near the contact state `warm` (the
    /// touching contacts) when there is one.
    pub(super) fn minimise(
        &self,
        mode: ContactMode,
        terms: &Linearisation,
        warm: Option<Vec<usize>>,
        trust: Option<&TrustRegion>,
    ) -> Result<Reached, ProblemError> {
        let mut limits: Vec<&dyn Limit> = vec![&self.bounds, &self.tied];
        limits.extend(trust.map(|t| t as &dyn Limit));
        let free = Piece::without_contact(&self.space);
        let contact = match (mode, &self.contact) {
            (ContactMode::Off, _) | (_, None) => return self.only(free, terms, &limits),
            (ContactMode::Kinematic, Some(contact)) => {
                return self.only(Piece::new(&self.space, contact, []), terms, &limits);
            }
            (ContactMode::Reactions, Some(contact)) => contact,
        };
        let landscape = Landscape { space: &self.space, contact, terms, limits: &limits };
        let mut search = Search::new(landscape, self.rest_objective(terms));
        if let Some(touching) = warm {
            return search.near(touching);
        }
        let mut starts: Vec<DVector<f64>> = Vec::new();
        match free.optimum(terms, &limits, &BTreeSet::new())? {
            Outcome::Optimum(optimum) => starts.push(optimum.state.activation),
            Outcome::Infeasible(proof) => return Ok(Err(Failure::Infeasible(proof))),
            Outcome::NotConverged => {}
        }
        let range = &self.bounds.max - &self.bounds.min;
        starts.extend(STARTS.map(|share| &self.bounds.min + &range * share));
        search.best(&starts)
    }

    /// The optimum of a problem that has one piece.
    fn only(
        &self,
        piece: Piece,
        terms: &Linearisation,
        limits: &[&dyn Limit],
    ) -> Result<Reached, ProblemError> {
        Ok(match piece.optimum(terms, limits, &BTreeSet::new())? {
            Outcome::Optimum(optimum) => Ok(Found { piece, optimum: *optimum, settled: true }),
            Outcome::Infeasible(proof) => Err(Failure::Infeasible(proof)),
            Outcome::NotConverged => Err(Failure::NotConverged),
        })
    }

    /// Gauss-Newton with Levenberg's damping: linearises the terms where the last answer left them until
    /// the activations stay, or, where many fit alike, until the linearised terms promise no less.
    fn relinearise(&self, mode: ContactMode, mut found: Found) -> Result<(Found, bool), ProblemError> {
        let mut value = objective(&self.terms, &found.optimum.state);
        let nothing = NOTHING * objective(&self.terms, &self.rest());
        let mut damping = 0.0;
        for _ in 0..RELINEARISATIONS {
            let state = &found.optimum.state;
            let proximal = Damping { weight: damping, centre: state.activation.clone() };
            let terms = self.terms.iter().map(AsRef::as_ref).chain([&proximal as &dyn Term]);
            let Ok(next) =
                self.minimise(mode, &Linearisation::new(terms, state), Some(found.piece.key()), None)?
            else {
                return Ok((found, false));
            };
            let step = (&next.optimum.state.activation - &state.activation).amax();
            let next_value = objective(&self.terms, &next.optimum.state);
            // A step that promises so little leaves its square.
            let is_level = value - next.optimum.objective <= PROMISE * value + nothing;
            if damping == 0.0
                && (step <= SETTLED || is_level && next_value <= value * (1.0 + LEVEL) + nothing)
            {
                return Ok((next, true));
            }
            if next_value <= value * (1.0 + LEVEL) {
                (found, value) = (next, next_value);
                damping =
                    if damping < 1e-6 * self.curvature(&found.optimum.state) { 0.0 } else { 0.1 * damping };
            } else {
                damping = (10.0 * damping).max(1e-3 * self.curvature(state));
            }
        }
        Ok((found, false))
    }

    /// Largest diagonal of the contact-free Hessian, the measure of the damping.
    fn curvature(&self, state: &State) -> f64 {
        let program = self.build(ContactMode::Off, &[], state);
        program.problem.hessian.diagonal().amax()
    }

    /// The point of the full program, with every contact in it, and its certificate.
    fn certify(
        &self,
        mode: ContactMode,
        terms: &Linearisation,
        found: &Found,
    ) -> Result<(Point, Certificate), ProblemError> {
        let touching = found.piece.touching.contacts();
        let program = self.build_from(terms, mode, touching);
        let mut point = match mode {
            ContactMode::Reactions => found.piece.lifted(terms, &found.optimum),
            ContactMode::Kinematic | ContactMode::Off => found.optimum.point.clone(),
        };
        let mut certificate = Certificate::of(&program.problem, &point);
        if !certificate.passes()
            && let Answer::Solved(better) | Answer::NotConverged(Some(better)) =
                qp::refine(&program.problem, &point)?
            && better.certificate.worst() < certificate.worst()
        {
            (point, certificate) = (better.point, better.certificate);
        }
        Ok((point, certificate))
    }
}
