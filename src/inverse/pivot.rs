//! The search over contact states.

use std::collections::BTreeSet;

use nalgebra::DVector;

use super::descent::Landscape;
use super::piece::{Crossing, Optimum, Outcome, Piece};
use crate::qp::{Infeasible, ProblemError};

/// Pieces solved before the search is given up.
const BUDGET: usize = 600;
/// Share of the objective by which a neighbour must improve.
const PROGRESS: f64 = 1e-10;

/// Crossings between walks.
const STRIDE: usize = 4;
/// Contacts whose crossings are worth the same up to this share cross together: on a symmetric face those
/// of the left and the right do.
const EQUAL: f64 = 1e-6;

/// The search over the pieces of a landscape.
pub(super) struct Search<'a> {
    pub(super) landscape: Landscape<'a>,
    /// Objective at rest: what improvements are measured against.
    pub(super) rest_objective: f64,
    visited: BTreeSet<Vec<usize>>,
}

/// A piece and its optimum.
#[derive(Clone, Debug)]
pub(super) struct Found {
    pub(super) piece: Piece,
    pub(super) optimum: Optimum,
    /// Whether every neighbouring piece was tried.
    pub(super) settled: bool,
}

/// What a search ends with when it finds no point.
#[derive(Debug)]
pub(super) enum Failure {
    Infeasible(Option<Infeasible>),
    NotConverged,
}

impl<'a> Search<'a> {
    /// A search that has seen no piece yet.
    pub(super) fn new(landscape: Landscape<'a>, rest_objective: f64) -> Self {
        Self { landscape, rest_objective, visited: BTreeSet::new() }
    }

    /// The best point reached from the contact state `touching`.
    pub(super) fn near(
        &mut self,
        touching: impl IntoIterator<Item = usize>,
    ) -> Result<Result<Found, Failure>, ProblemError> {
        let piece = Piece::new(self.landscape.space, self.landscape.contact, touching);
        self.visited.insert(piece.key());
        self.from(piece)
    }

    /// The best point reached from the activations `starts`, each followed downhill first.
    pub(super) fn best(&mut self, starts: &[DVector<f64>]) -> Result<Result<Found, Failure>, ProblemError> {
        let mut best: Option<Found> = None;
        let mut failure = Failure::Infeasible(None);
        for start in starts {
            let Some(end) = self.landscape.walk(start)? else { continue };
            let piece = Piece::on(self.landscape.space, self.landscape.contact, end.touching);
            if !self.visited.insert(piece.key()) {
                continue;
            }
            match self.from(piece)? {
                Ok(found) => {
                    if best.as_ref().is_none_or(|b| self.improves(found.optimum.objective, b)) {
                        best = Some(found);
                    }
                }
                Err(Failure::Infeasible(proof)) => {
                    if let Failure::Infeasible(None) = failure {
                        failure = Failure::Infeasible(proof);
                    }
                }
                Err(Failure::NotConverged) => failure = Failure::NotConverged,
            }
        }
        Ok(best.ok_or(failure))
    }

    /// The best point reached from `piece`.
    fn from(&mut self, piece: Piece) -> Result<Result<Found, Failure>, ProblemError> {
        let Landscape { terms, limits, .. } = self.landscape;
        Ok(match piece.optimum(terms, limits, &BTreeSet::new())? {
            Outcome::Optimum(optimum) => {
                Ok(self.descend(Found { piece, optimum: *optimum, settled: false })?)
            }
            Outcome::Infeasible(proof) => Err(Failure::Infeasible(proof)),
            Outcome::NotConverged => Err(Failure::NotConverged),
        })
    }

    fn improves(&self, objective: f64, old: &Found) -> bool {
        objective < old.optimum.objective - self.progress(old)
    }

    /// The least decrease that counts.
    fn progress(&self, old: &Found) -> f64 {
        PROGRESS * (old.optimum.objective + 1e-6 * self.rest_objective)
    }

