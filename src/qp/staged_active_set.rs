//! An active set for programs in stages, begun from that of a program nearby.

use nalgebra::{Cholesky, DMatrix, DVector, Dyn};

use super::TOLERANCE;
use super::clarabel;
use super::staged::{Stage, StagePoint, StagedPoint, StagedProblem};
use super::staged_interior_point::interior_point;

/// Exchanges of an active set before an interior point is sought,
const HOT: usize = 10;
/// and of that of the interior point before it is given up.
const EXCHANGES: usize = 60;
/// Exchanges of all that is wrong of a stage without progress before single ones.
const PATIENCE: usize = 2;
/// Violations below this are rounding.
const ROUNDING: f64 = 1e-12;
/// A row of which less than this share is left when the others are held repeats them.
const REPEATED: f64 = 1e-12;

/// Where a variable is held.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
enum Hold {
    #[default]
    Free,
    Lower,
    Upper,
}

/// The constraints of a [`StagedProblem`] that hold as equalities.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub struct StagedActiveSet {
    holds: Vec<Vec<Hold>>,
    rows: Vec<Vec<bool>>,
    links: Vec<Vec<bool>>,
}

/// What was found.
#[derive(Clone, Debug)]
pub struct StagedSolution {
    /// Values and multipliers.
    pub point: StagedPoint,
    /// The largest violation of the optimality conditions, recomputed from the program.
    pub worst: f64,
    /// Active sets that were tried.
    pub exchanges: usize,
    /// Whether the interior-point solver had to find the active set.
    pub by_interior_point: bool,
}

impl StagedSolution {
    /// Whether the optimality conditions hold to [`TOLERANCE`].
    pub fn passes(&self) -> bool {
        self.worst <= TOLERANCE
    }
}

/// Solves `problem` from the active set `active`, which becomes that of the answer; an empty one is none.
///
/// Each active set leaves a linear system that is block tridiagonal in the stages and is solved by block elimination, its
/// blocks by Cholesky's method. Block principal pivoting (Portugal, Judice and Vicente 1994, Math Comp 63:625) exchanges all
/// that is violated in a stage at once while that makes progress there, then one by one. Where that takes long an interior
/// point of the same structure gives another active set to begin from, and where that fails Clarabel does. `None` when no point
/// was found; [`StagedSolution::passes`] says whether what was found is the optimum.
///
/// The cost is that of `f` dense factorisations of at most `n` plus the active rows of a stage for each active set tried.
pub fn solve_staged(problem: &StagedProblem, active: &mut StagedActiveSet) -> Option<StagedSolution> {
    active.fit(problem);
    let mut exchanges = 0;
    let mut best: Option<StagedSolution> = None;
    let finders: [fn(&StagedProblem) -> Option<StagedPoint>; 2] = [interior_point, clarabel::solve_staged];
    for finder in std::iter::once(None).chain(finders.map(Some)) {
        let by_interior_point = finder.is_some();
        let mut found = |point: StagedPoint, exchanges: usize| {
            let worst = problem.worst(&point);
            if best.as_ref().is_none_or(|b| worst < b.worst) {
                best = Some(StagedSolution { point, worst, exchanges, by_interior_point });
            }
            worst <= TOLERANCE
        };
        let within = match finder {
            None => HOT,
            Some(finder) => {
                let Some(near) = finder(problem) else { continue };
                *active = StagedActiveSet::of(problem, &near);
                // Where it is the optimum already it need not be sharpened for long.
                if found(near, exchanges) { HOT } else { EXCHANGES }
            }
        };
        if let Some(point) = pivot(problem, active, within, &mut exchanges) {
            found(point, exchanges);
        }
        if best.as_ref().is_some_and(StagedSolution::passes) {
            break;
        }
    }
    best
}

impl StagedActiveSet {
    /// A constraint is active when its multiplier exceeds its slack.
    fn of(problem: &StagedProblem, point: &StagedPoint) -> Self {
        let hold = |stage: &Stage, here: &StagePoint, i: usize| {
            if here.lower[i] > here.x[i] - stage.lower[i] {
                Hold::Lower
            } else if here.upper[i] > stage.upper[i] - here.x[i] {
                Hold::Upper
            } else {
                Hold::Free
            }
        };
        let stages = || problem.stages.iter().zip(&point.stages);
        Self {
            holds: stages().map(|(s, p)| (0..p.x.len()).map(|i| hold(s, p, i)).collect()).collect(),
            rows: stages()
                .map(|(s, p)| {
                    let slack = &s.limits - &s.rows * &p.x;
                    p.rows.iter().zip(slack.iter()).map(|(z, slack)| z > slack).collect()
                })
                .collect(),
            links: (0..problem.links.len())
                .map(|t| {
                    let (x, next) = (&point.stages[t].x, &point.stages[t + 1].x);
                    let rows = problem.links[t].rows.iter().zip(&point.links[t]);
                    rows.map(|(row, y)| *y > row.slack(x, next)).collect()
                })
                .collect(),
        }
    }

