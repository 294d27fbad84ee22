//! What can be wrong with a target file, and what is odd about it.

use thiserror::Error;

use crate::io::{Location, UnreadableText};
use crate::units::counted;

/// Why a target file was refused.
#[derive(Debug, Error)]
#[non_exhaustive]
pub enum TargetFileError {
    /// The file cannot be opened or is not text.
    #[error("{at}: {reason}")]
    Unreadable {
        /// The file.
        at: Box<Location>,
        /// Why not.
        reason: UnreadableText,
    },
    /// The text is not TOML.
    #[error("{at}: not TOML: {reason}; targets/README.md shows the form")]
    Syntax {
        /// The line.
        at: Box<Location>,
        /// What the parser says.
        reason: String,
    },
    /// A key that the format does not have.
    #[error("{at}: unknown field; {}", offer(.nearest, .accepted))]
    UnknownField {
        /// The field.
        at: Box<Location>,
        /// The accepted name closest to it.
        nearest: Option<String>,
        /// Every accepted name.
        accepted: Vec<String>,
    },
    /// A key that must be there is not.
    #[error("{at}: missing; add it: {what}")]
    MissingField {
        /// The field, at the line of its table.
        at: Box<Location>,
        /// What the field means.
        what: String,
    },
    /// A value of the wrong kind.
    #[error("{at}: {value} is not accepted; write: {what}")]
    WrongKind {
        /// The field.
        at: Box<Location>,
        /// The value.
        value: String,
        /// What the field means.
        what: String,
    },
    /// A row of the wrong length.
    #[error(
        "{at}: {value} has {}; write {expected}, with a decimal point and nan where missing", counted(*.found, "entry")
    )]
    WrongLength {
        /// The field.
        at: Box<Location>,
        /// Number of entries found.
        found: usize,
        /// Number of entries expected.
        expected: u64,
        /// The value.
        value: String,
    },
    /// The file's unit is not millimetres.
    #[error("{at}: unit \"{value}\" is not accepted; convert the lengths and write unit = \"mm\"")]
    UnknownUnit {
        /// The field.
        at: Box<Location>,
        /// The unit.
        value: String,
    },
    /// A name that is not one plain word.
    #[error(
        "{at}: {value:?} is no name; write one word of letters, digits, `_` and `-`, of at most {most} bytes: it becomes the \
         name of a folder"
    )]
    Name {
        /// The field.
        at: Box<Location>,
        /// The name, shortened.
        value: String,
        /// Longest name accepted, bytes.
        most: usize,
    },
    /// An empty name.
    #[error("{at}: empty; give it a name")]
    EmptyName {
        /// The field.
        at: Box<Location>,
    },
    /// Two fields that exclude each other.
    #[error("{at}: both {first} and {second} are given; keep one")]
    Both {
        /// The table.
        at: Box<Location>,
        /// One field.
        first: &'static str,
        /// The other.
        second: &'static str,
    },
    /// None of the fields of which one is needed.
    #[error("{at}: needs {first} or {second}; add one")]
    Neither {
        /// The table.
        at: Box<Location>,
        /// One field.
        first: &'static str,
        /// The other.
        second: &'static str,
    },
    /// A label that was used before.
    #[error(
        "{at}: \"{value}\" is already the label on line {first_line}; labels are unique: give one another name"
    )]
    Duplicate {
        /// The field.
        at: Box<Location>,
        /// The label.
        value: String,
        /// Line of its first use.
        first_line: usize,
    },
    /// An infinite number, or a nan where no number may be missing.
    #[error("{at}: {value} is not a finite number; write one")]
    NotFinite {
        /// The field.
        at: Box<Location>,
        /// The value.
        value: f64,
    },
    /// A number that must be positive.
    #[error("{at}: {value} is not positive; write how far the value may be off, in mm, such as 1.0")]
    NotPositive {
        /// The field.
        at: Box<Location>,
        /// The value.
        value: f64,
    },
    /// A number so small or large that nothing can be computed with it.
    #[error("{at}: {value:e} is out of range; write {:e} to {:e}: {what}", .accepted[0], .accepted[1])]
    OutOfRange {
        /// The field.
        at: Box<Location>,
        /// The value.
        value: f64,
        /// Least and greatest value accepted.
        accepted: [f64; 2],
        /// Unit and meaning.
        what: &'static str,
    },
    /// A number below zero.
    #[error("{at}: {value} is negative; write 0 or more")]
    Negative {
        /// The field.
        at: Box<Location>,
        /// The value.
        value: f64,
    },
    /// An activation bound outside [0, 1].
    #[error("{at}: {value} is outside 0 to 1; activations are fractions, not per cent")]
    OutsideUnit {
        /// The field.
        at: Box<Location>,
        /// The value.
        value: f64,
    },
    /// A jaw that opens less than not at all, or farther than jaws do.
    #[error(
        "{at}: a jaw opens by 0 to {most} mm, not by {value}; the opening is the arc of the lower incisal point"
    )]
    JawOpening {
        /// The field.
        at: Box<Location>,
        /// The value, mm.
        value: f64,
        /// Widest opening accepted, mm.
        most: f64,
    },
    /// A lower bound above the upper one.
    #[error("{at}: min {min} is above max {max} for \"{muscle}\"; exchange them")]
    BoundsCrossed {
        /// The table.
        at: Box<Location>,
        /// The muscle.
        muscle: String,
        /// Least activation.
        min: f64,
        /// Greatest activation.
        max: f64,
    },
    /// Lengths that cannot be millimetres on a face.
    #[error("{at}: {value} mm {problem}; metres, or another unit? Convert to mm")]
    Scale {
        /// The field.
        at: Box<Location>,
        /// The value, mm.
        value: f64,
        /// Why it is implausible.
        problem: &'static str,
    },
    /// Two points or muscles that must differ.
    #[error("{at}: {first} and {second} are the same, \"{value}\"; name two")]
    Same {
        /// The table.
        at: Box<Location>,
        /// One field.
        first: &'static str,
        /// The other.
        second: &'static str,
        /// The shared value.
        value: String,
    },
    /// A pattern that cannot be read or matches no muscle.
    #[error("{at}: pattern \"{pattern}\" {problem}; the face has: {known}")]
    Pattern {
        /// The field.
        at: Box<Location>,
        /// The pattern.
        pattern: String,
        /// What is wrong with it.
        problem: String,
        /// The muscles of the face.
        known: String,
    },
}

fn offer(nearest: &Option<String>, accepted: &[String]) -> String {
    match nearest {
        Some(name) => format!("did you mean {name}?"),
        None => format!("accepted: {}", accepted.join(", ")),
    }
}

/// What is odd about a target file that is used all the same.
#[derive(Clone, Debug, PartialEq, Error)]
#[non_exhaustive]
pub enum TargetWarning {
    /// A marker that is said not to move at all.
    #[error(
        "{at}: marker \"{name}\" is exactly (0, 0, 0): if it is missing write nan, if it is at rest ignore this"
    )]
    ZeroMarker {
        /// The field.
        at: Location,
        /// The marker.
        name: String,
    },
    /// A marker of which nothing was observed.
    #[error(
        "{at}: marker \"{name}\" has no observed component and is left out: give displacement_mm or position_mm, or remove it"
    )]
    MissingMarker {
        /// The table.
        at: Location,
        /// The marker.
        name: String,
    },
}
