//! What a limit is.

use nalgebra::DVector;

/// Which limit a row or bound of the program stands for.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum LimitName {
    /// `a_m >= min`.
    Least(usize),
    /// `a_m <= max`.
    Greatest(usize),
    /// `a_i = a_j`.
    Tied(usize, usize),
    /// `g_i = 0`.
    Touching(usize),
    /// `g_i >= 0`.
    Gap(usize),
    /// `lambda_i >= 0`.
    Force(usize),
}

/// One row over the unknowns `x` (n): `coefficients . x = value`, or `<= value`.
#[derive(Clone, Debug, PartialEq)]
pub struct Constraint {
    /// Coefficients (n).
    pub coefficients: DVector<f64>,
    /// Right-hand side.
    pub value: f64,
    /// What it stands for.
    pub name: LimitName,
}

/// The constraints of a program, stacked by its limits.
#[derive(Clone, Debug, PartialEq)]
pub struct Constraints {
    /// Rows `= value`.
    pub equality: Vec<Constraint>,
    /// Rows `<= value`.
    pub inequality: Vec<Constraint>,
    /// Least values (n).
    pub lower: DVector<f64>,
    /// Greatest values (n).
    pub upper: DVector<f64>,
}

impl Constraints {
    /// No constraint on `n` unknowns.
    pub fn none(n: usize) -> Self {
        Self {
            equality: Vec::new(),
            inequality: Vec::new(),
            lower: DVector::from_element(n, f64::NEG_INFINITY),
            upper: DVector::from_element(n, f64::INFINITY),
        }
    }

    /// Number of unknowns.
    pub fn n_unknowns(&self) -> usize {
        self.lower.len()
    }
}

/// A part of the constraints on the unknowns `x = (a, lambda)`.
pub trait Limit: std::fmt::Debug {
    /// Adds its rows and tightens its bounds.
    fn restrict(&self, constraints: &mut Constraints);
}
