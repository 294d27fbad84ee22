//! The interior-point solver Clarabel: the only file that knows it.

use clarabel::algebra::CscMatrix;
use clarabel::solver::{
    DefaultSettings, DefaultSolver, IPSolver, NonnegativeConeT, SecondOrderConeT, SolverStatus, ZeroConeT,
};
use nalgebra::DVector;

use super::extreme::EllipsoidInBox;
use super::staged::{StagePoint, StagedPoint, StagedProblem};
use super::{Point, Problem};

/// How the solver is asked; the later ones are for programs on which the earlier ones stall.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Effort {
    /// The program as scaled by us.
    Plain,
    /// Scaled once more by the solver.
    Rescaled,
    /// Rescaled, with shorter steps and more regularisation.
    Careful,
}

impl Effort {
    /// In the order to try.
    pub(super) const ALL: [Self; 3] = [Self::Plain, Self::Rescaled, Self::Careful];

    fn settings(self) -> DefaultSettings<f64> {
        let mut settings = DefaultSettings {
            verbose: false,
            presolve_enable: false,
            max_threads: 1,
            tol_gap_abs: 1e-12,
            tol_gap_rel: 1e-12,
            tol_feas: 1e-10,
            tol_infeas_abs: 1e-10,
            tol_infeas_rel: 1e-10,
            max_iter: 200,
            equilibrate_enable: self != Self::Plain,
            direct_solve_method: "qdldl".to_string(),
            // The default 1e-8 leaves a stationarity residual of some 1e-9 where the optimum is a face.
            static_regularization_constant: 1e-10,
            iterative_refinement_max_iter: 30,
            ..DefaultSettings::default()
        };
        if self == Self::Careful {
            settings.max_step_fraction = 0.9;
            settings.max_iter = 500;
            settings.static_regularization_constant = 1e-8;
            settings.iterative_refinement_max_iter = 50;
        }
        settings
    }
}

/// What the solver says, not yet believed.
pub(super) enum Outcome {
    /// A point, however accurate.
    Point(Point),
    /// Multipliers said to prove infeasibility.
    Infeasible(Point),
    /// A direction said to prove unboundedness.
    Unbounded(DVector<f64>),
    /// Nothing usable.
    Failed,
}

/// Rows of the solver's form `M x + s = v`, with `s = 0` in the first `zeros` rows and `s >= 0` below.
struct Rows {
    fixed: Vec<usize>,
    upper: Vec<usize>,
    lower: Vec<usize>,
    zeros: usize,
    matrix: CscMatrix<f64>,
    value: Vec<f64>,
}

impl Rows {
    fn of(problem: &Problem) -> Self {
        let n = problem.n_variables();
        let is_fixed = |j: &usize| problem.lower[*j] == problem.upper[*j];
        let fixed: Vec<_> = (0..n).filter(is_fixed).collect();
        let bounded = |bounds: &DVector<f64>| -> Vec<usize> {
            (0..n).filter(|j| bounds[*j].is_finite() && !is_fixed(j)).collect()
        };
        let (upper, lower) = (bounded(&problem.upper), bounded(&problem.lower));
        let (p, g) = (problem.equality.nrows(), problem.inequality.nrows());
        let zeros = p + fixed.len();
        let mut columns = vec![Vec::new(); n];
        for (j, column) in columns.iter_mut().enumerate() {
            column.extend((0..p).map(|i| (i, problem.equality[(i, j)])));
        }
        for (k, &j) in fixed.iter().enumerate() {
            columns[j].push((p + k, 1.0));
        }
        for (j, column) in columns.iter_mut().enumerate() {
            column.extend((0..g).map(|i| (zeros + i, problem.inequality[(i, j)])));
        }
        for (k, &j) in upper.iter().enumerate() {
            columns[j].push((zeros + g + k, 1.0));
        }
        for (k, &j) in lower.iter().enumerate() {
            columns[j].push((zeros + g + upper.len() + k, -1.0));
        }
        let value: Vec<f64> = problem
            .equality_value
            .iter()
            .copied()
            .chain(fixed.iter().map(|&j| problem.lower[j]))
            .chain(problem.inequality_limit.iter().copied())
            .chain(upper.iter().map(|&j| problem.upper[j]))
            .chain(lower.iter().map(|&j| -problem.lower[j]))
            .collect();
        let matrix = csc(value.len(), &columns);
        Self { fixed, upper, lower, zeros, matrix, value }
    }

