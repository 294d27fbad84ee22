//! A fit whose contacts are those of the face where it went.

use nalgebra::DVector;

use super::activated::touching;
use super::sequential::{Approach, SequentialState, SequentialStep};
use super::solution::{Solution, Status};
use super::warning::Warning;
use super::{ActivatedProblem, ContactMode, InverseError, Observations, Target};
use crate::contact::Pair;
use crate::face::{ContactSearch, Face};
use crate::forward::{Equilibrium, FixedStiffness, Model, Nearby};

/// Linearisations of the contacts before giving up.
const MOST_ROUNDS: usize = 8;
/// Linearisations under the same activations before the fit goes on from the best of them.
const SETTLING_ROUNDS: [usize; 2] = [36, 8];
/// Deepest overlap of the true surfaces, mm, that counts as none.
const TOUCHING_MM: f64 = 1e-2;
/// Deepest overlap, mm, of an answer that may be called solved: a quarter of the error of placing a landmark
/// (0.4 mm).
const BEARABLE_MM: f64 = 0.1;
/// Largest change of an activation from one linearisation to the next when the activations stay: where a whole one
/// moves a point by 10 mm, this moves it by the 0.01 mm that counts as none.
const SAME: f64 = 1e-3;
/// Of what the last linearisation changed, the share to which the next is fitted before the contacts stay,
const ROUGHLY: f64 = 0.1;
/// at least and at most.
const ROUGHEST: [f64; 2] = [1e-4, 5e-3];
/// Candidates farther apart than this, mm, where contact was linearised are left out: no activation changes by
/// more than the next linearisation finds out.
const REACH_MM: f64 = 4.;

/// A target on a face, fitted with the gaps and normals of where the answer leads, until surfaces that are not
/// planes no longer overlap.
///
/// Each linearisation is about the face [at rest on its true surfaces](FixedStiffness::settle) under the last
/// activations; where these stay, the answer satisfies the optimality conditions with the contacts of its own
/// deformed face. Until then a fit need only be finer than what the next linearisation changes.
#[derive(Clone, Copy, Debug)]
pub struct ContactFit<'a> {
    /// The face.
    pub face: &'a Face,
    /// Its contacts; `None` when contact is off.
    pub search: Option<&'a ContactSearch>,
    /// Its model with the candidates at rest.
    pub model: &'a Model,
    /// The target.
    pub target: &'a Target,
    /// Its points on the face.
    pub observations: &'a Observations,
    /// What contact does; only reactions are linearised again.
    pub mode: ContactMode,
}

/// An answer with the contacts that it was found with.
#[derive(Clone, Debug)]
pub struct FittedContact {
    /// The answer; not [`Status::Solved`] when its surfaces overlap by more than 0.1 mm.
    pub solution: Solution,
    /// The contacts as linearised last: those of the solution's forces.
    pub pairs: Vec<Pair>,
    /// Displacement of the answer (3n), mm; `None` when there is no answer.
    pub displacement: Option<Vec<f64>>,
    /// Deepest overlap beyond that at rest, mm, measured on the surfaces of the deformed face; `None` without
    /// contact or answer.
    pub overlap_mm: Option<f64>,
    /// Linearisations of the contacts that were fitted with.
    pub linearisations: usize,
    /// The programs solved on the way; none at fixed stiffness.
    pub history: Vec<SequentialStep>,
    /// Displacements `P u` (d), mm, at the start, at the stiffness of the start; empty at fixed stiffness.
    pub start_mm: DVector<f64>,
    /// Other local solutions with the same contacts, to which the start from rest led.
    pub others: Vec<Solution>,
}

impl FittedContact {
    /// A solution that has no activations.
    fn without_answer(solution: Solution, pairs: Vec<Pair>) -> Self {
        Self {
            solution,
            pairs,
            displacement: None,
            overlap_mm: None,
            linearisations: 0,
            history: Vec::new(),
            start_mm: DVector::zeros(0),
            others: Vec::new(),
        }
    }
}

