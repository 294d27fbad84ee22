//! What can be wrong with a face, and what is odd about it.

use thiserror::Error;

use super::RestOverlap;
use crate::mesh::{MeshError, MeshWarning};
use crate::units::counted;

/// Why a face cannot be computed with.
#[derive(Clone, Debug, Error, PartialEq)]
#[non_exhaustive]
pub enum FaceError {
    /// A Young's modulus that is not positive.
    #[error("{field} is {value} kPa; give a positive modulus in kPa: soft tissue has 1 to 500")]
    Modulus {
        /// `tissue.young_kpa`, `muscle_tissue.rest_kpa` or `muscle_tissue.active_kpa`.
        field: &'static str,
        /// The modulus, kPa.
        value: f64,
    },
    /// A Poisson's ratio outside (-1, 0.5).
    #[error("{field} is {value}; give more than -1 and less than 0.5 (soft tissue: 0.49)")]
    Poisson {
        /// `tissue.poisson` or `muscle_tissue.poisson`.
        field: &'static str,
        /// The ratio.
        value: f64,
    },
    /// A stiffening that is negative: the tissue would soften until it tears.
    #[error("tissue.strain_stiffening is {value}; give 0 (neo-Hookean) or more (facial tissue: 0.47)")]
    StrainStiffening {
        /// The ratio `c_2/c_1`.
        value: f64,
    },
    /// Muscle tissue that loses its stiffness along the fibre within the range of activation.
    #[error(
        "muscle tissue is not stable from activation {threshold:.3} on: its fibre modulus \
         {rest_kpa} + ({active_kpa} - {rest_kpa}) a kPa is not positive there; give a positive `active_kpa`"
    )]
    UnstableMuscle {
        /// Modulus at rest, kPa.
        rest_kpa: f64,
        /// Modulus at full activation, kPa.
        active_kpa: f64,
        /// The least activation at which it is not positive definite.
        threshold: f64,
    },
    /// A number of a muscle that makes no sense.
    #[error("muscle {muscle}: {field} is {value}; give {accepted}")]
    MuscleNumber {
        /// The muscle.
        muscle: String,
        /// `max_force_n`, `radius_mm`, `area_mm2` or `insertion_mm`.
        field: &'static str,
        /// The value.
        value: f64,
        /// What is accepted.
        accepted: &'static str,
    },
    /// Two muscles of one name.
    #[error("two muscles are called {muscle}; rename or remove one")]
    DuplicateName {
        /// The name.
        muscle: String,
    },
    /// A muscle without fibres.
    #[error("muscle {muscle} has no fibre; give it one or remove it")]
    NoFibre {
        /// The muscle.
        muscle: String,
    },
    /// A fibre that has no length.
    #[error("muscle {muscle}: fibre {fibre} has no length; give it at least two distinct points")]
    ZeroLength {
        /// The muscle.
        muscle: String,
        /// The fibre, from 1.
        fibre: usize,
    },
    /// A fibre point that the tissue does not hold.
    #[error(
        "muscle {muscle}: fibre {fibre} leaves the mesh by {distance_mm:.2} mm at ({:.2}, {:.2}, {:.2}), more \
         than {limit_mm} mm; correct the path, or raise `max_projection_mm`", at[0], at[1], at[2]
    )]
    OutsideMesh {
        /// The muscle.
        muscle: String,
        /// The fibre, from 1.
        fibre: usize,
        /// The point, mm.
        at: [f64; 3],
        /// Its distance from the mesh, mm.
        distance_mm: f64,
        /// The greatest distance accepted, mm.
        limit_mm: f64,
    },
    /// A muscle whose radius reaches no tissue.
    #[error(
        "muscle {muscle}: no element has a quadrature point within {radius_mm} mm of its fibres; \
         raise `radius_mm` to at least {needed_mm:.2}"
    )]
    NoTissue {
        /// The muscle.
        muscle: String,
        /// Its radius, mm.
        radius_mm: f64,
        /// The least radius that reaches tissue, mm.
        needed_mm: f64,
    },
    /// The mesh, or how it is held.
    #[error(transparent)]
    Mesh(#[from] MeshError),
    /// A joint on which nothing can turn.
    #[error("{field}: {problem}")]
    Jaw {
        /// `jaw.bone`, `jaw.condyles_mm` or `jaw.incisor_mm`.
        field: &'static str,
        /// What is wrong, and what to give.
        problem: String,
    },
    /// Teeth on, or a piece of, a bone that the face has not.
    #[error("{field}: no bone is called `{bone}`; the face has {}", .known.join(", "))]
    UnknownBone {
        /// Path of the field.
        field: String,
        /// The bone.
        bone: String,
        /// The bones of the face.
        known: Vec<String>,
    },
    /// A set names a node that belongs to no cell.
    #[error(
        "{set}: node {node} belongs to no cell, so that nothing carries it; remove it from the set, or give it a cell"
    )]
    OrphanNode {
        /// `mucosa`, `skin`, a bone ...
        set: String,
        /// The node, by its number in the file.
        node: u64,
    },
    /// A set names a node that the mesh has not.
    #[error("{set} names node {node} (from 0), but the mesh has {n_nodes}")]
    MissingNode {
        /// `mucosa`, `skin`, a bone ...
        set: String,
        /// The node.
        node: usize,
        /// Number of nodes.
        n_nodes: usize,
    },
}