    /// That of a program with more stages, each of which begins from one of these, `from`.
    pub fn spread(&self, from: &[usize]) -> Self {
        let take =
            |of: &Vec<Vec<Hold>>| from.iter().map(|&t| of.get(t).cloned().unwrap_or_default()).collect();
        // What joins stages, and rows that not all have, begin inactive.
        Self { holds: take(&self.holds), rows: Vec::new(), links: Vec::new() }
    }

    fn exchange(&mut self, problem: &StagedProblem, stage: usize, one: Wrong) {
        match one {
            Wrong::Variable(variable, hold) => self.holds[stage][variable] = hold,
            Wrong::Row(row) => self.rows[stage][row] ^= true,
            Wrong::Link(row) => {
                let is_active = &mut self.links[stage - 1][row];
                *is_active ^= true;
                // A held variable cannot follow.
                if *is_active {
                    self.holds[stage][problem.links[stage - 1].rows[row].variable] = Hold::Free;
                }
            }
        }
    }

    /// The same for the shapes of `problem`.
    fn fit(&mut self, problem: &StagedProblem) {
        let (f, n) = (problem.stages.len(), problem.n_variables());
        self.holds.resize(f, Vec::new());
        self.holds.iter_mut().for_each(|holds| holds.resize(n, Hold::Free));
        self.rows.resize(f, Vec::new());
        for (rows, stage) in self.rows.iter_mut().zip(&problem.stages) {
            rows.resize(stage.limits.len(), false);
        }
        self.links.resize(problem.links.len(), Vec::new());
        for (rows, link) in self.links.iter_mut().zip(&problem.links) {
            rows.resize(link.rows.len(), false);
        }
        for (holds, stage) in self.holds.iter_mut().zip(&problem.stages) {
            let fixed = |i: usize| stage.lower[i] == stage.upper[i];
            for (_, hold) in holds.iter_mut().enumerate().filter(|(i, h)| fixed(*i) && **h == Hold::Free) {
                *hold = Hold::Lower;
            }
        }
    }
}

/// A constraint of a stage that is on the wrong side of the active set.
#[derive(Clone, Copy)]
enum Wrong {
    /// A variable, and where it is to be held.
    Variable(usize, Hold),
    Row(usize),
    /// A row of the link to the stage before.
    Link(usize),
}

fn pivot(
    problem: &StagedProblem,
    active: &mut StagedActiveSet,
    within: usize,
    exchanges: &mut usize,
) -> Option<StagedPoint> {
    // Stages are far more to themselves than to each other: each has its own progress.
    let mut progress = vec![(usize::MAX, PATIENCE); problem.stages.len()];
    for _ in 0..within {
        *exchanges += 1;
        let point = stationary(problem, active)?;
        let wrong = wrong(problem, active, &point);
        if wrong.iter().all(Vec::is_empty) {
            return Some(point);
        }
        for ((stage, wrong), (fewest, patience)) in wrong.iter().enumerate().zip(&mut progress) {
            if wrong.is_empty() {
                continue;
            }
            if wrong.len() < *fewest {
                (*fewest, *patience) = (wrong.len(), PATIENCE);
            } else {
                *patience = patience.saturating_sub(1);
            }
            let exchanged = if *patience > 0 { &wrong[..] } else { &wrong[wrong.len() - 1..] };
            exchanged.iter().for_each(|one| active.exchange(problem, stage, *one));
        }
    }
    None
}

