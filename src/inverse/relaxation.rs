//! The convex relaxation of contact: complementarity dropped where the contact state is not fixed.

use std::collections::BTreeSet;
use std::sync::Arc;

use nalgebra::{DMatrix, DVector};

use super::descent::Landscape;
use super::limit::Limit;
use super::limits::ContactReactions;
use super::program::{Space, build};
use super::term::State;
use crate::qp::{self, Answer, Point, ProblemError};

/// Rounds of adding contacts to one relaxation before it is given up.
const ROUNDS: usize = 60;
/// Contacts added in one round, of each sort.
const BATCH: usize = 20;
/// Violations below this share of their size are rounding.
const ROUNDING: f64 = 1e-9;

/// Contacts whose state is fixed; the others only keep `lambda >= 0` and `g >= 0`.
#[derive(Clone, Debug, Default)]
pub(super) struct Fixed {
    /// Contacts with `lambda = 0`.
    pub(super) open: BTreeSet<usize>,
    /// Contacts with `g = 0`.
    pub(super) touching: BTreeSet<usize>,
}

/// The contacts that are unknowns and rows of a relaxation; the others hold without being asked.
#[derive(Clone, Debug, Default)]
pub(super) struct Working {
    pub(super) forces: BTreeSet<usize>,
    pub(super) gaps: BTreeSet<usize>,
}

/// The optimum of a relaxation.
#[derive(Clone, Debug)]
pub(super) struct Relaxed {
    /// Least objective: no point with these contact states has less.
    pub(super) bound: f64,
    pub(super) activation: DVector<f64>,
    /// `lambda_i g_i` (c), N mm, of the contacts that are not fixed: zero where complementarity holds.
    pub(super) work: DVector<f64>,
    /// Contacts that matter here: a good start for the states that are part of these.
    pub(super) working: Working,
}

/// What became of a relaxation.
pub(super) enum Relaxation {
    Optimum(Box<Relaxed>),
    /// The contact states contradict each other, or the limits.
    Empty,
    /// It stopped short, or its cost was spent.
    Failed,
}

/// Cost of the programs of a bound: (unknowns + rows)^3 summed, what their factorisations need.
#[derive(Clone, Copy, Debug)]
pub(super) struct Cost {
    pub(super) spent: f64,
    pub(super) limit: f64,
}

impl Landscape<'_> {
    /// Least objective with the contact states of `fixed`, and `lambda >= 0`, `g >= 0` without
    /// `lambda g = 0` for the others.
    ///
    /// Contacts enter as they matter: gaps that are violated, and forces whose reduced cost
    /// `R' df/du - S w` is negative, `w` being the multipliers of the gaps. Of a restricted program without
    /// a point the multipliers of its proof are priced in the same way, with `df/du = 0`.
    pub(super) fn relaxed(
        &self,
        fixed: &Fixed,
        start: &Working,
        cost: &mut Cost,
    ) -> Result<Relaxation, ProblemError> {
        let Landscape { space, contact, terms, limits } = *self;
        let (m, c) = (space.n_unknowns(), contact.gap.len());
        let mut working = start.clone();
        working.forces.extend(&fixed.touching);
        working.forces.retain(|i| !fixed.open.contains(i));
        working.gaps.retain(|i| !fixed.touching.contains(i));
        for _ in 0..ROUNDS {
            let columns: Vec<usize> = working.forces.iter().copied().collect();
            let rows: Vec<usize> = working.gaps.iter().copied().collect();
            let touching: Vec<usize> = fixed.touching.iter().copied().collect();
            cost.spent += ((m + columns.len() + rows.len() + touching.len()) as f64).powi(3);
            if cost.spent > cost.limit {
                return Ok(Relaxation::Failed);
            }
            let mut observed = DMatrix::zeros(space.offset.len(), m + columns.len());
            observed.columns_mut(0, m).copy_from(&space.observed);
            observed.columns_mut(m, columns.len()).copy_from(&contact.reach.select_columns(&columns));
            let pushed = Space { observed, offset: space.offset.clone() };
            let reactions = ContactReactions {
                contact: Arc::clone(contact),
                forces: columns.clone(),
                touching: touching.clone(),
                open: rows.clone(),
            };
            let mut all: Vec<&dyn Limit> = limits.to_vec();
            all.push(&reactions);
            let model = terms.over(&pushed);
            // Multipliers `w` (c) of the gaps, from those of the rows.
            let by_contact = |point: &Point| {
                let mut w = DVector::zeros(c);
                for (&i, &z) in rows.iter().zip(point.inequality.iter()) {
                    w[i] = z;
                }
                let ties = point.equality.len() - touching.len();
                for (&i, &y) in touching.iter().zip(point.equality.iter().skip(ties)) {
                    w[i] = -y;
                }
                w
            };
            let price = |slope: DVector<f64>, w: DVector<f64>, forces: &mut BTreeSet<usize>| {
                let pressed = &contact.compliance * w;
                let size = slope.amax().max(pressed.amax());
                add_negative(&(slope - pressed), size, forces, &fixed.open)
            };
            match qp::solve(&build(&model, &all).problem)? {
                Answer::Solved(solution) => {
                    let x = &solution.point.x;
                    let mut force = DVector::zeros(c);
                    for (k, &i) in columns.iter().enumerate() {
                        force[i] = x[m + k];
                    }
                    let activation = x.rows(0, m).into_owned();
                    let gap = &contact.gap + &contact.approach * &activation + &contact.compliance * &force;
                    let state = State { observed: pushed.at(x), activation };
                    let slope = contact.reach.tr_mul(&terms.observed_gradient(&state));
                    let size = gap.amax().max(contact.gap.amax());
                    let deep = add_negative(&gap, size, &mut working.gaps, &fixed.touching);
                    if deep | price(slope, by_contact(&solution.point), &mut working.forces) {
                        continue;
                    }
                    let bound = model.objective(x);
                    let mut work = force.component_mul(&gap.map(|g| g.max(0.0)));
                    for &i in fixed.touching.iter().chain(&fixed.open) {
                        work[i] = 0.0;
                    }
                    let activation = state.activation;
                    let w = by_contact(&solution.point);
                    working.forces.retain(|&i| force[i] > 0.0);
                    working.gaps.retain(|&i| w[i] > 0.0);
                    return Ok(Relaxation::Optimum(Box::new(Relaxed { bound, activation, work, working })));
                }
                Answer::Infeasible(proof) => {
                    let w = by_contact(&proof.multipliers);
                    if !price(DVector::zeros(c), w, &mut working.forces) {
                        return Ok(Relaxation::Empty);
                    }
                }
                Answer::NotConverged(_) | Answer::Unbounded(_) => return Ok(Relaxation::Failed),
            }
        }
        Ok(Relaxation::Failed)
    }
}

