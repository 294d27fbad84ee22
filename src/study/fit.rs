//! From a target to activations.

use nalgebra::DVector;

use super::{Mechanics, MovedContact, Stiffness, Strain};
use crate::contact::Pair;
use crate::face::{ContactReach, ContactSearch, Face};
use crate::forward::Model;
use crate::forward::finite::{FaceContact, FiniteModel, SettlingCost};
use crate::inverse::{
    ActivatedProblem, ContactFit, ContactMode, FiniteFit, FittedContact, InverseError, Observations,
    SequentialState, SequentialStep, Solution, Status, Target, Warning,
};

/// The activation at which a nonlinear fit first holds the stiffness, to find a start.
const MIDDLE: f64 = 0.5;
/// Overlap at finite strain, mm, measured by geometry that contact does not use, beyond which an answer is not called
/// solved.
const BEARABLE_MM: f64 = 0.05;

/// The linear answer beside a nonlinear one.
#[derive(Clone, Debug)]
pub struct LinearAnswer {
    /// The activation at which the stiffness was held.
    pub stiffness: f64,
    /// The answer.
    pub solution: Solution,
    /// Displacements `P u` (d), mm, where its activations lead in truth.
    pub leads_to_mm: DVector<f64>,
}

/// A target fitted.
#[derive(Clone, Debug)]
pub struct Fit {
    /// The answer.
    pub solution: Solution,
    /// Displacement of the answer (3n), mm; `None` when there is no answer.
    pub displacement: Option<Vec<f64>>,
    /// What touches at the answer; `None` without contact or answer.
    pub contact: Option<MovedContact>,
    /// The programs solved on the way; none at fixed stiffness.
    pub history: Vec<SequentialStep>,
    /// The linear answer that the nonlinear one began with; `None` when there is only one.
    pub linear: Option<LinearAnswer>,
    /// Other local solutions, to which the start from rest led.
    pub others: Vec<Solution>,
    /// What it took; `None` at linear strain.
    pub cost: Option<SettlingCost>,
}

/// Fits `target`, whose points on `face` are `observations`, by `mechanics`, contact being what `mode` says; `tell`
/// hears of every step and of the objective there.
///
/// Every fit begins with the linear map at a fixed stiffness and its program, which is the answer where the stiffness is
/// to be held. Where it follows the activations, or strain is finite, the fit goes on from there.
///
/// # Errors
/// [`InverseError`] for a target that does not fit the face and a face that cannot be solved.
pub fn fit(
    face: &Face,
    target: &Target,
    observations: &Observations,
    mechanics: Mechanics,
    mode: ContactMode,
    mut tell: impl FnMut(usize, f64) + Clone + 'static,
) -> Result<Fit, InverseError> {
    let search = (mode != ContactMode::Off).then(|| ContactSearch::new(face, ContactReach::default()));
    let model = Model::new(face, search.as_ref().map_or_else(Vec::new, |s| s.rest().to_vec()))?;
    let problem = ActivatedProblem::new(&model, target, observations, mode);
    let held = match mechanics.stiffness {
        Stiffness::Activated => MIDDLE,
        Stiffness::Fixed(a) => a,
    };
    let linear = problem.solve_at_fixed_stiffness(held)?;
    let has_answer = !linear.activations.values.is_empty();
    let start = problem.start(&linear);
    let beside = |solution, leads_to_mm| Some(LinearAnswer { stiffness: held, solution, leads_to_mm });
    if mechanics.strain == Strain::Finite && has_answer {
        let contact = (mode != ContactMode::Off).then(|| FaceContact::new(face)).transpose()?;
        let model = FiniteModel::new(face, contact)?;
        let mut steps = 0;
        let answer = FiniteFit { model: &model, target, observations }.solve(&start, |step| {
            steps += 1;
            tell(steps, step.objective);
        })?;
        let contact = answer.state.as_ref().and_then(|state| MovedContact::of_finite(face, state));
        let mut solution = answer.solution;
        if let Some(overlap_mm) = contact.as_ref().map(|c| c.overlap_mm).filter(|mm| *mm > BEARABLE_MM) {
            solution.warnings.push(Warning::Unsettled { overlap_mm });
            if solution.status.is_optimum() {
                solution.status = Status::NotConverged;
            }
        }
        return Ok(Fit {
            displacement: answer.state.as_ref().map(|state| state.displacement().to_vec()),
            contact,
            solution,
            history: answer.history,
            linear: beside(linear, answer.start_mm),
            others: answer.others,
            cost: Some(answer.cost),
        });
    }
    let fit = ContactFit { face, search: search.as_ref(), model: &model, target, observations, mode };
    if mechanics.stiffness == Stiffness::Activated && has_answer {
        let fitted = fit.activated(start.as_slice(), move |state: &SequentialState| {
            use argmin::core::State;
            tell(usize::try_from(state.get_iter()).unwrap_or(usize::MAX), state.get_cost());
        })?;
        let leads_to_mm = fitted.start_mm.clone();
        return Ok(Fit { linear: beside(linear, leads_to_mm), ..of_linear(face, fitted) });
    }
    Ok(of_linear(face, fit.fixed(held, linear)?))
}

fn of_linear(face: &Face, fitted: FittedContact) -> Fit {
    let FittedContact { solution, pairs, displacement, overlap_mm, linearisations, history, others, .. } =
        fitted;
    let contact =
        overlap_mm.map(|overlap_mm| linear_contact(face, &pairs, &solution, overlap_mm, linearisations));
    Fit { solution, displacement, contact, history, linear: None, others, cost: None }
}

fn linear_contact(
    face: &Face,
    pairs: &[Pair],
    solution: &Solution,
    overlap_mm: f64,
    linearisations: usize,
) -> MovedContact {
    let report = &solution.contact;
    MovedContact {
        candidates: report.pairs,
        active: report.active,
        force_n: report.force_n,
        load: face.contact_load(pairs, solution.contact_forces.as_slice()),
        overlap_mm,
        linear_penetration_mm: report.max_penetration_mm,
        linearisations,
        settled: !solution.warnings.iter().any(|w| matches!(w, Warning::Unsettled { .. })),
    }
}
