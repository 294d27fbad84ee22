//! What known expressions say about a face's parameters, and what they leave open.
//!
//! [`Expression`]: markers and the activations behind them -> [`Sensitivity`]: residuals and exact derivatives -> the
//! parameters that explain all of them best -> [`Calibration`]: each with what is known of it, and the
//! [`Combination`]s that the data determine.

mod combination;
mod error;
mod expression;
mod held_contact;
mod parameters;
mod search;
mod sensitivity;

use nalgebra::{Cholesky, DMatrix, DVector};

pub use combination::{Combination, per_cent};
pub use error::CalibrationError;
pub use expression::Expression;
pub use held_contact::HeldContact;
pub use parameters::{LogNormal, Parameter, Parameters, Quantity, StatedPrior};
pub use sensitivity::Sensitivity;

use self::search::{Found, Search, white};
use crate::certainty::Discrepancy;
use crate::face::ContactSearch;
use crate::forward::ScaledModel;

/// Share of the prior variance that the data must take away for a parameter to be theirs.
const RESOLVED: f64 = 0.5;
/// Correlation from which a trade is told, and how many are.
const TRADED: f64 = 0.5;
const NAMED: usize = 2;
/// Influence below this share of the strongest is none.
const NEGLIGIBLE: f64 = 1e-9;

/// How far the data determine a parameter.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Knowledge {
    /// It was held.
    Held,
    /// The muscle is active in no expression, or moves nothing that was observed: nothing is known but the prior.
    Unseen,
    /// The data took away less than half of the prior variance: it is mostly the prior's.
    Prior,
    /// The data did more.
    Data,
}

/// What is known of a parameter.
#[derive(Clone, Debug, PartialEq)]
pub struct Calibrated {
    /// What it is, and what was known before.
    pub parameter: Parameter,
    /// Its value: the multiple of what the face has.
    pub factor: f64,
    /// Standard deviation of its logarithm.
    pub spread: f64,
    /// `1 - spread^2 / prior spread^2`: the share of the prior variance that the data took away.
    pub resolution: f64,
    /// In a word.
    pub knowledge: Knowledge,
    /// What it trades against, the most correlated first: other parameters, and activations as `MUSCLE in EXPRESSION`, with
    /// their correlations.
    pub trades: Vec<(String, f64)>,
}

/// How well an expression is explained.
#[derive(Clone, Debug, PartialEq)]
pub struct Explained {
    /// Its name.
    pub name: String,
    /// Observed components.
    pub components: usize,
    /// Root mean square of the residuals, in the standard deviations of the markers, at the medians of the priors,
    pub rms_before: f64,
    /// and with what was found.
    pub rms_after: f64,
    /// Displacement (3n) with what was found, mm.
    pub displacement: Vec<f64>,
}

/// Parameters of a face, from expressions whose activations are known.
#[derive(Clone, Debug, PartialEq)]
pub struct Calibration {
    /// Each parameter (p).
    pub parameters: Vec<Calibrated>,
    /// What the data determine without priors, the best determined first, of the parameters that act.
    pub combinations: Vec<Combination>,
    /// Each expression.
    pub expressions: Vec<Explained>,
    /// By how much all standard deviations had to be multiplied for the residuals to be likely (Birge 1932); 1 where they are.
    pub noise_factor: f64,
    /// Whether the search ended where nothing moves.
    pub converged: bool,
    /// Logarithms (p) of the factors.
    pub theta: Vec<f64>,
}

impl Calibration {
    /// The most likely `parameters` of the face of `model` with the activations of the `expressions` uncertain as they state,
    /// and the distribution of the parameters about it.
    ///
    /// `contact` says what may touch; `None` is without contact.
    ///
    /// Errors of the activations are integrated out on the tangent: `M sigma_a^2 M'` is added to the covariance of the
    /// residuals. So is how far the model is from the face, but for its strength, which is what is sought. The posterior is
    /// the normal distribution of the logarithms with the covariance `(J' C^-1 J + S^-2)^-1`.
    ///
    /// # Errors
    /// [`CalibrationError`].
    pub fn of(
        model: &ScaledModel,
        parameters: &Parameters,
        expressions: &[Expression],
        discrepancy: Discrepancy,
        contact: Option<&ContactSearch>,
    ) -> Result<Self, CalibrationError> {
        if expressions.is_empty() {
            return Err(CalibrationError::NoExpression);
        }
        for (k, expression) in expressions.iter().enumerate() {
            if expressions[..k].iter().any(|other| other.name == expression.name) {
                return Err(CalibrationError::GivenTwice { expression: expression.name.clone() });
            }
        }
        let discrepancy = Discrepancy { strength: 0., ..discrepancy };
        let search = Search { model, parameters, expressions, discrepancy, contact };
        let found = search.run()?;
        let told = Told::new(parameters, &found)?;
        let rms = |at: &Sensitivity| (at.residual.norm_squared() / at.residual.len().max(1) as f64).sqrt();
        let explained = expressions.iter().zip(found.before.iter().zip(&found.at));
        let explained = explained.map(|(expression, (before, after))| Explained {
            name: expression.name.clone(),
            components: after.residual.len(),
            rms_before: rms(before),
            rms_after: rms(after),
            displacement: after.displacement.clone(),
        });
        let names: Vec<&str> = parameters.list().iter().map(|parameter| parameter.name.as_str()).collect();
        Ok(Self {
            parameters: told.parameters(parameters, expressions, &found),
            combinations: Combination::all(&names, &told.seen, &told.information),
            expressions: explained.collect(),
            noise_factor: told.noise_factor,
            converged: found.converged,
            theta: found.theta,
        })
    }
}