    /// The solver's primal `x` and dual `z` with our names and signs.
    fn point(&self, problem: &Problem, x: &[f64], z: &[f64]) -> Point {
        let (p, g) = (problem.equality.nrows(), problem.inequality.nrows());
        let mut point = Point::at(problem, DVector::from_column_slice(x));
        point.equality.copy_from_slice(&z[..p]);
        point.inequality.copy_from_slice(&z[self.zeros..self.zeros + g]);
        for (k, &j) in self.fixed.iter().enumerate() {
            let multiplier = z[p + k];
            point.upper[j] = multiplier.max(0.0);
            point.lower[j] = (-multiplier).max(0.0);
        }
        let bounds = &z[self.zeros + g..];
        for (k, &j) in self.upper.iter().enumerate() {
            point.upper[j] = bounds[k];
        }
        for (k, &j) in self.lower.iter().enumerate() {
            point.lower[j] = bounds[self.upper.len() + k];
        }
        point
    }
}

/// Compressed columns from `(row, value)` lists in ascending rows, zeros left out.
fn csc(rows: usize, columns: &[Vec<(usize, f64)>]) -> CscMatrix<f64> {
    let (mut start, mut row, mut value) = (vec![0], Vec::new(), Vec::new());
    for column in columns {
        for &(i, v) in column.iter().filter(|(_, v)| *v != 0.0) {
            row.push(i);
            value.push(v);
        }
        start.push(row.len());
    }
    CscMatrix::new(rows, columns.len(), start, row, value)
}

/// Runs the solver on the scaled `problem`.
pub(super) fn solve(problem: &Problem, effort: Effort) -> Outcome {
    let n = problem.n_variables();
    let upper_triangle: Vec<Vec<(usize, f64)>> =
        (0..n).map(|j| (0..=j).map(|i| (i, problem.hessian[(i, j)])).collect()).collect();
    let rows = Rows::of(problem);
    let cones = [ZeroConeT(rows.zeros), NonnegativeConeT(rows.value.len() - rows.zeros)];
    let solver = DefaultSolver::new(
        &csc(n, &upper_triangle),
        problem.linear.as_slice(),
        &rows.matrix,
        &rows.value,
        &cones,
        effort.settings(),
    );
    let Ok(mut solver) = solver else { return Outcome::Failed };
    solver.solve();
    let solution = &solver.solution;
    let point = rows.point(problem, &solution.x, &solution.z);
    match solution.status {
        SolverStatus::PrimalInfeasible | SolverStatus::AlmostPrimalInfeasible => Outcome::Infeasible(point),
        SolverStatus::DualInfeasible | SolverStatus::AlmostDualInfeasible => Outcome::Unbounded(point.x),
        _ if point.is_finite() => Outcome::Point(point),
        _ => Outcome::Failed,
    }
}

