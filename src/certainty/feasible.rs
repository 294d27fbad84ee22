//! The unknowns that fit as well as the noise allows.

use nalgebra::DVector;

use super::misfit::Misfit;
use crate::inverse::ActivationBounds;
use crate::qp::{EllipsoidInBox, Extreme};

/// Violation of the set, and difference between an extreme and what its multipliers prove, that rounding explains.
const FEASIBLE: f64 = 1e-6;

/// What the misfit may rise above the least: the 95 % quantile of chi-squared with one degree of freedom, for intervals
/// that each hold the truth in 95 of 100 cases (the profile likelihood).
pub(super) const RISE: f64 = 3.841_458_820_694_124;

/// All unknowns within their bounds whose misfit is within [`RISE`] of the least: the feasible activations of Sohn,
/// McKay and Ting, J Biomech 46:1363 (2013), with the misfit as tolerance.
#[derive(Clone, Debug)]
pub(super) struct Feasible(EllipsoidInBox);

/// The extremes of a function over a feasible set, and the unknowns (k) there.
#[derive(Clone, Debug)]
pub(super) struct Range {
    pub(super) min: f64,
    pub(super) max: f64,
    pub(super) at_min: DVector<f64>,
    pub(super) at_max: DVector<f64>,
}

impl Feasible {
    /// Around the `best` unknowns.
    pub(super) fn new(misfit: &Misfit, bounds: &ActivationBounds, best: &DVector<f64>) -> Self {
        let radius = (misfit.at(best) + RISE - misfit.rest).sqrt();
        Self(EllipsoidInBox {
            ball: &misfit.matrix / radius,
            centre: &misfit.centre / radius,
            lower: bounds.min.clone(),
            upper: bounds.max.clone(),
        })
    }

    /// The extremes of `f'y`; `None` where no program converges.
    pub(super) fn range(&self, f: &DVector<f64>) -> Option<Range> {
        let (low, high) = (self.0.least(f)?, self.0.least(&-f)?);
        let holds = |e: &Extreme| e.primal <= FEASIBLE && (e.value - e.bound).abs() <= FEASIBLE * f.amax();
        // What the multipliers prove bounds the interval from outside.
        (holds(&low) && holds(&high)).then(|| Range {
            min: low.bound.min(low.value),
            max: -high.bound.min(high.value),
            at_min: low.x,
            at_max: high.x,
        })
    }
}
