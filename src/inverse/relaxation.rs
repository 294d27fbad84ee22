//! The convex lower bound without complementarity.

use std::collections::BTreeSet;
use std::sync::Arc;

use nalgebra::{DMatrix, DVector};

use super::limit::Limit;
use super::limits::ContactReactions;
use super::program::{Linearisation, Space, build};
use super::term::State;
use crate::forward::ContactResponse;
use crate::qp::{self, Answer, ProblemError};

/// Rounds of adding contacts before the trivial bound is returned.
const ROUNDS: usize = 40;
/// Contacts added in one round, of each sort.
const BATCH: usize = 40;
/// Forces beyond which the programs get too slow to be worth a bound.
const LARGEST: usize = 120;
/// Violations below this share of their size are rounding.
const ROUNDING: f64 = 1e-9;

/// Least `1/2 sum r^2` with `lambda >= 0` and `g >= 0` but without `lambda g = 0`.
///
/// Contacts enter as they matter: forces whose reduced cost is negative, gaps that are violated. When
/// that does not settle, the answer is 0, which a sum of squares always exceeds.
pub(super) fn lower_bound(
    space: &Space,
    contact: &Arc<ContactResponse>,
    terms: &Linearisation,
    limits: &[&dyn Limit],
    start: &[usize],
) -> Result<f64, ProblemError> {
    let (m, c) = (space.n_unknowns(), contact.gap.len());
    let mut forces: BTreeSet<usize> = start.iter().copied().collect();
    let mut open = forces.clone();
    for _ in 0..ROUNDS {
        if forces.len() > LARGEST {
            break;
        }
        let columns: Vec<usize> = forces.iter().copied().collect();
        let rows: Vec<usize> = open.iter().copied().collect();
        let reach = contact.reach.select_columns(&columns);
        let mut observed = DMatrix::zeros(space.offset.len(), m + columns.len());
        observed.columns_mut(0, m).copy_from(&space.observed);
        observed.columns_mut(m, columns.len()).copy_from(&reach);
        let space = Space { observed, offset: space.offset.clone() };
        let reactions = ContactReactions {
            contact: Arc::clone(contact),
            forces: columns.clone(),
            touching: Vec::new(),
            open: rows.clone(),
        };
        let mut all: Vec<&dyn Limit> = limits.to_vec();
        all.push(&reactions);
        let residuals = terms.residuals(&space);
        let program = build(&residuals, &all);
        let Answer::Solved(solution) = qp::solve(&program.problem)? else { break };
        let x = &solution.point.x;
        let mut force = DVector::zeros(c);
        for (k, &i) in columns.iter().enumerate() {
            force[i] = x[m + k];
        }
        let mut multiplier = DVector::zeros(c);
        for (&i, &z) in rows.iter().zip(solution.point.inequality.iter()) {
            multiplier[i] = z;
        }
        let activation = x.rows(0, m).into_owned();
        let gap = &contact.gap + &contact.approach * &activation + &contact.compliance * &force;
        let state = State { observed: &space.observed * x, activation };
        let slope = contact.reach.tr_mul(&terms.observed_gradient(&state));
        let pressed = &contact.compliance * &multiplier;
        let cost = &slope - &pressed;
        let gap_size = gap.amax().max(contact.gap.amax());
        let cost_size = slope.amax().max(pressed.amax());
        let add = |values: &DVector<f64>, size: f64, chosen: &mut BTreeSet<usize>| -> bool {
            let mut wrong: Vec<usize> =
                (0..c).filter(|i| values[*i] < -ROUNDING * size && !chosen.contains(i)).collect();
            wrong.sort_by(|&i, &j| values[i].total_cmp(&values[j]).then(i.cmp(&j)));
            chosen.extend(wrong.iter().take(BATCH));
            !wrong.is_empty()
        };
        let grown = [add(&gap, gap_size, &mut open), add(&cost, cost_size, &mut forces)];
        if grown == [false, false] {
            return Ok(residuals.objective(x));
        }
    }
    Ok(0.0)
}