/// What is on the wrong side of the active set, by stage; links count for the later of their two.
fn wrong(problem: &StagedProblem, active: &StagedActiveSet, point: &StagedPoint) -> Vec<Vec<Wrong>> {
    let of = |t: usize| {
        let (stage, here) = (&problem.stages[t], &point.stages[t]);
        let scale = stage.linear.amax().max(1.);
        let mut wrong = Vec::new();
        for (variable, hold) in active.holds[t].iter().enumerate() {
            let next = match hold {
                Hold::Free if here.x[variable] < stage.lower[variable] - ROUNDING => Hold::Lower,
                Hold::Free if here.x[variable] > stage.upper[variable] + ROUNDING => Hold::Upper,
                Hold::Lower | Hold::Upper if stage.lower[variable] == stage.upper[variable] => continue,
                Hold::Lower if here.lower[variable] < -ROUNDING * scale => Hold::Free,
                Hold::Upper if here.upper[variable] < -ROUNDING * scale => Hold::Free,
                _ => continue,
            };
            wrong.push(Wrong::Variable(variable, next));
        }
        let excess = &stage.rows * &here.x - &stage.limits;
        for (row, is_active) in active.rows[t].iter().enumerate() {
            let size = stage.limits[row].abs().max(1.);
            if if *is_active { here.rows[row] < -ROUNDING * scale } else { excess[row] > ROUNDING * size } {
                wrong.push(Wrong::Row(row));
            }
        }
        let Some(s) = t.checked_sub(1) else { return wrong };
        for (row, is_active) in active.links[s].iter().enumerate() {
            let slack = || problem.links[s].rows[row].slack(&point.stages[s].x, &here.x);
            if if *is_active { point.links[s][row] < -ROUNDING * scale } else { slack() < -ROUNDING } {
                wrong.push(Wrong::Link(row));
            }
        }
        wrong
    };
    (0..problem.stages.len()).map(of).collect()
}

/// A stage's part of the linear system: its free variables, then the multipliers of its active rows and of the active rows
/// that join it to the stage before.
struct Block {
    free: Vec<usize>,
    rows: Vec<usize>,
    links: Vec<usize>,
    factor: Factor,
    /// What the block's system equals.
    value: DVector<f64>,
    /// The coupling to the block before, transposed (size before x size).
    coupling: DMatrix<f64>,
}

/// `[H C'; C -N]` with `H` positive definite and `N` positive semidefinite, by Cholesky's method for `H` and for
/// `N + C H^-1 C'`; rows that repeat others get no multiplier.
struct Factor {
    own: Cholesky<f64, Dyn>,
    /// `H^-1 C'`.
    carried: DMatrix<f64>,
    /// Lower triangle of the factor of `N + C H^-1 C'`.
    schur: DMatrix<f64>,
    /// Rows that repeat others.
    repeated: Vec<bool>,
}

impl Factor {
    fn new(mut matrix: DMatrix<f64>, free: usize) -> Option<Self> {
        let extra = matrix.nrows() - free;
        if extra == 0 {
            let (carried, schur) = (DMatrix::zeros(free, 0), DMatrix::zeros(0, 0));
            return Some(Self { own: matrix.cholesky()?, carried, schur, repeated: Vec::new() });
        }
        let across = matrix.view((0, free), (free, extra)).into_owned();
        let mut schur = -matrix.view((free, free), (extra, extra)).into_owned();
        matrix = matrix.view((0, 0), (free, free)).into_owned();
        let own = matrix.cholesky()?;
        let carried = own.solve(&across);
        schur.gemm_tr(1., &across, &carried, 1.);
        let least = REPEATED * schur.diagonal().amax();
        let mut repeated = vec![false; extra];
        for k in 0..extra {
            let left = schur[(k, k)] - schur.view((k, 0), (1, k)).norm_squared();
            if left.is_nan() {
                return None;
            }
            repeated[k] = left <= least;
            schur[(k, k)] = if repeated[k] { 1. } else { left.sqrt() };
            for i in k + 1..extra {
                let done = schur.view((i, 0), (1, k)).dot(&schur.view((k, 0), (1, k)));
                schur[(i, k)] = if repeated[k] { 0. } else { (schur[(i, k)] - done) / schur[(k, k)] };
            }
        }
        Some(Self { own, carried, schur, repeated })
    }

    /// Solves in place (size x any).
    fn solve(&self, values: &mut DMatrix<f64>) {
        let (free, extra) = self.carried.shape();
        if extra == 0 {
            self.own.solve_mut(values);
            return;
        }
        let columns = values.ncols();
        // [H C'; C -N] [u; v] = [f; g]:  (N + C H^-1 C') v = C H^-1 f - g,  u = H^-1 f - H^-1 C' v.
        let mut lower = self.carried.tr_mul(&values.rows(0, free)) - values.rows(free, extra);
        for (k, _) in self.repeated.iter().enumerate().filter(|(_, repeated)| **repeated) {
            lower.row_mut(k).fill(0.);
        }
        self.schur.solve_lower_triangular_mut(&mut lower);
        for (k, _) in self.repeated.iter().enumerate().filter(|(_, repeated)| **repeated) {
            lower.row_mut(k).fill(0.);
        }
        self.schur.tr_solve_lower_triangular_mut(&mut lower);
        let mut upper = values.rows(0, free).into_owned();
        self.own.solve_mut(&mut upper);
        upper.gemm(-1., &self.carried, &lower, 1.);
        values.view_mut((0, 0), (free, columns)).copy_from(&upper);
        values.view_mut((free, 0), (extra, columns)).copy_from(&lower);
    }
}

