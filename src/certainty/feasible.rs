//! The unknowns that fit as well as the noise allows.

use nalgebra::{DMatrix, DVector};

use super::limits::Limits;
use super::misfit::Misfit;

/// What the misfit may rise above the least: the 95 % quantile of chi-squared with one degree of freedom, for intervals
/// that each hold the truth in 95 of 100 cases (the profile likelihood).
pub(super) const RISE: f64 = 3.841_458_820_694_124;

/// All unknowns within the limits whose misfit is within [`RISE`] of the least: the feasible activations of Sohn,
/// McKay and Ting, J Biomech 46:1363 (2013), with the misfit as tolerance.
#[derive(Clone, Debug)]
pub(super) struct Feasible<'a> {
    limits: &'a Limits,
    ball: DMatrix<f64>,
    centre: DVector<f64>,
}

/// The extremes of a function over a feasible set, and the unknowns (k) there.
#[derive(Clone, Debug)]
pub(super) struct Range {
    pub(super) min: f64,
    pub(super) max: f64,
    pub(super) at_min: DVector<f64>,
    pub(super) at_max: DVector<f64>,
}

impl<'a> Feasible<'a> {
    /// Around the `best` unknowns.
    pub(super) fn new(misfit: &Misfit, limits: &'a Limits, best: &DVector<f64>) -> Self {
        let radius = (misfit.at(best) + RISE - misfit.rest).sqrt();
        Self { limits, ball: &misfit.matrix / radius, centre: &misfit.centre / radius }
    }

    /// The extremes of `f'y`; `None` where no program converges.
    pub(super) fn range(&self, f: &DVector<f64>) -> Option<Range> {
        let low = self.limits.extreme(&self.ball, &self.centre, f)?;
        let high = self.limits.extreme(&self.ball, &self.centre, &-f)?;
        Some(Range { min: low.value, max: -high.value, at_min: low.x, at_max: high.x })
    }
}
