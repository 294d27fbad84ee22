//! The statement of the quadratic program.

use nalgebra::{DMatrix, DVector};
use thiserror::Error;

/// Finite bounds this large are refused: solvers take them for infinity without saying so.
const LARGEST_BOUND: f64 = 1e20;
/// Asymmetry and negative curvature up to this share of the diagonal are rounding.
const ROUNDING: f64 = 1e-10;

/// A convex quadratic program in `n` variables.
///
/// ```text
/// minimise    1/2 x'Px + q'x + r
/// subject to  A x  = b        multipliers y, any sign
///             G x <= h        multipliers z >= 0
///        lo <=  x <= hi       multipliers z_lo, z_hi >= 0, zero where the bound is infinite
///
/// stationary  P x + q + A'y + G'z - z_lo + z_hi = 0
/// dual        -1/2 x'Px + r - b'y - h'z + lo'z_lo - hi'z_hi
/// ```
#[derive(Clone, Debug, PartialEq)]
pub struct Problem {
    /// `P` (n x n), symmetric positive semidefinite.
    pub hessian: DMatrix<f64>,
    /// `q` (n).
    pub linear: DVector<f64>,
    /// `r`.
    pub constant: f64,
    /// `A` (rows x n).
    pub equality: DMatrix<f64>,
    /// `b`.
    pub equality_value: DVector<f64>,
    /// `G` (rows x n).
    pub inequality: DMatrix<f64>,
    /// `h`, finite.
    pub inequality_limit: DVector<f64>,
    /// `lo` (n); `-inf` where there is none.
    pub lower: DVector<f64>,
    /// `hi` (n); `+inf` where there is none.
    pub upper: DVector<f64>,
}

/// A part of a [`Problem`], for messages.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Data {
    /// `P`.
    Hessian,
    /// `q`.
    Linear,
    /// `r`.
    Constant,
    /// `A`.
    Equality,
    /// `b`.
    EqualityValue,
    /// `G`.
    Inequality,
    /// `h`.
    InequalityLimit,
    /// `lo`.
    Lower,
    /// `hi`.
    Upper,
}

impl std::fmt::Display for Data {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        f.write_str(match self {
            Self::Hessian => "P",
            Self::Linear => "q",
            Self::Constant => "r",
            Self::Equality => "A",
            Self::EqualityValue => "b",
            Self::Inequality => "G",
            Self::InequalityLimit => "h",
            Self::Lower => "lo",
            Self::Upper => "hi",
        })
    }
}

/// Why a [`Problem`] is no convex quadratic program.
#[derive(Clone, Debug, PartialEq, Error)]
#[non_exhaustive]
pub enum ProblemError {
    /// A matrix or vector does not fit the others.
    #[error("{data} is {rows} x {columns}, but must be {expected_rows} x {expected_columns}")]
    Shape {
        /// Which one.
        data: Data,
        /// Its rows.
        rows: usize,
        /// Its columns.
        columns: usize,
        /// Rows it must have.
        expected_rows: usize,
        /// Columns it must have.
        expected_columns: usize,
    },
    /// NaN, or infinity where it has no meaning.
    #[error("{data}[{row}, {column}] is {value}; it must be a finite number")]
    NotFinite {
        /// Which matrix or vector.
        data: Data,
        /// Row, from 0.
        row: usize,
        /// Column, from 0.
        column: usize,
        /// The value.
        value: f64,
    },
    /// A finite bound that stands for infinity.
    #[error("{data}[{row}] is {value}; write an infinite bound for no bound")]
    HugeBound {
        /// `lo` or `hi`.
        data: Data,
        /// Variable, from 0.
        row: usize,
        /// The value.
        value: f64,
    },
    /// `P` differs from its transpose.
    #[error("P[{row}, {column}] is {value} but P[{column}, {row}] is {transposed}; P must be symmetric")]
    Asymmetric {
        /// Row, from 0.
        row: usize,
        /// Column, from 0.
        column: usize,
        /// The value there.
        value: f64,
        /// The value at the transposed place.
        transposed: f64,
    },
    /// `P` has negative curvature, so that a minimum need not exist.
    #[error(
        "P is indefinite: its curvature is {value} (scaled to a unit diagonal) along a direction mostly of variable {row}"
    )]
    Indefinite {
        /// Variable with the largest part in that direction, from 0.
        row: usize,
        /// The most negative eigenvalue of `P` scaled to a unit diagonal.
        value: f64,
    },
}

impl Problem {
    /// The program without constraints: `min 1/2 x'Px + q'x`.
    pub fn unconstrained(hessian: DMatrix<f64>, linear: DVector<f64>) -> Self {
        let n = linear.len();
        Self {
            hessian,
            linear,
            constant: 0.0,
            equality: DMatrix::zeros(0, n),
            equality_value: DVector::zeros(0),
            inequality: DMatrix::zeros(0, n),
            inequality_limit: DVector::zeros(0),
            lower: DVector::from_element(n, f64::NEG_INFINITY),
            upper: DVector::from_element(n, f64::INFINITY),
        }
    }

