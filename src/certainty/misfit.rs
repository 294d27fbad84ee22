//! How badly unknowns fit what was observed, in the measure of its noise.

use nalgebra::{Cholesky, DMatrix, DVector, SVD};

use super::Discrepancy;
use crate::inverse::{ActivationBounds, FreeUnknowns, TangentProgram};
use crate::qp::{self, Answer};

/// `|M y - c|^2 + rest` over the free unknowns `y` (k), in which a residual of one standard deviation counts one.
#[derive(Clone, Debug)]
pub(super) struct Misfit {
    /// `M` (rows x k), rows <= k, singular values descending.
    pub(super) matrix: DMatrix<f64>,
    /// `c` (rows).
    pub(super) centre: DVector<f64>,
    /// What no unknowns explain.
    pub(super) rest: f64,
    /// Singular values of `M`, descending.
    pub(super) singular: DVector<f64>,
    /// By how much the noise was too small for the residuals: the square root of the misfit by degree of freedom where
    /// that is above one (Birge 1932); all of the above is divided by it.
    pub(super) birge: f64,
    /// Observed components.
    pub(super) components: usize,
}

impl Misfit {
    /// The misfit of the data of `program`, the noise of its markers increased by `discrepancy` of activations whose
    /// expected squares are `squares` (m); `None` without data.
    pub(super) fn of(
        program: &TangentProgram,
        free: &FreeUnknowns,
        discrepancy: &Discrepancy,
        squares: &DVector<f64>,
    ) -> Option<Self> {
        let data: Vec<usize> = program
            .shares()
            .iter()
            .filter(|share| share.part.is_data())
            .flat_map(|share| share.rows.clone())
            .collect();
        if data.is_empty() {
            return None;
        }
        let reduced = program.reduced();
        let matrix = reduced.matrix.select_rows(&data) * &free.transform;
        let value = reduced.at(&free.offset).select_rows(&data);
        let seen = program.by_observed().select_rows(&data);
        let model = discrepancy.covariance(&program.points_mm, &program.space().observed, squares);
        let noise = DMatrix::identity(data.len(), data.len()) + &seen * model * seen.transpose();
        Self::white(&matrix, &-value, noise)
    }

    /// That of data `matrix y = target` (rows x k), in standard deviations, whose errors have the covariance `noise`.
    pub(super) fn white(matrix: &DMatrix<f64>, target: &DVector<f64>, noise: DMatrix<f64>) -> Option<Self> {
        let factor = Cholesky::new(noise)?;
        let white = |m: &DMatrix<f64>| factor.l().solve_lower_triangular(m);
        let matrix = white(matrix)?;
        let target =
            white(&DMatrix::from_column_slice(target.len(), 1, target.as_slice()))?.column(0).into_owned();
        let components = target.len();
        if matrix.ncols() == 0 {
            let (matrix, centre, singular) = (DMatrix::zeros(0, 0), DVector::zeros(0), DVector::zeros(0));
            return Some(Self {
                matrix,
                centre,
                rest: target.norm_squared(),
                singular,
                birge: 1.,
                components,
            });
        }
        let SVD { u, v_t, singular_values } = matrix.svd(true, true);
        let (u, v_t) = (u?, v_t?);
        let centre = u.tr_mul(&target);
        let rest = (target.norm_squared() - centre.norm_squared()).max(0.);
        let matrix = DMatrix::from_diagonal(&singular_values) * v_t;
        Some(Self { matrix, centre, rest, singular: singular_values, birge: 1., components })
    }

    /// The misfit at `y` (k).
    pub(super) fn at(&self, y: &DVector<f64>) -> f64 {
        (&self.matrix * y - &self.centre).norm_squared() + self.rest
    }

    /// The unknowns `y` (k) that fit best within `bounds`.
    pub(super) fn best(&self, bounds: &ActivationBounds) -> Option<DVector<f64>> {
        let (hessian, linear) = (self.matrix.tr_mul(&self.matrix), -self.matrix.tr_mul(&self.centre));
        least_quadratic(&hessian, &linear, bounds)
    }

    /// The same with the noise as large as the misfit at the `best` unknowns says, `used` of which it determines.
    pub(super) fn with_birge(mut self, best: &DVector<f64>, used: usize) -> Self {
        let freedom = self.components.saturating_sub(used);
        if freedom == 0 {
            return self;
        }
        let ratio = (self.at(best) / freedom as f64).max(1.);
        self.birge = ratio.sqrt();
        self.matrix /= self.birge;
        self.centre /= self.birge;
        self.singular /= self.birge;
        self.rest /= ratio;
        self
    }
}

/// The least of `1/2 y'P y + q'y` within `bounds`; `None` where no program converges.
pub(super) fn least_quadratic(
    hessian: &DMatrix<f64>,
    linear: &DVector<f64>,
    bounds: &ActivationBounds,
) -> Option<DVector<f64>> {
    let k = bounds.min.len();
    let problem = qp::Problem {
        hessian: hessian.clone(),
        linear: linear.clone(),
        constant: 0.,
        equality: DMatrix::zeros(0, k),
        equality_value: DVector::zeros(0),
        inequality: DMatrix::zeros(0, k),
        inequality_limit: DVector::zeros(0),
        lower: bounds.min.clone(),
        upper: bounds.max.clone(),
    };
    match qp::solve(&problem).ok()? {
        Answer::Solved(solution) | Answer::NotConverged(Some(solution)) => Some(solution.point.x),
        _ => None,
    }
}
