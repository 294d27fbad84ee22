//! What can be wrong with a face file, and what is odd about it.

use thiserror::Error;

use crate::contact::{TeethError, TeethWarning};
use crate::face::{FaceError, FaceWarning};
use crate::io::{Location, MeshFileError, UnreadableText};
use crate::mesh::MeshWarning;
use crate::units::counted;

/// A face file that cannot be used: where, what, and what to do.
#[derive(Clone, Debug, Error, PartialEq)]
#[error("{}", location.before(kind))]
pub struct FaceFileError {
    /// Where.
    pub location: Box<Location>,
    /// What.
    #[source]
    pub kind: FaceFileErrorKind,
}

impl FaceFileError {
    pub(super) fn new(location: Location, kind: FaceFileErrorKind) -> Self {
        Self { location: Box::new(location), kind }
    }
}

/// What is wrong, with the value and the fix.
#[derive(Clone, Debug, Error, PartialEq)]
#[non_exhaustive]
pub enum FaceFileErrorKind {
    /// The file cannot be opened or is not text.
    #[error(transparent)]
    Unreadable(#[from] UnreadableText),
    /// Something else than the format asks for.
    #[error("{reason}; schemas/face.schema.json shows the form")]
    Syntax {
        /// What the parser says.
        reason: String,
    },
    /// A key that the format does not have.
    #[error("unknown field `{field}`; {}", offer(.nearest, .known))]
    UnknownField {
        /// The key.
        field: String,
        /// The accepted name closest to it.
        nearest: Option<String>,
        /// Every accepted name.
        known: Vec<String>,
    },
    /// A key that must be there is not.
    #[error("the field `{field}` is missing; {hint}")]
    MissingField {
        /// The key.
        field: String,
        /// What to add.
        hint: String,
    },
    /// A name that stands for nothing.
    #[error("there is no {what} `{name}`; {}", offer(.nearest, .known))]
    UnknownName {
        /// `node set`, `muscle` ...
        what: &'static str,
        /// The name.
        name: String,
        /// The known name closest to it.
        nearest: Option<String>,
        /// Every known name.
        known: Vec<String>,
    },
    /// A value that makes no sense.
    #[error("`{value}` is not accepted; give {accepted}")]
    Value {
        /// The value.
        value: String,
        /// What is accepted.
        accepted: String,
    },
    /// The same name twice.
    #[error("{what} `{name}` is defined twice; rename or remove one")]
    Duplicate {
        /// `landmark`, `node set` ...
        what: &'static str,
        /// The name.
        name: String,
    },
    /// A row of a table with too few or too many entries.
    #[error("the row has {} but the header {expected}; add or remove some", counted(*.found, "entry"))]
    RowLength {
        /// Entries of the row.
        found: usize,
        /// Columns.
        expected: usize,
    },
    /// A landmark far from the skin.
    #[error(
        "landmark `{name}` is {distance_mm:.2} mm from the skin, more than {limit_mm} mm; correct its place, or \
         raise `max_projection_mm`"
    )]
    FarLandmark {
        /// The landmark.
        name: String,
        /// Its distance, mm.
        distance_mm: f64,
        /// The greatest distance accepted, mm.
        limit_mm: f64,
    },
    /// Something that is far smaller or larger than its like on a face of this size.
    #[error(
        "{what} measures {size_mm:.3} mm across where the mesh measures {mesh_mm:.0} mm{}; convert the coordinates, or \
         state the `unit` that they are in", .unit.map(|u| format!(": {u}?")).unwrap_or_default()
    )]
    Size {
        /// `the tooth surface`, `fibres of all muscles` ...
        what: &'static str,
        /// Longest side of the box around it, mm.
        size_mm: f64,
        /// That of the box around the mesh, mm.
        mesh_mm: f64,
        /// The unit in which it would be as large as expected.
        unit: Option<&'static str>,
    },
    /// Something that lies elsewhere than the mesh.
    #[error(
        "{what} lies {gap_mm:.0} mm away from the mesh, which measures {mesh_mm:.0} mm; check its `unit`, and that it is \
         in the frame of the mesh"
    )]
    Elsewhere {
        /// As above.
        what: &'static str,
        /// Distance of the boxes around the two, mm.
        gap_mm: f64,
        /// Longest side of the box around the mesh, mm.
        mesh_mm: f64,
    },
    /// The pieces of a sphincter that do not meet.
    #[error(
        "the pieces of the ring `{muscle}` leave a gap of {gap_mm:.1} mm; complete the ring or remove `ring = true`"
    )]
    OpenRing {
        /// The muscle.
        muscle: String,
        /// The widest gap, mm.
        gap_mm: f64,
    },
    /// A mesh or surface file.
    #[error(transparent)]
    Mesh(#[from] MeshFileError),
    /// A tooth surface.
    #[error(transparent)]
    Teeth(#[from] TeethError),
    /// The face as such.
    #[error(transparent)]
    Face(#[from] FaceError),
}

/// What is odd about a face file, with its place.
#[derive(Clone, Debug, Error, PartialEq)]
#[error("{}", location.before(kind))]
pub struct FaceFileWarning {
    /// Where.
    pub location: Location,
    /// What.
    #[source]
    pub kind: FaceFileWarningKind,
}

impl FaceFileWarning {
    /// This warning and the same of a muscle's other side as one, at the place of this one.
    pub(super) fn with_other_side(&self, other: &Self) -> Option<Self> {
        let (FaceFileWarningKind::Face(a), FaceFileWarningKind::Face(b)) = (&self.kind, &other.kind) else {
            return None;
        };
        let kind = FaceFileWarningKind::Face(a.with_other_side(b)?);
        Some(Self { location: self.location.clone(), kind })
    }
}

/// What is odd, and what to do.
#[derive(Clone, Debug, Error, PartialEq)]
#[non_exhaustive]
pub enum FaceFileWarningKind {
    /// The mesh.
    #[error("{0}")]
    Mesh(MeshWarning),
    /// A tooth surface.
    #[error(transparent)]
    Teeth(TeethWarning),
    /// The face as such.
    #[error(transparent)]
    Face(FaceWarning),
    /// A landmark that was not on the skin.
    #[error(
        "landmark `{name}` was moved {distance_mm:.2} mm to the skin; correct its place if that is too far"
    )]
    MovedLandmark {
        /// The landmark.
        name: String,
        /// How far, mm.
        distance_mm: f64,
    },
}

fn offer(nearest: &Option<String>, known: &[String]) -> String {
    match nearest {
        Some(name) => format!("did you mean `{name}`?"),
        None if known.is_empty() => "there are none".to_owned(),
        None => format!("known are: {}", known.join(", ")),
    }
}