/// One fit with contacts linearised once.
struct Fit {
    /// The unknowns (n); empty when nothing was found.
    unknowns: Vec<f64>,
    forces: DVector<f64>,
    objective: f64,
    /// The answer, where the fit was not a rough one.
    solution: Option<Solution>,
    history: Vec<SequentialStep>,
    start_mm: DVector<f64>,
}

impl Fit {
    fn of(
        unknowns: &DVector<f64>,
        solution: Solution,
        history: Vec<SequentialStep>,
        start_mm: DVector<f64>,
    ) -> Self {
        let forces = solution.contact_forces.clone();
        let objective = solution.objective;
        let unknowns =
            if solution.activations.values.is_empty() { Vec::new() } else { unknowns.as_slice().to_vec() };
        Self { unknowns, forces, objective, solution: Some(solution), history, start_mm }
    }
}

impl<'a> ContactFit<'a> {
    /// The answer at the fixed stiffness of the uniform activation `share`, from `first`, which was found with the
    /// candidates at rest.
    ///
    /// # Errors
    /// [`InverseError`] when the face cannot be solved.
    pub fn fixed(&self, share: f64, first: Solution) -> Result<FittedContact, InverseError> {
        let held = vec![share; self.model.muscles().len()];
        if first.activations.values.is_empty() {
            return Ok(FittedContact::without_answer(first, self.model.pairs().to_vec()));
        }
        let x = self.on(self.model).start(&first);
        let mut first = Some(first);
        self.settle(
            x.as_slice().to_vec(),
            None,
            |_| held.clone(),
            |model, _, _, _| {
                let solution = match first.take_if(|_| !self.is_linearised()) {
                    Some(first) => first,
                    None => self.on(model).solve_at_fixed_stiffness(share)?,
                };
                Ok(Fit::of(&self.on(model).start(&solution), solution, Vec::new(), DVector::zeros(0)))
            },
        )
    }

    /// The answer with muscles that stiffen, from the unknowns `start` (n); `tell` hears of every step.
    ///
    /// Where it stands, the same contacts are fitted from rest too: another answer is told, and taken where it is
    /// the better one.
    ///
    /// # Errors
    /// [`InverseError`] when the face cannot be solved at some activation.
    pub fn activated(
        &self,
        start: &[f64],
        tell: impl FnMut(&SequentialState) + Clone + 'static,
    ) -> Result<FittedContact, InverseError> {
        let exactly = |model: &Model, a: &[f64], touching: &[usize]| {
            self.on(model).near(touching).solve(DVector::from_column_slice(a), tell.clone())
        };
        let fit = |model: &Model, a: &[f64], touching: &[usize], roughly: Option<f64>| {
            let start = || DVector::from_column_slice(a);
            if let Some(roughly) = roughly
                && let Some(near) = self.on(model).near(touching).approach(start(), roughly, tell.clone())?
            {
                let Approach { unknowns, forces, objective, history, start_mm } = near;
                let unknowns = unknowns.as_slice().to_vec();
                return Ok(Fit { unknowns, forces, objective, solution: None, history, start_mm });
            }
            let found = exactly(model, a, touching)?;
            Ok(Fit::of(&self.on(model).start(&found.solution), found.solution, found.history, found.start_mm))
        };
        let m = self.model.muscles().len();
        let own = |x: &[f64]| x[..m].to_vec();
        let mut fitted = self.settle(start.to_vec(), None, own, fit)?;
        let old = &fitted.solution;
        if !old.status.is_optimum() || fitted.overlap_mm.is_some_and(|mm| mm > BEARABLE_MM) {
            return Ok(fitted);
        }
        let (objective, answer) = (old.objective, self.on(self.model).start(old).as_slice().to_vec());
        let is_other = |a: &[f64]| largest_change(a, &answer) > 2. * ROUGHEST[1];
        let model = self.model.with_pairs(fitted.pairs.clone());
        // Far from the answer its contacts may leave the face no place: then rest is no start.
        let Ok(second) = fit(&model, self.on(&model).rest().as_slice(), &[], Some(ROUGHEST[1])) else {
            return Ok(fitted);
        };
        fitted.history.extend(second.history);
        if !is_other(&second.unknowns) {
            return Ok(fitted);
        }
        if second.objective >= objective {
            let Ok(second) = exactly(&model, &second.unknowns, &touching(&second.forces)) else {
                return Ok(fitted);
            };
            fitted.history.extend(second.history);
            let is_told = second.solution.status.is_optimum()
                && is_other(self.on(&model).start(&second.solution).as_slice());
            fitted.others.extend(is_told.then_some(second.solution));
            return Ok(fitted);
        }
        let stiff = self.on(&model).model_at(&second.unknowns[..m], &second.unknowns)?;
        let place = stiff.displacement(&second.unknowns[..m], second.forces.as_slice());
        let better = self.settle(second.unknowns, Some(place), own, fit)?;
        let is_better = better.solution.status.is_optimum() && better.solution.objective < objective;
        let (mut best, other) = if is_better { (better, fitted) } else { (fitted, better) };
        best.linearisations += other.linearisations;
        best.history.extend(other.history);
        let apart = largest_change(&best.solution.activations.values, &other.solution.activations.values);
        let is_told = other.solution.status.is_optimum() && apart > 2. * ROUGHEST[1];
        best.others.extend(is_told.then_some(other.solution));
        Ok(best)
    }

