//! A movement whose activations are known.

use nalgebra::{DMatrix, DVector};

use super::CalibrationError;
use crate::forward::Response;
use crate::inverse::{Linearisation, Observations, Problem, State, Target};
use crate::mesh::Site;
use crate::units::Vec3;

/// A movement that was observed, and the activations that made it.
///
/// A muscle that the target's priors do not name is at rest, for certain.
#[derive(Debug)]
pub struct Expression {
    /// The target's name.
    pub(super) name: String,
    /// Its observations alone: no effort, no limits.
    problem: Problem,
    /// The observed points.
    pub(super) sites: Vec<Site>,
    /// Where they are at rest, mm.
    pub(super) points_mm: Vec<Vec3>,
    /// Activations (m).
    pub(super) activation: Vec<f64>,
    /// Their standard deviations (m).
    pub(super) sigma: Vec<f64>,
}

impl Expression {
    /// That of `target`, whose points on a face with these `muscles` are `observations`.
    ///
    /// # Errors
    /// [`CalibrationError`] for a target without known activations or observations, with an open jaw, or of another face.
    pub fn new(
        target: &Target,
        observations: &Observations,
        muscles: &[String],
    ) -> Result<Self, CalibrationError> {
        let name = target.name.clone();
        if target.jaw_opening.is_some() {
            return Err(CalibrationError::OpenJaw { expression: name });
        }
        let (mut activation, mut sigma) = (vec![0.; muscles.len()], vec![0.; muscles.len()]);
        for prior in &target.priors {
            if let Some(k) = muscles.iter().position(|muscle| *muscle == prior.muscle) {
                (activation[k], sigma[k]) = (prior.activation, prior.sigma);
            }
        }
        if activation.iter().all(|a| *a == 0.) {
            return Err(CalibrationError::NoActivation { expression: name });
        }
        let is_observed = target.markers.iter().any(|marker| marker.goal.observed().next().is_some())
            || !target.features.is_empty()
            || !target.symmetry.is_empty();
        if !is_observed {
            return Err(CalibrationError::NoObservation { expression: name });
        }
        let observed = Target {
            effort: 0.,
            costs: Vec::new(),
            priors: Vec::new(),
            bounds: Vec::new(),
            tied: Vec::new(),
            ..target.clone()
        };
        // The terms are asked for at states of our own; the response only says how many unknowns there are.
        let rows = observations.n_rows();
        let response = Response {
            muscles: muscles.to_vec(),
            jaw: None,
            map: DMatrix::zeros(rows, muscles.len()),
            offset: DVector::zeros(rows),
            contact: None,
        };
        let problem = Problem::new(&observed, observations, &response)
            .map_err(|error| CalibrationError::Target { expression: name.clone(), error: Box::new(error) })?;
        let points_mm = observations.sites.iter().map(|site| site.position).collect();
        Ok(Self { name, problem, sites: observations.sites.clone(), points_mm, activation, sigma })
    }

    /// The target's name.
    pub fn name(&self) -> &str {
        &self.name
    }

    /// Activations (m).
    pub fn activation(&self) -> &[f64] {
        &self.activation
    }

    /// Numbers of the muscles that are or may be active.
    pub(super) fn acting(&self) -> Vec<usize> {
        (0..self.activation.len()).filter(|&k| self.activation[k] > 0. || self.sigma[k] > 0.).collect()
    }

    /// The residuals, in standard deviations, linearised about the displacements `observed` (d, mm) of its points.
    pub(super) fn residuals(&self, observed: DVector<f64>) -> Linearisation {
        let activation = DVector::from_column_slice(&self.activation);
        self.problem.linearise(&State { observed, activation })
    }
}