/// The distribution of the parameters about the most likely ones.
struct Told {
    /// Of the data, without priors (p x p).
    information: DMatrix<f64>,
    /// Of the posterior (p x p), zero for what is held.
    covariance: DMatrix<f64>,
    /// Parameters that are free and act.
    seen: Vec<usize>,
    noise_factor: f64,
}

impl Told {
    fn new(parameters: &Parameters, found: &Found) -> Result<Self, CalibrationError> {
        let p = parameters.list().len();
        let (mut information, mut misfit, mut rows) = (DMatrix::zeros(p, p), 0., 0);
        for (at, noise) in found.at.iter().zip(&found.noise) {
            let slopes = white(noise, &at.by_parameter);
            information += slopes.tr_mul(&slopes);
            misfit += noise.solve(&at.residual).dot(&at.residual);
            rows += at.residual.len();
        }
        let spread = |k: usize| parameters.list()[k].prior.spread;
        let free: Vec<usize> = (0..p).filter(|&k| spread(k) > 0.).collect();
        let posterior = |information: &DMatrix<f64>| -> Result<DMatrix<f64>, CalibrationError> {
            let scaled = |i: usize, j: usize| {
                information[(free[i], free[j])] * spread(free[i]) * spread(free[j])
                    + if i == j { 1. } else { 0. }
            };
            let precision = DMatrix::from_fn(free.len(), free.len(), scaled);
            let inverse = Cholesky::new(precision).map(|factor| factor.inverse()).ok_or_else(|| {
                CalibrationError::Search("the posterior is no distribution; a `sigma_mm` is too small".into())
            })?;
            let mut covariance = DMatrix::zeros(p, p);
            for (i, &row) in free.iter().enumerate() {
                for (j, &column) in free.iter().enumerate() {
                    covariance[(row, column)] = inverse[(i, j)] * spread(row) * spread(column);
                }
            }
            Ok(covariance)
        };
        let used = (posterior(&information)? * &information).trace();
        let freedom = rows as f64 - used;
        let ratio = if freedom > 0. { (misfit / freedom).max(1.) } else { 1. };
        information /= ratio;
        let most = information.diagonal().amax();
        let is_seen = |k: &usize| information[(*k, *k)] > (NEGLIGIBLE * NEGLIGIBLE) * most;
        let seen = free.iter().copied().filter(is_seen).collect();
        Ok(Self { covariance: posterior(&information)?, information, seen, noise_factor: ratio.sqrt() })
    }

    fn parameters(
        &self,
        parameters: &Parameters,
        expressions: &[Expression],
        found: &Found,
    ) -> Vec<Calibrated> {
        let p = parameters.list().len();
        let spread = |k: usize| self.covariance[(k, k)].max(0.).sqrt();
        let mut others: Vec<(String, DVector<f64>)> = (0..p)
            .map(|k| {
                let size = spread(k);
                let with = |i: usize| if size > 0. { self.covariance[(i, k)] / size } else { 0. };
                (parameters.list()[k].name.clone(), DVector::from_fn(p, |i, _| with(i)))
            })
            .collect();
        others.extend(self.with_activations(parameters, expressions, found));
        let of = |k: usize| {
            let parameter = parameters.list()[k].clone();
            let spread = spread(k);
            let prior = parameter.prior.spread;
            let resolution = if prior > 0. { (1. - (spread / prior).powi(2)).clamp(0., 1.) } else { 0. };
            let knowledge = match () {
                () if prior == 0. => Knowledge::Held,
                () if !self.seen.contains(&k) => Knowledge::Unseen,
                () if resolution < RESOLVED => Knowledge::Prior,
                () => Knowledge::Data,
            };
            let mut trades: Vec<(String, f64)> = others
                .iter()
                .enumerate()
                .filter(|(other, (_, with))| *other != k && spread > 0. && with[k].abs() >= TRADED * spread)
                .map(|(_, (name, with))| (name.clone(), with[k] / spread))
                .collect();
            trades.sort_by(|a, b| b.1.abs().total_cmp(&a.1.abs()));
            trades.truncate(NAMED);
            Calibrated { factor: found.theta[k].exp(), parameter, spread, resolution, knowledge, trades }
        };
        (0..p).map(of).collect()
    }

    /// Each activation, and its covariance (p) with the parameters by its own standard deviation: that of the joint
    /// distribution of which the activations are integrated out. Errors of the activations are as many times larger as all
    /// others where the noise was raised, so that what the residuals say of them is the same: `z = -E' C^-1 J theta + rest`.
    fn with_activations(
        &self,
        parameters: &Parameters,
        expressions: &[Expression],
        found: &Found,
    ) -> Vec<(String, DVector<f64>)> {
        let mut all = Vec::new();
        let ratio = self.noise_factor.powi(2);
        for (expression, (at, noise)) in expressions.iter().zip(found.at.iter().zip(&found.noise)) {
            let (slopes, errors) = (white(noise, &at.by_parameter), white(noise, &at.by_activation));
            // What the residuals say of the activations' errors, and what that leaves of them.
            let by_parameter = errors.tr_mul(&slopes);
            let covariance = -&self.covariance * by_parameter.transpose();
            let own = (DMatrix::identity(errors.ncols(), errors.ncols()) - errors.tr_mul(&errors)) * ratio
                + &by_parameter * &self.covariance * by_parameter.transpose();
            for (k, &muscle) in at.acting.iter().enumerate() {
                let size = own[(k, k)].max(0.).sqrt();
                let acts = parameters.list().iter().find(|parameter| match &parameter.quantity {
                    Quantity::Strength(muscles) => muscles.contains(&muscle),
                    _ => false,
                });
                if let Some(parameter) = acts.filter(|_| size > 0.) {
                    let name = format!("activation of {} in {}", parameter.name, expression.name);
                    all.push((name, covariance.column(k) / size));
                }
            }
        }
        all
    }
}
