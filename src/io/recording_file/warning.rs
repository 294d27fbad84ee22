//! What is odd about a file of markers.

use thiserror::Error;

use crate::units::counted;

/// What the user should look at in a recording that was read.
#[derive(Clone, Debug, Error, PartialEq)]
#[non_exhaustive]
pub enum RecordingFileWarning {
    /// A marker at exactly (0, 0, 0), where a gap would be blank.
    #[error(
        "marker {marker} is at exactly (0, 0, 0) in {}, first in frame {}: leave what was not seen blank, or remove it",
        counted(*.frames, "frame"), .first + 1
    )]
    ZeroPosition {
        /// Its name.
        marker: String,
        /// The first such frame, from 0.
        first: usize,
        /// How many.
        frames: usize,
    },
    /// A marker at exactly (0, 0, 0) in a format whose programs write gaps so.
    #[error(
        "marker {marker} is at exactly (0, 0, 0) in {}, first in frame {}, and taken as not seen there",
        counted(*.frames, "frame"), .first + 1
    )]
    ZeroGap {
        /// Its name.
        marker: String,
        /// The first such frame, from 0.
        first: usize,
        /// How many.
        frames: usize,
    },
    /// A marker that leaps.
    #[error(
        "marker {marker} jumps by {distance_mm:.0} mm to frame {}, {}; look for labels that are swapped, or leave the \
         frame out", .frame + 1, if *.jumps > 1 { format!("the farthest of {jumps} jumps") } else { "once".to_owned() }
    )]
    Jump {
        /// Its name.
        marker: String,
        /// The frame that it leaps to, from 0.
        frame: usize,
        /// How far, mm.
        distance_mm: f64,
        /// How many leaps of more than [`Self::JUMP_MM`] there are.
        jumps: usize,
    },
    /// A position of which some coordinates are missing.
    #[error(
        "marker {marker} lacks coordinates in {}, first in frame {}, and is taken as not seen there",
        counted(*.frames, "frame"), .first + 1
    )]
    Partial {
        /// Its name.
        marker: String,
        /// The first such frame, from 0.
        first: usize,
        /// How many.
        frames: usize,
    },
    /// Labels without a point.
    #[error("POINT:LABELS: {} without a point left out: {names}", counted(*.count, "label"))]
    Labels {
        /// How many.
        count: usize,
        /// The first of them.
        names: String,
    },
    /// Points without a label.
    #[error("POINT:LABELS: {} without a label called point_{}, ...", counted(*.count, "point"), .first + 1)]
    Unlabelled {
        /// How many.
        count: usize,
        /// The first of them, from 0.
        first: usize,
    },
    /// Counts of frames that do not agree.
    #[error(
        "{parameter} says {other} frames and the header {taken}, which were read; write the file anew if frames are missing"
    )]
    Frames {
        /// The parameter.
        parameter: &'static str,
        /// What it says.
        other: u64,
        /// What the header says.
        taken: u64,
    },
    /// A unit that another went before.
    #[error("the file states {stated} and was read in {taken}, as was asked")]
    OtherUnit {
        /// The unit of the file.
        stated: String,
        /// The unit taken.
        taken: &'static str,
    },
    /// Times without a unit.
    #[error("column {column} has no unit and is taken as seconds; call it {column}_s or {column}_ms")]
    TimeUnit {
        /// The column.
        column: String,
    },
    /// Landmarks of a video.
    #[error(
        "landmarks found in a video are drawn to faces that are symmetric and usual, and their depth is guessed: use markers \
         to judge an asymmetry; scaled by {by}: {mm_a_pixel:.4} mm a pixel"
    )]
    VideoTracker {
        /// What gave the scale.
        by: String,
        /// The scale, mm.
        mm_a_pixel: f64,
    },
    /// Columns that are no positions.
    #[error("{} that no marker's position is left out: {names}", counted(*.count, "column"))]
    Columns {
        /// How many.
        count: usize,
        /// The first of them.
        names: String,
    },
}

impl RecordingFileWarning {
    /// How far a marker moves from one frame to the next before it is told, mm.
    pub const JUMP_MM: f64 = 50.;
}
