//! A primal and dual point of a program.

use nalgebra::DVector;

use super::Problem;

/// Values of the variables and of the multipliers, with the signs of [`Problem`].
#[derive(Clone, Debug, PartialEq)]
pub struct Point {
    /// `x`.
    pub x: DVector<f64>,
    /// `y`, of `A x = b`.
    pub equality: DVector<f64>,
    /// `z >= 0`, of `G x <= h`.
    pub inequality: DVector<f64>,
    /// `z_lo >= 0`.
    pub lower: DVector<f64>,
    /// `z_hi >= 0`.
    pub upper: DVector<f64>,
}

impl Point {
    /// The point `x` (n) of `problem` with multipliers zero.
    pub fn at(problem: &Problem, x: DVector<f64>) -> Self {
        let n = x.len();
        Self {
            x,
            equality: DVector::zeros(problem.equality.nrows()),
            inequality: DVector::zeros(problem.inequality.nrows()),
            lower: DVector::zeros(n),
            upper: DVector::zeros(n),
        }
    }

    /// Whether every number is finite.
    pub fn is_finite(&self) -> bool {
        [&self.x, &self.equality, &self.inequality, &self.lower, &self.upper]
            .into_iter()
            .all(|v| v.iter().all(|value| value.is_finite()))
    }

    /// `A'y + G'z - z_lo + z_hi`.
    pub fn constraint_force(&self, problem: &Problem) -> DVector<f64> {
        problem.equality.tr_mul(&self.equality) + problem.inequality.tr_mul(&self.inequality) - &self.lower
            + &self.upper
    }

    /// `b'y + h'z - lo'z_lo + hi'z_hi`, absent bounds counting nothing.
    pub fn constraint_value(&self, problem: &Problem) -> f64 {
        let bound = |bounds: &DVector<f64>, multipliers: &DVector<f64>| -> f64 {
            bounds.iter().zip(multipliers.iter()).filter(|(b, _)| b.is_finite()).map(|(b, z)| b * z).sum()
        };
        problem.equality_value.dot(&self.equality) + problem.inequality_limit.dot(&self.inequality)
            - bound(&problem.lower, &self.lower)
            + bound(&problem.upper, &self.upper)
    }
}