/// The stationary point of the program whose active constraints are equalities; `None` where they contradict or repeat each
/// other.
fn stationary(problem: &StagedProblem, active: &StagedActiveSet) -> Option<StagedPoint> {
    let n = problem.n_variables();
    let held: Vec<DVector<f64>> = problem
        .stages
        .iter()
        .zip(&active.holds)
        .map(|(stage, holds)| {
            DVector::from_fn(n, |i, _| match holds[i] {
                Hold::Free => 0.,
                Hold::Lower => stage.lower[i],
                Hold::Upper => stage.upper[i],
            })
        })
        .collect();
    let mut blocks: Vec<Block> = Vec::with_capacity(problem.stages.len());
    for t in 0..problem.stages.len() {
        let block = eliminate(problem, active, &held, t, blocks.last())?;
        blocks.push(block);
    }
    let mut solved: Vec<DVector<f64>> = Vec::with_capacity(blocks.len());
    for t in (0..blocks.len()).rev() {
        let mut value = DMatrix::from_column_slice(blocks[t].value.len(), 1, blocks[t].value.as_slice());
        if let (Some(next), Some(z)) = (blocks.get(t + 1), solved.last()) {
            value -= &next.coupling * z;
        }
        blocks[t].factor.solve(&mut value);
        solved.push(value.column(0).into_owned());
    }
    solved.reverse();
    let mut point = StagedPoint {
        stages: (0..blocks.len())
            .map(|t| StagePoint {
                x: held[t].clone(),
                rows: DVector::zeros(problem.stages[t].limits.len()),
                lower: DVector::zeros(n),
                upper: DVector::zeros(n),
            })
            .collect(),
        links: problem.links.iter().map(|link| vec![0.; link.rows.len()]).collect(),
    };
    for (t, (block, z)) in blocks.iter().zip(&solved).enumerate() {
        let here = &mut point.stages[t];
        for (k, &i) in block.free.iter().enumerate() {
            here.x[i] = z[k];
        }
        let at = block.free.len();
        for (k, &row) in block.rows.iter().enumerate() {
            here.rows[row] = z[at + k];
        }
        let at = at + block.rows.len();
        for (k, &row) in block.links.iter().enumerate() {
            point.links[t - 1][row] = z[at + k];
        }
    }
    for t in 0..blocks.len() {
        if active.holds[t].iter().all(|hold| *hold == Hold::Free) {
            continue;
        }
        let (mut slope, _) = problem.slope(&point, t);
        slope += problem.stages[t].rows.tr_mul(&point.stages[t].rows);
        if let Some(s) = t.checked_sub(1) {
            for (row, y) in problem.links[s].rows.iter().zip(&point.links[s]) {
                slope[row.variable] += row.after * y;
            }
        }
        for (row, y) in problem.links.get(t).into_iter().flat_map(|l| l.rows.iter().zip(&point.links[t])) {
            slope[row.variable] += row.before * y;
        }
        let (stage, here) = (&problem.stages[t], &mut point.stages[t]);
        for (i, hold) in active.holds[t].iter().enumerate() {
            match hold {
                Hold::Free => {}
                _ if stage.lower[i] == stage.upper[i] => {
                    (here.lower[i], here.upper[i]) = (slope[i].max(0.), (-slope[i]).max(0.));
                }
                Hold::Lower => here.lower[i] = slope[i],
                Hold::Upper => here.upper[i] = -slope[i],
            }
        }
    }
    Some(point)
}

