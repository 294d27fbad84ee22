//! How much effort to weigh: what the data say.

use argmin::core::{CostFunction, Error, Executor, IterState};
use argmin::solver::brent::{BrentOpt, BrentRoot};
use nalgebra::{Cholesky, DMatrix, DVector};

use super::NEGLIGIBLE;
use super::misfit::{Misfit, least_quadratic};
use crate::inverse::{ActivationBounds, EffortNorm, FreeUnknowns, TangentProgram};

/// Weights that are tried, as powers of ten: first, last, and steps a power.
const POWERS: [i32; 2] = [-6, 3];
const STEPS: i32 = 4;
/// Accuracy of the power of ten that is found.
const ACCURACY: f64 = 1e-3;
/// Iterations of Brent's methods.
const MOST_STEPS: u64 = 60;

/// Misfit against effort over the weight `w` of `w/2 sum c a^2` or `w sum c a`, on the tangent of an answer, and the weights
/// that three rules choose.
#[derive(Clone, Debug, PartialEq)]
pub struct EffortChoice {
    /// Which effort.
    pub norm: EffortNorm,
    /// The curve, weights ascending.
    pub curve: Vec<EffortPoint>,
    /// Weight at the corner of the L-curve: of the greatest curvature in logarithms (Hansen 1992).
    pub l_curve: f64,
    /// Weight of least generalised cross-validation (Golub, Heath and Wahba 1979), the unknowns at a bound taken to stay. With
    /// [`EffortNorm::L1`] the data determine as many unknowns as are not at a bound (Zou, Hastie and Tibshirani, On the degrees
    /// of freedom of the lasso, Ann Stat 35:2173, 2007): a number that jumps, so that the best weight of the curve is told.
    pub cross_validation: f64,
    /// Weight at which the misfit is as large as the noise makes it, one by component (Morozov 1966); `None` where it is
    /// larger, or smaller, whatever the weight.
    pub discrepancy: Option<f64>,
}

/// One weight.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct EffortPoint {
    /// The weight.
    pub weight: f64,
    /// Misfit in squared standard deviations.
    pub misfit: f64,
    /// Sum of the activations, or of their squares, by their costs.
    pub effort: f64,
    /// Generalised cross-validation.
    pub cross_validation: f64,
}

/// The fits of one misfit with any weight of the effort.
struct Regularised<'a> {
    misfit: &'a Misfit,
    bounds: &'a ActivationBounds,
    norm: EffortNorm,
    /// `c` (m).
    cost: &'a DVector<f64>,
    /// Activations of the free unknowns: `muscles y + offset`.
    muscles: DMatrix<f64>,
    offset: DVector<f64>,
}

impl EffortChoice {
    pub(super) fn of(program: &TangentProgram, free: &FreeUnknowns, misfit: &Misfit) -> Option<Self> {
        let (m, norm, cost) = (program.n_muscles(), program.effort_norm, &program.cost);
        let (muscles, offset) = (free.transform.rows(0, m).into_owned(), free.offset.rows(0, m).into_owned());
        if muscles.ncols() == 0 {
            return None;
        }
        let fits = Regularised { misfit, bounds: &free.bounds, norm, cost, muscles, offset };
        let powers = POWERS[0] * STEPS..=POWERS[1] * STEPS;
        let curve: Vec<EffortPoint> =
            powers.map(|k| fits.at(f64::from(k) / f64::from(STEPS))).collect::<Option<_>>()?;
        let corner = corner(&curve)?;
        let nearest = |of: &dyn Fn(&EffortPoint) -> f64| {
            (0..curve.len()).min_by(|&i, &j| of(&curve[i]).total_cmp(&of(&curve[j])))
        };
        let least = nearest(&|p| p.cross_validation)?;
        let power = |k: usize| curve[k].weight.log10();
        let around = [power(least.saturating_sub(1)), power((least + 1).min(curve.len() - 1))];
        let goal = misfit.components as f64;
        let crossed = curve.windows(2).find(|pair| pair[0].misfit <= goal && pair[1].misfit > goal);
        let cross_validation = match norm {
            EffortNorm::L1 => None,
            EffortNorm::L2 => fits.least_cross_validation(around),
        };
        let discrepancy =
            crossed.and_then(|pair| fits.of_misfit(goal, [pair[0].weight.log10(), pair[1].weight.log10()]));
        Some(Self {
            norm,
            l_curve: curve[corner].weight,
            cross_validation: cross_validation.map_or(curve[least].weight, |power| 10f64.powf(power)),
            discrepancy: discrepancy.map(|power| 10f64.powf(power)),
            curve,
        })
    }
}