/// Adds the contacts with the most negative `values` to `chosen`; false when there are none but those
/// already chosen and those `barred`.
fn add_negative(
    values: &DVector<f64>,
    size: f64,
    chosen: &mut BTreeSet<usize>,
    barred: &BTreeSet<usize>,
) -> bool {
    let mut wrong: Vec<usize> = (0..values.len())
        .filter(|i| values[*i] < -ROUNDING * size && !chosen.contains(i) && !barred.contains(i))
        .collect();
    wrong.sort_by(|&i, &j| values[i].total_cmp(&values[j]).then(i.cmp(&j)));
    chosen.extend(wrong.iter().take(BATCH));
    !wrong.is_empty()
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::contact::PairKind;
    use crate::forward::ContactResponse;
    use crate::inverse::limits::ActivationBounds;
    use crate::inverse::program::Linearisation;
    use crate::inverse::target::EffortNorm;
    use crate::inverse::terms::{Effort, MarkerDisplacement};

    /// What is left of `1/2 ((u - 1)^2 + a^2)` with `u = a + lambda_1` where only a force on contact 1 closes
    /// contact 0.
    fn relaxed(fixed: &Fixed) -> Relaxation {
        let contact = Arc::new(ContactResponse {
            kinds: vec![PairKind::Lips; 2],
            gap: DVector::from_vec(vec![0.9, 0.5]),
            approach: DMatrix::zeros(2, 1),
            compliance: DMatrix::from_row_slice(2, 2, &[1.0, -0.9, -0.9, 1.0]),
            reach: DMatrix::from_row_slice(3, 2, &[0.0, 1.0, 0.0, 0.0, 0.0, 0.0]),
        });
        let space =
            Space { observed: DMatrix::from_column_slice(3, 1, &[1.0, 0.0, 0.0]), offset: DVector::zeros(3) };
        let wish = MarkerDisplacement { point: 0, target_mm: [Some(1.0), None, None], sigma_mm: 1.0 };
        let rest = State { observed: DVector::zeros(3), activation: DVector::zeros(1) };
        let effort = Effort::even(1, 1.0, EffortNorm::L2);
        let terms = Linearisation::new([&wish as &dyn crate::inverse::term::Term, &effort], &rest);
        let bounds = ActivationBounds::unit(1);
        let limits: [&dyn Limit; 1] = [&bounds];
        let landscape = Landscape { space: &space, contact: &contact, terms: &terms, limits: &limits };
        let mut cost = Cost { spent: 0.0, limit: f64::INFINITY };
        landscape.relaxed(fixed, &Working::default(), &mut cost).expect("a program")
    }

    #[test]
    fn forces_that_only_a_proof_asks_for_are_found() {
        // g_0 = 0.9 + lambda_0 - 0.9 lambda_1 = 0 needs lambda_1 >= 1, which is also what the target wants; the
        // program with lambda_0 alone has no point.
        let touching = Fixed { touching: [0].into(), ..Fixed::default() };
        let Relaxation::Optimum(found) = relaxed(&touching) else { unreachable!("lambda_1 = 1 closes it") };
        assert!(found.bound.abs() < 1e-9 && found.working.forces.contains(&1), "{found:?}");
        // Without lambda_1 nothing closes it.
        let barred = Fixed { touching: [0].into(), open: [1].into() };
        assert!(matches!(relaxed(&barred), Relaxation::Empty));
    }

    #[test]
    fn a_force_enters_for_what_it_does_to_the_target_and_its_work_is_told() {
        let Relaxation::Optimum(found) = relaxed(&Fixed::default()) else { unreachable!("rest is a point") };
        // lambda_1 reaches the target alone, across a gap of 0.5 + 1.
        assert!(found.bound.abs() < 1e-9, "{found:?}");
        assert!((found.work[1] - 1.5).abs() < 1e-6 && found.work[0].abs() < 1e-6, "{:?}", found.work);
    }
}
