//! Dimensionless equilibration.

use nalgebra::DVector;

use super::{Point, Problem};

/// Sweeps of the equilibration; each halves the spread in the logarithm.
const SWEEPS: usize = 25;

/// Powers of two that make a program dimensionless: `x = D x^`, rows times `E` and `F`, objective times `c`.
///
/// Ruiz equilibration of the matrix `[P A' G'; A 0 0; G 0 0]`. Powers of two make scaling and
/// unscaling exact. Source: Ruiz, "A scaling algorithm to equilibrate both rows and columns norms in
/// matrices", RAL-TR-2001-034.
#[derive(Clone, Debug)]
pub(super) struct Scaling {
    variable: DVector<f64>,
    equality: DVector<f64>,
    inequality: DVector<f64>,
    objective: f64,
}

fn power_of_two(value: f64) -> f64 {
    if value > 0.0 && value.is_finite() { value.log2().round().clamp(-500.0, 500.0).exp2() } else { 1.0 }
}

impl Scaling {
    /// The scaling of `problem`.
    pub(super) fn of(problem: &Problem) -> Self {
        let n = problem.n_variables();
        let mut scaling = Self {
            variable: DVector::from_element(n, 1.0),
            equality: DVector::from_element(problem.equality.nrows(), 1.0),
            inequality: DVector::from_element(problem.inequality.nrows(), 1.0),
            objective: 1.0,
        };
        for _ in 0..SWEEPS {
            scaling.sweep(problem);
        }
        // A bounded variable keeps a range of at least one, so that a primal residual is also small
        // against the range.
        for j in 0..n {
            let range = problem.upper[j] - problem.lower[j];
            if range.is_finite() && range > 0.0 {
                scaling.variable[j] = scaling.variable[j].min(range);
            }
        }
        scaling.variable.apply(|v| *v = power_of_two(*v));
        for (rows, factors) in
            [(&problem.equality, &mut scaling.equality), (&problem.inequality, &mut scaling.inequality)]
        {
            for (i, factor) in factors.iter_mut().enumerate() {
                *factor = power_of_two(1.0 / rows.row(i).transpose().component_mul(&scaling.variable).amax());
            }
        }
        let d = &scaling.variable;
        let curvature = (0..n)
            .flat_map(|j| (0..n).map(move |i| (i, j)))
            .map(|(i, j)| (problem.hessian[(i, j)] * d[i] * d[j]).abs())
            .fold(0.0, f64::max);
        let slope = problem.linear.component_mul(d).amax();
        scaling.objective = power_of_two(1.0 / curvature.max(slope));
        scaling
    }

    fn sweep(&mut self, problem: &Problem) {
        let d = self.variable.as_slice();
        let columns = problem.hessian.column_iter().zip(d);
        let mut column: Vec<f64> = columns.map(|(p, &own)| largest(p.as_slice(), d, own)).collect();
        for (rows, factors) in
            [(&problem.equality, &mut self.equality), (&problem.inequality, &mut self.inequality)]
        {
            let mut row = vec![0.0; factors.len()];
            for ((entries, &own), column) in rows.column_iter().zip(d).zip(&mut column) {
                for ((row, entry), factor) in row.iter_mut().zip(entries).zip(factors.iter()) {
                    *row = f64::max(*row, (entry * factor * own).abs());
                }
                *column = column.max(largest(entries.as_slice(), factors.as_slice(), own));
            }
            shrink(factors, &row);
        }
        shrink(&mut self.variable, &column);
    }

    /// The dimensionless program.
    pub(super) fn scale(&self, problem: &Problem) -> Problem {
        let (d, c) = (&self.variable, self.objective);
        let mut scaled = problem.clone();
        for j in 0..d.len() {
            for i in 0..d.len() {
                // The average keeps rounding in the caller's P from tilting the two halves.
                let p = 0.5 * (problem.hessian[(i, j)] + problem.hessian[(j, i)]);
                scaled.hessian[(i, j)] = p * d[i] * d[j] * c;
            }
            for i in 0..self.equality.len() {
                scaled.equality[(i, j)] *= self.equality[i] * d[j];
            }
            for i in 0..self.inequality.len() {
                scaled.inequality[(i, j)] *= self.inequality[i] * d[j];
            }
        }
        scaled.linear = problem.linear.component_mul(d) * c;
        scaled.constant = problem.constant * c;
        scaled.equality_value.component_mul_assign(&self.equality);
        scaled.inequality_limit.component_mul_assign(&self.inequality);
        scaled.lower.component_div_assign(d);
        scaled.upper.component_div_assign(d);
        scaled
    }

    /// A point of the dimensionless program in the caller's units.
    pub(super) fn unscale(&self, point: &Point) -> Point {
        let c = self.objective;
        Point {
            x: self.direction(&point.x),
            equality: point.equality.component_mul(&self.equality) / c,
            inequality: point.inequality.component_mul(&self.inequality) / c,
            lower: point.lower.component_div(&self.variable) / c,
            upper: point.upper.component_div(&self.variable) / c,
        }
    }

    /// The caller's point in dimensionless units.
    pub(super) fn scale_point(&self, point: &Point) -> Point {
        let c = self.objective;
        Point {
            x: point.x.component_div(&self.variable),
            equality: point.equality.component_div(&self.equality) * c,
            inequality: point.inequality.component_div(&self.inequality) * c,
            lower: point.lower.component_mul(&self.variable) * c,
            upper: point.upper.component_mul(&self.variable) * c,
        }
    }

    /// A direction of the dimensionless variables in the caller's units.
    pub(super) fn direction(&self, direction: &DVector<f64>) -> DVector<f64> {
        direction.component_mul(&self.variable)
    }
}

/// Largest `|entry factor own|` of a column, in lanes that need not wait for each other.
fn largest(entries: &[f64], factors: &[f64], own: f64) -> f64 {
    const LANES: usize = 8;
    let mut lanes = [0.0; LANES];
    for (entries, factors) in entries.chunks(LANES).zip(factors.chunks(LANES)) {
        for (lane, (entry, factor)) in lanes.iter_mut().zip(entries.iter().zip(factors)) {
            *lane = f64::max(*lane, (entry * factor * own).abs());
        }
    }
    lanes.into_iter().fold(0.0, f64::max)
}

/// Divides each factor by the root of what is the largest in its row or column, unless that is zero.
fn shrink(factors: &mut DVector<f64>, largest: &[f64]) {
    for (factor, &largest) in factors.iter_mut().zip(largest) {
        if largest > 0.0 {
            *factor /= largest.sqrt();
        }
    }
}