    /// Number `n` of variables.
    pub fn n_variables(&self) -> usize {
        self.linear.len()
    }

    /// `1/2 x'Px + q'x + r` at `x` (n).
    pub fn objective(&self, x: &DVector<f64>) -> f64 {
        0.5 * x.dot(&(&self.hessian * x)) + self.linear.dot(x) + self.constant
    }

    /// Checks shapes, numbers, symmetry and convexity.
    ///
    /// # Errors
    /// The first [`ProblemError`] found.
    pub fn validate(&self) -> Result<(), ProblemError> {
        self.check_shapes()?;
        self.check_numbers()?;
        self.check_convexity()
    }

    fn check_shapes(&self) -> Result<(), ProblemError> {
        let n = self.n_variables();
        let (p, g) = (self.equality.nrows(), self.inequality.nrows());
        let shapes = [
            (Data::Hessian, self.hessian.shape(), (n, n)),
            (Data::Equality, self.equality.shape(), (p, n)),
            (Data::EqualityValue, self.equality_value.shape(), (p, 1)),
            (Data::Inequality, self.inequality.shape(), (g, n)),
            (Data::InequalityLimit, self.inequality_limit.shape(), (g, 1)),
            (Data::Lower, self.lower.shape(), (n, 1)),
            (Data::Upper, self.upper.shape(), (n, 1)),
        ];
        for (data, (rows, columns), (expected_rows, expected_columns)) in shapes {
            if (rows, columns) != (expected_rows, expected_columns) {
                return Err(ProblemError::Shape { data, rows, columns, expected_rows, expected_columns });
            }
        }
        Ok(())
    }

    fn check_numbers(&self) -> Result<(), ProblemError> {
        let finite = |data, rows: usize, values: &[f64]| match values.iter().position(|v| !v.is_finite()) {
            Some(k) => {
                Err(ProblemError::NotFinite { data, row: k % rows, column: k / rows, value: values[k] })
            }
            None => Ok(()),
        };
        finite(Data::Hessian, self.hessian.nrows(), self.hessian.as_slice())?;
        finite(Data::Linear, self.linear.len(), self.linear.as_slice())?;
        finite(Data::Constant, 1, &[self.constant])?;
        finite(Data::Equality, self.equality.nrows(), self.equality.as_slice())?;
        finite(Data::EqualityValue, self.equality_value.len(), self.equality_value.as_slice())?;
        finite(Data::Inequality, self.inequality.nrows(), self.inequality.as_slice())?;
        finite(Data::InequalityLimit, self.inequality_limit.len(), self.inequality_limit.as_slice())?;
        for (data, bounds, absent) in
            [(Data::Lower, &self.lower, f64::NEG_INFINITY), (Data::Upper, &self.upper, f64::INFINITY)]
        {
            for (row, &value) in bounds.iter().enumerate().filter(|&(_, &value)| value != absent) {
                if !value.is_finite() {
                    return Err(ProblemError::NotFinite { data, row, column: 0, value });
                }
                if value.abs() >= LARGEST_BOUND {
                    return Err(ProblemError::HugeBound { data, row, value });
                }
            }
        }
        Ok(())
    }

    fn check_convexity(&self) -> Result<(), ProblemError> {
        let (p, n) = (&self.hessian, self.n_variables());
        for row in 0..n {
            for column in 0..row {
                let (value, transposed) = (p[(row, column)], p[(column, row)]);
                if (value - transposed).abs() > ROUNDING * (value.abs() + transposed.abs()) {
                    let size = (p[(row, row)] * p[(column, column)]).abs().sqrt();
                    if (value - transposed).abs() > ROUNDING * size {
                        return Err(ProblemError::Asymmetric { row, column, value, transposed });
                    }
                }
            }
        }
        if n == 0 {
            return Ok(());
        }
        for row in 0..n {
            let (diagonal, largest) = (p[(row, row)], p.row(row).amax());
            if diagonal < 0.0 || (diagonal == 0.0 && largest > 0.0) {
                return Err(ProblemError::Indefinite { row, value: -1.0 });
            }
        }
        // A unit diagonal makes the verdict independent of the units of the variables.
        let factor = DVector::from_fn(n, |i, _| if p[(i, i)] > 0.0 { 1.0 / p[(i, i)].sqrt() } else { 0.0 });
        let unit = DMatrix::from_fn(n, n, |i, j| 0.5 * (p[(i, j)] + p[(j, i)]) * factor[i] * factor[j]);
        let tolerance = ROUNDING * n as f64;
        let shifted = &unit + DMatrix::identity(n, n) * tolerance;
        if shifted.cholesky().is_some() {
            return Ok(());
        }
        let eigen = unit.symmetric_eigen();
        let (least, value) = eigen.eigenvalues.argmin();
        if value < -tolerance {
            return Err(ProblemError::Indefinite { row: eigen.eigenvectors.column(least).iamax(), value });
        }
        Ok(())
    }
}
