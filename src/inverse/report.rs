//! From the numbers of an optimum to a solution with names.

use std::sync::Arc;

use nalgebra::DVector;

use super::branching::Bound;
use super::detect;
use super::limit::LimitName;
use super::pivot::Found;
use super::problem::{ContactMode, Problem};
use super::solution::{
    Activations, ActiveLimit, ContactReport, FeatureFit, LimitKind, MarkerFit, Residual, Solution, Status,
};
use super::tangent_program::TangentProgram;
use super::target::JawOpening;
use super::term::{State, objective};
use super::warning::Warning;
use crate::contact::PairKind;
use crate::forward::ContactResponse;
use crate::qp::{Certificate, Point};
use crate::units::Vec3;

/// Multipliers below this share of the largest hold nothing back.
const IDLE: f64 = 1e-9;

/// The answer when there is none.
pub(super) fn empty(problem: &Problem, status: Status) -> Solution {
    let markers = problem
        .markers
        .iter()
        .map(|marker| MarkerFit {
            name: marker.name.clone(),
            rest_mm: marker.rest_mm,
            target_mm: marker.target_mm,
            model_mm: Vec3::zeros(),
            residual_mm: None,
        })
        .collect();
    Solution {
        status,
        activations: Activations::default(),
        jaw_opening_mm: None,
        contact_forces: DVector::zeros(0),
        observed_mm: problem.space.offset.clone(),
        objective: 0.0,
        residual: Residual::default(),
        explained: None,
        markers,
        features: Vec::new(),
        active_limits: Vec::new(),
        contact: ContactReport::default(),
        certificate: Certificate::default(),
        program: None,
        infeasible: None,
        warnings: detect::before(problem),
    }
}

/// The answer at `point`, the certified point over `(a, lambda_I)` of the piece that was found.
pub(super) fn solution(
    problem: &Problem,
    mode: ContactMode,
    status: Status,
    found: &Found,
    point: &Point,
    certificate: Certificate,
    bound: Option<&Bound>,
) -> Solution {
    let activation = point.x.rows(0, problem.n_unknowns()).into_owned();
    let contact = problem.contact.as_deref().filter(|_| mode != ContactMode::Off);
    let touching = if mode == ContactMode::Reactions { found.piece.touching.contacts() } else { &[] };
    let mut forces = DVector::zeros(contact.map_or(0, |c| c.gap.len()));
    for (k, &i) in touching.iter().enumerate() {
        forces[i] = point.x[problem.n_unknowns() + k];
    }
    let mut observed = problem.space.at(&activation);
    if let Some(contact) = contact {
        observed += &contact.reach * &forces;
    }
    let state = State { observed, activation };
    let value = objective(&problem.terms, &state);
    let program = TangentProgram::new(problem, mode, &state, touching, point);
    let markers = marker_fits(problem, &state);
    let residuals: Vec<f64> = markers.iter().filter_map(|m| m.residual_mm).collect();
    let residual = Residual {
        rms_mm: (residuals.iter().fold(0., |sum, r| sum + r * r) / residuals.len().max(1) as f64).sqrt(),
        max_mm: residuals.iter().copied().fold(0.0, f64::max),
    };
    // The markers' own share of the objective goes with the square of their residuals.
    let fits = problem.markers.iter().zip(&markers);
    let own: f64 = fits.filter_map(|(aim, fit)| Some(0.5 * (fit.residual_mm? / aim.sigma_mm).powi(2))).sum();
    let gain = (residual.rms_mm > 0. && own > 0.).then(|| residual.rms_mm / (2. * own));
    let active_limits = active_limits(problem, mode, found, point, gain);
    let mut contact = contact.map(|c| contact_report(c, &state, &forces)).unwrap_or_default();
    if let Some(bound) = bound {
        contact.relaxation_gap = (value - bound.lower).max(0.0);
        contact.relaxation_nodes = bound.nodes;
        contact.relaxation_end = Some(bound.end);
    }
    let mut warnings = detect::before(problem);
    warnings.extend(detect::undecided(problem, found));
    let is_open = |w: &Warning| matches!(w, Warning::Underdetermined { .. } | Warning::Undecided { .. });
    let is_open = warnings.iter().any(is_open);
    let status = if is_open && status == Status::Solved { Status::Underdetermined } else { status };
    warnings.extend(detect::outliers(problem, &markers));
    warnings.extend(detect::unreachable(problem, &markers, &active_limits));
    let (names, m) = (problem.muscles.clone(), problem.n_muscles());
    let values = state.activation.iter().take(m).copied().collect();
    let jaw_opening_mm = match problem.jaw {
        Some(JawOpening::Held(opening)) => Some(opening),
        _ => problem.jaw_range().map(|range| range.at(state.activation[m])),
    };
    Solution {
        status,
        activations: Activations { names, values },
        jaw_opening_mm,
        contact_forces: if mode == ContactMode::Reactions { forces } else { DVector::zeros(0) },
        features: feature_fits(problem, &state),
        observed_mm: state.observed,
        objective: value,
        residual,
        explained: MarkerFit::explained(&markers),
        markers,
        active_limits,
        contact,
        certificate,
        program: Some(Arc::new(program)),
        infeasible: None,
        warnings,
    }
}

fn displacement(state: &State, point: usize) -> Vec3 {
    Vec3::new(state.observed[3 * point], state.observed[3 * point + 1], state.observed[3 * point + 2])
}

