//! Sequential quadratic programming with a trust region.

use argmin::core::observers::{Observe, ObserverMode};
use argmin::core::{
    Error, Executor, IterState, KV, Problem as Counted, Solver, TerminationReason, TerminationStatus,
};
use nalgebra::DVector;

use super::activated::{ActivatedProblem, Iterate};
use super::limits::TrustRegion;
use super::pivot::{Failure, Found};
use super::problem::InverseError;
use super::residual_curvature::ResidualCurvature;
use super::solution::{Solution, Status};

/// The state that `argmin` carries from step to step: the activations and the objective.
pub type SequentialState = IterState<DVector<f64>, (), (), (), (), f64>;

/// Largest nonlinear KKT residual of an answer that may be called solved.
const KKT: f64 = 1e-9;
/// Quadratic programs before the search is given up.
const MOST_STEPS: u64 = 100;
/// Share of the predicted decrease that a step must bring to be taken.
const WORTH: f64 = 1e-4;
/// Relative change of the objective that rounding explains.
const ROUNDING: f64 = 1e-12;
/// Least radius: a region that small has lost the way.
const LEAST_RADIUS: f64 = 1e-12;

/// One quadratic program of a sequence.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct SequentialStep {
    /// That of the nonlinear model before the step.
    pub objective: f64,
    /// Largest residual of the nonlinear optimality conditions before the step.
    pub kkt: f64,
    /// Largest change of an activation that the program proposed, or of the jaw's opening as a share of its range.
    pub change: f64,
    /// Half width of the trust region.
    pub radius: f64,
    /// Whether the step was taken.
    pub taken: bool,
}

/// Sequential quadratic programming: at each activation the tangent of the model, with all terms,
/// limits and contact pieces, is solved as one program within a trust region; the step is taken when
/// the nonlinear objective falls with it (Conn, Gould and Toint 2000, chapter 15).
///
/// An `argmin` solver over [`ActivatedProblem`]; [`ActivatedProblem::solve`] runs it.
#[derive(Debug)]
pub struct SequentialQp {
    /// Change of the activations at which a rough answer does.
    roughly: f64,
    radius: f64,
    at: Option<Iterate>,
    /// What the tangents leave out, as far as it is known.
    curvature: ResidualCurvature,
    history: Vec<SequentialStep>,
    start_mm: DVector<f64>,
    end: Option<End>,
}

#[derive(Debug)]
enum End {
    /// An optimum on the tangent that satisfies the nonlinear conditions.
    Optimum(Box<Found>),
    /// As near as was asked for.
    Near,
    /// The limits leave nothing, or a program stopped short.
    Failed(Failure),
    /// The trust region shrank to nothing.
    Lost,
}

impl Default for SequentialQp {
    fn default() -> Self {
        Self {
            roughly: 0.,
            radius: 1.,
            at: None,
            curvature: ResidualCurvature::none(0),
            history: Vec::new(),
            start_mm: DVector::zeros(0),
            end: None,
        }
    }
}

impl SequentialQp {
    /// Carries on from `at`, if there is still a region to look in.
    fn go_on(&mut self, at: Iterate, state: SequentialState) -> Result<(SequentialState, Option<KV>), Error> {
        if self.radius < LEAST_RADIUS {
            self.end = Some(End::Lost);
        }
        let at = self.at.insert(at);
        let told = argmin::kv!("radius" => self.radius;);
        Ok((state.param(at.state.activation.clone()).cost(at.objective), Some(told)))
    }
}

