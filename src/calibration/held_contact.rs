//! The contact of an expression while parameters are sought.

use super::{CalibrationError, Expression};
use crate::contact::Pair;
use crate::face::ContactSearch;
use crate::forward::{Equilibrium, Model};

/// Candidates farther apart than this, mm, where contact was linearised are left out: parameters that move the face as far
/// have it linearised again.
const REACH_MM: f64 = 4.;

/// The contact candidates of an expression, their gaps and normals held where the face was found last.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct HeldContact {
    /// The candidates; none without contact.
    pub pairs: Vec<Pair>,
    /// Those that touched.
    pub touching: Vec<usize>,
}

impl HeldContact {
    /// No contact.
    pub fn none() -> Self {
        Self::default()
    }

    /// That of `expression` on `model`, where its face comes to rest on its true surfaces under contacts sought from `last`;
    /// `None` where those of `last` still hold.
    ///
    /// # Errors
    /// [`CalibrationError::Forward`], [`CalibrationError::Contact`].
    pub(super) fn renewed(
        model: &Model,
        search: &ContactSearch,
        expression: &Expression,
        last: Option<&Self>,
    ) -> Result<Option<Self>, CalibrationError> {
        let a = &expression.activation;
        let told = |error| CalibrationError::Contact { expression: expression.name.clone(), error };
        let model = model.with_pairs(last.map_or_else(Vec::new, |last| last.pairs.clone()));
        let stiff = model.at(a)?;
        let before = match last {
            Some(last) => Some(stiff.equilibrium_from(&last.touching).map_err(told)?),
            None => None,
        };
        if before.as_ref().is_some_and(|before| stiff.is_settled(model.face(), search, before)) {
            return Ok(None);
        }
        let start = before.as_ref().map(|before| before.displacement.as_slice());
        let settled = stiff.settle(model.face(), search, a, start).map_err(told)?;
        let Equilibrium { displacement, contact_forces } = settled.equilibrium;
        let is_near =
            |pair: &Pair, force: f64| force > 0. || pair.gap_mm + pair.change_mm(&displacement) <= REACH_MM;
        let near =
            settled.pairs.into_iter().zip(&contact_forces).filter(|(pair, force)| is_near(pair, **force));
        let (pairs, forces): (Vec<Pair>, Vec<f64>) = near.map(|(pair, force)| (pair, *force)).unzip();
        let touching = (0..forces.len()).filter(|&k| forces[k] > 0.).collect();
        Ok(Some(Self { pairs, touching }))
    }
}
