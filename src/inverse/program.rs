//! Terms are summed and limits stacked into one quadratic program.

use nalgebra::{DMatrix, DVector};

use super::limit::{Constraint, Constraints, Limit, LimitName};
use super::term::{Row, State, Term};
use crate::qp::Problem;

/// How the unknowns `x` (n: first the `m` activations, then the share of the jaw's opening where that is unknown)
/// move the observed points:
/// `P u = observed x + offset`.
#[derive(Clone, Debug, PartialEq)]
pub struct Space {
    /// (d x n), mm per unit of each unknown.
    pub observed: DMatrix<f64>,
    /// (d), mm.
    pub offset: DVector<f64>,
}

impl Space {
    /// Number of unknowns.
    pub fn n_unknowns(&self) -> usize {
        self.observed.ncols()
    }

    /// `P u` at the unknowns `x` (n), mm.
    pub fn at(&self, x: &DVector<f64>) -> DVector<f64> {
        &self.observed * x + &self.offset
    }
}

/// A quadratic program whose rows know which limit they stand for.
#[derive(Clone, Debug, PartialEq)]
pub struct Program {
    /// The program.
    pub problem: Problem,
    /// Names of the equality rows.
    pub equality: Vec<LimitName>,
    /// Names of the inequality rows.
    pub inequality: Vec<LimitName>,
}

/// Residuals linearised about a state: `r(x) = matrix x + value`, for `1/2 |r|^2`.
#[derive(Clone, Debug, PartialEq)]
pub struct Residuals {
    /// (rows x n).
    pub matrix: DMatrix<f64>,
    /// (rows).
    pub value: DVector<f64>,
}

/// The terms linearised about a state, before the unknowns are chosen.
#[derive(Clone, Debug, PartialEq)]
pub struct Linearisation {
    rows: Vec<Row>,
    state: State,
}

impl Linearisation {
    /// `terms` about `state`.
    pub fn new<'a>(terms: impl IntoIterator<Item = &'a dyn Term>, state: &State) -> Self {
        Self { rows: terms.into_iter().flat_map(|term| term.rows(state)).collect(), state: state.clone() }
    }

    /// `rows`, taken about `state`.
    pub(super) fn of_rows(rows: Vec<Row>, state: &State) -> Self {
        Self { rows, state: state.clone() }
    }

    /// These terms and `rows`, taken about the same state.
    pub(super) fn with(&self, rows: Vec<Row>) -> Self {
        Self { rows: self.rows.iter().cloned().chain(rows).collect(), state: self.state.clone() }
    }

    /// The residuals over the unknowns of `space`.
    pub fn residuals(&self, space: &Space) -> Residuals {
        let n = space.n_unknowns();
        let mut transposed = DMatrix::zeros(n, self.rows.len());
        let mut value = DVector::zeros(self.rows.len());
        let by_point = space.observed.transpose();
        for (k, row) in self.rows.iter().enumerate() {
            let mut column = transposed.column_mut(k);
            value[k] = row.value;
            for &(point_row, weight) in &row.observed {
                column.axpy(weight, &by_point.column(point_row), 1.0);
                value[k] += weight * (space.offset[point_row] - self.state.observed[point_row]);
            }
            for &(muscle, weight) in &row.activation {
                column[muscle] += weight;
                value[k] -= weight * self.state.activation[muscle];
            }
        }
        Residuals { matrix: transposed.transpose(), value }
    }

    /// The residuals at the state.
    pub fn value(&self) -> DVector<f64> {
        DVector::from_iterator(self.rows.len(), self.rows.iter().map(|row| row.value))
    }

    /// Derivatives of the residuals by the `d` observed displacements (rows x d), 1/mm.
    pub fn by_observed(&self, d: usize) -> DMatrix<f64> {
        let mut derivatives = DMatrix::zeros(self.rows.len(), d);
        for (k, row) in self.rows.iter().enumerate() {
            for &(point_row, weight) in &row.observed {
                derivatives[(k, point_row)] += weight;
            }
        }
        derivatives
    }

    /// `1/2 |r|^2` at `state`.
    pub fn objective(&self, state: &State) -> f64 {
        self.rows.iter().map(|row| 0.5 * self.residual(row, state).powi(2)).sum()
    }

    fn residual(&self, row: &Row, state: &State) -> f64 {
        let by_point = |&(k, w): &(usize, f64)| w * (state.observed[k] - self.state.observed[k]);
        let by_muscle = |&(k, w): &(usize, f64)| w * (state.activation[k] - self.state.activation[k]);
        row.value
            + row.observed.iter().map(by_point).sum::<f64>()
            + row.activation.iter().map(by_muscle).sum::<f64>()
    }

    /// Gradient (d, 1/mm) of `1/2 |r|^2` by the observed displacements at `state`.
    pub fn observed_gradient(&self, state: &State) -> DVector<f64> {
        let mut gradient = DVector::zeros(state.observed.len());
        for row in &self.rows {
            let value = self.residual(row, state);
            for &(k, weight) in &row.observed {
                gradient[k] += weight * value;
            }
        }
        gradient
    }
}

impl Residuals {
    /// `r(x)`.
    pub fn at(&self, x: &DVector<f64>) -> DVector<f64> {
        &self.matrix * x + &self.value
    }

    /// `1/2 |r(x)|^2`.
    pub fn objective(&self, x: &DVector<f64>) -> f64 {
        0.5 * self.at(x).norm_squared()
    }
}

/// The program `min 1/2 |r(x)|^2` under `limits`.
pub fn build(residuals: &Residuals, limits: &[&dyn Limit]) -> Program {
    let mut constraints = Constraints::none(residuals.matrix.ncols());
    for limit in limits {
        limit.restrict(&mut constraints);
    }
    let (equality, equality_value, equality_names) = stack(&constraints.equality, constraints.n_unknowns());
    let (inequality, inequality_limit, inequality_names) =
        stack(&constraints.inequality, constraints.n_unknowns());
    Program {
        problem: Problem {
            hessian: residuals.matrix.tr_mul(&residuals.matrix),
            linear: residuals.matrix.tr_mul(&residuals.value),
            constant: 0.5 * residuals.value.norm_squared(),
            equality,
            equality_value,
            inequality,
            inequality_limit,
            lower: constraints.lower,
            upper: constraints.upper,
        },
        equality: equality_names,
        inequality: inequality_names,
    }
}

fn stack(rows: &[Constraint], n: usize) -> (DMatrix<f64>, DVector<f64>, Vec<LimitName>) {
    (
        DMatrix::from_fn(rows.len(), n, |i, j| rows[i].coefficients[j]),
        DVector::from_fn(rows.len(), |i, _| rows[i].value),
        rows.iter().map(|row| row.name).collect(),
    )
}
