//! A target on a face at finite strain.

use nalgebra::DVector;

use super::kink::{Side, mixed};
use super::limits::TrustRegion;
use super::pivot::{Failure, Found};
use super::problem::{ContactMode, InverseError, Problem};
use super::program::{Objective, build};
use super::residual_curvature::ResidualCurvature;
use super::sequential::SequentialStep;
use super::solution::{Solution, Status};
use super::term::{State, objective};
use super::warning::Warning;
use super::{JawOpening, Observations, Target, report};
use crate::face::{JawRange, Pose};
use crate::forward::finite::{FiniteError, FiniteModel, FiniteState, SettlingCost, Tangent};
use crate::qp::{Certificate, Point};

/// Largest residual of the optimality conditions of an answer that may be called solved.
const KKT: f64 = 1e-5;
/// How near gradients are taken for those of one place: surfaces have corners, where the gradient jumps.
const KINK: f64 = 1e-4;
/// Places whose gradients are remembered.
const MOST_SIDES: usize = 8;
/// Steps before a start is given up, the first and the second: lips that close over an open jaw take 118.
const MOST_STEPS: [usize; 2] = [200, 60];
/// Half width of the first trust region.
const FIRST_RADIUS: f64 = 0.5;
/// Half width at which the way is lost.
const LEAST_RADIUS: f64 = 1e-7;
/// Share of the predicted decrease that a step must bring to be taken.
const WORTH: f64 = 1e-4;
/// Relative change of the objective that rounding and unbalanced forces explain.
const ROUNDING: f64 = 1e-10;
/// Difference of the activations of two starts that lead to the same answer.
const SAME: f64 = 1e-3;
/// Distance between two states of the same activations, mm, by which the answer depends on the path.
const SAME_MM: f64 = 0.01;

/// A target on a face at finite strain: `min 1/2 |r(P u(x), x)|^2 + slope'x`, where `u(x)` is the face at rest under the unknowns.
///
/// One loop: the tangent of the face at rest makes one program, within a trust region; the face is brought to rest
/// under what it proposes, from where its tangent predicts it, and the step is judged by the objective there.
/// Contact is part of the potential, and so of the tangent: the program has no contact row.
#[derive(Clone, Copy, Debug)]
pub struct FiniteFit<'a> {
    /// The face.
    pub model: &'a FiniteModel,
    /// The target.
    pub target: &'a Target,
    /// Its points on the face.
    pub observations: &'a Observations,
}

/// An answer at finite strain.
#[derive(Clone, Debug)]
pub struct FiniteAnswer {
    /// The answer; its certificate is that of the objective itself, at the face at rest.
    pub solution: Solution,
    /// The face of which the answer's markers and certificate are; `None` when there is no answer.
    pub state: Option<FiniteState>,
    /// Farthest that a node lies from where the fit had it, mm, when the face is loaded from rest; `None` where it is not
    /// found that way.
    pub path_mm: Option<f64>,
    /// The programs solved on the way.
    pub history: Vec<SequentialStep>,
    /// What it took.
    pub cost: SettlingCost,
    /// Displacements `P u` (d), mm, at the start.
    pub start_mm: DVector<f64>,
    /// Other local solutions, to which the second start led.
    pub others: Vec<Solution>,
}

/// The face under some unknowns, and how it goes on.
struct Here {
    state: FiniteState,
    tangent: Tangent,
    problem: Problem,
    seen: State,
    model: Objective,
    objective: f64,
}

/// Where one start led.
struct End {
    here: Here,
    /// The answer of the last program, and that program's objective.
    found: Option<(Found, Objective)>,
    status: Status,
    /// Displacements `P u` (d), mm, at its start.
    start_mm: DVector<f64>,
}

