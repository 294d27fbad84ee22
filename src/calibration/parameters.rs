//! What is calibrated.

use super::CalibrationError;
use crate::certainty::Discrepancy;
use crate::face::{Face, without_side};
use crate::forward::ModulusFactors;

/// A log-normal distribution of a factor.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct LogNormal {
    /// Its median.
    pub median: f64,
    /// Standard deviation of its logarithm; 0 is known exactly.
    pub spread: f64,
}

impl LogNormal {
    /// Medians that are accepted.
    pub const MEDIANS: [f64; 2] = [1e-3, 1e3];
    /// Greatest spread that is accepted.
    pub const WIDEST: f64 = 5.;
    /// Spread of a modulus. The skin and what is under it has 31 to 42 kPa at four places of sixteen faces (Luboz, Promayon and
    /// Payan 2014, hal-01092748), the standard face 15: logarithms of the ratios from 0.73 to 1.03.
    pub const MODULUS_SPREAD: f64 = 0.8;
    /// Spread of the muscles' stress: the standard face has 0.1 N/mm², human skeletal muscle 0.268 (Persad et al. 2024,
    /// 10.1152/japplphysiol.00296.2024): the logarithm of the ratio is 0.99.
    pub const STRESS_SPREAD: f64 = 0.8;
    /// Spread of one muscle's strength: how far two anatomists differ ([`Discrepancy::ANATOMY`]).
    pub const STRENGTH_SPREAD: f64 = Discrepancy::ANATOMY.strength;
}

/// What a parameter is a multiple of.
#[derive(Clone, Debug, PartialEq, Eq)]
pub enum Quantity {
    /// Young's modulus of the passive tissue.
    TissueModulus,
    /// The moduli of muscle tissue, at rest and contracted.
    MuscleModulus,
    /// The stress of all muscles: their greatest forces together.
    MuscleStress,
    /// The greatest force of the muscles of these numbers: of one muscle, or of both its sides.
    Strength(Vec<usize>),
}

/// A multiple of what the face has.
#[derive(Clone, Debug, PartialEq)]
pub struct Parameter {
    /// `tissue_modulus`, `muscle_modulus`, `muscle_stress`, or a muscle without its side.
    pub name: String,
    /// What it is a multiple of.
    pub quantity: Quantity,
    /// What is known of it before.
    pub prior: LogNormal,
}

/// A prior that replaces the default one.
#[derive(Clone, Debug, PartialEq)]
pub struct StatedPrior {
    /// The parameter, or [`Parameters::STRENGTH`] for every muscle.
    pub name: String,
    /// What is known.
    pub prior: LogNormal,
}

/// Everything that is calibrated on one face: `theta` (p) is the vector of the logarithms.
#[derive(Clone, Debug, PartialEq)]
pub struct Parameters {
    list: Vec<Parameter>,
    n_muscles: usize,
}

impl Parameters {
    /// Name of the strengths of all muscles in [`StatedPrior`].
    pub const STRENGTH: &str = "strength";

    /// Those of `face`, with the default priors about what it has but for the `stated` ones, the last of which counts.
    ///
    /// # Errors
    /// [`CalibrationError::UnknownParameter`], [`CalibrationError::Prior`], [`CalibrationError::NothingFree`].
    pub fn of(face: &Face, stated: &[StatedPrior]) -> Result<Self, CalibrationError> {
        let own = |spread| LogNormal { median: 1., spread };
        let global =
            |name: &str, quantity, spread| Parameter { name: name.to_owned(), quantity, prior: own(spread) };
        let mut list = vec![
            global("tissue_modulus", Quantity::TissueModulus, LogNormal::MODULUS_SPREAD),
            global("muscle_modulus", Quantity::MuscleModulus, LogNormal::MODULUS_SPREAD),
            global("muscle_stress", Quantity::MuscleStress, LogNormal::STRESS_SPREAD),
        ];
        for (k, muscle) in face.muscles.iter().enumerate() {
            let stem = without_side(&muscle.name);
            let known = list.iter_mut().find_map(|parameter| match &mut parameter.quantity {
                Quantity::Strength(muscles) if parameter.name == stem => Some(muscles),
                _ => None,
            });
            match known {
                Some(muscles) => muscles.push(k),
                None => list.push(global(stem, Quantity::Strength(vec![k]), LogNormal::STRENGTH_SPREAD)),
            }
        }
        for StatedPrior { name, prior } in stated {
            let [least, most] = LogNormal::MEDIANS;
            if !(least..=most).contains(&prior.median) || !(0. ..=LogNormal::WIDEST).contains(&prior.spread) {
                let (range, widest) = (LogNormal::MEDIANS, LogNormal::WIDEST);
                return Err(CalibrationError::Prior { name: name.clone(), range, widest });
            }
            let is_meant = |parameter: &&mut Parameter| match parameter.quantity {
                Quantity::Strength(_) => name == Self::STRENGTH || *name == parameter.name,
                _ => *name == parameter.name,
            };
            let mut found = false;
            for parameter in list.iter_mut().filter(is_meant) {
                (parameter.prior, found) = (*prior, true);
            }
            if !found {
                let mut known: Vec<&str> = list.iter().map(|parameter| parameter.name.as_str()).collect();
                known.push(Self::STRENGTH);
                let known = known.join(", ");
                return Err(CalibrationError::UnknownParameter { name: name.clone(), known });
            }
        }
        if list.iter().all(|parameter| parameter.prior.spread == 0.) {
            return Err(CalibrationError::NothingFree);
        }
        Ok(Self { list, n_muscles: face.muscles.len() })
    }

    /// Each of the `p` parameters: the moduli, the stress, the strengths in the order of the muscles.
    pub fn list(&self) -> &[Parameter] {
        &self.list
    }

    /// The logarithms (p) of the medians.
    pub fn medians(&self) -> Vec<f64> {
        self.list.iter().map(|parameter| parameter.prior.median.ln()).collect()
    }

    /// The multiples of the moduli at `theta` (p).
    pub fn moduli(&self, theta: &[f64]) -> ModulusFactors {
        let of = |quantity| {
            let mut all = self.list.iter().zip(theta);
            all.find(|(parameter, _)| parameter.quantity == quantity).map_or(1., |(_, log)| log.exp())
        };
        ModulusFactors { tissue: of(Quantity::TissueModulus), muscle: of(Quantity::MuscleModulus) }
    }

    /// The multiples (m) of the muscles' greatest forces at `theta` (p).
    pub fn forces(&self, theta: &[f64]) -> Vec<f64> {
        let mut logs = vec![0.; self.n_muscles];
        for (parameter, log) in self.list.iter().zip(theta) {
            match &parameter.quantity {
                Quantity::MuscleStress => logs.iter_mut().for_each(|sum| *sum += log),
                Quantity::Strength(muscles) => muscles.iter().for_each(|&muscle| logs[muscle] += log),
                Quantity::TissueModulus | Quantity::MuscleModulus => {}
            }
        }
        logs.into_iter().map(f64::exp).collect()
    }

    /// `face` with the parameters at `theta` (p).
    #[must_use]
    pub fn apply(&self, theta: &[f64], mut face: Face) -> Face {
        let ModulusFactors { tissue, muscle } = self.moduli(theta);
        face.tissue.young_kpa *= tissue;
        face.muscle_tissue.rest_kpa *= muscle;
        face.muscle_tissue.active_kpa *= muscle;
        for (muscle, factor) in face.muscles.iter_mut().zip(self.forces(theta)) {
            muscle.max_force_n *= factor;
        }
        face
    }
}