impl Solver<ActivatedProblem<'_>, SequentialState> for SequentialQp {
    fn name(&self) -> &'static str {
        "sequential quadratic programming"
    }

    fn init(
        &mut self,
        problem: &mut Counted<ActivatedProblem<'_>>,
        mut state: SequentialState,
    ) -> Result<(SequentialState, Option<KV>), Error> {
        let start = state.take_param().ok_or_else(|| Error::msg("no start"))?;
        let mut at = problem.problem("cost_count", |p| Ok(p.iterate(&start, p.touching())?))?;
        let within = start.sup(&at.tangent.bounds.min).inf(&at.tangent.bounds.max);
        if within != start {
            at = problem.problem("cost_count", |p| Ok(p.iterate(&within, p.touching())?))?;
        }
        let objective = at.objective;
        self.start_mm.clone_from(&at.state.observed);
        self.curvature = ResidualCurvature::none(within.len());
        self.at = Some(at);
        Ok((state.param(within).cost(objective), None))
    }

    fn next_iter(
        &mut self,
        problem: &mut Counted<ActivatedProblem<'_>>,
        state: SequentialState,
    ) -> Result<(SequentialState, Option<KV>), Error> {
        let Some(at) = self.at.take() else { return Ok((state, None)) };
        let mode = problem.problem("mode_count", |p| Ok(p.mode()))?;
        let trust = TrustRegion { centre: at.state.activation.clone(), radius: self.radius };
        let terms = at.terms.with(self.curvature.convex_rows());
        let mut reached = at.tangent.minimise(mode, &terms, Some(at.touching()), Some(&trust))?;
        if reached.is_err() {
            // No point of the region keeps the contacts as they are: look from other contact states.
            reached = at.tangent.minimise(mode, &terms, None, Some(&trust))?;
        }
        let found = match reached {
            Ok(found) => found,
            Err(failure) => {
                self.end = Some(End::Failed(failure));
                self.at = Some(at);
                return Ok((state, None));
            }
        };
        let (_, certificate) = at.optimality(mode, &found);
        let proposed = &found.optimum.state.activation;
        let change = (proposed - &at.state.activation).amax();
        let kkt = certificate.worst();
        let mut step =
            SequentialStep { objective: at.objective, kkt, change, radius: self.radius, taken: false };
        if kkt <= KKT {
            self.history.push(step);
            self.end = Some(End::Optimum(Box::new(found)));
            self.at = Some(at);
            return Ok((state, None));
        }
        if change <= self.roughly {
            self.history.push(step);
            self.end = Some(End::Near);
            self.at = Some(at);
            return Ok((state, None));
        }
        let next = problem.problem("cost_count", |p| Ok(p.iterate(proposed, &at.touching())?))?;
        if at.touching() == next.touching() {
            // Where contacts open or close the gradient turns for another reason.
            let [before, after] = [&at, &next].map(|at| (&at.state.activation, &at.reduced));
            self.curvature.learn(before, after);
        }
        let predicted = at.objective - found.optimum.objective;
        let actual = at.objective - next.objective;
        let noise = ROUNDING * at.objective;
        if predicted <= noise && actual.abs() <= noise {
            // Too close for the objective to judge: the optimality conditions do. Where contacts open and
            // close about a kink the steps would go back and forth for ever.
            step.taken = true;
            let before = self.history.last().map_or(f64::INFINITY, |last| last.kkt);
            if kkt < before && change > 0.99 * self.radius && at.touching() == next.touching() {
                self.radius = (2. * self.radius).min(1.);
            } else if kkt > 0.5 * before {
                self.radius = 0.5 * change;
            }
            self.history.push(step);
            return self.go_on(next, state);
        }
        step.taken = actual >= WORTH * predicted;
        if actual < 0.25 * predicted {
            self.radius = 0.5 * change;
        } else if actual > 0.75 * predicted && change > 0.99 * self.radius {
            self.radius = (2. * self.radius).min(1.);
        }
        self.history.push(step);
        self.go_on(if step.taken { next } else { at }, state)
    }

    fn terminate(&mut self, _: &SequentialState) -> TerminationStatus {
        match self.end {
            Some(End::Optimum(_) | End::Near) => {
                TerminationStatus::Terminated(TerminationReason::SolverConverged)
            }
            Some(_) => TerminationStatus::Terminated(TerminationReason::SolverExit("no step".into())),
            None => TerminationStatus::NotTerminated,
        }
    }
}

/// Largest difference between two activations of the same answer.
const SAME: f64 = 1e-5;
/// Largest difference between two jaw openings of the same answer, mm.
const SAME_MM: f64 = 1e-4;

/// What a nonlinear fit found, and how.
#[derive(Clone, Debug)]
pub struct ActivatedSolution {
    /// The answer; its certificate is that of the nonlinear optimality conditions.
    pub solution: Solution,
    /// The programs solved on the way.
    pub history: Vec<SequentialStep>,
    /// Displacements `P u` (d), mm, at the start, at the stiffness of the start.
    pub start_mm: DVector<f64>,
    /// Other local solutions that other starts led to, the best first.
    pub others: Vec<Solution>,
}

/// Tells a caller of every step as it is taken.
struct Teller<F>(F);

impl<F: FnMut(&SequentialState)> Observe<SequentialState> for Teller<F> {
    fn observe_iter(&mut self, state: &SequentialState, _: &KV) -> Result<(), Error> {
        (self.0)(state);
        Ok(())
    }
}