/// A point of `problem`, not yet believed; `None` when the solver has none.
pub(super) fn solve_staged(problem: &StagedProblem) -> Option<StagedPoint> {
    let (f, n) = (problem.stages.len(), problem.n_variables());
    let mut hessian: Vec<Vec<(usize, f64)>> = Vec::with_capacity(f * n);
    for (t, stage) in problem.stages.iter().enumerate() {
        let links = [t.checked_sub(1).and_then(|s| problem.links.get(s)), problem.links.get(t)];
        for j in 0..n {
            let mut column = Vec::new();
            if let Some(link) = links[0] {
                column.push(((t - 1) * n + j, -link.weight[j]));
            }
            let joined: f64 = links.iter().flatten().map(|link| link.weight[j]).sum();
            column.extend(
                (0..=j).map(|i| (t * n + i, stage.hessian[(i, j)] + if i == j { joined } else { 0. })),
            );
            hessian.push(column);
        }
    }
    let linear: Vec<f64> = problem.stages.iter().flat_map(|s| s.linear.iter().copied()).collect();
    // Rows: those of each stage, its upper and its lower bounds, then those of the links.
    let mut columns = vec![Vec::new(); f * n];
    let mut value = Vec::new();
    for (t, stage) in problem.stages.iter().enumerate() {
        for (k, &limit) in stage.limits.iter().enumerate() {
            (0..n).for_each(|j| columns[t * n + j].push((value.len(), stage.rows[(k, j)])));
            value.push(limit);
        }
        for (bounds, sign) in [(&stage.upper, 1.), (&stage.lower, -1.)] {
            for j in 0..n {
                columns[t * n + j].push((value.len(), sign));
                value.push(sign * bounds[j]);
            }
        }
    }
    for (t, link) in problem.links.iter().enumerate() {
        for row in &link.rows {
            columns[t * n + row.variable].push((value.len(), row.before));
            columns[(t + 1) * n + row.variable].push((value.len(), row.after));
            value.push(row.limit);
        }
    }
    let (hessian, matrix) = (csc(f * n, &hessian), csc(value.len(), &columns));
    let cones = [NonnegativeConeT(value.len())];
    for effort in Effort::ALL {
        let Ok(mut solver) =
            DefaultSolver::new(&hessian, &linear, &matrix, &value, &cones, effort.settings())
        else {
            continue;
        };
        solver.solve();
        let solution = &solver.solution;
        if !matches!(solution.status, SolverStatus::Solved | SolverStatus::AlmostSolved) {
            continue;
        }
        let mut multipliers = solution.z.iter().copied();
        let mut take = |count: usize| DVector::from_iterator(count, multipliers.by_ref().take(count));
        let stages = problem.stages.iter().enumerate().map(|(t, stage)| {
            let x = DVector::from_column_slice(&solution.x[t * n..][..n]);
            let rows = take(stage.limits.len());
            let upper = take(n);
            StagePoint { x, rows, upper, lower: take(n) }
        });
        let stages = stages.collect();
        let links = problem.links.iter().map(|link| take(link.rows.len()).as_slice().to_vec()).collect();
        return Some(StagedPoint { stages, links });
    }
    None
}

/// The point of `set` with the least `f'x`, and the multipliers (k) of its ball.
pub(super) fn least(set: &EllipsoidInBox, f: &DVector<f64>) -> Option<(DVector<f64>, DVector<f64>)> {
    let (k, n) = set.ball.shape();
    // Rows: x <= hi, -x <= -lo; then (1, c - B x) in the cone.
    let columns: Vec<Vec<(usize, f64)>> = (0..n)
        .map(|j| {
            let ball = (0..k).map(|i| (2 * n + 1 + i, set.ball[(i, j)]));
            [(j, 1.), (n + j, -1.)].into_iter().chain(ball).collect()
        })
        .collect();
    let bounds = set.upper.iter().copied().chain(set.lower.iter().map(|lo| -lo));
    let value: Vec<f64> = bounds.chain([1.]).chain(set.centre.iter().copied()).collect();
    let cones = [NonnegativeConeT(2 * n), SecondOrderConeT(k + 1)];
    for effort in Effort::ALL {
        let settings = DefaultSettings { tol_gap_abs: 1e-9, tol_gap_rel: 1e-9, ..effort.settings() };
        let (hessian, matrix) = (csc(n, &vec![Vec::new(); n]), csc(value.len(), &columns));
        let Ok(mut solver) = DefaultSolver::new(&hessian, f.as_slice(), &matrix, &value, &cones, settings)
        else {
            continue;
        };
        solver.solve();
        let solution = &solver.solution;
        match solution.status {
            SolverStatus::Solved | SolverStatus::AlmostSolved => {
                let ball = solution.z[2 * n + 1..].iter().map(|v| -v);
                return Some((DVector::from_column_slice(&solution.x), DVector::from_iterator(k, ball)));
            }
            SolverStatus::PrimalInfeasible | SolverStatus::AlmostPrimalInfeasible => return None,
            _ => {}
        }
    }
    None
}
