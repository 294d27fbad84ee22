//! The program of an answer: the target on the tangent at the answer.

use std::collections::BTreeSet;
use std::ops::Range;
use std::sync::Arc;

use nalgebra::{DMatrix, DVector};

use super::limit::Limit;
use super::limits::{ActivationBounds, ContactReactions, KinematicContact, TiedPairs};
use super::piece::Piece;
use super::problem::{ContactMode, Problem};
use super::program::{Linearisation, Objective, Program, Space, build};
use super::target::EffortNorm;
use super::term::{State, linear};
use crate::face::JawRange;
use crate::forward::{ContactResponse, Touching};
use crate::qp::Point;
use crate::units::Vec3;

/// What some residuals are of.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Part {
    /// The marker of this index in the target.
    Marker(usize),
    /// The feature of this index.
    Feature(usize),
    /// The mirrored pair of this index.
    Symmetry(usize),
    /// The activation of this index that was observed or is thought likely.
    Prior(usize),
    /// The effort: a preference, no observation.
    Effort,
}

impl Part {
    /// Whether it says something about the face, not about what is preferred.
    pub fn is_data(self) -> bool {
        self != Self::Effort
    }
}

/// What a [`Part`] adds to the objective: `1/2 sum r^2 + sum slope x`.
#[derive(Clone, Debug, PartialEq)]
pub struct Share {
    /// What it is of.
    pub part: Part,
    /// Its rows of the residuals.
    pub rows: Range<usize>,
    /// Its slopes: (unknown, slope).
    pub slopes: Vec<(usize, f64)>,
}

impl Share {
    /// Its objective where all residuals are `residuals`, at the unknowns `x`.
    pub fn objective(&self, residuals: &DVector<f64>, x: &DVector<f64>) -> f64 {
        let own = residuals.rows(self.rows.start, self.rows.len());
        0.5 * own.norm_squared() + linear(self.slopes.iter().copied(), x)
    }
}

/// The target on the tangent at an answer, as plain numbers: what a change of the unknowns does to every residual, the
/// limits, the contacts, and the primal and dual point of the answer.
///
/// The `n` unknowns are the `m` activations and, where it is unknown, the jaw's opening as a share of its range.
#[derive(Clone, Debug, PartialEq)]
pub struct TangentProgram {
    /// Names of the unknowns (n).
    pub unknowns: Vec<String>,
    /// The openings between which the jaw's is the last unknown, if it is.
    pub jaw: Option<JawRange>,
    /// The observed points at rest (p), mm.
    pub points_mm: Vec<Vec3>,
    /// The unknowns at the answer (n).
    pub x: DVector<f64>,
    /// Least and greatest values (n each).
    pub bounds: ActivationBounds,
    /// Muscles that act together.
    pub tied: TiedPairs,
    /// What each muscle (m) costs in the effort, relative to the others,
    pub cost: DVector<f64>,
    /// and which effort.
    pub effort_norm: EffortNorm,
    /// What contact does.
    pub mode: ContactMode,
    /// The contacts; `None` where there is none or the tangent has it in itself.
    pub contact: Option<Arc<ContactResponse>>,
    /// Contacts that touch, their forces being unknowns of the [full program](Self::program) in this order.
    pub touching: Vec<usize>,
    /// The answer as a point of the full program, with all multipliers.
    pub point: Point,
    shares: Vec<Share>,
    space: Space,
    terms: Linearisation,
}

/// The unknowns that are free: `x = transform y + offset`, those that are fixed left out and those that are tied one.
#[derive(Clone, Debug, PartialEq)]
pub struct FreeUnknowns {
    /// (n x k), of ones and zeros.
    pub transform: DMatrix<f64>,
    /// (n): the values of those that are fixed.
    pub offset: DVector<f64>,
    /// Least and greatest values of `y` (k each).
    pub bounds: ActivationBounds,
}

impl TangentProgram {
    pub(super) fn new(
        problem: &Problem,
        mode: ContactMode,
        state: &State,
        touching: &[usize],
        point: &Point,
    ) -> Self {
        let mut end = 0;
        let shares = problem.parts().zip(problem.terms()).map(|(part, term)| {
            let start = end;
            end += term.rows(state).len();
            Share { part, rows: start..end, slopes: term.slopes() }
        });
        Self {
            unknowns: (0..problem.n_unknowns()).map(|k| problem.name_of(k).to_owned()).collect(),
            jaw: problem.jaw_range(),
            points_mm: problem.points_mm.clone(),
            x: state.activation.clone(),
            bounds: problem.bounds.clone(),
            tied: problem.tied.clone(),
            cost: problem.cost.clone(),
            effort_norm: problem.effort_norm,
            mode,
            contact: problem.contact.clone().filter(|_| mode != ContactMode::Off),
            touching: touching.to_vec(),
            point: point.clone(),
            shares: shares.collect(),
            space: problem.space.clone(),
            terms: problem.linearise(state),
        }
    }

