//! The unknowns that fit best, and how large the noise is there.

use nalgebra::DVector;

use super::misfit::Misfit;
use crate::inverse::ActivationBounds;

/// Distance to a limit at which an unknown lies on it.
pub(super) const AT_LIMIT: f64 = 1e-6;

/// A misfit and the unknowns at which it is least.
#[derive(Clone, Debug)]
pub(super) struct Fitted {
    /// The misfit, its noise as large as the residuals say.
    pub(super) misfit: Misfit,
    /// The free unknowns (k) that fit best.
    pub(super) best: DVector<f64>,
}

impl Fitted {
    /// That of `misfit` within `bounds`; `None` where no program converges.
    pub(super) fn of(misfit: Misfit, bounds: &ActivationBounds) -> Option<Self> {
        let best = misfit.best(bounds)?;
        let within = best.iter().zip(bounds.min.iter().zip(bounds.max.iter()));
        let used = within.filter(|(y, (lo, hi))| **y > *lo + AT_LIMIT && **y < *hi - AT_LIMIT).count();
        let misfit = misfit.with_birge(&best, used);
        Some(Self { misfit, best })
    }
}