    fn is_linearised(&self) -> bool {
        self.search.is_some() && self.mode == ContactMode::Reactions
    }

    fn on<'m>(&'m self, model: &'m Model) -> ActivatedProblem<'m> {
        ActivatedProblem::new(model, self.target, self.observations, self.mode)
    }

    /// Fits and linearises from the unknowns `x` (n), and from the displacement `place` (3n, mm) or rest, until both
    /// stay, at the `stiffness` of activations (m); `fit` starts near the contacts that it is told touch, and fits to
    /// a roughness or, without one, exactly.
    fn settle(
        &self,
        mut x: Vec<f64>,
        mut place: Option<Vec<f64>>,
        stiffness: impl Fn(&[f64]) -> Vec<f64>,
        mut fit: impl FnMut(&Model, &[f64], &[usize], Option<f64>) -> Result<Fit, InverseError>,
    ) -> Result<FittedContact, InverseError> {
        let m = self.model.muscles().len();
        let mut stiff = self.on(self.model).model_at(&stiffness(&x), &x)?;
        let (mut pairs, mut near) = (self.model.pairs().to_vec(), Vec::new());
        let mut best: Option<Least> = None;
        let (mut history, mut start_mm, mut linearisations) = (Vec::new(), None, 0);
        let mut roughly = self.is_linearised().then_some(ROUGHEST[1]);
        let mut rounds = MOST_ROUNDS;
        for round in 0..=MOST_ROUNDS {
            let is_last = round >= rounds || !self.is_linearised();
            if is_last && let Some(least) = best.take() {
                (pairs, x, near, roughly) = (least.pairs, least.unknowns, least.touching, None);
            } else if let Some(search) = self.search.filter(|_| roughly.is_some()) {
                linearisations += 1;
                let before = place.as_deref().map(|displacement| Nearby {
                    displacement,
                    pairs: &pairs,
                    touching: &near,
                });
                if let Some(there) = self.linearised(&stiff, search, &x[..m], before) {
                    near = touching(&there.equilibrium.contact_forces);
                    (pairs, place) = (there.pairs, Some(there.equilibrium.displacement));
                }
            }
            let found = fit(&self.model.with_pairs(pairs.clone()), &x, &near, roughly)?;
            history.extend(found.history);
            start_mm.get_or_insert(found.start_mm);
            let has_failed = found.unknowns.is_empty();
            if has_failed && !is_last && best.is_some() {
                // These contacts leave no answer: the best of those before is the last.
                rounds = round + 1;
                continue;
            }
            let (mut displacement, mut overlap_mm) = (None, None);
            if !has_failed {
                stiff = self.on(self.model).model_at(&stiffness(&found.unknowns), &found.unknowns)?;
                let u = stiff.displacement_with(&pairs, &found.unknowns[..m], found.forces.as_slice());
                overlap_mm = self.search.map(|search| search.at(self.face, &u, &stiff.pose()).overlap_mm());
                displacement = Some(u);
            }
            let overlap = overlap_mm.unwrap_or(0.);
            let change = largest_change(&found.unknowns, &x);
            let stands = overlap <= TOUCHING_MM && (change <= SAME || found.forces.iter().all(|f| *f <= 0.));
            if let Some(mut solution) = found.solution.filter(|_| is_last || stands || has_failed) {
                if self.is_linearised() && !stands && !has_failed {
                    solution.warnings.push(Warning::Unsettled { overlap_mm: overlap });
                    if overlap > BEARABLE_MM && solution.status.is_optimum() {
                        solution.status = Status::NotConverged;
                    }
                }
                let start_mm = start_mm.unwrap_or_else(|| DVector::zeros(0));
                let (linearisations, others) = (linearisations.max(1), Vec::new());
                return Ok(FittedContact {
                    solution,
                    pairs,
                    displacement,
                    overlap_mm,
                    linearisations,
                    history,
                    start_mm,
                    others,
                });
            }
            near = touching(&found.forces);
            if best.as_ref().is_none_or(|least| overlap < least.overlap_mm) {
                let (pairs, unknowns) = (pairs.clone(), found.unknowns.clone());
                best = Some(Least { overlap_mm: overlap, pairs, unknowns, touching: near.clone() });
            }
            // When the contacts stay the same ones are fitted exactly.
            roughly = (!stands).then_some((ROUGHLY * change).clamp(ROUGHEST[0], ROUGHEST[1]));
            x = found.unknowns;
        }
        Err(InverseError::NoStart)
    }

