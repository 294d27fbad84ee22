//! The contact forces that given activations call up.

use nalgebra::{DMatrix, DVector};
use thiserror::Error;

use super::{ContactResponse, Touching};
use crate::qp::{self, Answer, Problem, ProblemError};

/// Gaps and forces within this share of their scale count as zero.
const ROUNDING: f64 = 1e-11;
/// Exchanges of the touching set before the descent takes over.
const EXCHANGES: usize = 15;
/// Contacts that join in a descent before the quadratic program takes over.
const DESCENTS: usize = 2000;
/// Whole-set exchanges without progress before single ones.
const PATIENCE: usize = 5;

/// Why no contact forces were found.
#[derive(Clone, Debug, PartialEq, Error)]
#[non_exhaustive]
pub enum ContactError {
    /// The response is not that of a stable face.
    #[error("the contact response is malformed: {0}")]
    Response(#[from] ProblemError),
    /// Contacts that no force can keep apart, or a program too badly conditioned.
    #[error("the contact forces could not be found to 1e-9; a fixed node may penetrate")]
    NotConverged,
}

/// Contact forces `lambda` (c), N, at activations `a` (m):
/// `0 <= lambda  _|_  g0 + V a + S lambda >= 0`.
///
/// Redundant contacts share their force arbitrarily; displacements and gaps are unique. Block
/// principal pivoting (Judice and Pires 1994), backed by a descent of `min 1/2 l'Sl + (g0 + Va)'l` over `l >= 0`
/// from one set of touching contacts to the next, and that by the quadratic program.
///
/// # Errors
/// [`ContactError`] when the response is not finite or not positive semidefinite, or no forces exist.
pub fn contact_forces(
    contact: &ContactResponse,
    activation: &DVector<f64>,
) -> Result<DVector<f64>, ContactError> {
    contact_forces_near(contact, activation, None).map(|(forces, _)| forces)
}

/// The [`contact_forces`] `lambda` (c), N, and the contacts that hold them, sought from those of a
/// nearby activation.
///
/// # Errors
/// As [`contact_forces`].
pub fn contact_forces_near(
    contact: &ContactResponse,
    activation: &DVector<f64>,
    nearby: Option<&Touching>,
) -> Result<(DVector<f64>, Touching), ContactError> {
    forces_holding(&contact.compliance, &(&contact.gap + &contact.approach * activation), nearby)
}

/// The forces `lambda` (c), N, with `0 <= lambda  _|_  v + S lambda >= 0` for the `compliance` `S` (c x c, mm/N) and the gaps
/// `v` (c, mm) without them, and the contacts that hold them, sought from those `nearby`.
///
/// # Errors
/// As [`contact_forces`].
pub fn forces_holding(
    compliance: &DMatrix<f64>,
    free_gap: &DVector<f64>,
    nearby: Option<&Touching>,
) -> Result<(DVector<f64>, Touching), ContactError> {
    let start = match nearby {
        Some(touching) => touching.clone(),
        None => Touching::new(compliance, (0..free_gap.len()).filter(|&i| free_gap[i] < 0.0)),
    };
    let found =
        exchange(compliance, free_gap, start.clone()).or_else(|| descend(compliance, free_gap, start));
    if let Some(found) = found {
        return Ok(found);
    }
    let forces = program(compliance, free_gap)?;
    let touching = Touching::new(compliance, (0..forces.len()).filter(|&i| forces[i] > 0.0));
    Ok((forces, touching))
}

/// Exchanges contacts that pull with ones that penetrate until neither is left.
fn exchange(
    compliance: &DMatrix<f64>,
    free_gap: &DVector<f64>,
    mut touching: Touching,
) -> Option<(DVector<f64>, Touching)> {
    let c = free_gap.len();
    let gap_scale = free_gap.amax();
    if !gap_scale.is_finite() {
        return None;
    }
    let (mut fewest, mut patience) = (usize::MAX, PATIENCE);
    for _ in 0..EXCHANGES {
        let mut closed = vec![false; c];
        for &i in touching.contacts() {
            closed[i] = true;
        }
        let mut forces = touching.forces(free_gap);
        let held: Vec<f64> = touching.contacts().iter().map(|&i| forces[i]).collect();
        let gaps = free_gap + touching.opening(compliance, &held);
        let force_tolerance = ROUNDING * forces.amax();
        let wrong: Vec<usize> = (0..c)
            .filter(
                |&i| if closed[i] { forces[i] < -force_tolerance } else { gaps[i] < -ROUNDING * gap_scale },
            )
            .collect();
        if wrong.is_empty() {
            forces.apply(|f| *f = f.max(0.0));
            return Some((forces, touching));
        }
        if wrong.len() < fewest {
            (fewest, patience) = (wrong.len(), PATIENCE);
        } else {
            patience = patience.saturating_sub(1);
        }
        let last = wrong.len() - 1;
        let exchanged = if patience > 0 { &wrong[..] } else { &wrong[last..] };
        for &i in exchanged.iter().filter(|&&i| closed[i]) {
            touching.drop(i);
        }
        let (mut all, mut repeats) = (touching.contacts().to_vec(), false);
        for &i in exchanged.iter().filter(|&&i| !closed[i]) {
            all.push(i);
            repeats |= !touching.add(compliance, i);
        }
        if repeats {
            // Of contacts that repeat each other another choice may hold.
            all.sort_unstable();
            touching = Touching::new(compliance, all);
        }
    }
    None
}

/// The same forces by a primal active set: the energy `1/2 l'Sl + v'l` falls with every step, so that no set of
/// touching contacts comes back (Lawson and Hanson 1974, chapter 23). The contact that penetrates deepest joins; a
/// force that would pull stops the step at zero and leaves. Where the row of the new contact repeats those held,
/// `S d = 0` for an exchange of force `d` between them, and the energy falls along it until one of them lets go.
fn descend(
    compliance: &DMatrix<f64>,
    free_gap: &DVector<f64>,
    mut touching: Touching,
) -> Option<(DVector<f64>, Touching)> {
    let c = free_gap.len();
    let tolerance = ROUNDING * free_gap.amax();
    let mut forces = DVector::<f64>::zeros(c);
    for _ in 0..DESCENTS {
        loop {
            let sought = touching.forces(free_gap);
            let pulls = |&&i: &&usize| sought[i] <= 0.0 && sought[i] < forces[i] || sought[i] < 0.0;
            let share = |&i: &usize| forces[i] / (forces[i] - sought[i]);
            let blocking: Vec<usize> = touching.contacts().iter().filter(pulls).copied().collect();
            let Some(first) = blocking.iter().map(share).min_by(f64::total_cmp) else {
                forces = sought;
                break;
            };
            let leaving: Vec<usize> = blocking.iter().copied().filter(|i| share(i) <= first).collect();
            forces += first * (&sought - &forces);
            for i in leaving {
                touching.drop(i);
                forces[i] = 0.0;
            }
        }
        let held: Vec<f64> = touching.contacts().iter().map(|&i| forces[i]).collect();
        let gaps = free_gap + touching.opening(compliance, &held);
        let open = (0..c).filter(|i| !touching.contacts().contains(i));
        let deepest = open.min_by(|&i, &j| gaps[i].total_cmp(&gaps[j])).filter(|&i| gaps[i] < -tolerance);
        let Some(entering) = deepest else { return Some((forces, touching)) };
        if touching.add(compliance, entering) {
            continue;
        }
        let contacts = touching.contacts().to_vec();
        let mut repeated = DMatrix::from_fn(contacts.len(), 1, |k, _| compliance[(contacts[k], entering)]);
        touching.solve(&mut repeated);
        let gives = |&k: &usize| repeated[k] > 0.0;
        let by_ratio = |k: &usize| forces[contacts[*k]] / repeated[*k];
        let out = (0..contacts.len()).filter(gives).min_by(|a, b| by_ratio(a).total_cmp(&by_ratio(b)))?;
        let moved = by_ratio(&out);
        for (k, &i) in contacts.iter().enumerate() {
            forces[i] = (forces[i] - moved * repeated[k]).max(0.0);
        }
        touching.drop(contacts[out]);
        forces[contacts[out]] = 0.0;
        forces[entering] = moved;
        if !touching.add(compliance, entering) {
            return None;
        }
    }
    None
}

/// The same forces from the quadratic program, with columns added as their contacts penetrate.
fn program(compliance: &DMatrix<f64>, free_gap: &DVector<f64>) -> Result<DVector<f64>, ContactError> {
    let c = free_gap.len();
    let mut chosen: Vec<usize> = (0..c).filter(|&i| free_gap[i] < 0.0 || free_gap[i].is_nan()).collect();
    loop {
        let k = chosen.len();
        let hessian = DMatrix::from_fn(k, k, |i, j| compliance[(chosen[i], chosen[j])]);
        let mut problem = Problem::unconstrained(hessian, DVector::from_fn(k, |i, _| free_gap[chosen[i]]));
        problem.lower.fill(0.0);
        let Answer::Solved(solution) = qp::solve(&problem)? else { return Err(ContactError::NotConverged) };
        let mut forces = DVector::zeros(c);
        for (&i, &force) in chosen.iter().zip(solution.point.x.iter()) {
            forces[i] = force;
        }
        let gaps = free_gap + compliance * &forces;
        let tolerance = 1e-9 * free_gap.amax();
        let penetrating: Vec<usize> =
            (0..c).filter(|i| gaps[*i] < -tolerance && chosen.binary_search(i).is_err()).collect();
        if penetrating.is_empty() {
            return Ok(forces);
        }
        chosen.extend(penetrating);
        chosen.sort_unstable();
    }
}
