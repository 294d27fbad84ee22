//! The parameters that explain the expressions best.

use std::sync::Mutex;

use argmin::core::{Error, Executor, IterState, Jacobian, Operator, State};
use argmin::solver::gaussnewton::GaussNewtonLS;
use argmin::solver::linesearch::BacktrackingLineSearch;
use argmin::solver::linesearch::condition::ArmijoCondition;
use nalgebra::{Cholesky, DMatrix, DVector, Dyn};
use rayon::prelude::*;

use super::{CalibrationError, Expression, HeldContact, Parameters, Sensitivity};
use crate::certainty::Discrepancy;
use crate::face::ContactSearch;
use crate::forward::ScaledModel;

/// Rounds of the covariance and of contact.
const MOST_ROUNDS: usize = 30;
/// Steps of Gauss and Newton within a round.
const MOST_STEPS: u64 = 30;
/// Change of the norm of the residuals that ends a round.
const LEAST_GAIN: f64 = 1e-10;
/// Step of a parameter, in standard deviations of its prior, that is none.
const STILL: f64 = 1e-5;
/// Slope of Armijo's condition. The search's cost is `|r|` and its slope that of `|r|^2 / 2`, which is `|r|` times as steep.
const ARMIJO: f64 = 1e-8;
/// Factor on a step that does not fall.
const SHORTER: f64 = 0.5;

/// The factor of the covariance of an expression's residuals.
pub(super) type Noise = Cholesky<f64, Dyn>;

/// What is asked of the parameters.
#[derive(Clone, Copy, Debug)]
pub(super) struct Search<'a> {
    pub(super) model: &'a ScaledModel,
    pub(super) parameters: &'a Parameters,
    pub(super) expressions: &'a [Expression],
    pub(super) discrepancy: Discrepancy,
    /// What may touch; `None` without contact.
    pub(super) contact: Option<&'a ContactSearch>,
}

/// Where the search ended.
#[derive(Debug)]
pub(super) struct Found {
    /// Logarithms (p) of the parameters.
    pub(super) theta: Vec<f64>,
    /// Each expression there,
    pub(super) at: Vec<Sensitivity>,
    /// and the factor of the covariance of its residuals.
    pub(super) noise: Vec<Noise>,
    /// Whether nothing moved any more.
    pub(super) converged: bool,
    /// Each expression at the medians of the priors.
    pub(super) before: Vec<Sensitivity>,
}

impl Search<'_> {
    /// The least of `sum_e r_e' C_e^-1 r_e + sum_p ((theta_p - mu_p) / s_p)^2`.
    ///
    /// The covariances `C_e` change with the parameters, and so do the gaps and normals of contact; they are held while
    /// Gauss-Newton steps with a backtracking line search go on, then taken anew, until contact holds on the true surfaces and
    /// a step from there with the covariances of there is none (iterated generalised least squares, Carroll and Ruppert 1988).
    pub(super) fn run(&self) -> Result<Found, CalibrationError> {
        let medians = self.parameters.medians();
        let spreads: Vec<f64> = self.parameters.list().iter().map(|p| p.prior.spread).collect();
        let free: Vec<usize> = (0..spreads.len()).filter(|&k| spreads[k] > 0.).collect();
        let mut x = DVector::zeros(free.len());
        let theta_at = |x: &DVector<f64>| {
            let mut theta = medians.clone();
            free.iter().zip(x.iter()).for_each(|(&k, x)| theta[k] += spreads[k] * x);
            theta
        };
        let mut contacts = self.contacts(&theta_at(&x), None)?.0;
        let (mut at, mut noise) = self.known(&theta_at(&x), &contacts)?;
        let before = at.clone();
        let (mut converged, mut is_renewed) = (false, self.contact.is_some());
        for round in 0..=MOST_ROUNDS {
            let posed = Posed {
                search: self,
                contacts: &contacts,
                noise: &noise,
                free: &free,
                spreads: &spreads,
                theta_at: &theta_at,
                last: Mutex::new(None),
            };
            converged = !is_renewed && posed.weigh(&x, &at).step() <= STILL;
            if converged || round == MOST_ROUNDS {
                break;
            }
            x = posed.least(x)?;
            (contacts, is_renewed) = self.contacts(&theta_at(&x), Some(contacts))?;
            (at, noise) = self.known(&theta_at(&x), &contacts)?;
        }
        Ok(Found { theta: theta_at(&x), at, noise, converged, before })
    }

    /// The contact of every expression at `theta` (p), sought from `last`, and whether any had to be linearised again.
    fn contacts(
        &self,
        theta: &[f64],
        last: Option<Vec<HeldContact>>,
    ) -> Result<(Vec<HeldContact>, bool), CalibrationError> {
        let Some(search) = self.contact else {
            return Ok((vec![HeldContact::none(); self.expressions.len()], false));
        };
        let model = self.model.at(self.parameters.moduli(theta), &self.parameters.forces(theta));
        let of = |(k, expression)| {
            HeldContact::renewed(&model, search, expression, last.as_ref().map(|last| &last[k]))
        };
        let renewed: Vec<Option<HeldContact>> =
            self.expressions.par_iter().enumerate().map(of).collect::<Result<_, _>>()?;
        let is_renewed = renewed.iter().any(Option::is_some);
        let kept = last.into_iter().flatten().map(Some).chain(std::iter::repeat(None));
        let all = renewed.into_iter().zip(kept).map(|(new, kept)| new.or(kept).unwrap_or_default());
        Ok((all.collect(), is_renewed))
    }

    /// Every expression at `theta` (p) against its contacts.
    fn at(&self, theta: &[f64], contacts: &[HeldContact]) -> Result<Vec<Sensitivity>, CalibrationError> {
        let of =
            |(expression, contact)| Sensitivity::of(self.model, self.parameters, expression, theta, contact);
        self.expressions.par_iter().zip(contacts).map(of).collect()
    }

    fn known(
        &self,
        theta: &[f64],
        contacts: &[HeldContact],
    ) -> Result<(Vec<Sensitivity>, Vec<Noise>), CalibrationError> {
        let at = self.at(theta, contacts)?;
        let noise =
            at.iter().zip(self.expressions).map(|(at, expression)| at.noise(expression, &self.discrepancy));
        let noise = noise.collect::<Option<Vec<_>>>().ok_or_else(|| {
            CalibrationError::Search(
                "the noise of an expression is no covariance; its `sigma_mm` is too small".into(),
            )
        })?;
        Ok((at, noise))
    }
}