fn marker_fits(problem: &Problem, state: &State) -> Vec<MarkerFit> {
    let fit = |marker: &super::problem::MarkerAim| {
        let model_mm = displacement(state, marker.point);
        let differences: Vec<f64> =
            (0..3).filter_map(|axis| marker.target_mm[axis].map(|t| model_mm[axis] - t)).collect();
        let residual_mm =
            (!differences.is_empty()).then(|| differences.iter().map(|r| r * r).sum::<f64>().sqrt());
        MarkerFit {
            name: marker.name.clone(),
            rest_mm: marker.rest_mm,
            target_mm: marker.target_mm,
            model_mm,
            residual_mm,
        }
    };
    problem.markers.iter().map(fit).collect()
}

fn feature_fits(problem: &Problem, state: &State) -> Vec<FeatureFit> {
    let fit = |feature: &super::problem::FeatureAim| {
        let [from, to] = feature.ends;
        let span = feature.rest_mm + displacement(state, to) - displacement(state, from);
        let model_mm = feature.axis.map_or(span.norm(), |axis| span[axis]);
        FeatureFit { name: feature.name.clone(), target_mm: feature.target_mm, model_mm }
    };
    problem.features.iter().map(fit).collect()
}

fn contact_report(contact: &ContactResponse, state: &State, forces: &DVector<f64>) -> ContactReport {
    let gap = &contact.gap + &contact.approach * &state.activation + &contact.compliance * forces;
    ContactReport {
        pairs: contact.gap.len(),
        active: forces.iter().filter(|f| **f > 0.0).count(),
        force_n: forces.sum(),
        max_penetration_mm: gap.iter().fold(0.0, |deepest, g| (-g).max(deepest)),
        ..ContactReport::default()
    }
}

/// The limits with multipliers; `gain` turns an objective into mm of the markers.
fn active_limits(
    problem: &Problem,
    mode: ContactMode,
    found: &Found,
    point: &Point,
    gain: Option<f64>,
) -> Vec<ActiveLimit> {
    let m = problem.n_unknowns();
    let ties = problem.tied.pairs.iter().zip(point.equality.iter());
    let mut named: Vec<(LimitName, f64)> =
        ties.map(|(&[i, j], y)| (LimitName::Tied(i, j), y.abs())).collect();
    for k in 0..m {
        named.push((LimitName::Least(k), point.lower[k]));
        named.push((LimitName::Greatest(k), point.upper[k]));
    }
    match mode {
        ContactMode::Off => {}
        ContactMode::Kinematic => {
            named.extend(point.inequality.iter().enumerate().map(|(i, &z)| (LimitName::Gap(i), z)));
        }
        ContactMode::Reactions => {
            let open = found.piece.open().into_iter().map(LimitName::Gap);
            named.extend(open.zip(point.inequality.iter().copied()));
            let touching = found.piece.touching.contacts().iter().map(|&i| LimitName::Force(i));
            named.extend(touching.zip(point.lower.iter().skip(m).copied()));
        }
    }
    let largest = named.iter().map(|(_, z)| *z).fold(0.0, f64::max);
    named.retain(|(_, z)| *z > IDLE * largest && *z > 0.0);
    named.sort_by(|a, b| b.1.total_cmp(&a.1));
    named
        .into_iter()
        .map(|(name, multiplier)| {
            let is_jaw =
                matches!(name, LimitName::Least(k) | LimitName::Greatest(k) if k == problem.n_muscles());
            let kind = match name {
                LimitName::Least(k) if !is_jaw && problem.bounds.min[k] == 0. => LimitKind::AtRest,
                LimitName::Least(_) | LimitName::Greatest(_) => LimitKind::Cap,
                LimitName::Tied(..) => LimitKind::Tie,
                LimitName::Touching(_) | LimitName::Gap(_) | LimitName::Force(_) => LimitKind::Contact,
            };
            let (name, unit) = describe(problem, name);
            let (multiplier, unit) = match problem.jaw_range() {
                // The unknown is a share of the range.
                Some(range) if is_jaw => (multiplier / range.width_mm(), "1/mm"),
                _ => (multiplier, unit),
            };
            ActiveLimit { kind, name, multiplier, unit, gain_mm: gain.map(|gain| gain * multiplier) }
        })
        .collect()
}

fn describe(problem: &Problem, name: LimitName) -> (String, &'static str) {
    let contact = |i: usize| {
        let kind = match problem.contact.as_ref().map(|c| c.kinds[i]) {
            Some(PairKind::UpperTeeth) => "upper teeth",
            Some(PairKind::LowerTeeth) => "lower teeth",
            Some(PairKind::Lips) => "lips",
            None => "none",
        };
        format!("contact {i} ({kind})")
    };
    let muscle = |k: usize| problem.name_of(k);
    let bound = |k: usize, value: f64| match problem.jaw_range() {
        Some(range) if k == problem.n_muscles() => range.at(value),
        _ => value,
    };
    match name {
        LimitName::Least(k) => (format!("{} >= {}", muscle(k), bound(k, problem.bounds.min[k])), "1"),
        LimitName::Greatest(k) => (format!("{} <= {}", muscle(k), bound(k, problem.bounds.max[k])), "1"),
        LimitName::Tied(i, j) => (format!("{} = {}", muscle(i), muscle(j)), "1"),
        LimitName::Touching(i) => (format!("gap of {} = 0", contact(i)), "1/mm"),
        LimitName::Gap(i) => (format!("gap of {} >= 0", contact(i)), "1/mm"),
        LimitName::Force(i) => (format!("force of {} >= 0", contact(i)), "1/N"),
    }
}
