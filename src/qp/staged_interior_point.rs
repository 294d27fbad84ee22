//! An interior point for programs in stages: where no nearby active set is known.

use nalgebra::{Cholesky, DMatrix, DVector, Dyn};

use super::staged::{StagePoint, StagedPoint, StagedProblem};

/// Steps before giving up.
const STEPS: usize = 60;
/// Complementarity as a share of the largest number that enters the slopes, at which active sets show,
const CLOSE: f64 = 1e-18;
/// and at which they may show where no more can be had.
const NEAR: f64 = 1e-12;
/// Residuals, as shares of the largest number that enters them.
const RESIDUAL: f64 = 1e-10;
/// Share of the way to the boundary that a step goes at most.
const SHORT: f64 = 0.995;

/// One number for each constraint: of a stage its lower bounds (n), upper bounds (n) and rows (k); of a link its rows.
#[derive(Clone)]
struct PerConstraint {
    stages: Vec<DVector<f64>>,
    links: Vec<DVector<f64>>,
}

impl PerConstraint {
    fn parts(&self) -> impl Iterator<Item = &f64> {
        self.stages.iter().chain(&self.links).flat_map(|v| v.iter())
    }

    fn parts_mut(&mut self) -> impl Iterator<Item = &mut f64> {
        self.stages.iter_mut().chain(&mut self.links).flat_map(|v| v.iter_mut())
    }

    /// `f` of the numbers of both, constraint by constraint.
    fn with(&self, other: &Self, f: impl Fn(f64, f64) -> f64) -> Self {
        let pairs = |a: &[DVector<f64>], b: &[DVector<f64>]| -> Vec<DVector<f64>> {
            a.iter().zip(b).map(|(a, b)| a.zip_map(b, &f)).collect()
        };
        Self { stages: pairs(&self.stages, &other.stages), links: pairs(&self.links, &other.links) }
    }

    fn dot(&self, other: &Self) -> f64 {
        self.parts().zip(other.parts()).map(|(a, b)| a * b).sum()
    }

    /// The greatest share of the step `d`, at most 1, over which no number turns negative.
    fn reach(&self, d: &Self) -> f64 {
        let shares = self.parts().zip(d.parts()).filter(|(_, d)| **d < 0.).map(|(v, d)| -v / d);
        shares.fold(1., f64::min)
    }
}

/// `C x` with every constraint as `C x <= d`.
fn applied(problem: &StagedProblem, x: &[DVector<f64>]) -> PerConstraint {
    let stages = problem.stages.iter().zip(x).map(|(stage, x)| {
        let rows = &stage.rows * x;
        let both = x.iter().map(|v| -v).chain(x.iter().copied()).chain(rows.iter().copied());
        DVector::from_iterator(2 * x.len() + rows.len(), both)
    });
    let links = problem.links.iter().zip(x.windows(2)).map(|(link, x)| {
        let of = |row: &super::LinkRow| row.before * x[0][row.variable] + row.after * x[1][row.variable];
        DVector::from_iterator(link.rows.len(), link.rows.iter().map(of))
    });
    PerConstraint { stages: stages.collect(), links: links.collect() }
}

/// `C' w`.
fn transposed(problem: &StagedProblem, w: &PerConstraint) -> Vec<DVector<f64>> {
    let n = problem.n_variables();
    let stages = problem.stages.iter().zip(&w.stages);
    let mut sum: Vec<DVector<f64>> = stages
        .map(|(stage, w)| w.rows(n, n) - w.rows(0, n) + stage.rows.tr_mul(&w.rows(2 * n, stage.limits.len())))
        .collect();
    for (t, (link, w)) in problem.links.iter().zip(&w.links).enumerate() {
        for (row, w) in link.rows.iter().zip(w.iter()) {
            sum[t][row.variable] += row.before * w;
            sum[t + 1][row.variable] += row.after * w;
        }
    }
    sum
}

fn limits(problem: &StagedProblem) -> PerConstraint {
    let stages = problem.stages.iter().map(|stage| {
        let both = stage.lower.iter().map(|v| -v).chain(stage.upper.iter().copied());
        DVector::from_iterator(
            2 * stage.lower.len() + stage.limits.len(),
            both.chain(stage.limits.iter().copied()),
        )
    });
    let links =
        problem.links.iter().map(|l| DVector::from_iterator(l.rows.len(), l.rows.iter().map(|r| r.limit)));
    PerConstraint { stages: stages.collect(), links: links.collect() }
}

