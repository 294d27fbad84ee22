//! What the displacements of some points say of bounded unknowns.

use nalgebra::{DMatrix, DVector};

use super::feasible::Feasible;
use super::fitted::Fitted;
use super::misfit::Misfit;
use super::posterior::Posterior;
use super::{Discrepancy, SAMPLES};
use crate::inverse::{ActivationBounds, FreeUnknowns, TiedPairs};
use crate::units::Vec3;

/// Points of the face whose displacements were seen, and the tangent at the unknowns `x` (n) that explain them.
#[derive(Clone, Debug, PartialEq)]
pub struct SeenPoints {
    /// The points at rest (p), mm.
    pub points_mm: Vec<Vec3>,
    /// What the unknowns do to them (3p x n), mm; the first `n_muscles` are activations.
    pub map: DMatrix<f64>,
    /// How many of the unknowns are activations, `m`.
    pub n_muscles: usize,
    /// Seen less explained displacement (3p), mm.
    pub residual_mm: DVector<f64>,
    /// One over the standard deviation of each component (3p), 1/mm.
    pub weights: DVector<f64>,
    /// The unknowns of the answer (n).
    pub x: DVector<f64>,
    /// Their least and greatest values (n).
    pub bounds: ActivationBounds,
}

/// The intervals of unknowns, each of which holds the truth in 95 of 100 cases.
#[derive(Clone, Debug, PartialEq)]
pub struct Intervals {
    /// By how much all standard deviations had to be multiplied for the residuals to be likely; 1 where they are.
    pub noise_factor: f64,
    /// Least values whose misfit the noise allows (n).
    pub min: DVector<f64>,
    /// Greatest values whose misfit the noise allows (n).
    pub max: DVector<f64>,
}

impl SeenPoints {
    /// The intervals of the unknowns with a model as far from the face as `discrepancy`, as those of
    /// [`Certainty`](super::Certainty): by the misfit of what was seen alone. `None` when nothing was seen, or no program converges.
    pub fn intervals(&self, discrepancy: &Discrepancy) -> Option<Intervals> {
        if self.points_mm.is_empty() {
            return None;
        }
        let free = FreeUnknowns::new(&self.bounds, &TiedPairs::default());
        let m = self.n_muscles;
        let mut squares: DVector<f64> = self.x.rows(0, m).map(|a| a * a);
        if *discrepancy != Discrepancy::NONE {
            // What a muscle may do counts as well as what it does in the answer.
            let Fitted { misfit, best } =
                Fitted::of(self.misfit(&free, discrepancy, &squares)?, &free.bounds)?;
            if let Some(posterior) = Posterior::of(&misfit, &free.bounds, &best, SAMPLES[0]) {
                let mean = &free.transform * posterior.mean() + &free.offset;
                let covariance = &free.transform * posterior.covariance() * free.transform.transpose();
                squares = DVector::from_fn(m, |k, _| mean[k].powi(2) + covariance[(k, k)]);
            }
        }
        let Fitted { misfit, best } = Fitted::of(self.misfit(&free, discrepancy, &squares)?, &free.bounds)?;
        let feasible = Feasible::new(&misfit, &free.bounds, &best);
        let (mut min, mut max) = (self.x.clone(), self.x.clone());
        for k in 0..self.x.len() {
            let unit = free.transform.row(k).transpose();
            if unit.amax() == 0. {
                continue;
            }
            let (least, most) = match feasible.range(&unit) {
                Some(range) => (range.min, range.max),
                None => (self.bounds.min[k], self.bounds.max[k]),
            };
            // The answer has an effort and neighbours in time, and need not be where the misfit is least.
            min[k] = least.max(self.bounds.min[k]).min(self.x[k]);
            max[k] = most.min(self.bounds.max[k]).max(self.x[k]);
        }
        Some(Intervals { noise_factor: misfit.birge, min, max })
    }

    fn misfit(
        &self,
        free: &FreeUnknowns,
        discrepancy: &Discrepancy,
        squares: &DVector<f64>,
    ) -> Option<Misfit> {
        // map (x + y' - x) = residual:  matrix y = weighted (residual + map (x - offset)).
        let mut matrix = &self.map * &free.transform;
        matrix.column_iter_mut().for_each(|mut column| column.component_mul_assign(&self.weights));
        let target = (&self.residual_mm + &self.map * (&self.x - &free.offset)).component_mul(&self.weights);
        let mut noise = discrepancy.covariance(&self.points_mm, &self.map, squares);
        for (mut column, weight) in noise.column_iter_mut().zip(self.weights.iter()) {
            column.component_mul_assign(&(&self.weights * *weight));
        }
        noise += DMatrix::identity(target.len(), target.len());
        Misfit::white(&matrix, &target, noise)
    }
}
