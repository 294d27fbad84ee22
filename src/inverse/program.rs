//! Terms are summed and limits stacked into one quadratic program.

use nalgebra::{DMatrix, DVector};

use super::limit::{Constraint, Constraints, Limit, LimitName};
use super::term::{Row, State, Term, linear};
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

/// The objective about a state: `1/2 |r(x)|^2 + slope'x` with the residuals `r(x) = matrix x + value`.
#[derive(Clone, Debug, PartialEq)]
pub struct Objective {
    /// (rows x n).
    pub matrix: DMatrix<f64>,
    /// (rows).
    pub value: DVector<f64>,
    /// (n).
    pub slope: DVector<f64>,
}

/// The terms linearised about a state, before the unknowns are chosen.
#[derive(Clone, Debug, PartialEq)]
pub struct Linearisation {
    rows: Vec<Row>,
    slopes: Vec<(usize, f64)>,
    state: State,
}

impl Linearisation {
    /// `terms` about `state`.
    pub fn new<'a>(terms: impl IntoIterator<Item = &'a dyn Term>, state: &State) -> Self {
        let (mut rows, mut slopes) = (Vec::new(), Vec::new());
        for term in terms {
            rows.extend(term.rows(state));
            slopes.extend(term.slopes());
        }
        Self { rows, slopes, state: state.clone() }
    }

    /// `rows` and the `slope` (n), taken about `state`.
    pub(super) fn of_rows(rows: Vec<Row>, slope: &DVector<f64>, state: &State) -> Self {
        Self { rows, slopes: slope.iter().copied().enumerate().collect(), state: state.clone() }
    }

    /// These terms and `rows`, taken about the same state.
    pub(super) fn with(&self, rows: Vec<Row>) -> Self {
        let mut all = self.clone();
        all.rows.extend(rows);
        all
    }

    /// The objective over the unknowns of `space`.
    pub fn over(&self, space: &Space) -> Objective {
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
        let mut slope = DVector::zeros(n);
        self.slopes.iter().for_each(|&(k, by)| slope[k] += by);
        Objective { matrix: transposed.transpose(), value, slope }
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

    /// `1/2 |r|^2 + sum slope x` at `state`.
    pub fn objective(&self, state: &State) -> f64 {
        let squares = self.rows.iter().map(|row| 0.5 * self.residual(row, state).powi(2));
        squares.sum::<f64>() + linear(self.slopes.iter().copied(), &state.activation)
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

impl Objective {
    /// The residuals `r(x)`.
    pub fn at(&self, x: &DVector<f64>) -> DVector<f64> {
        &self.matrix * x + &self.value
    }

    /// `1/2 |r(x)|^2 + slope'x`.
    pub fn objective(&self, x: &DVector<f64>) -> f64 {
        0.5 * self.at(x).norm_squared() + self.slope.dot(x)
    }

    /// Its gradient (n) at `x`.
    pub fn gradient(&self, x: &DVector<f64>) -> DVector<f64> {
        self.matrix.tr_mul(&self.at(x)) + &self.slope
    }
}

/// The program `min 1/2 |r(x)|^2 + slope'x` under `limits`.
pub fn build(objective: &Objective, limits: &[&dyn Limit]) -> Program {
    let mut constraints = Constraints::none(objective.matrix.ncols());
    for limit in limits {
        limit.restrict(&mut constraints);
    }
    let (equality, equality_value, equality_names) = stack(&constraints.equality, constraints.n_unknowns());
    let (inequality, inequality_limit, inequality_names) =
        stack(&constraints.inequality, constraints.n_unknowns());
    Program {
        problem: Problem {
            hessian: objective.matrix.tr_mul(&objective.matrix),
            linear: objective.matrix.tr_mul(&objective.value) + &objective.slope,
            constant: 0.5 * objective.value.norm_squared(),
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