/// `P x` with what the links weigh.
fn curved(problem: &StagedProblem, x: &[DVector<f64>]) -> Vec<DVector<f64>> {
    let mut sum: Vec<DVector<f64>> =
        problem.stages.iter().zip(x).map(|(stage, x)| &stage.hessian * x).collect();
    for (t, link) in problem.links.iter().enumerate() {
        let pull = link.weight.component_mul(&(&x[t + 1] - &x[t]));
        sum[t] -= &pull;
        sum[t + 1] += pull;
    }
    sum
}

/// The factor of `P + C' diag(w) C`: block tridiagonal with couplings that are diagonal.
struct Factor {
    blocks: Vec<Cholesky<f64, Dyn>>,
    /// Between each stage and the next.
    couplings: Vec<DVector<f64>>,
}

impl Factor {
    fn new(problem: &StagedProblem, w: &PerConstraint) -> Option<Self> {
        let n = problem.n_variables();
        let mut couplings: Vec<DVector<f64>> = problem.links.iter().map(|link| -&link.weight).collect();
        let mut own: Vec<DMatrix<f64>> = problem
            .stages
            .iter()
            .zip(&w.stages)
            .map(|(stage, w)| {
                let mut block = stage.hessian.clone();
                for i in 0..n {
                    block[(i, i)] += w[i] + w[n + i];
                }
                for (k, row) in stage.rows.row_iter().enumerate() {
                    block.ger(w[2 * n + k], &row.transpose(), &row.transpose(), 1.);
                }
                block
            })
            .collect();
        for (t, (link, w)) in problem.links.iter().zip(&w.links).enumerate() {
            for i in 0..n {
                own[t][(i, i)] += link.weight[i];
                own[t + 1][(i, i)] += link.weight[i];
            }
            for (row, w) in link.rows.iter().zip(w.iter()) {
                let i = row.variable;
                own[t][(i, i)] += w * row.before * row.before;
                own[t + 1][(i, i)] += w * row.after * row.after;
                couplings[t][i] += w * row.before * row.after;
            }
        }
        let mut blocks: Vec<Cholesky<f64, Dyn>> = Vec::with_capacity(own.len());
        for (t, mut block) in own.into_iter().enumerate() {
            if let Some(before) = blocks.last() {
                let (inverse, coupling) = (inverse(before), &couplings[t - 1]);
                for j in 0..n {
                    for i in 0..n {
                        block[(i, j)] -= coupling[i] * inverse[(i, j)] * coupling[j];
                    }
                }
            }
            blocks.push(block.cholesky()?);
        }
        Some(Self { blocks, couplings })
    }

    fn solve(&self, mut value: Vec<DVector<f64>>) -> Vec<DVector<f64>> {
        for t in 1..value.len() {
            let carried = self.blocks[t - 1].solve(&value[t - 1]);
            value[t] -= self.couplings[t - 1].component_mul(&carried);
        }
        for t in (0..value.len()).rev() {
            if t + 1 < value.len() {
                let back = self.couplings[t].component_mul(&value[t + 1]);
                value[t] -= back;
            }
            self.blocks[t].solve_mut(&mut value[t]);
        }
        value
    }
}

/// `A^-1` from the factor of `A`: `L^-1`, whose columns begin at the diagonal, then `L^-T L^-1`.
fn inverse(factor: &Cholesky<f64, Dyn>) -> DMatrix<f64> {
    let lower = factor.l_dirty();
    let n = lower.nrows();
    let mut half = DMatrix::<f64>::identity(n, n);
    for (j, mut column) in half.column_iter_mut().enumerate() {
        let x = column.as_mut_slice();
        for k in j..n {
            let below = lower.view((k, k), (n - k, 1));
            let (own, rest) = x[k..].split_at_mut(1);
            own[0] /= below[0];
            rest.iter_mut().zip(below.iter().skip(1)).for_each(|(x, l)| *x -= own[0] * l);
        }
    }
    let mut whole = DMatrix::zeros(n, n);
    for j in 0..n {
        for i in j..n {
            let dot = half.view((i, i), (n - i, 1)).dot(&half.view((i, j), (n - i, 1)));
            (whole[(i, j)], whole[(j, i)]) = (dot, dot);
        }
    }
    whole
}