/// The block of stage `t` after the blocks before it were eliminated.
fn eliminate(
    problem: &StagedProblem,
    active: &StagedActiveSet,
    held: &[DVector<f64>],
    t: usize,
    before: Option<&Block>,
) -> Option<Block> {
    let (stage, n) = (&problem.stages[t], problem.n_variables());
    let is_free = |s: usize, i: usize| active.holds[s][i] == Hold::Free;
    let free: Vec<usize> = (0..n).filter(|&i| is_free(t, i)).collect();
    let rows: Vec<usize> = (0..active.rows[t].len()).filter(|&k| active.rows[t][k]).collect();
    let earlier = t.checked_sub(1);
    let links: Vec<usize> = earlier
        .map_or_else(Vec::new, |s| (0..active.links[s].len()).filter(|&k| active.links[s][k]).collect());
    let (f, size) = (free.len(), free.len() + rows.len() + links.len());
    let mut place = vec![usize::MAX; n];
    free.iter().enumerate().for_each(|(k, &i)| place[i] = k);
    let mut matrix = DMatrix::zeros(size, size);
    let mut value = DVector::zeros(size);
    let pulled = &stage.hessian * &held[t] + &stage.linear;
    for (k, &i) in free.iter().enumerate() {
        value[k] = -pulled[i];
        for (l, &j) in free.iter().enumerate() {
            matrix[(l, k)] = stage.hessian[(j, i)];
        }
    }
    for (k, &row) in rows.iter().enumerate() {
        let own = stage.rows.row(row);
        value[f + k] = stage.limits[row] - own.transpose().dot(&held[t]);
        for (l, &i) in free.iter().enumerate() {
            matrix[(l, f + k)] = own[i];
            matrix[(f + k, l)] = own[i];
        }
    }
    let neighbours = earlier.map(|s| (&problem.links[s], s)).into_iter();
    for (link, other) in neighbours.chain(problem.links.get(t).map(|link| (link, t + 1))) {
        for (k, &i) in free.iter().enumerate() {
            matrix[(k, k)] += link.weight[i];
            if !is_free(other, i) {
                value[k] += link.weight[i] * held[other][i];
            }
        }
    }
    let mut coupling = DMatrix::zeros(before.map_or(0, |b| b.value.len()), size);
    if let (Some(s), Some(before)) = (earlier, before) {
        let link = &problem.links[s];
        let mut place_before = vec![usize::MAX; n];
        before.free.iter().enumerate().for_each(|(k, &i)| place_before[i] = k);
        for (k, &i) in free.iter().enumerate().filter(|(_, i)| place_before[**i] != usize::MAX) {
            coupling[(place_before[i], k)] = -link.weight[i];
        }
        for (k, &row) in links.iter().enumerate() {
            let (row, at) = (&link.rows[row], f + rows.len() + k);
            value[at] = row.limit;
            match place[row.variable] {
                usize::MAX => value[at] -= row.after * held[t][row.variable],
                own => {
                    matrix[(own, at)] = row.after;
                    matrix[(at, own)] = row.after;
                }
            }
            match place_before[row.variable] {
                usize::MAX => value[at] -= row.before * held[s][row.variable],
                other => coupling[(other, at)] = row.before,
            }
        }
        let mut carried = coupling.clone();
        before.factor.solve(&mut carried);
        matrix -= coupling.tr_mul(&carried);
        value -= carried.tr_mul(&before.value);
    }
    let factor = Factor::new(matrix, f)?;
    Some(Block { free, rows, links, factor, value, coupling })
}

#[cfg(test)]
mod tests {
    use nalgebra::{DMatrix, DVector};
    use rand_xoshiro::Xoshiro256PlusPlus;
    use rand_xoshiro::rand_core::{RngCore, SeedableRng};

    use super::super::staged::{Link, LinkRow};
    use super::super::{Answer, Problem, solve};
    use super::*;

    struct Random(Xoshiro256PlusPlus);

    impl Random {
        fn next(&mut self) -> f64 {
            (self.0.next_u64() >> 11) as f64 / (1u64 << 53) as f64 * 2. - 1.
        }
    }

    fn staged(seed: u64, f: usize, n: usize, rows: usize) -> StagedProblem {
        let mut random = Random(Xoshiro256PlusPlus::seed_from_u64(seed));
        let stages = (0..f).map(|_| {
            let root = DMatrix::from_fn(n, n, |_, _| random.next());
            Stage {
                hessian: &root * root.transpose() + DMatrix::identity(n, n) * 0.1,
                linear: DVector::from_fn(n, |_, _| 2. * random.next()),
                lower: DVector::zeros(n),
                upper: DVector::from_element(n, 1.),
                rows: DMatrix::from_fn(rows, n, |_, _| random.next()),
                limits: DVector::from_fn(rows, |_, _| 0.2 + random.next().abs()),
            }
        });
        let stages: Vec<Stage> = stages.collect();
        let falls = |variable| LinkRow { variable, before: 0.8, after: -1., limit: 0. };
        let rises = |variable| LinkRow { variable, before: -0.4, after: 1., limit: 0.6 };
        let rows: Vec<LinkRow> = (0..n).flat_map(|i| [falls(i), rises(i)]).collect();
        let link = Link { weight: DVector::from_fn(n, |i, _| 0.1 * i as f64), rows };
        StagedProblem { links: vec![link; f - 1], stages }
    }

