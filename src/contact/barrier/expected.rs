//! What pairs are expected to carry at the end of a step.

use std::collections::HashMap;

use super::Barrier;
use super::term::Term;
use crate::units::Vec3;

/// The force of each pair that a step closes, N, as its tangent has it at the end of the step.
///
/// The force of a barrier is near `c / d`: its tangent at `d` foretells a force `F` well, but at a distance far beyond
/// the touch. The secant to where the barrier carries `F` has the stiffness `F / d`, and stays before it. Source: so do
/// primal-dual interior-point methods with their multipliers; Wright, Primal-Dual Interior-Point Methods (1997).
#[derive(Clone, Debug, Default)]
pub struct ExpectedForces(HashMap<[u32; 4], f64>);

impl ExpectedForces {
    /// Of `terms` at `x` as the vertices go by `step` (mm).
    pub(super) fn of(terms: &[Term], barrier: &Barrier, x: &[Vec3], step: &[Vec3]) -> Self {
        let expected = |term: &Term| {
            let [_, slope, curve] = term.pair(barrier, x);
            let closing = -term.separation.rate(&Term::places(term.vertices, step));
            (closing > 0. && term.weight > 0.).then_some((term.vertices, curve * closing - slope))
        };
        Self(terms.iter().filter_map(expected).collect())
    }

    /// By how much the stiffness of `term` is exceeded by that of its secant; 1 where nothing is expected.
    pub(super) fn stiffening(&self, term: &Term, barrier: &Barrier, x: &[Vec3]) -> f64 {
        let Some(force) = self.0.get(&term.vertices) else { return 1. };
        let [.., curve] = term.pair(barrier, x);
        let secant = force / term.separation.distance();
        if curve > 0. && secant > curve { secant / curve } else { 1. }
    }
}