/// What is odd about a face that can still be computed with.
#[derive(Clone, Debug, Error, PartialEq)]
#[non_exhaustive]
pub enum FaceWarning {
    /// The mesh.
    #[error("{0}")]
    Mesh(MeshWarning),
    /// A modulus far from that of soft tissue.
    #[error("{field} is {value} kPa; soft tissue has 1 to 500: was it given in Pa or MPa?")]
    ImplausibleModulus {
        /// The field.
        field: &'static str,
        /// The modulus, kPa.
        value: f64,
    },
    /// Muscle that softens when it contracts.
    #[error(
        "muscle tissue softens with activation ({rest_kpa} to {active_kpa} kPa); were `rest_kpa` and \
         `active_kpa` swapped?"
    )]
    SofterWhenActive {
        /// Modulus at rest, kPa.
        rest_kpa: f64,
        /// Modulus at full activation, kPa.
        active_kpa: f64,
    },
    /// Fibres that seem to run from the skin to the bone.
    #[error(
        "muscle {muscle}: {} on bone at the insertion and off it at the origin; if they are flipped, change `origin` to \
         the other end", counted(*.fibres, "fibre")
    )]
    FlippedFibres {
        /// The muscle.
        muscle: String,
        /// How many.
        fibres: usize,
    },
    /// A fibre that is all insertion.
    #[error(
        "muscle {muscle}: its shortest fibre is {length_mm:.1} mm, no longer than `insertion_mm`, so that it \
         never reaches its full tension; shorten the insertion"
    )]
    AllInsertion {
        /// The muscle.
        muscle: String,
        /// Length of the shortest fibre, mm.
        length_mm: f64,
    },
    /// Nodes on two bones, which may move apart.
    #[error(
        "{} (the first is {node}, from 0) fixed to both {first} and {second}, to go where {second} goes; take them out of \
         one of the two sets", counted(*.nodes, "node")
    )]
    TwoBones {
        /// One bone.
        first: String,
        /// The other, whose motion they take.
        second: String,
        /// Which of the supports that is, from 0.
        support: usize,
        /// The first such node.
        node: usize,
        /// How many.
        nodes: usize,
    },
    /// Two muscles with the same fibres.
    #[error("muscles {first} and {second} have the same fibres, so data cannot tell them apart; remove one")]
    SameFibres {
        /// One.
        first: String,
        /// The other.
        second: String,
    },
    /// Fibre points that were brought inside the mesh.
    #[error(
        "muscle {muscle}: {outside} of {} outside the mesh, by {largest_mm:.2} mm at most, and moved to its boundary; \
         correct the path if that is too far", counted(*.points, "fibre point")
    )]
    Projected {
        /// The muscle.
        muscle: String,
        /// Points outside.
        outside: usize,
        /// Points in all.
        points: usize,
        /// Greatest distance, mm.
        largest_mm: f64,
    },
    /// Teeth that nothing can touch.
    #[error(
        "the {arch} teeth have no candidate for contact: {}; check the place and the unit of their surface, and the set \
         `mucosa`", if *.mucosa == 0 { "the face has no mucosa".to_owned() } else {
            format!("no free one of {} comes within {reach_mm} mm", counted(*.mucosa, "mucosa node"))
        }
    )]
    NoContact {
        /// `upper` or `lower`.
        arch: &'static str,
        /// Mucosa nodes.
        mucosa: usize,
        /// Farthest node that is a candidate, mm.
        reach_mm: f64,
    },
    /// Mucosa inside the teeth at rest.
    #[error(
        "{} of {} inside the teeth at rest (median {:.2} mm, at most {:.2}); the overlap is \
         taken as zero gap", .0.inside, counted(.0.nodes, "mucosa node"), .0.median_mm, .0.deepest_mm
    )]
    RestOverlap(RestOverlap),
}
