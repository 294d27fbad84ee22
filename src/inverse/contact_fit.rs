//! A fit whose contacts are those of the face where it went.

use super::sequential::SequentialState;
use super::solution::{Solution, Status};
use super::warning::Warning;
use super::{ActivatedProblem, ActivatedSolution, ContactMode, InverseError, Observations, Target};
use crate::contact::Pair;
use crate::face::{ContactSearch, Face};
use crate::forward::{FixedStiffness, Model};

/// Linearisations of the contacts before giving up.
const MOST_ROUNDS: usize = 8;
/// Deepest overlap of the true surfaces, mm, that counts as none.
const TOUCHING_MM: f64 = 1e-2;
/// Deepest overlap, mm, of an answer that may be called solved: a quarter of the error of placing a landmark
/// (0.4 mm).
const BEARABLE_MM: f64 = 0.1;
/// Largest change of an activation from one linearisation to the next when the activations stay.
const SAME: f64 = 1e-3;
/// Candidates farther apart than this, mm, where contact was linearised are left out: no activation changes by
/// more than the next linearisation finds out.
const REACH_MM: f64 = 4.;

/// A target on a face, fitted again with the gaps and normals of where the last answer led, until surfaces that
/// are not planes no longer overlap.
///
/// Each linearisation is about the face [at rest on its true surfaces](FixedStiffness::settle) under the last
/// activations; where these stay, the answer satisfies the optimality conditions with the contacts of its own
/// deformed face.
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
}

impl<'a> ContactFit<'a> {
    /// The answer at the fixed stiffness of the uniform activation `share`, from `first`, which was found with the
    /// candidates at rest.
    ///
    /// # Errors
    /// [`InverseError`] when the face cannot be solved.
    pub fn fixed(&self, share: f64, first: Solution) -> Result<FittedContact, InverseError> {
        let held = vec![share; self.model.muscles().len()];
        self.settle(first, |_| held.clone(), |problem, _| problem.solve_at_fixed_stiffness(share))
    }

    /// The answer with muscles that stiffen, from `first`, which was found with the candidates at rest and gets
    /// the programs of all linearisations as its history; `tell` hears of every step.
    ///
    /// # Errors
    /// [`InverseError`] when the face cannot be solved at some activation.
    pub fn activated(
        &self,
        first: &mut ActivatedSolution,
        tell: impl FnMut(&SequentialState) + Clone + 'static,
    ) -> Result<FittedContact, InverseError> {
        let history = &mut first.history;
        self.settle(first.solution.clone(), <[f64]>::to_vec, |problem, last| {
            let next = problem.solve(problem.start(last), tell.clone())?;
            history.extend(next.history);
            Ok(next.solution)
        })
    }

    fn settle(
        &self,
        first: Solution,
        stiffness: impl Fn(&[f64]) -> Vec<f64>,
        mut fit: impl FnMut(ActivatedProblem<'_>, &Solution) -> Result<Solution, InverseError>,
    ) -> Result<FittedContact, InverseError> {
        let mut model = self.model.clone();
        let mut solution = first;
        let mut best: Option<FittedContact> = None;
        let (mut last, mut place): (Option<Vec<f64>>, Option<Vec<f64>>) = (None, None);
        for linearisations in 1..=MOST_ROUNDS {
            let a = solution.activations.values.clone();
            if a.is_empty() {
                break;
            }
            let problem = ActivatedProblem::new(&model, self.target, self.observations, self.mode);
            let stiff = problem.model_at(&stiffness(&a), &solution)?;
            let u = stiff.displacement(&a, solution.contact_forces.as_slice());
            let overlap_mm = self.search.map(|search| search.at(self.face, &u, &stiff.pose()).overlap_mm());
            let change = last.as_ref().map_or(f64::INFINITY, |last| largest_change(last, &a));
            let now = FittedContact {
                solution: solution.clone(),
                pairs: model.pairs().to_vec(),
                displacement: Some(u),
                overlap_mm,
                linearisations,
            };
            let Some((search, overlap)) =
                self.search.zip(overlap_mm).filter(|_| self.mode == ContactMode::Reactions)
            else {
                return Ok(now);
            };
            let is_free = now.solution.contact_forces.iter().all(|f| *f <= 0.);
            if overlap <= TOUCHING_MM && (change <= SAME || is_free) {
                return Ok(now);
            }
            let is_better = |best: &FittedContact| {
                let solved = |f: &FittedContact| f.solution.status == Status::Solved;
                (solved(&now), -overlap) > (solved(best), -best.overlap_mm.unwrap_or(0.))
            };
            if best.as_ref().is_none_or(is_better) {
                best = Some(now);
            }
            if linearisations == MOST_ROUNDS {
                break;
            }
            let Some((pairs, there)) = self.linearised(&stiff, search, &a, place.as_deref()) else { break };
            (last, place) = (Some(a.clone()), Some(there));
            model = self.model.with_pairs(pairs);
            let problem = ActivatedProblem::new(&model, self.target, self.observations, self.mode);
            solution = fit(problem, &solution)?;
        }
        let Some(mut fitted) = best else {
            let pairs = self.model.pairs().to_vec();
            return Ok(FittedContact {
                solution,
                pairs,
                displacement: None,
                overlap_mm: None,
                linearisations: 1,
            });
        };
        if let Some(overlap_mm) = fitted.overlap_mm {
            fitted.solution.warnings.push(Warning::Unsettled { overlap_mm });
            if overlap_mm > BEARABLE_MM && fitted.solution.status == Status::Solved {
                fitted.solution.status = Status::NotConverged;
            }
        }
        Ok(fitted)
    }

    /// The candidates about the face under the activations `a`, and its displacement there; `None` when it cannot
    /// be found.
    fn linearised(
        &self,
        stiff: &FixedStiffness<'_>,
        search: &ContactSearch,
        a: &[f64],
        start: Option<&[f64]>,
    ) -> Option<(Vec<Pair>, Vec<f64>)> {
        let settled = stiff.settle(self.face, search, a, start).ok()?;
        let u = settled.equilibrium.displacement;
        let forces = settled.equilibrium.contact_forces;
        let by_teeth = self.face.tooth_changes(&settled.pairs, &stiff.pose());
        let all = settled.pairs.into_iter().zip(forces.iter()).zip(by_teeth);
        let near = all.filter(|((pair, force), by_tooth)| {
            **force > 0. || pair.gap_mm + pair.change_mm(&u) + by_tooth <= REACH_MM
        });
        Some((near.map(|((pair, _), _)| pair).collect(), u))
    }
}

fn largest_change(a: &[f64], b: &[f64]) -> f64 {
    a.iter().zip(b).map(|(a, b)| (a - b).abs()).fold(0., f64::max)
}
