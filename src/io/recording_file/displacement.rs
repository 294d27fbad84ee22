//! Displacements become positions.

use std::collections::HashMap;
use std::path::Path;

use super::draft::Draft;
use super::error::{RecordingFileError, RecordingFileErrorKind};
use super::options::ReadOptions;
use super::reader::read_recording;
use crate::io::text::shown;
use crate::io::{InputFile, Location, nearest};
use crate::units::LengthUnit;

type Result<T> = std::result::Result<T, RecordingFileError>;

/// What the neutral frame is called.
const NEUTRAL: &str = "neutral";

/// `draft`, whose positions are displacements, from the neutral positions in the file that `options` name: its first frame,
/// or that called `neutral`. Markers are those of the neutral file; named frames come after one called `neutral`.
pub(super) fn from_neutral(
    file: &Path,
    draft: Draft,
    options: &ReadOptions,
    files: &mut Vec<InputFile>,
) -> Result<Draft> {
    let Some(path) = options.neutral else {
        let kind = RecordingFileErrorKind::AbsentNeutral { column: "dx".to_owned() };
        return Err(RecordingFileError::new(draft.names_at, kind));
    };
    let mut document = read_recording(path, &ReadOptions { neutral: None, ..*options })?;
    let neutral = &document.recording;
    let rest = neutral.frame(neutral.frame_named(NEUTRAL).unwrap_or(0));
    let known: HashMap<&str, usize> =
        neutral.names().iter().enumerate().map(|(m, name)| (name.as_str(), m)).collect();
    let mut to = Vec::with_capacity(draft.names.len());
    for (m, name) in draft.names.iter().enumerate() {
        match known.get(name.as_str()) {
            Some(&place) => to.push(place),
            None => {
                let line = draft.marker_lines.get(m).copied();
                let at = Location { line, ..Location::file(file) };
                let nearest = nearest(name, neutral.names().iter().map(String::as_str)).map(shown);
                let (marker, neutral) = (shown(name), path.display().to_string());
                let kind = RecordingFileErrorKind::NotInNeutral { marker, neutral, nearest };
                return Err(RecordingFileError::new(at, kind));
            }
        }
    }
    let (n, scale) = (neutral.names().len(), draft.unit.in_mm());
    let named = !draft.frame_names.is_empty() && !draft.frame_names.iter().any(|name| name == NEUTRAL);
    let before = usize::from(named);
    let mut positions = if named { rest.to_vec() } else { Vec::new() };
    positions.resize(n * (before + draft.times_s.len()), None);
    for (k, d) in draft.positions.iter().enumerate() {
        let (frame, m) = (k / draft.names.len(), to[k % draft.names.len()]);
        positions[n * (before + frame) + m] = d.zip(rest[m]).map(|(d, p)| p + scale * d);
    }
    files.append(&mut document.files);
    let mut warnings = draft.warnings;
    warnings.append(&mut document.warnings);
    let mut made = Draft {
        unit: LengthUnit::Millimetre,
        names: neutral.names().to_vec(),
        positions,
        warnings,
        marker_lines: Vec::new(),
        ..draft
    };
    if named {
        made.frame_names.insert(0, NEUTRAL.to_owned());
        made.lines.insert(0, 1);
        made.times_s = (0..made.frame_names.len()).map(|k| k as f64).collect();
    }
    Ok(made)
}
