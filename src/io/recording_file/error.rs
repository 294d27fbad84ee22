//! What can be wrong with a file of markers.

use thiserror::Error;

use crate::io::Location;
use crate::recording::RecordingError;

/// A file of markers that cannot be used: where, what, and what to do.
#[derive(Clone, Debug, Error, PartialEq)]
#[error("{}", .location.before(.kind))]
pub struct RecordingFileError {
    /// Where.
    pub location: Box<Location>,
    /// What.
    #[source]
    pub kind: RecordingFileErrorKind,
}

impl RecordingFileError {
    pub(super) fn new(location: Location, kind: RecordingFileErrorKind) -> Self {
        Self { location: Box::new(location), kind }
    }
}

/// What is wrong, with the value and the fix.
#[derive(Clone, Debug, Error, PartialEq)]
#[non_exhaustive]
pub enum RecordingFileErrorKind {
    /// The file system refused.
    #[error("cannot be accessed ({reason}); check the path and its permissions")]
    Io {
        /// What the system says.
        reason: String,
    },
    /// Nothing in the file.
    #[error("is empty; export the recording again")]
    Empty,
    /// Bytes that are no text where text is expected.
    #[error("is neither C3D nor text (byte 0x{value:02x}); export the recording as {formats}")]
    NotText {
        /// The byte.
        value: u8,
        /// The formats that are read.
        formats: &'static str,
    },
    /// Content that is of no format.
    #[error("is no recording that is read ({formats}): {why}")]
    Unrecognised {
        /// The formats that are read.
        formats: &'static str,
        /// What is missing.
        why: &'static str,
    },
    /// The file ends too early.
    #[error("ends before {expected}; the file is truncated: export or copy it again")]
    Truncated {
        /// What should have followed.
        expected: String,
    },
    /// A block that the file does not have.
    #[error(
        "block {block} is asked for, and the file has {blocks} of 512 bytes; the file is truncated or its header damaged: \
         export it again"
    )]
    PastEnd {
        /// The block, from 1.
        block: u64,
        /// Blocks of the file.
        blocks: u64,
    },
    /// A parameter that reaches past the end of the file.
    #[error("{parameter} reaches past the end of the file; its parameters are damaged: export it again")]
    ParameterPastEnd {
        /// `GROUP:NAME`, as far as known.
        parameter: String,
    },
    /// More frames than the bytes hold.
    #[error(
        "{parameter} says {declared} frames, and the file holds {held}; the file is truncated: export or copy it again"
    )]
    FramesPastEnd {
        /// What says so.
        parameter: &'static str,
        /// How many are declared.
        declared: u64,
        /// How many there are.
        held: u64,
    },
    /// A value that cannot be.
    #[error("{value} is not accepted; {accepted}")]
    Value {
        /// The value.
        value: String,
        /// What is accepted, or what to do.
        accepted: &'static str,
    },
    /// NaN or infinity where a number must be, or a word.
    #[error(
        "`{value}` is not a finite number; write one with a decimal point, and leave what was not seen blank"
    )]
    NotANumber {
        /// The word.
        value: String,
    },
    /// A unit that is not known.
    #[error(
        "unit of length {value} is not known; state mm, cm or m: --unit mm goes before what the file says"
    )]
    UnknownUnit {
        /// What stands for it.
        value: String,
    },
    /// No unit at all.
    #[error("no unit of length is stated; {fix}, or state it beside the file: --unit mm")]
    AbsentUnit {
        /// Where it would stand.
        fix: &'static str,
    },
    /// Columns of different units.
    #[error("{first} and {second} are both units of this table; write all its lengths in one")]
    TwoUnits {
        /// One.
        first: &'static str,
        /// The other.
        second: &'static str,
    },
    /// A count that is not what is there.
    #[error(
        "{declared} {what} are declared and {found} are there; correct the count, or export the file again"
    )]
    CountMismatch {
        /// What is counted.
        what: &'static str,
        /// The count.
        declared: u64,
        /// How many there are.
        found: u64,
    },
    /// A short or long row.
    #[error("has {found} entries where there should be {expected}; leave entries blank rather than out")]
    RowLength {
        /// Entries found.
        found: usize,
        /// Entries expected.
        expected: usize,
    },
    /// A quote that is never closed.
    #[error("a quote that begins here is not closed")]
    OpenQuote,
    /// A column that must be there.
    #[error("there is no column {name}; add it{}", .nearest.as_ref().map(|n| format!(", or was it {n}?")).unwrap_or_default())]
    MissingColumn {
        /// Its name.
        name: String,
        /// The column closest to it.
        nearest: Option<String>,
    },
    /// A column that is there twice.
    #[error("two columns are {name}; name the markers apart, or remove one")]
    DuplicateColumn {
        /// What it is.
        name: String,
    },
    /// A marker twice in one frame.
    #[error("marker {marker} is in this frame twice, first on line {first_line}; keep one")]
    DuplicateRow {
        /// Its name.
        marker: String,
        /// Where it is first.
        first_line: usize,
    },
    /// A table whose rows are not in the order of time.
    #[error(
        "the frame is at {time_s} s, not after the frame before it, at {before_s} s; sort the rows by time"
    )]
    TimeNotIncreasing {
        /// Its time, s.
        time_s: f64,
        /// The time of the one before it, s.
        before_s: f64,
    },
    /// Frames without time.
    #[error("frames are numbered and have no times; add a column time_s, or state their rate: --rate-hz 60")]
    AbsentTime,
    /// Hardly a marker in any frame.
    #[error(
        "{rows} rows are too few for {frames} frames of {markers} markers; are the frames those of one recording, and the \
         markers the same in each?"
    )]
    Sparse {
        /// Rows.
        rows: usize,
        /// Frames.
        frames: usize,
        /// Markers.
        markers: usize,
    },
    /// Displacements from nowhere.
    #[error("the table has displacements ({column}); give the file of the neutral positions: --neutral FILE")]
    AbsentNeutral {
        /// A column of them.
        column: String,
    },
    /// Neutral positions that are not needed.
    #[error(
        "holds positions, not displacements, so that no neutral positions are needed; leave --neutral out"
    )]
    NeutralUnused,
    /// A marker without a neutral position.
    #[error(
        "marker {marker} has no position in {neutral}{}; add it there, or remove its rows",
        .nearest.as_ref().map(|n| format!(" (did you mean {n}?)")).unwrap_or_default()
    )]
    NotInNeutral {
        /// Its name.
        marker: String,
        /// The file of the neutral positions.
        neutral: String,
        /// The name closest to it.
        nearest: Option<String>,
    },
    /// JSON that is none, or holds something else.
    #[error("is no JSON of face landmarks: {reason}; export the tracker's results as they are")]
    Json {
        /// What the parser says.
        reason: String,
    },
    /// A face of another mesh.
    #[error("a face has {found} points, and MediaPipe's has 468, or 478 with irises; export all of them")]
    Points {
        /// How many.
        found: usize,
    },
    /// More than one face in a frame.
    #[error("several faces are in this frame; export one of them, such as with num_faces = 1")]
    Faces,
    /// Hardly a face in any frame.
    #[error("fewer than one frame in 64 has a face; cut the recording to where the face is seen")]
    NoFaces,
    /// An image of unknown size.
    #[error(
        "landmarks are shares of the image's width and height, which the file does not state; add `width` and `height` to its \
         JSON, or state them: --image 1920x1080"
    )]
    AbsentImage,
    /// Images of different sizes.
    #[error("the image has another size than before; export one video at a time")]
    TwoImages,
    /// Positions in pixels.
    #[error(
        "a coordinate is {value}, which is no share of the image; export normalised landmarks, from 0 to 1"
    )]
    Pixels {
        /// The coordinate.
        value: f64,
    },
    /// No iris to measure.
    #[error(
        "the face has 468 points and no irises to tell its size; refine_landmarks = true gives 478, or state a length: --length \
         exocanthion_r,exocanthion_l=90"
    )]
    NoIris,
    /// A length between nothing.
    #[error(
        "there is no point {name}; name a landmark, such as exocanthion_r, or a point from p0 to p{last}"
    )]
    NoPoint {
        /// The name.
        name: String,
        /// The last index.
        last: usize,
    },
    /// A length that is nothing in the image.
    #[error(
        "{by} give no scale: they are in no frame, or at one point; state another length: --length FROM,TO=MM"
    )]
    NoScale {
        /// What was measured.
        by: String,
    },
    /// What was read is no recording.
    #[error(transparent)]
    Recording(#[from] RecordingError),
}