impl FiniteFit<'_> {
    /// The answer from rest, where the tangent is the linear map, and, as a second start, from the unknowns `start` (n:
    /// activations, then the share of the jaw's opening where that is unknown), those of the linear answer; `tell` hears
    /// of every step.
    ///
    /// # Errors
    /// [`InverseError`] when the face does not come to rest at the start. A search that ends without an optimum is no
    /// error: see [`Status`].
    pub fn solve(
        &self,
        start: &DVector<f64>,
        mut tell: impl FnMut(&SequentialStep),
    ) -> Result<FiniteAnswer, InverseError> {
        let (mut history, mut cost) = (Vec::new(), SettlingCost::default());
        let mut told = |step: &SequentialStep| {
            tell(step);
            history.push(*step);
        };
        let rest = DVector::zeros(start.len());
        let at_rest = self.model.settle(&self.load(&rest)?.0, &self.load(&rest)?.1)?;
        cost.add(at_rest.cost());
        let first = match self.descend(self.at(rest, at_rest)?, None, &mut told, &mut cost)? {
            Ok(end) => end,
            Err(solution) => return Ok(FiniteAnswer::without(*solution)),
        };
        let start_mm = first.start_mm.clone();
        let second = match first.status {
            Status::Solved => match self.beside(&first.here, start, &mut cost)? {
                Some(there) => {
                    let known = Some(&first.here.seen.activation);
                    self.descend(there, known, &mut told, &mut cost)?.ok()
                }
                None => None,
            },
            _ => None,
        };
        let is_other = |end: &End| {
            end.status == Status::Solved
                && (&end.here.seen.activation - &first.here.seen.activation).amax() > SAME
        };
        let (best, others) = match second.filter(is_other) {
            Some(second) if second.here.objective < first.here.objective => (second, vec![first.solution()?]),
            Some(second) => {
                let other = second.solution()?;
                (first, vec![other])
            }
            None => (first, Vec::new()),
        };
        let mut solution = best.solution()?;
        let state = best.here.state;
        // What `forward` shows under these activations.
        let path_mm = match self.model.settle(state.activation(), state.pose()) {
            Ok(from_rest) => {
                cost.add(from_rest.cost());
                let apart = from_rest.positions().iter().zip(state.positions()).map(|(a, b)| (a - b).norm());
                let apart_mm = apart.fold(0., f64::max);
                if apart_mm > SAME_MM {
                    solution.warnings.push(Warning::Path { apart_mm });
                }
                Some(apart_mm)
            }
            Err(FiniteError::NoRest { reached }) => {
                solution.warnings.push(Warning::OwnPath { reached });
                None
            }
            Err(error) => return Err(error.into()),
        };
        if !state.is_stable() {
            solution.warnings.push(Warning::Unstable);
        }
        Ok(FiniteAnswer { solution, state: Some(state), path_mm, history, cost, others, start_mm })
    }

    /// Goes downhill from `here` to an optimum, or to where another one, `known`, is near.
    fn descend(
        &self,
        mut here: Here,
        known: Option<&DVector<f64>>,
        told: &mut impl FnMut(&SequentialStep),
        cost: &mut SettlingCost,
    ) -> Result<Result<End, Box<Solution>>, InverseError> {
        let start = &here.seen.activation;
        let within = start.sup(&here.problem.bounds.min).inf(&here.problem.bounds.max);
        if within != *start {
            let (a, pose) = self.load(&within)?;
            let state = self.model.settle_from(&here.state, &a, &pose)?;
            cost.add(state.cost());
            here = self.at(within, state)?;
        }
        let start_mm = here.seen.observed.clone();
        let mut curvature = ResidualCurvature::none(here.seen.activation.len());
        let mut radius = FIRST_RADIUS;
        let mut last = None;
        let mut sides: Vec<Side> = Vec::new();
        for _ in 0..MOST_STEPS[usize::from(known.is_some())] {
            let trust = TrustRegion { centre: here.seen.activation.clone(), radius };
            let reached = |model: &Objective| {
                let terms = curvature.terms(model, &here.seen);
                here.problem.minimise(ContactMode::Off, &terms, None, Some(&trust))
            };
            let best = |model: &Objective| match reached(model)? {
                Ok(found) => Ok(found.optimum.state.activation),
                Err(_) => Ok::<_, InverseError>(here.seen.activation.clone()),
            };
            sides.retain(|side| (&side.at - &here.seen.activation).amax() <= KINK);
            let model = mixed(&here.side(), sides.iter().rev().take(MOST_SIDES), best)?;
            let found = match reached(&model)? {
                Ok(found) => found,
                Err(failure) => return Ok(Err(Box::new(here.problem.failed(failure)))),
            };
            let (_, certificate) = here.certified(&found, &model);
            let proposed = found.optimum.state.activation.clone();
            let change = (&proposed - &here.seen.activation).amax();
            let kkt = certificate.worst();
            let mut step = SequentialStep { objective: here.objective, kkt, change, radius, taken: false };
            if kkt <= KKT || known.is_some_and(|known| (&here.seen.activation - known).amax() <= SAME) {
                told(&step);
                let found = Some((found, model));
                return Ok(Ok(End { here, found, status: Status::Solved, start_mm }));
            }
            let predicted =
                curvature.terms(&model, &here.seen).objective(&here.seen) - found.optimum.objective;
            last = Some((found, model));
            let next = self.beside(&here, &proposed, cost)?;
            let Some(next) = next else {
                told(&step);
                radius = 0.25 * change;
                if radius < LEAST_RADIUS {
                    break;
                }
                continue;
            };
            let actual = here.objective - next.objective;
            let noise = ROUNDING * here.objective;
            step.taken = actual >= WORTH * predicted - noise;
            if actual < 0.25 * predicted - noise {
                radius = 0.5 * change;
            } else if actual > 0.75 * predicted && change > 0.99 * radius {
                radius = (2. * radius).min(1.);
            }
            told(&step);
            let [before, after] = [&here, &next].map(|at| (&at.seen.activation, &at.model));
            curvature.learn(before, after);
            if step.taken {
                sides.push(here.side());
                here = next;
            } else {
                sides.push(next.side());
            }
            if radius < LEAST_RADIUS {
                break;
            }
        }
        Ok(Ok(End { here, found: last, status: Status::NotConverged, start_mm }))
    }

    /// The activations and the pose of the unknowns `x`.
    fn load(&self, x: &DVector<f64>) -> Result<(Vec<f64>, Pose), InverseError> {
        let m = self.model.face().muscles.len();
        let opening = match self.target.jaw_opening {
            None => None,
            Some(JawOpening::Held(opening)) => Some(opening),
            Some(JawOpening::Within(range)) => Some(range.at(x[m])),
        };
        let pose = match (opening, &self.model.face().jaw) {
            (None, _) => Pose::rest(),
            (Some(opening), Some(jaw)) => Pose::opened(jaw, opening),
            (Some(_), None) => return Err(crate::forward::ForwardError::NoJaw.into()),
        };
        Ok((x.as_slice()[..m].to_vec(), pose))
    }

    fn jaw(&self, x: &DVector<f64>) -> Option<(JawRange, f64)> {
        match self.target.jaw_opening {
            Some(JawOpening::Within(range)) => Some((range, x[self.model.face().muscles.len()])),
            _ => None,
        }
    }

    /// The face under the unknowns `x`, from where the tangent of `here` predicts it; `None` where it finds no rest.
    fn beside(
        &self,
        here: &Here,
        x: &DVector<f64>,
        cost: &mut SettlingCost,
    ) -> Result<Option<Here>, InverseError> {
        let (a, pose) = self.load(x)?;
        let step = x - &here.seen.activation;
        match self.model.settle_beside(&here.state, (&here.tangent, &step), &a, &pose) {
            Ok(state) => {
                cost.add(state.cost());
                self.at(x.clone(), state).map(Some)
            }
            Err(FiniteError::NoRest { .. }) => Ok(None),
            Err(error) => Err(error.into()),
        }
    }

    fn at(&self, x: DVector<f64>, state: FiniteState) -> Result<Here, InverseError> {
        let tangent = self.model.tangent(&state, self.jaw(&x)).ok_or(FiniteError::NoRest { reached: 0. })?;
        let response = tangent.response(&state, &x, &self.observations.sites);
        let observed = &response.offset + &response.map * &x;
        let problem = Problem::new(self.target, self.observations, &response)?;
        let seen = State { observed, activation: x };
        let objective = objective(problem.terms(), &seen);
        let model = problem.linearise(&seen).over(&problem.space);
        Ok(Here { state, tangent, problem, seen, model, objective })
    }
}

