//! Gauss-Newton steps across the pieces: near a local optimum before its piece is sought.

use std::sync::Arc;

use nalgebra::DVector;

use super::limit::{Constraints, Limit};
use super::limits::TrustRegion;
use super::piece::Piece;
use super::program::{Linearisation, Space, build};
use super::term::State;
use crate::forward::{ContactResponse, Touching, contact_forces_near};
use crate::qp::{self, Answer, ProblemError};

/// Half width of the first trust region.
const FIRST_RADIUS: f64 = 0.25;
/// Half width at which the pieces are too small for steps across them.
const LEAST_RADIUS: f64 = 1e-3;
/// Share of the objective below which the predicted decrease is left to the pieces.
const PROGRESS: f64 = 1e-5;
/// Steps before the pieces take over.
const MOST_STEPS: usize = 60;

/// The objective over the activations with the contact forces that they call up: continuous and
/// quadratic on each piece.
#[derive(Clone, Copy, Debug)]
pub(super) struct Landscape<'a> {
    pub(super) space: &'a Space,
    pub(super) contact: &'a Arc<ContactResponse>,
    pub(super) terms: &'a Linearisation,
    pub(super) limits: &'a [&'a dyn Limit],
}

/// A point of the landscape.
#[derive(Clone, Debug)]
pub(super) struct Standing {
    pub(super) activation: DVector<f64>,
    pub(super) touching: Touching,
    pub(super) objective: f64,
}

impl Landscape<'_> {
    /// The point at `activation` (m), its touching set sought from one nearby; `None` where no contact
    /// forces are found.
    pub(super) fn at(&self, activation: &DVector<f64>, nearby: Option<&Touching>) -> Option<Standing> {
        let (forces, touching) = contact_forces_near(self.contact, activation, nearby).ok()?;
        let observed = self.space.at(activation) + &self.contact.reach * forces;
        let objective = self.terms.objective(&State { observed, activation: activation.clone() });
        Some(Standing { activation: activation.clone(), touching, objective })
    }

    /// Walks down from `activation`: each step is the optimum of the present piece's quadratic within a
    /// trust region, as if the piece had no boundary, and is taken when the objective falls with it.
    ///
    /// Where it ends does not decide anything: the search over pieces goes on from there.
    pub(super) fn walk(&self, activation: &DVector<f64>) -> Result<Option<Standing>, ProblemError> {
        let Some(mut here) = self.at(activation, None) else { return Ok(None) };
        let mut allowed = self.allows(activation);
        let mut radius = FIRST_RADIUS;
        for _ in 0..MOST_STEPS {
            let piece = Piece::on(self.space, self.contact, here.touching.clone());
            let model = self.terms.over(&piece.space);
            let trust = TrustRegion { centre: here.activation.clone(), radius };
            let mut limits: Vec<&dyn Limit> = self.limits.to_vec();
            if allowed {
                limits.push(&trust);
            }
            let Answer::Solved(solution) = qp::solve(&build(&model, &limits).problem)? else { break };
            let proposed = solution.point.x;
            let predicted = here.objective - model.objective(&proposed);
            let Some(next) = self.at(&proposed, Some(&here.touching)) else { break };
            if !allowed {
                (here, allowed) = (next, true);
                continue;
            }
            if predicted <= PROGRESS * here.objective {
                break;
            }
            let (step, actual) = ((&proposed - &here.activation).amax(), here.objective - next.objective);
            if actual < 0.25 * predicted {
                radius = 0.5 * step;
            } else if actual > 0.75 * predicted && step > 0.99 * radius {
                radius *= 2.0;
            }
            if actual > 0.1 * predicted {
                here = next;
            }
            if radius < LEAST_RADIUS {
                break;
            }
        }
        Ok(Some(here))
    }

    /// Whether the limits allow `activation`, up to rounding.
    fn allows(&self, activation: &DVector<f64>) -> bool {
        let mut constraints = Constraints::none(activation.len());
        for limit in self.limits {
            limit.restrict(&mut constraints);
        }
        let excess = |row: &super::limit::Constraint| row.coefficients.dot(activation) - row.value;
        constraints.equality.iter().all(|row| excess(row).abs() <= 1e-9)
            && constraints.inequality.iter().all(|row| excess(row) <= 1e-9)
            && (activation - &constraints.lower).min() >= -1e-9
            && (&constraints.upper - activation).min() >= -1e-9
    }
}
