//! Target files, `targets/*.toml`.

mod check;
mod error;
mod file;
mod lines;
mod pattern;
mod shape;

use std::path::{Path, PathBuf};

use serde::Deserialize;
use toml::de::DeTable;

pub(super) use check::word;
pub use error::{TargetFileError, TargetWarning};
pub use lines::FieldLines;
pub(super) use lines::line_of;
pub(super) use shape::check_table;

use self::check::Checker;
use self::file::{RecordingTable, TargetTable};
use super::input_file::read_text;
use super::schema::toml_schema_of;
use super::{Location, sha256};
use crate::inverse::Target;
use crate::recording::FrameChoice;

/// A target as its file states it, with the line of each field.
#[derive(Clone, Debug)]
pub struct TargetDocument {
    /// The target; bounds and tied pairs may still hold patterns such as `*_r`.
    pub target: Target,
    /// The frame of a recording whose markers are the target's, too, once a face is known.
    pub recording: Option<RecordedFrame>,
    /// Where each field stands, so that later errors can name its line.
    pub lines: FieldLines,
    /// What is odd about the file.
    pub warnings: Vec<TargetWarning>,
    /// SHA-256 of the text that was parsed.
    pub sha256: String,
}

/// A frame of a recording that a target file names.
#[derive(Clone, Debug, PartialEq)]
pub struct RecordedFrame {
    /// The recording.
    pub file: PathBuf,
    /// Which of its frames.
    pub frame: FrameChoice,
    /// Its marker map.
    pub map: Option<PathBuf>,
}

/// Reads the target file `path`.
///
/// # Errors
/// [`TargetFileError`] when the file is not a target: it names the line, the field, the value and
/// the remedy.
pub fn read_target(path: &Path) -> Result<TargetDocument, TargetFileError> {
    let text = read_text(path)
        .map_err(|reason| TargetFileError::Unreadable { at: Box::new(Location::file(path)), reason })?;
    parse_target(&text, path)
}

/// Reads a target from `text`; `path` is only named in messages.
///
/// # Errors
/// As [`read_target`].
pub fn parse_target(text: &str, path: &Path) -> Result<TargetDocument, TargetFileError> {
    let sha256 = sha256(text.as_bytes());
    let text = text.strip_prefix('\u{feff}').unwrap_or(text);
    let not_toml = |e: toml::de::Error| TargetFileError::Syntax {
        at: Box::new(Location::file(path).at_line(line_of(text, e.span().map_or(0, |s| s.start)))),
        reason: e.message().to_owned(),
    };
    let root = DeTable::parse(text).map_err(not_toml)?;
    let lines = FieldLines::of(path, text, root.get_ref());
    if let Some(unit) = root.get_ref().get("unit").and_then(|v| v.get_ref().as_str())
        && unit != "mm"
    {
        return Err(TargetFileError::UnknownUnit {
            at: Box::new(lines.location("unit")),
            value: unit.to_owned(),
        });
    }
    check_table(root.get_ref(), toml_schema_of::<TargetTable>().as_value(), "", &lines)?;
    let mut table = TargetTable::deserialize(toml::Deserializer::from(root)).map_err(not_toml)?;
    let recording = table.recording.take().map(|table| recorded(table, path, &lines)).transpose()?;
    let mut checker = Checker::new(&lines);
    let target = checker.target(table)?;
    let warnings = checker.warnings;
    Ok(TargetDocument { target, recording, lines, warnings, sha256 })
}

fn recorded(
    table: RecordingTable,
    path: &Path,
    lines: &FieldLines,
) -> Result<RecordedFrame, TargetFileError> {
    let at = |field: &str| Box::new(lines.location(&format!("recording.{field}")));
    let frame = match (table.frame, table.time_s, table.name) {
        (Some(frame), None, None) if frame >= 0. && frame.fract() == 0. && frame < 1e9 => {
            FrameChoice::Index(frame as usize)
        }
        (Some(frame), None, None) => {
            let (value, what) = (frame.to_string(), "the frame, a whole number from 0".to_owned());
            return Err(TargetFileError::WrongKind { at: at("frame"), value, what });
        }
        (None, Some(time_s), None) if time_s.is_finite() => FrameChoice::Time(time_s),
        (None, None, Some(name)) => FrameChoice::Named(name),
        _ => {
            let what = "one of `frame`, `time_s` and `name`".to_owned();
            return Err(TargetFileError::MissingField { at: at("frame"), what });
        }
    };
    let beside = |name: String| path.with_file_name(name);
    Ok(RecordedFrame { file: beside(table.file), frame, map: table.map.map(beside) })
}

/// The JSON schema of target files, as in `schemas/target.schema.json`.
pub fn target_schema() -> String {
    super::schema::pretty(&toml_schema_of::<TargetTable>())
}