/// `matrix` in the measure of a covariance: `L^-1 M`.
pub(super) fn white(noise: &Noise, matrix: &DMatrix<f64>) -> DMatrix<f64> {
    noise.l().solve_lower_triangular(matrix).unwrap_or_else(|| matrix.map(|_| f64::NAN))
}

/// Residuals and their derivatives at one point.
#[derive(Clone, Debug)]
struct Weighed {
    x: DVector<f64>,
    residual: DVector<f64>,
    jacobian: DMatrix<f64>,
}

impl Weighed {
    /// The largest component of a step of Gauss and Newton from here.
    fn step(&self) -> f64 {
        let normal = Cholesky::new(self.jacobian.tr_mul(&self.jacobian));
        normal.map_or(f64::INFINITY, |factor| factor.solve(&self.jacobian.tr_mul(&self.residual)).amax())
    }
}

/// Residuals over the free parameters `x`, in standard deviations from their medians, the covariances held.
struct Posed<'a, T> {
    search: &'a Search<'a>,
    contacts: &'a [HeldContact],
    noise: &'a [Noise],
    free: &'a [usize],
    spreads: &'a [f64],
    theta_at: &'a T,
    /// The solver asks for residuals and derivatives one by one.
    last: Mutex<Option<Weighed>>,
}

impl<T: Fn(&DVector<f64>) -> Vec<f64>> Posed<'_, T> {
    fn least(self, start: DVector<f64>) -> Result<DVector<f64>, CalibrationError> {
        let stopped = |error: Error| CalibrationError::Search(error.to_string());
        let armijo = ArmijoCondition::new(ARMIJO).map_err(stopped)?;
        let line = BacktrackingLineSearch::new(armijo).rho(SHORTER).map_err(stopped)?;
        let solver = GaussNewtonLS::new(line).with_tolerance(LEAST_GAIN).map_err(stopped)?;
        let run = Executor::new(self, solver)
            .configure(|state: IterState<DVector<f64>, DVector<f64>, DMatrix<f64>, (), (), f64>| {
                state.param(start).max_iters(MOST_STEPS)
            })
            .timer(false)
            .run()
            .map_err(stopped)?;
        let found = run.state.get_best_param().cloned();
        found.ok_or_else(|| CalibrationError::Search("no step was taken".into()))
    }

    /// The residuals at `x`, where the expressions are `at`.
    fn weigh(&self, x: &DVector<f64>, at: &[Sensitivity]) -> Weighed {
        let rows: usize = at.iter().map(|at| at.residual.len()).sum();
        let k = self.free.len();
        let mut residual = DVector::zeros(rows + k);
        let mut jacobian = DMatrix::zeros(rows + k, k);
        let mut row = 0;
        for (at, noise) in at.iter().zip(self.noise) {
            let r = at.residual.len();
            let value = DMatrix::from_column_slice(r, 1, at.residual.as_slice());
            residual.rows_mut(row, r).copy_from(&white(noise, &value).column(0));
            let slopes = white(noise, &at.by_parameter);
            for (column, &parameter) in self.free.iter().enumerate() {
                let scaled = slopes.column(parameter) * self.spreads[parameter];
                jacobian.view_mut((row, column), (r, 1)).copy_from(&scaled);
            }
            row += r;
        }
        residual.rows_mut(rows, k).copy_from(x);
        jacobian.view_mut((rows, 0), (k, k)).fill_with_identity();
        Weighed { x: x.clone(), residual, jacobian }
    }

    fn at(&self, x: &DVector<f64>) -> Result<Weighed, Error> {
        let mut last = self.last.lock().map_err(|_| Error::msg("a step was given up"))?;
        if let Some(known) = last.as_ref().filter(|known| known.x == *x) {
            return Ok(known.clone());
        }
        let weighed = self.weigh(x, &self.search.at(&(self.theta_at)(x), self.contacts)?);
        *last = Some(weighed.clone());
        Ok(weighed)
    }
}

impl<T: Fn(&DVector<f64>) -> Vec<f64>> Operator for Posed<'_, T> {
    type Param = DVector<f64>;
    type Output = DVector<f64>;

    fn apply(&self, x: &DVector<f64>) -> Result<DVector<f64>, Error> {
        Ok(self.at(x)?.residual)
    }
}

impl<T: Fn(&DVector<f64>) -> Vec<f64>> Jacobian for Posed<'_, T> {
    type Param = DVector<f64>;
    type Jacobian = DMatrix<f64>;

    fn jacobian(&self, x: &DVector<f64>) -> Result<DMatrix<f64>, Error> {
        Ok(self.at(x)?.jacobian)
    }
}
