//! A quadratic program in stages, of which only neighbours know each other: the frames of a recording.

use nalgebra::{DMatrix, DVector};

/// A convex quadratic program over the stages `t` (f), each of `n` variables:
///
/// ```text
/// minimise    sum_t 1/2 x_t'P_t x_t + q_t'x_t  +  sum_t 1/2 (x_t+1 - x_t)' diag(w_t) (x_t+1 - x_t)
/// subject to  G_t x_t <= h_t                        multipliers z_t >= 0
///       lo <= x_t <= hi                             multipliers z_lo, z_hi >= 0
///             b x_t[i] + a x_t+1[i] <= l            multipliers y_t >= 0, a row a [`LinkRow`]
/// ```
#[derive(Clone, Debug, PartialEq)]
pub struct StagedProblem {
    /// The stages (f), at least one.
    pub stages: Vec<Stage>,
    /// What joins each stage to the next (f - 1).
    pub links: Vec<Link>,
}

/// One stage.
#[derive(Clone, Debug, PartialEq)]
pub struct Stage {
    /// `P` (n x n), symmetric positive definite.
    pub hessian: DMatrix<f64>,
    /// `q` (n).
    pub linear: DVector<f64>,
    /// `lo` (n), finite.
    pub lower: DVector<f64>,
    /// `hi` (n), finite, not below `lo`.
    pub upper: DVector<f64>,
    /// `G` (k x n).
    pub rows: DMatrix<f64>,
    /// `h` (k).
    pub limits: DVector<f64>,
}

/// What joins a stage to the next.
#[derive(Clone, Debug, PartialEq)]
pub struct Link {
    /// `w` (n), not negative.
    pub weight: DVector<f64>,
    /// Bounds of what a variable does from one stage to the next.
    pub rows: Vec<LinkRow>,
}

/// `before x_t[variable] + after x_t+1[variable] <= limit`.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct LinkRow {
    /// Which variable, from 0.
    pub variable: usize,
    /// Its factor in the earlier stage.
    pub before: f64,
    /// Its factor in the later stage, not zero.
    pub after: f64,
    /// What the sum may be at most.
    pub limit: f64,
}

/// Values and multipliers of a [`StagedProblem`].
#[derive(Clone, Debug, PartialEq)]
pub struct StagedPoint {
    /// Of each stage (f).
    pub stages: Vec<StagePoint>,
    /// `y`, of the rows of each link (f - 1).
    pub links: Vec<Vec<f64>>,
}

/// Values and multipliers of a stage.
#[derive(Clone, Debug, PartialEq)]
pub struct StagePoint {
    /// `x` (n).
    pub x: DVector<f64>,
    /// `z` (k).
    pub rows: DVector<f64>,
    /// `z_lo` (n).
    pub lower: DVector<f64>,
    /// `z_hi` (n).
    pub upper: DVector<f64>,
}

impl StagedProblem {
    /// Number `n` of variables of a stage.
    pub fn n_variables(&self) -> usize {
        self.stages.first().map_or(0, |stage| stage.linear.len())
    }

    /// The objective at `x` (f of n).
    pub fn objective<'a>(&self, x: impl Iterator<Item = &'a DVector<f64>> + Clone) -> f64 {
        let own =
            |(stage, x): (&Stage, &DVector<f64>)| 0.5 * x.dot(&(&stage.hessian * x)) + stage.linear.dot(x);
        let joined = |(link, (x, next)): (&Link, (&DVector<f64>, &DVector<f64>))| {
            link.weight.iter().zip((next - x).iter()).map(|(w, d)| 0.5 * w * d * d).sum::<f64>()
        };
        self.stages.iter().zip(x.clone()).map(own).sum::<f64>()
            + self.links.iter().zip(x.clone().zip(x.skip(1))).map(joined).sum::<f64>()
    }

    /// Slope of the objective by the variables of stage `t` at `point`, and the largest term that enters each.
    pub(super) fn slope(&self, point: &StagedPoint, t: usize) -> (DVector<f64>, DVector<f64>) {
        let (stage, x) = (&self.stages[t], &point.stages[t].x);
        let curved = &stage.hessian * x;
        let mut size = curved.abs().sup(&stage.linear.abs());
        let mut slope = curved + &stage.linear;
        let before = t.checked_sub(1).map(|s| (&self.links[s], &point.stages[s].x));
        let after = self.links.get(t).map(|link| (link, &point.stages[t + 1].x));
        for (link, other) in before.into_iter().chain(after) {
            for i in 0..x.len() {
                slope[i] += link.weight[i] * (x[i] - other[i]);
                size[i] = size[i].max(link.weight[i] * x[i].abs().max(other[i].abs()));
            }
        }
        (slope, size)
    }

    /// The largest violation of the optimality conditions at `point`, each divided by the largest term that enters it or by
    /// one where all are smaller, as in [`Certificate`](super::Certificate).
    pub fn worst(&self, point: &StagedPoint) -> f64 {
        let mut worst = 0_f64;
        let complementary = |multiplier: f64, slack: f64| multiplier.min(slack.max(0.)).max(0.);
        for (t, (stage, here)) in self.stages.iter().zip(&point.stages).enumerate() {
            let (mut slope, size) = self.slope(point, t);
            slope += stage.rows.tr_mul(&here.rows) - &here.lower + &here.upper;
            if let Some(s) = t.checked_sub(1) {
                for (row, y) in self.links[s].rows.iter().zip(&point.links[s]) {
                    slope[row.variable] += row.after * y;
                }
            }
            for (row, y) in
                self.links.get(t).into_iter().flat_map(|link| link.rows.iter().zip(&point.links[t]))
            {
                slope[row.variable] += row.before * y;
            }
            for i in 0..slope.len() {
                let scale = size[i].max(1.);
                let (below, above) = (here.x[i] - stage.lower[i], stage.upper[i] - here.x[i]);
                worst = worst.max(slope[i].abs() / scale).max(-below).max(-above);
                for (z, slack) in [(here.lower[i], below), (here.upper[i], above)] {
                    worst = worst.max(-z / scale).max(complementary(z / scale, slack));
                }
            }
            let slack = &stage.limits - &stage.rows * &here.x;
            for (k, &z) in here.rows.iter().enumerate() {
                let scale = stage.limits[k].abs().max(stage.rows.row(k).amax()).max(1.);
                let slack = slack[k] / scale;
                worst = worst.max(-slack).max(-z).max(complementary(z, slack));
            }
        }
        for (t, (link, y)) in self.links.iter().zip(&point.links).enumerate() {
            for (row, &y) in link.rows.iter().zip(y) {
                let slack = row.slack(&point.stages[t].x, &point.stages[t + 1].x);
                worst = worst.max(-slack).max(-y).max(complementary(y, slack));
            }
        }
        if worst.is_nan() { f64::INFINITY } else { worst }
    }
}

impl Stage {
    /// A stage without rows.
    pub fn boxed(
        hessian: DMatrix<f64>,
        linear: DVector<f64>,
        lower: DVector<f64>,
        upper: DVector<f64>,
    ) -> Self {
        let n = linear.len();
        Self { hessian, linear, lower, upper, rows: DMatrix::zeros(0, n), limits: DVector::zeros(0) }
    }
}

impl LinkRow {
    /// How far the sum is below its limit.
    pub(super) fn slack(&self, before: &DVector<f64>, after: &DVector<f64>) -> f64 {
        self.limit - self.before * before[self.variable] - self.after * after[self.variable]
    }
}
