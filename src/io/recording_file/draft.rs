//! A recording under construction.

use std::path::Path;

use super::error::{RecordingFileError, RecordingFileErrorKind};
use super::format::RecordingFormat;
use super::warning::RecordingFileWarning;
use crate::io::Location;
use crate::recording::{Recording, RecordingError};
use crate::units::{LengthUnit, Vec3};

type Result<T> = std::result::Result<T, RecordingFileError>;

/// What a reader found, in the file's unit.
pub(super) struct Draft {
    pub(super) format: RecordingFormat,
    pub(super) unit: LengthUnit,
    pub(super) names: Vec<String>,
    pub(super) times_s: Vec<f64>,
    /// Frame by frame.
    pub(super) positions: Vec<Option<Vec3>>,
    /// Of frames, where they have any.
    pub(super) frame_names: Vec<String>,
    /// What depth counts beside the other directions.
    pub(super) depth_weight: f64,
    pub(super) warnings: Vec<RecordingFileWarning>,
    /// Where the names of the markers stand.
    pub(super) names_at: Location,
    /// The line of each frame, where there are lines.
    pub(super) lines: Vec<usize>,
    /// The first line of each marker, where markers have lines.
    pub(super) marker_lines: Vec<usize>,
}

impl Draft {
    /// The recording, its oddities told.
    pub(super) fn finish(mut self, file: &Path) -> Result<(Recording, Vec<RecordingFileWarning>)> {
        self.zeros();
        let scale = self.unit.in_mm();
        self.positions.iter_mut().flatten().for_each(|p| *p *= scale);
        let at = |error: &RecordingError| match error {
            RecordingError::TimeNotIncreasing { frame, .. } | RecordingError::NotFinite { frame, .. } => {
                let at = Location::file(file);
                self.lines.get(*frame).map_or(at.clone(), |line| at.at_line(*line))
            }
            _ => self.names_at.clone(),
        };
        let refused = |error: RecordingError| RecordingFileError::new(at(&error), kind(error));
        let recording = Recording::new(self.names, self.times_s, self.positions).map_err(refused)?;
        let recording = match self.frame_names.is_empty() {
            true => recording,
            false => recording.with_frame_names(self.frame_names).map_err(refused)?,
        };
        let recording = recording.with_depth_weight(self.depth_weight);
        if recording.frame_names().is_none() {
            jumps(&recording, &mut self.warnings);
        }
        Ok((recording, self.warnings))
    }

    /// What stands at exactly (0, 0, 0): a gap in C3D, and a question elsewhere.
    fn zeros(&mut self) {
        let is_gap = self.format == RecordingFormat::C3d;
        let n = self.names.len();
        let mut zeros = vec![(0, 0); n];
        for (k, p) in self.positions.iter_mut().enumerate() {
            if *p == Some(Vec3::zeros()) {
                let (first, frames) = &mut zeros[k % n];
                if *frames == 0 {
                    *first = k / n;
                }
                *frames += 1;
                if is_gap {
                    *p = None;
                }
            }
        }
        for (marker, (first, frames)) in self.names.iter().zip(zeros).filter(|(_, (_, frames))| *frames > 0) {
            let marker = marker.clone();
            self.warnings.push(match is_gap {
                true => RecordingFileWarning::ZeroGap { marker, first, frames },
                false => RecordingFileWarning::ZeroPosition { marker, first, frames },
            });
        }
    }
}

fn kind(error: RecordingError) -> RecordingFileErrorKind {
    match error {
        RecordingError::TimeNotIncreasing { time_s, before_s, .. } => {
            RecordingFileErrorKind::TimeNotIncreasing { time_s, before_s }
        }
        other => RecordingFileErrorKind::Recording(other),
    }
}

/// Markers that leap from one frame to the next.
fn jumps(recording: &Recording, warnings: &mut Vec<RecordingFileWarning>) {
    for (m, marker) in recording.names().iter().enumerate() {
        let (mut jumps, mut farthest) = (0, (0, 0.));
        for frame in 1..recording.n_frames() {
            if let (Some(before), Some(now)) = (recording.frame(frame - 1)[m], recording.frame(frame)[m]) {
                let distance_mm = (now - before).norm();
                if distance_mm > RecordingFileWarning::JUMP_MM {
                    jumps += 1;
                    if distance_mm > farthest.1 {
                        farthest = (frame, distance_mm);
                    }
                }
            }
        }
        if jumps > 0 {
            let (frame, distance_mm) = farthest;
            let marker = marker.clone();
            warnings.push(RecordingFileWarning::Jump { marker, frame, distance_mm, jumps });
        }
    }
}
