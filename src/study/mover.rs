//! What moves a face.

use super::{Mechanics, MovedContact, MovedFace, Stiffness, Strain, StudyError};
use crate::face::{ContactReach, ContactSearch, Face, Pose};
use crate::forward::Model;
use crate::forward::finite::{FaceContact, FiniteModel};

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
            (Strain::Finite, Stiffness::Activated) => {
                let contact = mechanics.contact.then(|| FaceContact::new(face)).transpose()?;
                Kind::Finite(FiniteModel::new(face, contact)?)
            }
        };
        Ok(Self { kind })
    }

    /// The face under the activations `a` (m) with its bones at `pose`.
    ///
    /// # Errors
    /// [`StudyError`] for activations outside [0, 1] and a face that does not come to rest.
    pub fn settle(&self, a: &[f64], pose: &Pose) -> Result<MovedFace, StudyError> {
        match &self.kind {
            Kind::Linear { model, search, stiffness } => {
                let held = match stiffness {
                    Stiffness::Activated => a.to_vec(),
                    Stiffness::Fixed(share) => vec![*share; a.len()],
                };
                let fixed = model.at_pose(&held, pose)?;
                let Some(search) = search else {
                    let displacement = fixed.displacement(a, &[]);
                    return Ok(MovedFace { displacement, contact: None, is_stable: true, cost: None });
                };
                let settled = fixed.settle(model.face(), search, a, None)?;
                let contact = Some(MovedContact::of_linear(model.face(), &settled));
                Ok(MovedFace {
                    displacement: settled.equilibrium.displacement,
                    contact,
                    is_stable: true,
                    cost: None,
                })
            }
            Kind::Finite(model) => {
                let state = model.settle(a, pose)?;
                let contact = MovedContact::of_finite(model.face(), &state);
                let displacement = state.displacement().to_vec();
                Ok(MovedFace {
                    displacement,
                    contact,
                    is_stable: state.is_stable(),
                    cost: Some(state.cost()),
                })
            }
        }
    }
}