    /// Number `n` of unknowns.
    pub fn n_unknowns(&self) -> usize {
        self.x.len()
    }

    /// Number `m` of muscles.
    pub fn n_muscles(&self) -> usize {
        self.x.len() - usize::from(self.jaw.is_some())
    }

    /// What the objective is made of, in the order of the rows of the residuals.
    pub fn shares(&self) -> &[Share] {
        &self.shares
    }

    /// The program over the unknowns and the forces of the contacts that touch, [`point`](Self::point) being its answer.
    pub fn program(&self) -> Program {
        let mut limits: Vec<&dyn Limit> = vec![&self.bounds, &self.tied];
        let kinematic;
        let reactions;
        match (&self.contact, self.mode) {
            (Some(contact), ContactMode::Kinematic) => {
                kinematic = KinematicContact { contact: Arc::clone(contact) };
                limits.push(&kinematic);
            }
            (Some(contact), ContactMode::Reactions) => {
                reactions = ContactReactions::piece(contact, &self.touching);
                limits.push(&reactions);
            }
            _ => {}
        }
        build(&self.objective(), &limits)
    }

    /// The objective over the unknowns of the [full program](Self::program).
    pub fn objective(&self) -> Objective {
        let (d, n) = self.space.observed.shape();
        let reach = match &self.contact {
            Some(contact) if self.mode == ContactMode::Reactions => {
                contact.reach.select_columns(&self.touching)
            }
            _ => DMatrix::zeros(d, 0),
        };
        let mut observed = DMatrix::zeros(d, n + reach.ncols());
        observed.columns_mut(0, n).copy_from(&self.space.observed);
        observed.columns_mut(n, reach.ncols()).copy_from(&reach);
        self.terms.over(&Space { observed, offset: self.space.offset.clone() })
    }

    /// How the unknowns (n) move the observed points with the contacts of the answer.
    pub fn space(&self) -> Space {
        self.piece().space
    }

    /// The objective over the unknowns (n), with the contacts of the answer.
    pub fn reduced(&self) -> Objective {
        self.terms.over(&self.piece().space)
    }

    /// Derivatives of the residuals by the observed displacements (rows x d), 1/mm.
    pub fn by_observed(&self) -> DMatrix<f64> {
        self.terms.by_observed(self.space.offset.len())
    }

    /// The unknowns that are free.
    pub fn free(&self) -> FreeUnknowns {
        FreeUnknowns::new(&self.bounds, &self.tied)
    }

    fn piece(&self) -> Piece {
        match &self.contact {
            Some(contact) if self.mode == ContactMode::Reactions => {
                let touching = Touching::new(&contact.compliance, self.touching.iter().copied());
                Piece::on(&self.space, contact, touching)
            }
            _ => Piece::without_contact(&self.space),
        }
    }
}

impl FreeUnknowns {
    /// Those within `bounds` of which the `tied` pairs are equal.
    pub fn new(bounds: &ActivationBounds, tied: &TiedPairs) -> Self {
        let n = bounds.min.len();
        // Each unknown goes with the first of those that it is tied to.
        let mut leader: Vec<usize> = (0..n).collect();
        for &[a, b] in &tied.pairs {
            let (from, to) = (leader[a].max(leader[b]), leader[a].min(leader[b]));
            leader.iter_mut().filter(|k| **k == from).for_each(|k| *k = to);
        }
        let within = |lead: usize| {
            let group = (0..n).filter(|&k| leader[k] == lead);
            group.fold((f64::NEG_INFINITY, f64::INFINITY), |(least, most), k| {
                (least.max(bounds.min[k]), most.min(bounds.max[k]))
            })
        };
        let leaders: BTreeSet<usize> = leader.iter().copied().collect();
        let mut offset = DVector::zeros(n);
        let (mut columns, mut min, mut max) = (Vec::new(), Vec::new(), Vec::new());
        for lead in leaders {
            let (least, most) = within(lead);
            let column = DVector::from_fn(n, |k, _| f64::from(leader[k] == lead));
            if most > least {
                columns.push(column);
                min.push(least);
                max.push(most);
            } else {
                offset += column * least;
            }
        }
        let transform = match columns.is_empty() {
            true => DMatrix::zeros(n, 0),
            false => DMatrix::from_columns(&columns),
        };
        let bounds = ActivationBounds { min: DVector::from_vec(min), max: DVector::from_vec(max) };
        Self { transform, offset, bounds }
    }

    /// `y` (k) of the unknowns `x` (n).
    pub fn of(&self, x: &DVector<f64>) -> DVector<f64> {
        let first = |column: nalgebra::DVectorView<'_, f64>| {
            column.iter().position(|v| *v != 0.).map_or(0., |k| x[k] - self.offset[k])
        };
        DVector::from_iterator(self.transform.ncols(), self.transform.column_iter().map(first))
    }
}
