//! Contact whose gaps and normals are those of the deformed face.

use nalgebra::DVector;

use super::{ContactError, Equilibrium, FixedStiffness, contact_forces as forces_at};
use crate::contact::Pair;
use crate::face::{ContactReach, Face};

/// Linearisations of the gaps before giving up.
const MOST_ROUNDS: usize = 12;
/// Largest change of a displacement, mm, at which the gaps have settled.
const SETTLED_MM: f64 = 1e-3;
/// Deepest overlap, mm, that counts as none.
const TOUCHING_MM: f64 = 1e-2;

/// Where the tissue comes to rest against surfaces that are not planes.
#[derive(Clone, Debug)]
pub struct SettledContact {
    /// The candidates as last linearised.
    pub pairs: Vec<Pair>,
    /// Displacement and the forces of these pairs.
    pub equilibrium: Equilibrium,
    /// Deepest violation of the linearised gaps, mm.
    pub linear_penetration_mm: f64,
    /// Deepest overlap beyond that at rest, mm, measured on the surfaces of the deformed face.
    pub penetration_mm: f64,
    /// Linearisations made.
    pub rounds: usize,
    /// Whether displacement and gaps settled.
    pub settled: bool,
}

impl FixedStiffness<'_> {
    /// The equilibrium under `activation` (m) with gaps and normals linearised again where the tissue
    /// went, until they settle; where they do not, that with the least overlap. `rest` are the candidates
    /// at rest within `reach`.
    ///
    /// # Errors
    /// [`ContactError`] when no contact forces keep the gaps at rest open.
    pub fn settle(
        &self,
        face: &Face,
        reach: ContactReach,
        rest: &[Pair],
        activation: &[f64],
    ) -> Result<SettledContact, ContactError> {
        let mut now = self.linearised(rest.to_vec(), activation)?;
        let mut best: Option<SettledContact> = None;
        for rounds in 1..=MOST_ROUNDS {
            let (next, overlap) = face.contact_pairs_at(reach, rest, &now.equilibrium.displacement);
            (now.penetration_mm, now.rounds) = (overlap, rounds);
            if best.as_ref().is_none_or(|b| overlap < b.penetration_mm) {
                best = Some(now.clone());
            }
            let Ok(moved) = self.linearised(next, activation) else { break };
            let steps = now.equilibrium.displacement.iter().zip(&moved.equilibrium.displacement);
            let change = steps.fold(0f64, |c, (x, y)| c.max((x - y).abs()));
            if change <= SETTLED_MM && overlap <= TOUCHING_MM {
                now.settled = true;
                return Ok(now);
            }
            now = moved;
        }
        Ok(best.unwrap_or(now))
    }

    /// The equilibrium against `pairs` as they are linearised.
    fn linearised(&self, pairs: Vec<Pair>, activation: &[f64]) -> Result<SettledContact, ContactError> {
        let (mut contact_forces, mut deepest) = (DVector::zeros(0), 0f64);
        if let Some(contact) = self.response_with(&[], &pairs).contact {
            let a = DVector::from_column_slice(activation);
            contact_forces = forces_at(&contact, &a)?;
            let gaps = &contact.gap + &contact.approach * &a + &contact.compliance * &contact_forces;
            deepest = gaps.iter().fold(0., |deepest, gap| deepest.max(-gap));
        }
        let displacement = self.displacement_with(&pairs, activation, contact_forces.as_slice());
        Ok(SettledContact {
            pairs,
            equilibrium: Equilibrium { displacement, contact_forces },
            linear_penetration_mm: deepest,
            penetration_mm: 0.,
            rounds: 0,
            settled: false,
        })
    }
}
