//! The face in the frames of a recording that was fitted.

use rayon::prelude::*;

use super::{Strain, TrackError};
use crate::face::{ContactReach, ContactSearch, Face, Pose};
use crate::forward::Model;
use crate::forward::finite::{FaceContact, FiniteError, FiniteModel};
use crate::recording::{JawFreedom, Mechanism};

/// A face as a recording was fitted on it: what its muscles and its jaw do to all of it.
#[derive(Clone, Debug)]
pub struct TrackedFace {
    kind: Kind,
    /// Of what the jaw may do; at the held stiffness where one is held.
    mechanism: Mechanism,
}

#[derive(Clone, Debug)]
enum Kind {
    /// Activations (m) at which the stiffness is held; `None` where it follows them.
    Linear {
        model: Model,
        held: Option<Vec<f64>>,
    },
    Finite(FiniteModel),
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
    /// `face` with each muscle's stiffness held as at the activations `held` (m), or following them where that is `None`, as it does at
    /// finite strain; with contact where `has_contact` says.
    ///
    /// # Errors
    /// [`TrackError`] for a face that cannot be solved.
    pub fn new(
        face: &Face,
        strain: Strain,
        held: Option<&[f64]>,
        has_contact: bool,
    ) -> Result<Self, TrackError> {
        let pairs = match strain {
            Strain::Linear => contact_pairs(face, has_contact),
            Strain::Finite => Vec::new(),
        };
        let model = Model::new(face, pairs)?;
        // The freedom scales the unknowns of the jaw and bounds nothing here.
        let freedom = Some(JawFreedom::default());
        let at_rest = vec![0.; model.muscles().len()];
        let mechanism = Mechanism::new(&model.at(held.unwrap_or(&at_rest))?, &[], freedom);
        let kind = match strain {
            Strain::Linear => Kind::Linear { model, held: held.map(<[f64]>::to_vec) },
            Strain::Finite => Kind::Finite(finite_model(face, has_contact)?),
        };
        Ok(Self { kind, mechanism })
    }

    fn face(&self) -> &Face {
        match &self.kind {
            Kind::Linear { model, .. } => model.face(),
            Kind::Finite(model) => model.face(),
        }
    }

    /// The displacement (3n, mm) of the face at each of the `moments`, and where its bones are; at finite strain that of the
    /// face at rest. The same whatever the number of threads; `done` hears of each.
    ///
    /// # Errors
    /// [`TrackError`] when no contact forces hold it, or it is not found at rest.
    pub fn at(
        &self,
        moments: &[TrackedMoment<'_>],
        done: impl Fn(usize) + Sync,
    ) -> Result<Vec<(Vec<f64>, Pose)>, TrackError> {
        let freedom = Some(JawFreedom::default());
        let fixed = match &self.kind {
            Kind::Linear { model, held: Some(held) } => Some(model.at(held)?),
            _ => None,
        };
        let at = |moment: &TrackedMoment<'_>| {
            let mut x = moment.activation.to_vec();
            if let Some(JawFreedom { opening_mm, protrusion_mm, lateral_mm, .. }) = self.mechanism.jaw() {
                let [opening, forward, left] = moment.jaw_mm;
                x.extend([opening / opening_mm, forward / protrusion_mm, left / lateral_mm]);
            }
            let pose = self.mechanism.pose(self.face(), &x);
            let displacement = match (&self.kind, &fixed) {
                (Kind::Finite(model), _) => model.settle(moment.activation, &pose)?.displacement().to_vec(),
                (_, Some(fixed)) => self.mechanism.displacement(fixed, &x)?,
                (Kind::Linear { model, .. }, None) => {
                    let fixed = model.at(moment.activation)?;
                    Mechanism::about(&fixed, &[], freedom, &x)?.displacement(&fixed, &x)?
                }
            };
            done(1);
            Ok((displacement, pose))
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

/// `face` at finite strain, with contact where `has_contact` says.
///
/// # Errors
/// [`FiniteError`] when it cannot be modelled so.
pub(super) fn finite_model(face: &Face, has_contact: bool) -> Result<FiniteModel, FiniteError> {
    let contact = has_contact.then(|| FaceContact::new(face)).transpose()?;
    FiniteModel::new(face, contact)
}
