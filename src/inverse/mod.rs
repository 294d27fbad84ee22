//! From a target to activations: a list of terms and a list of limits become one quadratic program.
//!
//! [`Target`] -> [`Observations::resolve`] (names to points of a face) -> `Response` of those points ->
//! [`Problem::new`] -> [`Problem::build`] (the program, to look at) or [`Problem::solve`].

mod activated;
mod branching;
mod check;
mod contact_fit;
mod descent;
mod detect;
mod error;
mod finite_fit;
mod kink;
mod limit;
mod limits;
mod observations;
mod piece;
mod pivot;
mod problem;
mod program;
mod relaxation;
mod report;
mod residual_curvature;
mod sequential;
mod solution;
mod solve;
pub(crate) mod spelling;
mod tangent_program;
mod target;
mod term;
mod terms;
mod warning;

pub use activated::ActivatedProblem;
pub use branching::RelaxationEnd;
pub use contact_fit::{ContactFit, FittedContact};
pub use error::TargetError;
pub use finite_fit::{FiniteAnswer, FiniteFit};
pub use limit::{Constraint, Constraints, Limit, LimitName};
pub use limits::{ActivationBounds, ContactReactions, KinematicContact, TiedPairs, TrustRegion};
pub use observations::Observations;
pub use problem::{ContactMode, InverseError, Problem};
pub use program::{Linearisation, Objective, Program, Space, build};
pub use sequential::{ActivatedSolution, SequentialQp, SequentialState, SequentialStep};
pub use solution::{
    Activations, ActiveLimit, ContactReport, FeatureFit, LimitKind, MarkerFit, Residual, Solution, Status,
};
pub use tangent_program::{FreeUnknowns, Part, Share, TangentProgram};
pub use target::{
    Axis, Bound, EffortMeasure, EffortNorm, Expected, Feature, FeatureGoal, Goal, JawOpening, Loss, Marker,
    MirroredPair, MuscleCost, Place, Prior, Target,
};
pub use term::{Row, State, Term, objective};
pub use terms::{
    ActivationPrior, Component, Distance, Effort, HuberMarker, MarkerDisplacement, MarkerPosition,
    MirroredPoints,
};
pub use warning::Warning;
