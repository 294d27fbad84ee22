//! What can be wrong with a mesh or surface file.

use thiserror::Error;

use super::Location;
use crate::mesh::MeshError;

/// The greatest node or element number accepted: that of a signed 32-bit integer, which no real file
/// exceeds and a corrupt one soon does.
pub const MAX_ID: u64 = i32::MAX as u64;

/// The most members that the sets of a file may have together: what a small file asks for by naming sets
/// in sets must still fit into memory.
pub(super) const MAX_MEMBERS: usize = 10_000_000;

/// The elements that all readers take, for messages.
pub(super) const SUPPORTED: &str = "8-node hexahedra, 6-node wedges, 4-node and 10-node tetrahedra";

/// A mesh or surface file that cannot be used: where, what, and what to do.
#[derive(Clone, Debug, Error, PartialEq)]
#[error("{location}: {kind}")]
pub struct MeshFileError {
    /// Where.
    pub location: Box<Location>,
    /// What.
    #[source]
    pub kind: MeshFileErrorKind,
}

impl MeshFileError {
    pub(super) fn new(location: Location, kind: MeshFileErrorKind) -> Self {
        Self { location: Box::new(location), kind }
    }

    /// The mesh of file `file` was read but is not sound.
    pub fn invalid(file: impl Into<std::path::PathBuf>, error: MeshError) -> Self {
        Self::new(Location::file(file), MeshFileErrorKind::Invalid(error))
    }
}

/// What is wrong, with the value and the fix.
#[derive(Clone, Debug, Error, PartialEq)]
#[non_exhaustive]
pub enum MeshFileErrorKind {
    /// The file system refused.
    #[error("cannot be accessed ({reason}); check the path and its permissions")]
    Io {
        /// What the system says.
        reason: String,
    },
    /// Nothing in the file.
    #[error("is empty; export the mesh again")]
    Empty,
    /// Bytes that are no text where text is expected.
    #[error("is not text (byte 0x{value:02x}); export as ASCII, or name the file after its format")]
    BinaryAsText {
        /// The byte.
        value: u8,
    },
    /// The file ends too early.
    #[error("ends before {expected}; the file is truncated: export or copy it again")]
    Truncated {
        /// What should have followed.
        expected: String,
    },
    /// A word where a number should be.
    #[error("`{value}` is not a number; write {expected}")]
    NotANumber {
        /// The word.
        value: String,
        /// What is expected.
        expected: &'static str,
    },
    /// A comma for the decimal point.
    #[error("`{value}` has a decimal comma; write a decimal point (`{fixed}`)")]
    DecimalComma {
        /// The number as it stands.
        value: String,
        /// As it should be.
        fixed: String,
    },
    /// NaN or infinity.
    #[error("`{value}` is not finite; remove the node or give it a position")]
    NotFinite {
        /// The number.
        value: String,
    },
    /// A declared count that the file cannot hold.
    #[error("declares {declared} {what}, but a file of this size holds at most {most}; correct the count")]
    DeclaredTooMany {
        /// What is counted.
        what: String,
        /// The count.
        declared: u64,
        /// The most that the bytes of the file can mean.
        most: u64,
    },
    /// More than any mesh of a face has, asked for by a file however small.
    #[error(
        "asks for more than {most} {what}; a face needs far fewer: correct the file, or cut it down to the face"
    )]
    TooMuch {
        /// What is counted.
        what: String,
        /// The most that is read.
        most: u64,
    },
    /// Content that is of no format.
    #[error("is no {formats}; check that it is the file that is meant, and export it again")]
    Unrecognised {
        /// The formats that it might have had.
        formats: String,
    },
    /// A name that stands for nothing.
    #[error("there is no {what} `{name}`; known are: {known}")]
    Unknown {
        /// `instance`, ...
        what: &'static str,
        /// The name.
        name: String,
        /// The names there are.
        known: String,
    },
    /// A declared count that is not the number of entries.
    #[error("declares {declared} {what} but has {found}; correct the count or restore the entries")]
    CountMismatch {
        /// What is counted.
        what: String,
        /// The count.
        declared: u64,
        /// What is there.
        found: u64,
    },
    /// A number given twice.
    #[error("{what} {id} is defined twice; renumber one of them")]
    DuplicateId {
        /// `node` or `element`.
        what: &'static str,
        /// The number.
        id: u64,
    },
    /// A reference to a node that is not in the file.
    #[error("{what} {id} uses node {node}, which is not defined; add the node or correct the number")]
    MissingNode {
        /// `element` or `set`.
        what: &'static str,
        /// Its number or name.
        id: String,
        /// The node.
        node: String,
    },
    /// A reference to an element that is not in the file.
    #[error("set {set} lists element {element}, which is not defined; correct the set")]
    MissingElement {
        /// The set.
        set: String,
        /// The element.
        element: u64,
    },
    /// A negative number or one beyond [`MAX_ID`].
    #[error("`{value}` is no {what} number; number from 0 or 1 up to {MAX_ID}")]
    BadId {
        /// `node`, `element`, ...
        what: &'static str,
        /// The number.
        value: String,
    },
    /// An element kind that has no implementation here.
    #[error("element {id} is of the unsupported kind {name}; convert it to one of: {SUPPORTED}")]
    UnsupportedElement {
        /// The element.
        id: String,
        /// Its kind as the file calls it.
        name: String,
    },
    /// A variant of the format that is not read.
    #[error("{what} is not read; {fix}")]
    UnsupportedFormat {
        /// The variant.
        what: String,
        /// What to export.
        fix: &'static str,
    },
    /// Something else than the format asks for.
    #[error("expected {expected}, found `{found}`; correct it or export the mesh again")]
    Syntax {
        /// What belongs here.
        expected: String,
        /// What is here.
        found: String,
    },
    /// No nodes or no volume elements.
    #[error("has no {what}; export the volume mesh, not only its surface")]
    Nothing {
        /// `nodes` or `volume elements`.
        what: &'static str,
    },
    /// A set that is not in the file.
    #[error("set `{name}` is not defined; defined are: {known}")]
    UnknownSet {
        /// The name.
        name: String,
        /// The names there are.
        known: String,
    },
    /// The mesh is complete but not sound.
    #[error(transparent)]
    Invalid(#[from] MeshError),
}
