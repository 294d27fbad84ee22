//! What the unknowns may be.

use nalgebra::{DMatrix, DVector};

use crate::inverse::{FreeUnknowns, TangentProgram};
use crate::qp::{self, Answer, BallSection, Extreme};

/// Rows added to the working set at once.
const BATCH: usize = 40;
/// How far below zero a slack may be, as a share of its row.
const ROUNDING: f64 = 1e-9;

/// Bounds and contacts over the free unknowns `y` (k): `lo <= y <= hi`, `slope y + offset >= 0`, the rows of length one.
#[derive(Clone, Debug)]
pub(super) struct Limits {
    pub(super) lower: DVector<f64>,
    pub(super) upper: DVector<f64>,
    /// (c x k).
    pub(super) slope: DMatrix<f64>,
    /// (c).
    pub(super) offset: DVector<f64>,
}

impl Limits {
    /// Those of `program`, which its answer satisfies.
    pub(super) fn of(program: &TangentProgram, free: &FreeUnknowns) -> Self {
        let slacks = program.slacks();
        let slope = &slacks.slope * &free.transform;
        let here = free.of(&program.x);
        let offset = slacks.offset + &slacks.slope * &free.offset;
        let lengths: Vec<f64> = slope.row_iter().map(|row| row.norm()).collect();
        let longest = lengths.iter().copied().fold(0., f64::max);
        // A row without length is a slack that nothing changes.
        let rows: Vec<usize> = (0..lengths.len()).filter(|&i| lengths[i] > ROUNDING * longest).collect();
        let unit = DMatrix::from_fn(rows.len(), slope.ncols(), |i, j| slope[(rows[i], j)] / lengths[rows[i]]);
        let values = DVector::from_fn(rows.len(), |i, _| offset[rows[i]] / lengths[rows[i]]);
        // The answer satisfies them up to rounding.
        let short = (&unit * here + &values).map(|slack| (-slack).max(0.));
        let bounds = &free.bounds;
        Self { lower: bounds.min.clone(), upper: bounds.max.clone(), slope: unit, offset: values + short }
    }

    fn violated(&self, y: &DVector<f64>, rows: &[usize]) -> Vec<usize> {
        let slack = &self.slope * y + &self.offset;
        let mut violated: Vec<usize> =
            (0..slack.len()).filter(|i| slack[*i] < -ROUNDING && !rows.contains(i)).collect();
        violated.sort_by(|&i, &j| slack[i].total_cmp(&slack[j]).then(i.cmp(&j)));
        violated.truncate(BATCH);
        violated
    }

    /// The least of `|M y - c|` within the limits.
    pub(super) fn least(&self, matrix: &DMatrix<f64>, centre: &DVector<f64>) -> Option<DVector<f64>> {
        let mut rows = Vec::new();
        loop {
            let problem = qp::Problem {
                hessian: matrix.tr_mul(matrix),
                linear: -matrix.tr_mul(centre),
                constant: 0.5 * centre.norm_squared(),
                equality: DMatrix::zeros(0, self.lower.len()),
                equality_value: DVector::zeros(0),
                inequality: -self.slope.select_rows(&rows),
                inequality_limit: self.offset.select_rows(&rows),
                lower: self.lower.clone(),
                upper: self.upper.clone(),
            };
            let solution = match qp::solve(&problem).ok()? {
                Answer::Solved(solution) | Answer::NotConverged(Some(solution)) => solution,
                _ => return None,
            };
            let violated = self.violated(&solution.point.x, &rows);
            if violated.is_empty() {
                return Some(solution.point.x);
            }
            rows.extend(violated);
        }
    }

    /// Where `f'y` is least within the limits and `|B y - c| <= 1`.
    pub(super) fn extreme(
        &self,
        ball: &DMatrix<f64>,
        centre: &DVector<f64>,
        f: &DVector<f64>,
    ) -> Option<Extreme> {
        let mut rows = Vec::new();
        loop {
            let section = BallSection {
                ball: ball.clone(),
                centre: centre.clone(),
                inequality: -self.slope.select_rows(&rows),
                inequality_limit: self.offset.select_rows(&rows),
                lower: self.lower.clone(),
                upper: self.upper.clone(),
            };
            let extreme = section.least(f)?;
            let violated = self.violated(&extreme.x, &rows);
            if violated.is_empty() {
                return Some(extreme);
            }
            rows.extend(violated);
        }
    }
}
