//! Faces at rest at finite strain that stand for a recording.

use nalgebra::DVector;
use rayon::prelude::*;

use super::key_states::{key_states, nearest};
use crate::face::Pose;
use crate::forward::finite::{FiniteError, FiniteModel};
use crate::mesh::Site;
use crate::recording::Mechanism;

/// Faces settled in a round after the first,
const STATES: usize = 12;
/// and rounds at most.
pub(super) const ROUNDS: usize = 7;
/// Share of the way from the face about which a frame is described to what is found there that its next face goes, at first and later:
/// what is found about a face that is far off may lead to one from which the way leads back.
const WAY: [f64; 2] = [1., 0.5];
/// Rounds that go the whole way.
const WHOLE: usize = 2;
/// Distance of unknowns within which frames are described by a face that is known.
const NEAR: f64 = 0.05;
/// Distance of the points of each new face from where they were predicted that is good enough, mm (rms over points).
pub(super) const GOOD_MM: f64 = 0.2;

/// Faces at rest at finite strain, and what unknowns do to the observed points about each.
#[derive(Clone, Debug)]
pub(super) struct RestStates {
    model: FiniteModel,
    /// At linear strain.
    linear: Mechanism,
    /// The unknowns (n each),
    at: Vec<DVector<f64>>,
    /// and what they do from there.
    pub(super) mechanisms: Vec<Mechanism>,
    pub(super) rounds: Vec<RestRound>,
}

/// Faces that were settled in one round, and how far their observed points are from where the round before had them.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct RestRound {
    /// Faces settled.
    pub states: usize,
    /// Faces that do not come to rest.
    pub without_rest: usize,
    /// Distance of the observed points from where they were predicted, mm: root mean square over points and faces,
    pub rms_mm: f64,
    /// and the farthest.
    pub most_mm: f64,
}

impl RestStates {
    /// None yet of the face of `model`, which moves as `linear` has it at linear strain.
    pub(super) fn new(model: FiniteModel, linear: Mechanism) -> Self {
        Self { model, linear, at: Vec::new(), mechanisms: Vec::new(), rounds: Vec::new() }
    }

    /// Faces settled in all rounds together, at most.
    pub(super) const MOST: usize = 1 + (ROUNDS - 1) * STATES;

    /// The nearest to the unknowns `x`.
    pub(super) fn nearest(&self, x: &DVector<f64>) -> usize {
        nearest(x, &self.at).0
    }

    /// The unknowns about which frames are to be described in this `round` of which these were `found`, each about the face whose number
    /// is its `own`.
    pub(super) fn places(&self, round: usize, own: &[usize], found: &[DVector<f64>]) -> Vec<DVector<f64>> {
        let way = WAY[usize::from(round > WHOLE)];
        let place =
            |(own, x): (&usize, &DVector<f64>)| self.at.get(*own).map_or(x.clone(), |at| at.lerp(x, way));
        own.iter().zip(found).map(place).collect()
    }

    /// How far the unknowns `x` are from those of a face.
    pub(super) fn apart(&self, face: usize, x: &DVector<f64>) -> f64 {
        (x - &self.at[face]).norm()
    }

    /// Settles the face at the mean of the `places` of frames, each now described about the face whose number is its `own`, and in
    /// later rounds where they are far from what is known; the worst distance of a new face's points from where they were predicted,
    /// mm (rms), `None` where no face is new.
    ///
    /// # Errors
    /// [`FiniteError`] when none is at rest anywhere.
    pub(super) fn refine(
        &mut self,
        places: &[DVector<f64>],
        own: &[usize],
        sites: &[Site],
        done: &(impl Fn(usize) + Sync),
    ) -> Result<Option<f64>, FiniteError> {
        // The linear model is far off where muscles do much: it gives the mean, and what is found about that the rest.
        let most = if self.at.is_empty() { 1 } else { STATES };
        let m = self.linear.muscles.len();
        let mut new = key_states(places, &self.at, most, NEAR);
        // Frames are within their bounds to rounding.
        new.iter_mut().for_each(|x| x.rows_mut(0, m).apply(|a| *a = a.clamp(0., 1.)));
        let settled: Vec<Result<Mechanism, FiniteError>> = new
            .par_iter()
            .map(|x| {
                let found = self.about(x, sites);
                done(1);
                found
            })
            .collect();
        let (known, mut apart_mm, mut without_rest) = (self.at.len(), Vec::new(), Vec::new());
        let mut worst_mm = 0_f64;
        for (x, settled) in new.into_iter().zip(settled) {
            let mechanism = match settled {
                Ok(mechanism) => mechanism,
                Err(error @ FiniteError::NoRest { .. }) => {
                    without_rest.push(error);
                    continue;
                }
                Err(error) => return Err(error),
            };
            // What had the frame that is nearest.
            let before = match known {
                0 => &self.linear,
                _ => &self.mechanisms[own[nearest(&x, places).0]],
            };
            let predicted = before.observed_mm(x.as_slice()).into_iter();
            let there = mechanism.observed_mm(x.as_slice()).into_iter();
            for (predicted, there) in predicted.zip(there) {
                let off = there - predicted;
                let points = off.len() / 3;
                worst_mm = worst_mm.max(off.norm() / (points.max(1) as f64).sqrt());
                apart_mm.extend((0..points).map(|point| off.rows(3 * point, 3).norm()));
            }
            self.at.push(x);
            self.mechanisms.push(mechanism);
        }
        let states = self.at.len() - known;
        let without_rest = match without_rest.pop() {
            Some(error) if self.at.is_empty() => return Err(error),
            last => without_rest.len() + usize::from(last.is_some()),
        };
        let squares = apart_mm.iter().fold(0., |sum, mm| sum + mm * mm);
        let rms_mm = (squares / apart_mm.len().max(1) as f64).sqrt();
        let most_mm = apart_mm.iter().copied().fold(0., f64::max);
        if states + without_rest > 0 {
            self.rounds.push(RestRound { states, without_rest, rms_mm, most_mm });
        }
        Ok((states > 0).then_some(worst_mm))
    }

    /// What unknowns do about the face settled at `x`.
    fn about(&self, x: &DVector<f64>, sites: &[Site]) -> Result<Mechanism, FiniteError> {
        let a = &x.as_slice()[..self.linear.muscles.len()];
        let state = self.model.settle(a, &self.pose(x))?;
        let about = self.linear.about_rest(&self.model, &state, sites, x.as_slice());
        about.ok_or(FiniteError::NoRest { reached: 1. })
    }

    fn pose(&self, x: &DVector<f64>) -> Pose {
        self.linear.pose(self.model.face(), x.as_slice())
    }
}