    /// Crosses boundaries while the objective falls.
    fn descend(&mut self, mut current: Found) -> Result<Found, ProblemError> {
        let Landscape { terms, limits, .. } = self.landscape;
        let mut crossed = 0;
        'cross: loop {
            for crossing in self.crossings(&current) {
                if self.visited.len() >= BUDGET {
                    return Ok(current);
                }
                let piece = self.neighbour(&current, &crossing);
                if !self.visited.insert(piece.key()) {
                    continue;
                }
                if let Outcome::Optimum(optimum) = piece.optimum(terms, limits, &current.optimum.working)?
                    && self.improves(optimum.objective, &current)
                {
                    current = Found { piece, optimum: *optimum, settled: false };
                    crossed += 1;
                    if crossed % STRIDE == 0 {
                        current = self.stride(current)?;
                    }
                    continue 'cross;
                }
            }
            current.settled = true;
            return Ok(current);
        }
    }

    /// The optimum of the piece that a walk from the current one ends in, when that is better.
    fn stride(&mut self, current: Found) -> Result<Found, ProblemError> {
        let Landscape { space, contact, terms, limits } = self.landscape;
        let Some(end) = self.landscape.walk(&current.optimum.state.activation)? else { return Ok(current) };
        if !self.improves(end.objective, &current) {
            return Ok(current);
        }
        let piece = Piece::on(space, contact, end.touching);
        if self.visited.insert(piece.key())
            && let Outcome::Optimum(optimum) = piece.optimum(terms, limits, &BTreeSet::new())?
            && self.improves(optimum.objective, &current)
        {
            return Ok(Found { piece, optimum: *optimum, settled: false });
        }
        Ok(current)
    }

    /// Sets of contacts to cross: all promising ones together, then those whose crossings are worth the
    /// same, most first.
    ///
    /// Beyond the others the optimum is the present one: their multipliers prove it.
    fn crossings(&self, current: &Found) -> Vec<Vec<usize>> {
        let enough = self.progress(current) / self.landscape.space.n_unknowns() as f64;
        let mut promising: Vec<Crossing> =
            current.optimum.boundary.iter().filter(|c| c.rate > 0.0 && c.worth > enough).copied().collect();
        promising.sort_by(|a, b| b.worth.total_cmp(&a.worth).then(a.contact.cmp(&b.contact)));
        let alike = |a: &Crossing, b: &Crossing| a.worth - b.worth <= EQUAL * a.worth;
        let groups: Vec<Vec<usize>> =
            promising.chunk_by(alike).map(|group| group.iter().map(|c| c.contact).collect()).collect();
        let mut crossings = Vec::new();
        if promising.len() > 1 {
            crossings.push(promising.iter().map(|c| c.contact).collect());
        }
        let single = groups.iter().filter(|group| group.len() > 1).flatten().map(|&i| vec![i]);
        crossings.extend(groups.iter().cloned().chain(single));
        crossings
    }

    /// The piece beyond the boundary of `crossing`.
    fn neighbour(&self, current: &Found, crossing: &[usize]) -> Piece {
        let Landscape { space, contact, .. } = self.landscape;
        let mut touching = current.piece.touching.clone();
        for &i in crossing.iter().filter(|&&i| current.piece.touches(i)) {
            touching.drop(i);
        }
        let entering: Vec<usize> = crossing.iter().copied().filter(|&i| !current.piece.touches(i)).collect();
        let mut held = touching.contacts().to_vec();
        if entering.iter().all(|&i| touching.add(&contact.compliance, i)) {
            return Piece::on(space, contact, touching);
        }
        // Where an entering contact repeats a held one, the one without force gives way.
        let force = &current.optimum.force;
        held.sort_by_key(|&i| (force[i] <= 0.0, i));
        Piece::new(space, contact, entering.into_iter().chain(held))
    }
}
