//! What can be wrong with a face file, and what is odd about it.

use thiserror::Error;

use crate::contact::{TeethError, TeethWarning};
use crate::face::{FaceError, FaceWarning};
use crate::io::text::listed;
use crate::io::{Location, MeshFileError, MeshFileWarning, NoSet, UnreadableText};
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
    /// A node set that the mesh does not have.
    #[error("there is no node set `{name}`{}", offer_sets(.name, .nearest, .known, .no_sets))]
    UnknownSet {
        /// The name.
        name: String,
        /// The known name closest to it.
        nearest: Option<String>,
        /// Every set.
        known: Vec<String>,
        /// What the mesh file has that is no set.
        no_sets: Vec<NoSet>,
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
    /// A column that a table does not have. What is in a table without known columns stays there.
    #[error("the first row names no column `{name}`; {}", .nearest.as_ref().map_or_else(
        || "name the columns as docs/formats.md has them".to_owned(), |near| format!("did you mean `{near}`?")))]
    MissingColumn {
        /// The column.
        name: String,
        /// The column there is that is closest to it.
        nearest: Option<String>,
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
    /// Fibres of more points than any face needs.
    #[error(
        "fibre {fibre} of muscle {muscle} is {length_mm:.1} mm long, which in steps of {step_mm} mm makes more than {most} \
         points{}; correct its points, or raise `fibre_step_mm`", if *.most > 100_000 { " of all fibres together" } else { "" }
    )]
    FibrePoints {
        /// The muscle.
        muscle: String,
        /// The fibre, from 1.
        fibre: usize,
        /// Its length, mm.
        length_mm: f64,
        /// `fibre_step_mm`.
        step_mm: f64,
        /// The most points of a fibre, or of all.
        most: usize,
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
    /// How the mesh file was read.
    #[error(transparent)]
    MeshFile(MeshFileWarning),
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
        None => format!("known are: {}", listed(known.iter().map(String::as_str))),
    }
}

/// What to ask for in place of set `name`: a set like it, the sets there are, or why the file has none.
fn offer_sets(name: &str, nearest: &Option<String>, known: &[String], no_sets: &[NoSet]) -> String {
    if let Some(NoSet { why, .. }) = no_sets.iter().find(|no| no.name == name) {
        return format!(
            ": the mesh file has it, but {why}; mark its nodes by 0 and 1, or ask for another set"
        );
    }
    let mut offer = match known {
        [] => "; the mesh has none: mark nodes in the mesh file, or select them by `[[select]]`".to_owned(),
        _ => format!("; {}", offer(nearest, known)),
    };
    if nearest.is_none() && !no_sets.is_empty() {
        let described: Vec<String> = no_sets.iter().map(|no| format!("{} ({})", no.name, no.why)).collect();
        offer +=
            &format!("; in the mesh file, but no sets: {}", listed(described.iter().map(String::as_str)));
    }
    offer
}
