//! How far from the best an answer can be: best-first branch and bound on contact states.

use super::descent::Landscape;
use super::pivot::{Found, Search};
use super::relaxation::{Cost, Fixed, Relaxation, Relaxed, Working};
use crate::qp::ProblemError;

/// Share of the objective by which an answer may exceed the bound and still be called the best.
const RELATIVE: f64 = 1e-6;
/// The same as a share of the objective at rest, for targets that are met exactly.
const ABSOLUTE: f64 = 1e-10;
/// Relaxations before the bound is left as it is.
const MOST_NODES: usize = 4000;
/// Cost of the relaxations before the bound is left as it is: 0.3 to 0.8 s on an Intel Xeon core.
///
/// A program over 300 forces takes about 0.3 s. On a face hundreds of contact forces without complementarity are
/// as many actuators that fit anything, so that more time buys nothing there.
const MOST_COST: f64 = 1.5e8;

/// How the search for a lower bound ended.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum RelaxationEnd {
    /// No point is better by more than a millionth: the answer is the best of all contact states.
    Closed,
    /// The nodes were spent.
    NodeLimit,
    /// The cost of the relaxations was spent; programs with many contacts are expensive.
    CostLimit,
    /// A relaxation stopped short of its tolerance.
    NotConverged,
}

/// What branching found.
#[derive(Clone, Debug)]
pub(super) struct Bound {
    /// The objective that no point goes below.
    pub(super) lower: f64,
    /// Relaxations solved.
    pub(super) nodes: usize,
    pub(super) end: RelaxationEnd,
    /// A point with a lower objective than the one that was bounded.
    pub(super) better: Option<Found>,
}

/// Contact states still to be split.
struct Node {
    fixed: Fixed,
    relaxed: Relaxed,
}

/// Branch and bound over the contact states of a landscape.
struct Branching<'a> {
    landscape: Landscape<'a>,
    search: Search<'a>,
    cost: Cost,
    nodes: usize,
    /// Least objective known.
    best: f64,
    better: Option<Found>,
    open: Vec<Node>,
    /// Least bound among nodes that cannot be split further.
    stuck: f64,
}

/// Bounds the objective of `found` from below, and looks for better points on the way.
///
/// A node fixes some contacts to `lambda_i = 0` and some to `g_i = 0`. Its bound is the convex relaxation;
/// it is split at the contact that does the most work `lambda_i g_i`, which no point does. The node with
/// the least bound is split first, so that the least bound of all is that of the problem (Land and Doig 1960;
/// for complementarity, Bard and Moore 1990).
pub(super) fn branch<'a>(
    landscape: Landscape<'a>,
    found: &Found,
    rest_objective: f64,
) -> Result<Bound, ProblemError> {
    let mut branching = Branching {
        landscape,
        search: Search::new(landscape, rest_objective),
        cost: Cost { spent: 0.0, limit: MOST_COST },
        nodes: 0,
        best: found.optimum.objective,
        better: None,
        open: Vec::new(),
        stuck: f64::INFINITY,
    };
    let end = branching.run(ABSOLUTE * rest_objective)?;
    let lower = branching.least().min(branching.best);
    Ok(Bound { lower, nodes: branching.nodes, end, better: branching.better })
}

impl Branching<'_> {
    fn run(&mut self, absolute: f64) -> Result<RelaxationEnd, ProblemError> {
        self.add(Fixed::default(), &Working::default(), 0.0)?;
        loop {
            if self.least() >= self.best - RELATIVE * self.best - absolute {
                return Ok(RelaxationEnd::Closed);
            }
            if self.cost.spent > self.cost.limit {
                return Ok(RelaxationEnd::CostLimit);
            }
            if self.nodes >= MOST_NODES {
                return Ok(RelaxationEnd::NodeLimit);
            }
            let Some(at) = self.next() else { return Ok(RelaxationEnd::NotConverged) };
            let Node { fixed, relaxed } = self.open.swap_remove(at);
            let Some(contact) = splitting(&relaxed) else {
                // No work is left and yet no point was found there: the numbers do not allow more.
                self.stuck = self.stuck.min(relaxed.bound);
                continue;
            };
            for touches in [false, true] {
                let mut fixed = fixed.clone();
                let side = if touches { &mut fixed.touching } else { &mut fixed.open };
                side.insert(contact);
                self.add(fixed, &relaxed.working, relaxed.bound)?;
            }
        }
    }

    /// Bounds the contact states `fixed`, which are part of states that nothing below `parent` reaches.
    fn add(&mut self, fixed: Fixed, start: &Working, parent: f64) -> Result<(), ProblemError> {
        self.nodes += 1;
        match self.landscape.relaxed(&fixed, start, &mut self.cost)? {
            Relaxation::Empty => {}
            Relaxation::Failed => self.stuck = self.stuck.min(parent),
            Relaxation::Optimum(mut relaxed) => {
                relaxed.bound = relaxed.bound.max(parent);
                if relaxed.bound < self.best {
                    self.look_from(&relaxed)?;
                }
                self.open.push(Node { fixed, relaxed: *relaxed });
            }
        }
        Ok(())
    }

    /// Follows the relaxed activations downhill with the contact forces that they really call up.
    fn look_from(&mut self, relaxed: &Relaxed) -> Result<(), ProblemError> {
        if let Ok(found) = self.search.best(std::slice::from_ref(&relaxed.activation))?
            && found.optimum.objective < self.best
        {
            self.best = found.optimum.objective;
            self.better = Some(found);
        }
        Ok(())
    }

    /// The node with the least bound, the first of equal ones.
    fn next(&self) -> Option<usize> {
        let by_bound = |&a: &usize, &b: &usize| {
            self.open[a].relaxed.bound.total_cmp(&self.open[b].relaxed.bound).then(a.cmp(&b))
        };
        (0..self.open.len()).min_by(by_bound)
    }

    /// The least bound of all nodes: no point has a lower objective.
    fn least(&self) -> f64 {
        self.open.iter().map(|node| node.relaxed.bound).fold(self.stuck, f64::min)
    }
}

/// The contact that does the most work, the first of equal ones.
fn splitting(relaxed: &Relaxed) -> Option<usize> {
    let most = relaxed.work.max();
    let first = relaxed.work.iter().position(|&w| w == most)?;
    (most > 0.0).then_some(first)
}