    /// The face at rest under the activations `a` with the candidates about it; `None` when it cannot be found.
    fn linearised(
        &self,
        stiff: &FixedStiffness<'_>,
        search: &ContactSearch,
        a: &[f64],
        start: Option<Nearby<'_>>,
    ) -> Option<Linearised> {
        let rounds = SETTLING_ROUNDS[usize::from(start.is_some())];
        let settled = stiff.settle_within(rounds, self.face, search, a, start).ok()?;
        let Equilibrium { displacement, contact_forces } = settled.equilibrium;
        let by_teeth = self.face.tooth_changes(&settled.pairs, &stiff.pose());
        let all = settled.pairs.into_iter().zip(contact_forces.iter()).zip(by_teeth);
        let near = all.filter(|((pair, force), by_tooth)| {
            **force > 0. || pair.gap_mm + pair.change_mm(&displacement) + by_tooth <= REACH_MM
        });
        let (pairs, forces): (Vec<Pair>, Vec<f64>) = near.map(|((pair, force), _)| (pair, *force)).unzip();
        let contact_forces = DVector::from_vec(forces);
        Some(Linearised { pairs, equilibrium: Equilibrium { displacement, contact_forces } })
    }
}

/// The fit with the least overlap so far.
struct Least {
    overlap_mm: f64,
    pairs: Vec<Pair>,
    unknowns: Vec<f64>,
    touching: Vec<usize>,
}

/// The face under some activations, and the candidates about it.
struct Linearised {
    pairs: Vec<Pair>,
    /// Its displacement, and the forces of these pairs.
    equilibrium: Equilibrium,
}

fn largest_change(a: &[f64], b: &[f64]) -> f64 {
    a.iter().zip(b).map(|(a, b)| (a - b).abs()).fold(0., f64::max)
}