/// The point of the greatest curvature of (log misfit, log effort), by circles through neighbours.
fn corner(curve: &[EffortPoint]) -> Option<usize> {
    const LEAST: f64 = 1e-12;
    let at = |k: usize| [curve[k].misfit, curve[k].effort].map(|x| x.max(LEAST).log10());
    let turn = |k: usize| {
        let ([ax, ay], [bx, by], [cx, cy]) = (at(k - 1), at(k), at(k + 1));
        let area = (bx - ax) * (cy - ay) - (by - ay) * (cx - ax);
        let sides = (bx - ax).hypot(by - ay) * (cx - bx).hypot(cy - by) * (cx - ax).hypot(cy - ay);
        if sides > 0. { 2. * area.abs() / sides } else { 0. }
    };
    (1..curve.len().checked_sub(1)?).max_by(|&i, &j| turn(i).total_cmp(&turn(j)).then(j.cmp(&i)))
}

impl Regularised<'_> {
    /// The fit with the weight `10^power`.
    fn at(&self, power: f64) -> Option<EffortPoint> {
        let weight = 10f64.powf(power);
        let squares = self.misfit.matrix.tr_mul(&self.misfit.matrix);
        let data = self.misfit.matrix.tr_mul(&self.misfit.centre);
        let weighed = DMatrix::from_diagonal(self.cost) * weight;
        let (hessian, linear) = match self.norm {
            EffortNorm::L1 => (squares.clone(), self.muscles.tr_mul(self.cost) * weight - data),
            EffortNorm::L2 => (
                &squares + self.muscles.tr_mul(&(&weighed * &self.muscles)),
                self.muscles.tr_mul(&(&weighed * &self.offset)) - data,
            ),
        };
        let y = least_quadratic(&hessian, &linear, self.bounds)?;
        let misfit = self.misfit.at(&y);
        let a = &self.muscles * &y + &self.offset;
        let effort = match self.norm {
            EffortNorm::L1 => self.cost.dot(&a),
            EffortNorm::L2 => self.cost.dot(&a.component_mul(&a)),
        };
        let inside = |k: &usize| {
            let (lo, hi) = (self.bounds.min[*k], self.bounds.max[*k]);
            y[*k] > lo + super::fitted::AT_LIMIT && y[*k] < hi - super::fitted::AT_LIMIT
        };
        let free: Vec<usize> = (0..y.len()).filter(inside).collect();
        let pick = |matrix: &DMatrix<f64>| matrix.select_rows(&free).select_columns(&free);
        let used = match (free.is_empty(), self.norm) {
            (true, _) => 0.,
            (false, EffortNorm::L1) => {
                let seen = self.misfit.matrix.select_columns(&free).singular_values();
                seen.iter().filter(|value| **value > NEGLIGIBLE * seen.amax()).count() as f64
            }
            (false, EffortNorm::L2) => Cholesky::new(pick(&hessian))?.solve(&pick(&squares)).trace(),
        };
        let components = self.misfit.components as f64;
        let left = (components - used).max(f64::MIN_POSITIVE);
        let cross_validation = components * misfit / (left * left);
        Some(EffortPoint { weight, misfit, effort, cross_validation })
    }

    fn least_cross_validation(&self, [lo, hi]: [f64; 2]) -> Option<f64> {
        let of = Of(|power: f64| self.at(power).map(|point| point.cross_validation));
        let solver = BrentOpt::new(lo, hi).set_tolerance(f64::EPSILON.sqrt(), ACCURACY);
        let run = Executor::new(of, solver)
            .configure(|state: IterState<f64, (), (), (), (), f64>| state.max_iters(MOST_STEPS))
            .timer(false)
            .run();
        run.ok()?.state.best_param
    }

    fn of_misfit(&self, goal: f64, [lo, hi]: [f64; 2]) -> Option<f64> {
        let of = Of(|power: f64| self.at(power).map(|point| point.misfit - goal));
        let run = Executor::new(of, BrentRoot::new(lo, hi, ACCURACY))
            .configure(|state: IterState<f64, (), (), (), (), f64>| {
                state.param((lo + hi) / 2.).max_iters(MOST_STEPS)
            })
            .timer(false)
            .run();
        run.ok()?.state.best_param
    }
}

/// A function of one number, for `argmin`.
struct Of<F>(F);

impl<F: Fn(f64) -> Option<f64>> CostFunction for Of<F> {
    type Param = f64;
    type Output = f64;

    fn cost(&self, power: &f64) -> Result<f64, Error> {
        (self.0)(*power).ok_or_else(|| Error::msg("no fit converges with this weight"))
    }
}
