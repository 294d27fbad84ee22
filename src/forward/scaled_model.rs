//! The linear model of a face whose moduli are multiples of its own.

use std::sync::Arc;

use super::{Cholesky, ForwardError, Model, SparseColumn, assemble};
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
/// assembled once, for any factors `t` and `s`. Without contact, bones at rest.
#[derive(Clone, Debug)]
pub struct ScaledModel {
    model: Model,
    /// `K_t`, on the pattern of the stiffness, N/mm.
    tissue: Vec<f64>,
}

/// A [`ScaledModel`] at one stiffness.
#[derive(Clone, Debug)]
pub struct ScaledStiffness<'m> {
    model: &'m Model,
    factors: ModulusFactors,
    /// `t K_t`, N/mm.
    tissue: Vec<f64>,
    /// `s K_s(a)`, N/mm.
    muscle: Vec<f64>,
    cholesky: Cholesky,
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

    /// The stiffness at activations `a` (m).
    ///
    /// # Errors
    /// [`ForwardError::NotPositiveDefinite`].
    pub fn at(&self, factors: ModulusFactors, a: &[f64]) -> Result<ScaledStiffness<'_>, ForwardError> {
        let tissue: Vec<f64> = self.tissue.iter().map(|k| factors.tissue * k).collect();
        let own = self.model.stiffness_at(a);
        let muscle: Vec<f64> = own.iter().zip(&self.tissue).map(|(k, t)| factors.muscle * (k - t)).collect();
        let whole: Vec<f64> = tissue.iter().zip(&muscle).map(|(t, s)| t + s).collect();
        let cholesky = Cholesky::new(Arc::clone(self.model.symbolic()), &whole)?;
        Ok(ScaledStiffness { model: &self.model, factors, tissue, muscle, cholesky })
    }
}

impl ScaledStiffness<'_> {
    /// `K^-1 f` (3n each, mm) of forces (3n each, N).
    pub fn displacements(&self, forces: &[Vec<f64>]) -> Vec<Vec<f64>> {
        self.cholesky.displacements(forces)
    }

    /// `F b` (3n), N, of amounts `b` (m).
    pub fn pull(&self, amounts: impl IntoIterator<Item = f64>) -> Vec<f64> {
        let mut force = vec![0.; self.model.n_dofs()];
        let add = |(load, amount): (&SparseColumn, f64)| {
            load.iter().for_each(|&(dof, f)| force[dof] += amount * f);
        };
        self.model.loads().iter().zip(amounts).for_each(add);
        force
    }

    /// `t K_t u` (3n), N: `dK/dlog t u`.
    pub fn tissue_force(&self, u: &[f64]) -> Vec<f64> {
        self.model.stiffness().pattern().multiply(&self.tissue, u)
    }

    /// `s K_s(a) u` (3n), N: `dK/dlog s u`.
    pub fn muscle_force(&self, u: &[f64]) -> Vec<f64> {
        self.model.stiffness().pattern().multiply(&self.muscle, u)
    }

    /// `dK/da_m u` (3n), N, of `muscle` at its activation `a`.
    pub fn stiffening(&self, muscle: usize, a: f64, u: &[f64]) -> Vec<f64> {
        let own = self.model.stiffening(muscle, a, u);
        own.into_iter().map(|force| self.factors.muscle * force).collect()
    }
}
