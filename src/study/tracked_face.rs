//! The face in the frames of a recording that was fitted.

use rayon::prelude::*;

use super::TrackError;
use crate::face::{ContactReach, ContactSearch, Face, Pose};
use crate::forward::Model;
use crate::recording::{JawFreedom, Mechanism};

/// A face at the stiffness at which a recording was fitted: what its muscles and its jaw do to all of it.
#[derive(Clone, Debug)]
pub struct TrackedFace {
    model: Model,
    /// Of what the jaw may do; at the held stiffness where one is held.
    mechanism: Mechanism,
    /// Activations (m) at which the stiffness is held; `None` where it follows them.
    held: Option<Vec<f64>>,
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
    /// `face` with each muscle's stiffness held as at the activations `held` (m), or following them where that is `None`, with
    /// contact where `has_contact` says.
    ///
    /// # Errors
    /// [`TrackError`] for a face that cannot be solved.
    pub fn new(face: &Face, held: Option<&[f64]>, has_contact: bool) -> Result<Self, TrackError> {
        let model = Model::new(face, contact_pairs(face, has_contact))?;
        // The freedom scales the unknowns of the jaw and bounds nothing here.
        let freedom = Some(JawFreedom::default());
        let at_rest = vec![0.; model.muscles().len()];
        let mechanism = Mechanism::new(&model.at(held.unwrap_or(&at_rest))?, &[], freedom);
        Ok(Self { model, mechanism, held: held.map(<[f64]>::to_vec) })
    }

    /// The displacement (3n, mm) of the face at each of the `moments`, and where its bones are. The same whatever the number
    /// of threads.
    ///
    /// # Errors
    /// [`TrackError`] when no contact forces hold it.
    pub fn at(&self, moments: &[TrackedMoment<'_>]) -> Result<Vec<(Vec<f64>, Pose)>, TrackError> {
        let freedom = Some(JawFreedom::default());
        let held = self.held.as_ref().map(|held| self.model.at(held)).transpose()?;
        let at = |moment: &TrackedMoment<'_>| {
            let mut x = moment.activation.to_vec();
            if let Some(JawFreedom { opening_mm, protrusion_mm, lateral_mm, .. }) = self.mechanism.jaw() {
                let [opening, forward, left] = moment.jaw_mm;
                x.extend([opening / opening_mm, forward / protrusion_mm, left / lateral_mm]);
            }
            let displacement = match &held {
                Some(fixed) => self.mechanism.displacement(fixed, &x)?,
                None => {
                    let fixed = self.model.at(moment.activation)?;
                    Mechanism::about(&fixed, &[], freedom, &x)?.displacement(&fixed, &x)?
                }
            };
            Ok((displacement, self.mechanism.pose(self.model.face(), &x)))
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
