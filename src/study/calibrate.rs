//! From known expressions to a face with other parameters.

use crate::calibration::{Calibration, CalibrationError, Expression, Parameters, StatedPrior};
use crate::certainty::Discrepancy;
use crate::face::{ContactReach, ContactSearch, Face, Pose};
use crate::forward::ScaledModel;
use crate::inverse::{Observations, Target};

/// A face that was calibrated.
#[derive(Clone, Debug)]
pub struct CalibratedFace {
    /// What was found.
    pub calibration: Calibration,
    /// The face with it.
    pub face: Face,
    /// How deep each expression's surfaces overlap beyond rest, mm.
    pub overlap_mm: Vec<f64>,
}

/// Calibrates `face` by targets whose priors say what was active, with their points on it; by linear strain, with stiffness
/// that follows the activations, and with `contact` unless that is off.
///
/// # Errors
/// [`CalibrationError`].
pub fn calibrate(
    face: &Face,
    targets: &[(&Target, &Observations)],
    stated: &[StatedPrior],
    discrepancy: Discrepancy,
    contact: bool,
) -> Result<CalibratedFace, CalibrationError> {
    let parameters = Parameters::of(face, stated)?;
    let muscles: Vec<String> = face.muscles.iter().map(|muscle| muscle.name.clone()).collect();
    let known =
        |(target, observations): &(&Target, &Observations)| Expression::new(target, observations, &muscles);
    let expressions: Vec<Expression> = targets.iter().map(known).collect::<Result<_, _>>()?;
    let search = ContactSearch::new(face, ContactReach::default());
    let model = ScaledModel::new(face)?;
    let touching = contact.then_some(&search);
    let calibration = Calibration::of(&model, &parameters, &expressions, discrepancy, touching)?;
    let overlap = |u: &[f64]| search.at(face, u, &Pose::rest()).overlap_mm();
    Ok(CalibratedFace {
        overlap_mm: calibration.expressions.iter().map(|e| overlap(&e.displacement)).collect(),
        face: parameters.apply(&calibration.theta, face.clone()),
        calibration,
    })
}