    /// The same program without its stages.
    fn whole(staged: &StagedProblem) -> Problem {
        let (f, n) = (staged.stages.len(), staged.n_variables());
        let mut hessian = DMatrix::zeros(f * n, f * n);
        let mut linear = DVector::zeros(f * n);
        let (mut rows, mut limits): (Vec<DVector<f64>>, Vec<f64>) = (Vec::new(), Vec::new());
        for (t, stage) in staged.stages.iter().enumerate() {
            hessian.view_mut((t * n, t * n), (n, n)).copy_from(&stage.hessian);
            linear.rows_mut(t * n, n).copy_from(&stage.linear);
            for (k, &limit) in stage.limits.iter().enumerate() {
                let mut row = DVector::zeros(f * n);
                row.rows_mut(t * n, n).copy_from(&stage.rows.row(k).transpose());
                rows.push(row);
                limits.push(limit);
            }
        }
        for (t, link) in staged.links.iter().enumerate() {
            for i in 0..n {
                let (a, b) = (t * n + i, (t + 1) * n + i);
                hessian[(a, a)] += link.weight[i];
                hessian[(b, b)] += link.weight[i];
                hessian[(a, b)] -= link.weight[i];
                hessian[(b, a)] -= link.weight[i];
            }
            for row in &link.rows {
                let mut whole = DVector::zeros(f * n);
                whole[t * n + row.variable] = row.before;
                whole[(t + 1) * n + row.variable] = row.after;
                rows.push(whole);
                limits.push(row.limit);
            }
        }
        let mut problem = Problem::unconstrained(hessian, linear);
        problem.inequality = DMatrix::from_fn(rows.len(), f * n, |i, j| rows[i][j]);
        problem.inequality_limit = DVector::from_vec(limits);
        problem.lower.fill(0.);
        problem.upper.fill(1.);
        problem
    }

    #[test]
    fn stages_give_what_the_whole_program_gives() {
        for seed in 0..20 {
            let staged = staged(seed, 5, 6, 3);
            let mut active = StagedActiveSet::default();
            let found = solve_staged(&staged, &mut active).expect("solved");
            assert!(found.passes(), "seed {seed}: {:.1e}", found.worst);
            let Ok(Answer::Solved(other)) = solve(&whole(&staged)) else { panic!("seed {seed}") };
            let x = DVector::from_iterator(30, found.point.stages.iter().flat_map(|s| s.x.iter().copied()));
            assert!((&x - &other.point.x).amax() < 1e-8, "seed {seed}");
            let objective = staged.objective(found.point.stages.iter().map(|s| &s.x));
            assert!((objective - other.objective).abs() < 1e-9 * objective.abs().max(1.));
            // Begun from its own active set it is done at once.
            let again = solve_staged(&staged, &mut active).expect("solved");
            assert_eq!((again.exchanges, again.by_interior_point), (1, false), "seed {seed}");
            assert_eq!(again.point, found.point);
        }
    }

    #[test]
    fn one_stage_is_a_plain_program() {
        for seed in 100..140 {
            let staged = staged(seed, 1, 12, 4);
            let found = solve_staged(&staged, &mut StagedActiveSet::default()).expect("solved");
            let Ok(Answer::Solved(other)) = solve(&whole(&staged)) else { panic!("seed {seed}") };
            assert!(
                found.passes() && (&found.point.stages[0].x - &other.point.x).amax() < 1e-8,
                "seed {seed}"
            );
        }
    }

    #[test]
    fn the_interior_point_finds_the_same() {
        for seed in 0..5 {
            let staged = staged(seed, 4, 5, 2);
            let near = clarabel::solve_staged(&staged).expect("solved");
            let found = solve_staged(&staged, &mut StagedActiveSet::default()).expect("solved");
            for (a, b) in near.stages.iter().zip(&found.point.stages) {
                assert!((&a.x - &b.x).amax() < 1e-6, "seed {seed}");
            }
            assert!(staged.worst(&near) < 1e-6, "{:.1e}", staged.worst(&near));
        }
    }
}
