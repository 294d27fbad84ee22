//! What can be wrong with a forward model.

use crate::units::Vec3;

/// Why a forward model cannot be built or solved.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
#[non_exhaustive]
pub enum ForwardError {
    /// The Jacobian of a cell is not positive at an integration point.
    #[error("cell {cell} is inverted at an integration point; reorder its nodes or move them apart")]
    InvertedCell {
        /// The cell's id in its file.
        cell: u64,
    },
    /// The stiffness has a pivot that is not positive.
    #[error(
        "the stiffness is not positive definite: the supports leave a free motion; \
         fix at least three nodes that are not in line to a bone"
    )]
    NotPositiveDefinite,
    /// The factorisation could not be set up.
    #[error("the factorisation failed ({0}); use a coarser mesh or a machine with more memory")]
    Factorisation(String),
    /// A point of a fibre lies outside the tissue.
    #[error(
        "muscle {muscle}: fibre {fibre} point {point} at ({:.3}, {:.3}, {:.3}) mm lies {distance_mm:.2} mm \
         outside the mesh; move the fibre inside or let the face file project it",
        position.x, position.y, position.z
    )]
    FibreOutside {
        /// Muscle name.
        muscle: String,
        /// Fibre, from 0.
        fibre: usize,
        /// Point, from 0.
        point: usize,
        /// Where it is, mm.
        position: Vec3,
        /// How far outside, mm.
        distance_mm: f64,
    },
    /// No integration point lies within a muscle.
    #[error(
        "muscle {muscle} has no elements: no integration point lies within {radius_mm} mm of its fibres; \
         raise radius_mm or refine the mesh there"
    )]
    EmptyMuscle {
        /// Muscle name.
        muscle: String,
        /// Its radius, mm.
        radius_mm: f64,
    },
    /// A node carries a load but belongs to no cell.
    #[error("node {node} carries a load but belongs to no cell; remove it or give it a cell")]
    LoadedOrphan {
        /// The node's id in its file.
        node: u64,
    },
    /// A jaw that is to open but is not there.
    #[error("the face has no jaw joint, so that its jaw cannot be opened; give it a [jaw] table")]
    NoJaw,
    /// An activation is unusable.
    #[error("activation of {muscle} is {value}; give a number from 0 to 1")]
    Activation {
        /// Muscle name.
        muscle: String,
        /// The value given.
        value: f64,
    },
}