impl ActivatedProblem<'_> {
    /// Finds the activations, and the jaw's opening where it is unknown, from the start `x` (n); `tell` hears of every step.
    ///
    /// # Errors
    /// [`InverseError`] when the face cannot be solved at some activation. A search that ends without
    /// an optimum is no error: see [`Status`].
    pub fn solve(
        self,
        start: DVector<f64>,
        tell: impl FnMut(&SequentialState) + 'static,
    ) -> Result<ActivatedSolution, InverseError> {
        let mode = self.mode();
        let SequentialQp { at, end, history, start_mm, .. } =
            self.run(SequentialQp::default(), start, tell)?;
        let at = at.ok_or(InverseError::NoStart)?;
        let solution = match end {
            Some(End::Optimum(found)) => at.solution(mode, Status::Solved, &found)?,
            Some(End::Failed(failure)) => at.tangent.failed(failure),
            Some(End::Lost | End::Near) | None => {
                match at.tangent.minimise(mode, &at.terms, Some(at.touching()), None)? {
                    Ok(found) => at.solution(mode, Status::NotConverged, &found)?,
                    Err(failure) => at.tangent.failed(failure),
                }
            }
        };
        Ok(ActivatedSolution { solution, history, start_mm, others: Vec::new() })
    }

    /// Goes from the start `x` (n) towards the optimum only until the next program would change none of them
    /// by more than `roughly`; `None` when no program has an answer.
    pub(super) fn approach(
        self,
        start: DVector<f64>,
        roughly: f64,
        tell: impl FnMut(&SequentialState) + 'static,
    ) -> Result<Option<Approach>, InverseError> {
        let SequentialQp { at, end, history, start_mm, .. } =
            self.run(SequentialQp { roughly, ..SequentialQp::default() }, start, tell)?;
        let at = at.filter(|_| !matches!(end, Some(End::Failed(_))));
        Ok(at.map(|at| Approach {
            unknowns: at.state.activation,
            forces: at.forces,
            objective: at.objective,
            history,
            start_mm,
        }))
    }

    fn run(
        self,
        solver: SequentialQp,
        start: DVector<f64>,
        tell: impl FnMut(&SequentialState) + 'static,
    ) -> Result<SequentialQp, InverseError> {
        let run = Executor::new(self, solver)
            .configure(|state: SequentialState| state.param(start).max_iters(MOST_STEPS))
            .add_observer(Teller(tell), ObserverMode::Always)
            .timer(false)
            .run();
        // Every error that the solver raises is an inverse one.
        run.map(|result| result.solver).map_err(|error| error.downcast().unwrap_or(InverseError::NoStart))
    }
}

/// Where a search stopped short of the optimum.
#[derive(Clone, Debug)]
pub(super) struct Approach {
    /// The unknowns (n).
    pub(super) unknowns: DVector<f64>,
    /// Contact forces (c), N, of the face at rest under them.
    pub(super) forces: DVector<f64>,
    /// The objective there.
    pub(super) objective: f64,
    /// The programs solved on the way.
    pub(super) history: Vec<SequentialStep>,
    /// Displacements `P u` (d), mm, at the start, at the stiffness of the start.
    pub(super) start_mm: DVector<f64>,
}

impl ActivatedSolution {
    /// The best of what [`ActivatedProblem::solve`] found from several starts; where they led to different
    /// activations the others are told too: the target does not determine the answer.
    ///
    /// # Errors
    /// [`InverseError::NoStart`] without a solution.
    pub fn best_of(solutions: impl IntoIterator<Item = Self>) -> Result<Self, InverseError> {
        let mut found: Vec<Self> = Vec::new();
        for next in solutions {
            let is_same = |old: &Self| {
                let (a, b) = (&old.solution.activations.values, &next.solution.activations.values);
                let openings = old.solution.jaw_opening_mm.zip(next.solution.jaw_opening_mm);
                old.solution.status == next.solution.status
                    && openings.is_none_or(|(a, b)| (a - b).abs() <= SAME_MM)
                    && a.iter().zip(b).all(|(a, b)| (a - b).abs() <= SAME)
            };
            if !found.iter().any(is_same) {
                found.push(next);
            }
        }
        // Stable: of equal answers the earlier start's.
        found.sort_by(|a, b| {
            let unsolved = |s: &Self| !s.solution.status.is_optimum();
            unsolved(a).cmp(&unsolved(b)).then(a.solution.objective.total_cmp(&b.solution.objective))
        });
        let mut found = found.into_iter();
        let mut best = found.next().ok_or(InverseError::NoStart)?;
        best.others = found.map(|f| f.solution).filter(|s| s.status.is_optimum()).collect();
        Ok(best)
    }
}