/// A point near the optimum of `problem`, by Mehrotra's predictor and corrector (1992, SIAM J Optim 2:575); `None` where it does
/// not come near.
pub(super) fn interior_point(problem: &StagedProblem) -> Option<StagedPoint> {
    let mut x: Vec<DVector<f64>> = problem.stages.iter().map(|s| 0.5 * (&s.lower + &s.upper)).collect();
    let limits = limits(problem);
    let mut slack = limits.with(&applied(problem, &x), |d, c| (d - c).max(0.1));
    let pull = problem.stages.iter().map(|s| s.linear.amax()).fold(1., f64::max);
    let mut multiplier = slack.with(&slack, |_, _| 0.1 * pull);
    let count = slack.parts().count() as f64;
    let mut best = None;
    for _ in 0..STEPS {
        let forces = transposed(problem, &multiplier);
        let dual: Vec<DVector<f64>> = curved(problem, &x)
            .into_iter()
            .zip(&problem.stages)
            .zip(&forces)
            .map(|((curved, stage), force)| curved + &stage.linear + force)
            .collect();
        let primal = applied(problem, &x).with(&slack, |c, s| c + s).with(&limits, |v, d| v - d);
        let gap = slack.dot(&multiplier) / count;
        let worst_dual = dual.iter().map(|v| v.amax()).fold(0., f64::max);
        let worst_primal = primal.parts().fold(0_f64, |w, v| w.max(v.abs()));
        if gap.is_nan() {
            return best;
        }
        if gap <= NEAR * pull && worst_dual <= RESIDUAL * pull && worst_primal <= RESIDUAL {
            best = Some(point(problem, x.clone(), &multiplier));
            if gap <= CLOSE * pull {
                return best;
            }
        }
        let Some(factor) = Factor::new(problem, &multiplier.with(&slack, |z, s| z / s)) else { return best };
        let step = |complement: &PerConstraint| {
            // (P + C'WC) dx = -r_d + C'((r_c - z r_p) / s)
            let push = complement
                .with(&multiplier.with(&primal, |z, p| z * p), |c, zp| c - zp)
                .with(&slack, |v, s| v / s);
            let value = transposed(problem, &push).into_iter().zip(&dual).map(|(c, d)| c - d).collect();
            let dx = factor.solve(value);
            let ds = applied(problem, &dx).with(&primal, |c, p| -p - c);
            let dz = complement
                .with(&multiplier.with(&ds, |z, ds| z * ds), |c, zds| -(c + zds))
                .with(&slack, |v, s| v / s);
            (dx, ds, dz)
        };
        let both = slack.with(&multiplier, |s, z| s * z);
        let (_, ds, dz) = step(&both);
        let (near, far) = (slack.reach(&ds), multiplier.reach(&dz));
        let after =
            slack.with(&ds, |s, d| s + near * d).dot(&multiplier.with(&dz, |z, d| z + far * d)) / count;
        let centre = (after / gap).powi(3) * gap;
        let corrected = both.with(&ds.with(&dz, |a, b| a * b), |sz, d| sz + d - centre);
        let (dx, ds, dz) = step(&corrected);
        let share = SHORT * slack.reach(&ds).min(multiplier.reach(&dz));
        x.iter_mut().zip(&dx).for_each(|(x, d)| x.axpy(share, d, 1.));
        slack.parts_mut().zip(ds.parts()).for_each(|(s, d)| *s += share * d);
        multiplier.parts_mut().zip(dz.parts()).for_each(|(z, d)| *z += share * d);
    }
    best
}

fn point(problem: &StagedProblem, x: Vec<DVector<f64>>, multiplier: &PerConstraint) -> StagedPoint {
    let n = problem.n_variables();
    let stages = x.into_iter().zip(&multiplier.stages).map(|(x, z)| StagePoint {
        lower: z.rows(0, n).into_owned(),
        upper: z.rows(n, n).into_owned(),
        rows: z.rows(2 * n, z.len() - 2 * n).into_owned(),
        x,
    });
    StagedPoint {
        stages: stages.collect(),
        links: multiplier.links.iter().map(|z| z.as_slice().to_vec()).collect(),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn an_inverse_is_one() {
        let half = DMatrix::from_fn(7, 7, |i, j| ((3 * i + 5 * j) % 7) as f64 - 2.);
        let matrix = half.tr_mul(&half) + DMatrix::identity(7, 7);
        let factor = matrix.clone().cholesky().expect("positive definite");
        assert!((inverse(&factor) * matrix - DMatrix::identity(7, 7)).amax() < 1e-12);
    }
}
