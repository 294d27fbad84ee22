//! The face in the frames of a recording that was fitted.

use rayon::prelude::*;

use super::TrackError;
use crate::face::{ContactReach, ContactSearch, Face, Pose};
use crate::forward::{FixedStiffness, Model};
use crate::recording::{JawFreedom, Mechanism};

/// A face at the stiffness at which a recording was fitted: what its muscles and its jaw do to all of it.
#[derive(Clone, Debug)]
pub struct TrackedFace {
    model: Model,
    mechanism: Mechanism,
    held: Vec<f64>,
}

/// Activations (m), and the jaw's opening, protrusion and shift to the left, mm.
#[derive(Clone, Copy, Debug)]
pub struct TrackedMoment<'a> {
    /// Activations (m).
    pub activation: &'a [f64],
    /// Where the jaw is, mm.
    pub jaw_mm: [f64; 3],
}

impl TrackedFace {
    /// `face` with each muscle's stiffness held as at the activations `held` (m), with contact where `has_contact` says.
    ///
    /// # Errors
    /// [`TrackError`] for a face that cannot be solved.
    pub fn new(face: &Face, held: &[f64], has_contact: bool) -> Result<Self, TrackError> {
        let model = Model::new(face, contact_pairs(face, has_contact))?;
        // The freedom scales the unknowns of the jaw and bounds nothing here.
        let mechanism = Mechanism::new(&model.at(held)?, &[], Some(JawFreedom::default()));
        Ok(Self { model, mechanism, held: held.to_vec() })
    }

    /// The displacement (3n, mm) of the face at each of the `moments`, and where its bones are. The same whatever the number
    /// of threads.
    ///
    /// # Errors
    /// [`TrackError`] when no contact forces hold it.
    pub fn at(&self, moments: &[TrackedMoment<'_>]) -> Result<Vec<(Vec<f64>, Pose)>, TrackError> {
        let fixed = self.model.at(&self.held)?;
        let at = |moment: &TrackedMoment<'_>| {
            let mut x = moment.activation.to_vec();
            if let Some(JawFreedom { opening_mm, protrusion_mm, lateral_mm, .. }) = self.mechanism.jaw() {
                let [opening, forward, left] = moment.jaw_mm;
                x.extend([opening / opening_mm, forward / protrusion_mm, left / lateral_mm]);
            }
            Ok((displacement(&fixed, &self.mechanism, &x)?, self.mechanism.pose(self.model.face(), &x)))
        };
        moments.par_iter().map(at).collect()
    }
}

/// The contact candidates of `face` at rest, where it has contact.
pub(super) fn contact_pairs(face: &Face, has_contact: bool) -> Vec<crate::contact::Pair> {
    match has_contact {
        true => ContactSearch::new(face, ContactReach::default()).rest().to_vec(),
        false => Vec::new(),
    }
}

/// The displacement (3n), mm, at the unknowns `x` (n) of `mechanism`.
pub(super) fn displacement(
    fixed: &FixedStiffness<'_>,
    mechanism: &Mechanism,
    x: &[f64],
) -> Result<Vec<f64>, TrackError> {
    let forces = mechanism.contact_forces(x)?;
    let mut u = fixed.displacement(&x[..mechanism.muscles.len()], &forces);
    let pose = mechanism.pose(fixed.model().face(), x);
    if !pose.is_rest() {
        u.iter_mut().zip(fixed.lifted_by(&pose)).for_each(|(u, lift)| *u += lift);
    }
    Ok(u)
}
