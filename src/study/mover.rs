//! What moves a face.

use super::tangent::free_fields;
use super::tracked_face::finite_model;
use super::{Mechanics, MovedContact, MovedFace, MovedTangent, Stiffness, Strain, StudyError};
use crate::contact::Pair;
use crate::face::{ContactReach, ContactSearch, Face, Pose};
use crate::forward::Model;
use crate::forward::finite::FiniteModel;

/// A face with its mechanics: everything that does not depend on activations and pose.
#[derive(Clone, Debug)]
pub struct Mover {
    kind: Kind,
}

#[derive(Clone, Debug)]
enum Kind {
    Linear { model: Model, search: Option<Box<ContactSearch>>, stiffness: Stiffness },
    Finite(FiniteModel),
}

impl Mover {
    /// What moves `face` by `mechanics`.
    ///
    /// # Errors
    /// [`StudyError`] when the face cannot be modelled so.
    pub fn new(face: &Face, mechanics: Mechanics) -> Result<Self, StudyError> {
        let kind = match (mechanics.strain, mechanics.stiffness) {
            (Strain::Linear, stiffness) => {
                let search =
                    mechanics.contact.then(|| Box::new(ContactSearch::new(face, ContactReach::default())));
                let pairs = search.as_ref().map_or_else(Vec::new, |s| s.rest().to_vec());
                Kind::Linear { model: Model::new(face, pairs)?, search, stiffness }
            }
            (Strain::Finite, Stiffness::Fixed(share)) => {
                return Err(StudyError::FixedAtFiniteStrain { share });
            }
            (Strain::Finite, Stiffness::Activated) => Kind::Finite(finite_model(face, mechanics.contact)?),
        };
        Ok(Self { kind })
    }

    /// The face under the activations `a` (m) with its bones at `pose`.
    ///
    /// # Errors
    /// [`StudyError`] for activations outside [0, 1] and a face that does not come to rest.
    pub fn settle(&self, a: &[f64], pose: &Pose) -> Result<MovedFace, StudyError> {
        Ok(self.move_to(a, pose, false)?.moved)
    }

    /// The same with the fields that the muscles add from there.
    ///
    /// # Errors
    /// Those of [`settle`](Self::settle).
    pub fn tangent(&self, a: &[f64], pose: &Pose) -> Result<MovedTangent, StudyError> {
        self.move_to(a, pose, true)
    }

    /// The moved face, with no fields unless they are `wanted`.
    fn move_to(&self, a: &[f64], pose: &Pose, wanted: bool) -> Result<MovedTangent, StudyError> {
        match &self.kind {
            Kind::Linear { model, search, stiffness } => {
                let held = match stiffness {
                    Stiffness::Activated => a.to_vec(),
                    Stiffness::Fixed(share) => vec![*share; a.len()],
                };
                let fixed = model.at_pose(&held, pose)?;
                let follows = (*stiffness == Stiffness::Activated).then_some(a);
                let fields = |u: &[f64]| if wanted { free_fields(&fixed, follows, u) } else { Vec::new() };
                let Some(search) = search else {
                    let displacement = fixed.displacement(a, &[]);
                    let fields = fields(&displacement);
                    let moved = MovedFace { displacement, contact: None, is_stable: true, cost: None };
                    return Ok(MovedTangent { moved, fields });
                };
                let settled = fixed.settle(model.face(), search, a, None)?;
                let mut fields = fields(&settled.equilibrium.displacement);
                if wanted {
                    let forces = settled.equilibrium.contact_forces.iter();
                    let pushing = settled.pairs.iter().zip(forces).filter(|(_, force)| **force > 0.);
                    let touching: Vec<Pair> = pushing.map(|(pair, _)| pair.clone()).collect();
                    fixed.hold(&touching, &mut fields);
                }
                let contact = Some(MovedContact::of_linear(model.face(), &settled));
                let displacement = settled.equilibrium.displacement;
                let moved = MovedFace { displacement, contact, is_stable: true, cost: None };
                Ok(MovedTangent { moved, fields })
            }
            Kind::Finite(model) => {
                let state = model.settle(a, pose)?;
                let tangent = wanted.then(|| model.tangent(&state, None)).flatten();
                let fields = tangent.map_or_else(Vec::new, |tangent| tangent.fields().to_vec());
                let contact = MovedContact::of_finite(model.face(), &state);
                let displacement = state.displacement().to_vec();
                let (is_stable, cost) = (state.is_stable(), Some(state.cost()));
                Ok(MovedTangent { moved: MovedFace { displacement, contact, is_stable, cost }, fields })
            }
        }
    }
}