impl Here {
    fn side(&self) -> Side {
        Side { at: self.seen.activation.clone(), model: self.model.clone() }
    }

    /// This state as a point of the program of `model`, with the multipliers of `found`, and how well it satisfies the
    /// optimality conditions.
    fn certified(&self, found: &Found, model: &Objective) -> (Point, Certificate) {
        let mut point = found.optimum.point.clone();
        point.x.copy_from(&self.seen.activation);
        let program = build(model, &[&self.problem.bounds, &self.problem.tied]);
        let certificate = Certificate::of(&program.problem, &point);
        (point, certificate)
    }
}

impl End {
    fn solution(&self) -> Result<Solution, InverseError> {
        let Some((found, model)) = &self.found else {
            return Ok(self.here.problem.failed(Failure::NotConverged));
        };
        let (point, certificate) = self.here.certified(found, model);
        let problem = &self.here.problem;
        Ok(report::solution(problem, ContactMode::Off, self.status, found, &point, certificate, None))
    }
}

impl FiniteAnswer {
    /// A solution that has no activations.
    fn without(solution: Solution) -> Self {
        let (history, others, cost) = (Vec::new(), Vec::new(), SettlingCost::default());
        let start_mm = DVector::zeros(0);
        Self { solution, state: None, path_mm: None, history, cost, others, start_mm }
    }
}
