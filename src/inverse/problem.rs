//! A target posed on a response.

use std::sync::Arc;

use nalgebra::{DMatrix, DVector};
use thiserror::Error;

use super::check::muscle_index;
use super::error::TargetError;
use super::limit::Limit;
use super::limits::{ActivationBounds, ContactReactions, KinematicContact, TiedPairs};
use super::observations::Observations;
use super::program::{Linearisation, Program, Space, build};
use super::tangent_program::Part;
use super::target::{EffortNorm, FeatureGoal, Goal, JawOpening, Loss, Target};
use super::term::{State, Term};
use super::terms::{
    ActivationPrior, Component, Distance, Effort, HuberMarker, MarkerDisplacement, MarkerPosition,
    MirroredPoints,
};
use crate::face::JawRange;
use crate::forward::finite::FiniteError;
use crate::forward::{ContactError, ContactResponse, ForwardError, Response};
use crate::qp::ProblemError;
use crate::units::Vec3;

/// What contact does in the inverse.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum ContactMode {
    /// Teeth and lips push back: `0 <= lambda  _|_  g >= 0`.
    #[default]
    Reactions,
    /// Gaps must stay open without any push: forbids every activation that presses.
    Kinematic,
    /// Tissue passes through teeth and lips.
    Off,
}

/// Why an inverse could not be run; an inverse that runs and fails has a
/// [`Status`](super::Status) instead.
#[derive(Clone, Debug, PartialEq, Error)]
#[non_exhaustive]
pub enum InverseError {
    /// The response makes no quadratic program.
    #[error(
        "the response makes no quadratic program: {0}; a `max_force_n`, a modulus, a `sigma_mm` or the `effort` is too \
         large or too small to be computed with"
    )]
    Program(#[from] ProblemError),
    /// The target does not fit the response.
    #[error(transparent)]
    Target(#[from] TargetError),
    /// The face cannot be solved at some activation.
    #[error(transparent)]
    Forward(#[from] ForwardError),
    /// A nonlinear search was run without a start.
    #[error("the nonlinear search has no start; give it one activation a muscle")]
    NoStart,
    /// No contact forces hold the face at some activation.
    #[error(transparent)]
    Contact(#[from] ContactError),
    /// The face does not come to rest at finite strain.
    #[error(transparent)]
    Finite(#[from] FiniteError),
}

/// A marker as reported.
#[derive(Clone, Debug)]
pub(super) struct MarkerAim {
    pub(super) name: String,
    pub(super) point: usize,
    /// Displacement asked for, mm.
    pub(super) target_mm: [Option<f64>; 3],
    pub(super) goal: Goal,
    pub(super) rest_mm: Vec3,
    pub(super) sigma_mm: f64,
    /// The landmark's name, or the label where the marker sits on no landmark.
    pub(super) place: String,
}

/// A feature as reported.
#[derive(Clone, Debug)]
pub(super) struct FeatureAim {
    pub(super) name: String,
    pub(super) ends: [usize; 2],
    pub(super) axis: Option<usize>,
    pub(super) rest_mm: Vec3,
    pub(super) target_mm: f64,
}

/// A target posed on one response: terms, limits and the linear maps, without names of places.
#[derive(Debug)]
pub struct Problem {
    pub(super) muscles: Vec<String>,
    /// How far the jaw is open, where the target says.
    pub(super) jaw: Option<JawOpening>,
    pub(super) space: Space,
    pub(super) contact: Option<Arc<ContactResponse>>,
    pub(super) terms: Vec<Box<dyn Term>>,
    pub(super) bounds: ActivationBounds,
    pub(super) tied: TiedPairs,
    pub(super) markers: Vec<MarkerAim>,
    pub(super) features: Vec<FeatureAim>,
    /// What each of the terms is of.
    pub(super) parts: Vec<Part>,
    /// The observed points at rest (p), mm.
    pub(super) points_mm: Vec<Vec3>,
    /// What each muscle (m) costs in the effort,
    pub(super) cost: DVector<f64>,
    /// and which effort.
    pub(super) effort_norm: EffortNorm,
}

impl Problem {
    /// Poses `target` on the `response` of the points in `observations`.
    ///
    /// # Errors
    /// [`TargetError`] when the target is wrong, or the response is not that of these points.
    pub fn new(
        target: &Target,
        observations: &Observations,
        response: &Response,
    ) -> Result<Self, TargetError> {
        target.check(&response.muscles)?;
        check_shapes(target, observations, response)?;
        let n = response.map.ncols();
        let mut problem = Self {
            muscles: response.muscles.clone(),
            jaw: target.jaw_opening,
            space: Space { observed: response.map.clone(), offset: response.offset.clone() },
            contact: response.contact.clone().filter(|c| !c.gap.is_empty()).map(Arc::new),
            terms: Vec::new(),
            bounds: ActivationBounds::unit(n),
            tied: TiedPairs::default(),
            markers: Vec::new(),
            features: Vec::new(),
            parts: Vec::new(),
            cost: match observations.cost.is_empty() {
                true => DVector::from_element(response.muscles.len(), 1.),
                false => DVector::from_column_slice(&observations.cost),
            },
            effort_norm: target.effort_norm,
            points_mm: observations.sites.iter().map(|site| site.position).collect(),
        };
        problem.add_markers(target, observations);
        problem.add_features(target, observations)?;
        for (k, (pair, &[left, right])) in target.symmetry.iter().zip(&observations.symmetry).enumerate() {
            problem.add(Part::Symmetry(k), MirroredPoints { left, right, sigma_mm: pair.sigma_mm });
        }
        for (k, cost) in target.costs.iter().enumerate() {
            let muscle = muscle_index(&problem.muscles, &cost.muscle, || format!("costs[{k}].muscle"))?;
            problem.cost[muscle] *= cost.factor;
        }
        for (k, prior) in target.priors.iter().enumerate() {
            let muscle = muscle_index(&problem.muscles, &prior.muscle, || format!("priors[{k}].muscle"))?;
            problem
                .add(Part::Prior(k), ActivationPrior { muscle, value: prior.activation, sigma: prior.sigma });
        }
        if target.effort > 0.0 {
            let cost = problem.cost.clone();
            problem.add(Part::Effort, Effort { weight: target.effort, cost, norm: target.effort_norm });
        }
        for (k, bound) in target.bounds.iter().enumerate() {
            let muscle = muscle_index(&problem.muscles, &bound.muscle, || format!("bounds[{k}].muscle"))?;
            (problem.bounds.min[muscle], problem.bounds.max[muscle]) = (bound.min, bound.max);
        }
        for (k, [left, right]) in target.tied.iter().enumerate() {
            let left = muscle_index(&problem.muscles, left, || format!("tied[{k}][0]"))?;
            problem
                .tied
                .pairs
                .push([left, muscle_index(&problem.muscles, right, || format!("tied[{k}][1]"))?]);
        }
        Ok(problem)
    }

    fn add_markers(&mut self, target: &Target, observations: &Observations) {
        for (k, (marker, &point)) in target.markers.iter().zip(&observations.markers).enumerate() {
            let (rest_mm, sigma_mm) = (observations.sites[point].position, marker.sigma_mm);
            let place = match &marker.at {
                super::Place::Landmark(name) => name.clone(),
                super::Place::Point(_) => marker.name.clone(),
            };
            let displacement = match marker.goal {
                Goal::Displacement(target_mm) => MarkerDisplacement { point, target_mm, sigma_mm },
                Goal::Position(target_mm) => {
                    MarkerPosition { point, rest_mm, target_mm, sigma_mm }.displacement()
                }
            };
            let target_mm = displacement.target_mm;
            match target.loss {
                Loss::Squares => self.add(Part::Marker(k), displacement),
                Loss::Huber(sigmas) => {
                    self.add(Part::Marker(k), HuberMarker { marker: displacement, sigmas });
                }
            }
            let (name, goal) = (marker.name.clone(), marker.goal);
            self.markers.push(MarkerAim { name, point, target_mm, goal, rest_mm, sigma_mm, place });
        }
    }

    fn add_features(&mut self, target: &Target, observations: &Observations) -> Result<(), TargetError> {
        for (k, (feature, &[from, to])) in target.features.iter().zip(&observations.features).enumerate() {
            let rest = observations.sites[to].position - observations.sites[from].position;
            let rest_length = match feature.axis {
                Some(axis) => rest[axis.index()],
                None => rest.norm(),
            };
            let value_mm = match feature.goal {
                FeatureGoal::Value(value) => value,
                FeatureGoal::Change(change) => rest_length + change,
            };
            let (axis, sigma_mm) = (feature.axis, feature.sigma_mm);
            match axis {
                Some(axis) => {
                    let rest_mm = rest_length;
                    self.add(Part::Feature(k), Component { from, to, axis, rest_mm, value_mm, sigma_mm });
                }
                None if rest_length == 0.0 => {
                    return Err(TargetError::SamePoint { field: format!("features[{k}]") });
                }
                None if value_mm < 0.0 => {
                    let field = format!("features[{k}].change_mm");
                    return Err(TargetError::NegativeDistance { field, value: value_mm });
                }
                None => {
                    self.add(Part::Feature(k), Distance { from, to, rest_mm: rest, value_mm, sigma_mm });
                }
            }
            self.features.push(FeatureAim {
                name: feature.name.clone(),
                ends: [from, to],
                axis: axis.map(|a| a.index()),
                rest_mm: rest,
                target_mm: value_mm,
            });
        }
        Ok(())
    }

    /// Number `m` of muscles.
    pub fn n_muscles(&self) -> usize {
        self.muscles.len()
    }

    /// Number `n` of unknowns: the muscles, and the jaw's opening where it is unknown.
    pub(super) fn n_unknowns(&self) -> usize {
        self.space.n_unknowns()
    }

    /// The openings between which the jaw's is unknown, if it is.
    pub(super) fn jaw_range(&self) -> Option<JawRange> {
        match self.jaw {
            Some(JawOpening::Within(range)) if self.n_unknowns() > self.n_muscles() => Some(range),
            _ => None,
        }
    }

    /// What messages call an unknown.
    pub(super) fn name_of(&self, unknown: usize) -> &str {
        self.muscles.get(unknown).map_or(JawOpening::FIELD, String::as_str)
    }

    /// The terms of the objective.
    pub fn terms(&self) -> &[Box<dyn Term>] {
        &self.terms
    }

    /// What each of the terms is of.
    pub(super) fn parts(&self) -> impl Iterator<Item = Part> {
        self.parts.iter().copied()
    }

    fn add(&mut self, part: Part, term: impl Term + 'static) {
        self.parts.push(part);
        self.terms.push(Box::new(term));
    }

    /// Rest: least activations, and the displacements they cause without contact.
    pub fn rest(&self) -> State {
        let activation = self.bounds.min.clone();
        State { observed: self.space.at(&activation), activation }
    }

    /// The terms linearised about `state`.
    pub fn linearise(&self, state: &State) -> Linearisation {
        Linearisation::new(self.terms.iter().map(AsRef::as_ref), state)
    }

    /// The quadratic program about `state`, before it is solved.
    ///
    /// The unknowns are the activations (m), the share of the jaw's opening where that is unknown, and, in [`ContactMode::Reactions`], the forces of the
    /// `touching` contacts; the others are open. `touching` is ignored in the other modes.
    pub fn build(&self, mode: ContactMode, touching: &[usize], state: &State) -> Program {
        self.build_from(&self.linearise(state), mode, touching)
    }

    pub(super) fn build_from(&self, terms: &Linearisation, mode: ContactMode, touching: &[usize]) -> Program {
        let mut limits: Vec<&dyn Limit> = vec![&self.bounds, &self.tied];
        let (d, m) = self.space.observed.shape();
        match (mode, &self.contact) {
            (ContactMode::Off, _) | (_, None) => build(&terms.over(&self.space), &limits),
            (ContactMode::Kinematic, Some(contact)) => {
                let kinematic = KinematicContact { contact: Arc::clone(contact) };
                limits.push(&kinematic);
                build(&terms.over(&self.space), &limits)
            }
            (ContactMode::Reactions, Some(contact)) => {
                let reactions = ContactReactions::piece(contact, touching);
                limits.push(&reactions);
                let mut observed = DMatrix::zeros(d, m + touching.len());
                observed.columns_mut(0, m).copy_from(&self.space.observed);
                observed.columns_mut(m, touching.len()).copy_from(&contact.reach.select_columns(touching));
                build(&terms.over(&Space { observed, offset: self.space.offset.clone() }), &limits)
            }
        }
    }
}

fn check_shapes(
    target: &Target,
    observations: &Observations,
    response: &Response,
) -> Result<(), TargetError> {
    let jaw = usize::from(response.jaw.is_some());
    let (d, m) = (observations.n_rows(), response.muscles.len() + jaw);
    let asked = usize::from(matches!(target.jaw_opening, Some(JawOpening::Within(_))));
    let mut shapes = vec![
        ("response.map rows", response.map.nrows(), d),
        ("response.map columns", response.map.ncols(), m),
        ("response.jaw", jaw, asked),
        ("response.offset", response.offset.len(), d),
        ("observations.markers", observations.markers.len(), target.markers.len()),
        ("observations.features", observations.features.len(), target.features.len()),
        ("observations.symmetry", observations.symmetry.len(), target.symmetry.len()),
    ];
    if let Some(contact) = &response.contact {
        let c = contact.gap.len();
        shapes.extend([
            ("response.contact.kinds", contact.kinds.len(), c),
            ("response.contact.approach rows", contact.approach.nrows(), c),
            ("response.contact.approach columns", contact.approach.ncols(), m),
            ("response.contact.compliance rows", contact.compliance.nrows(), c),
            ("response.contact.compliance columns", contact.compliance.ncols(), c),
            ("response.contact.reach rows", contact.reach.nrows(), d),
            ("response.contact.reach columns", contact.reach.ncols(), c),
        ]);
    }
    if !observations.cost.is_empty() {
        shapes.push(("observations.cost", observations.cost.len(), response.muscles.len()));
    }
    for (field, found, expected) in shapes {
        if found != expected {
            return Err(TargetError::ResponseShape { field: field.to_string(), found, expected });
        }
    }
    let points = observations.markers.iter().chain(observations.features.iter().flatten());
    for &point in points.chain(observations.symmetry.iter().flatten()) {
        if point >= observations.sites.len() {
            let field = "observations.sites".to_string();
            return Err(TargetError::ResponseShape {
                field,
                found: observations.sites.len(),
                expected: point + 1,
            });
        }
    }
    let mut matrices = vec![("response.map", &response.map)];
    let gap;
    if let Some(contact) = &response.contact {
        gap = DMatrix::from_column_slice(contact.gap.len(), 1, contact.gap.as_slice());
        matrices.extend([
            ("response.contact.gap", &gap),
            ("response.contact.approach", &contact.approach),
            ("response.contact.compliance", &contact.compliance),
            ("response.contact.reach", &contact.reach),
        ]);
    }
    for (name, matrix) in matrices {
        if let Some(k) = matrix.iter().position(|v| !v.is_finite()) {
            let field = format!("{name}[{}, {}]", k % matrix.nrows(), k / matrix.nrows());
            return Err(TargetError::NotFinite { field, value: matrix[k] });
        }
    }
    Ok(())
}
