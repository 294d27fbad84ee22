//! The linear model of a face whose moduli and forces are multiples of its own.

use std::sync::Arc;

use super::{ForwardError, Model, assemble};
use crate::face::{Face, MuscleTissue};

/// Multiples of a face's moduli.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct ModulusFactors {
    /// Of the passive tissue's.
    pub tissue: f64,
    /// Of the muscle tissue's, at rest and contracted.
    pub muscle: f64,
}

/// `K(a) = t K_t + s K_s(a)`: stiffness is linear in the moduli, so that that of the passive tissue and that of muscle are
/// assembled once, for any factors `t` and `s`.
#[derive(Clone, Debug)]
pub struct ScaledModel {
    model: Model,
    /// `K_t`, on the pattern of the stiffness, N/mm.
    tissue: Vec<f64>,
}

impl ScaledModel {
    /// The model of `face`.
    ///
    /// # Errors
    /// Those of [`Model::new`].
    pub fn new(face: &Face) -> Result<Self, ForwardError> {
        let model = Model::new(face, Vec::new())?;
        let without_muscle = MuscleTissue { rest_kpa: 0., ..face.muscle_tissue };
        let (tissue, _) = assemble(&face.mesh, face.tissue, without_muscle, &face.muscles)?;
        Ok(Self { model, tissue: tissue.at(&[]) })
    }

    /// The model of the face as it is.
    pub fn model(&self) -> &Model {
        &self.model
    }

    /// The model with its moduli multiplied by `factors` and the greatest forces of its muscles by `forces` (m).
    pub fn at(&self, factors: ModulusFactors, forces: &[f64]) -> Model {
        let stiffness = self.model.stiffness().scaled(&self.tissue, factors.tissue, factors.muscle);
        let loads = self.model.loads().iter().zip(forces);
        let loads = loads.map(|(load, by)| load.iter().map(|&(dof, f)| (dof, by * f)).collect());
        self.model.with_stiffness(Arc::new(stiffness), Arc::new(loads.collect()))
    }

    /// `t K_t u` (3n), N: `dK/dlog t u`.
    pub fn tissue_force(&self, factors: ModulusFactors, u: &[f64]) -> Vec<f64> {
        let force = self.model.stiffness().pattern().multiply(&self.tissue, u);
        force.into_iter().map(|f| factors.tissue * f).collect()
    }
}
