//! What all tables of markers have in common.

use std::path::Path;

use super::column::Coordinate;
use super::draft::Draft;
use super::error::{RecordingFileError, RecordingFileErrorKind};
use super::format::RecordingFormat;
use super::long::{self, LongColumns};
use super::options::ReadOptions;
use super::warning::RecordingFileWarning;
use super::{displacement, unit};
use crate::io::csv::{self, Record};
use crate::io::text::{listed, shown};
use crate::io::{InputFile, Location};
use crate::units::LengthUnit;

type Result<T> = std::result::Result<T, RecordingFileError>;

/// Where a table's unit would stand.
const UNIT: &str = "write it into the names of the columns, such as x_mm";

/// The recording in the table `text` of `file`; other files that it needs join `files`.
pub(super) fn parse(
    file: &Path,
    text: &str,
    options: &ReadOptions,
    files: &mut Vec<InputFile>,
) -> Result<Draft> {
    let mut rows = csv::rows(text);
    let Some(heads) = rows.next() else {
        return Err(RecordingFileError::new(Location::file(file), RecordingFileErrorKind::Empty));
    };
    let heads = heads.map_err(|line| {
        RecordingFileError::new(Location::file(file).at_line(line), RecordingFileErrorKind::OpenQuote)
    })?;
    let mut warnings = Vec::new();
    let mut unit_of = |stated: Option<LengthUnit>| {
        let at = Location::file(file).at_line(heads.line);
        unit::resolve(options, stated.map(unit::name), at, UNIT, &mut warnings)
    };
    let Some(columns) = LongColumns::of(file, &heads)? else {
        let kind = RecordingFileErrorKind::Unrecognised {
            formats: RecordingFormat::READ,
            why: "its first row names no columns of markers",
        };
        return Err(RecordingFileError::new(Location::file(file), kind));
    };
    let unit = unit_of(columns.unit)?;
    let mut draft = long::parse(file, &heads, &columns, rows, unit, options)?;
    draft.warnings.splice(0..0, warnings);
    if columns.displacement {
        return displacement::from_neutral(file, draft, options, files);
    }
    if options.neutral.is_some() {
        return Err(RecordingFileError::new(Location::file(file), RecordingFileErrorKind::NeutralUnused));
    }
    Ok(draft)
}

/// The unit that all `coordinates` state, if any does.
pub(super) fn one_unit<'a>(
    file: &Path,
    heads: &Record,
    coordinates: impl Iterator<Item = &'a Coordinate>,
) -> Result<Option<LengthUnit>> {
    let mut units = coordinates.map(|c| c.unit);
    let first = units.next().flatten();
    match units.find(|unit| *unit != first) {
        None => Ok(first),
        Some(second) => {
            let word = |unit: Option<LengthUnit>| unit.map_or("none", unit::name);
            let kind = RecordingFileErrorKind::TwoUnits { first: word(first), second: word(second) };
            Err(RecordingFileError::new(Location::file(file).at_line(heads.line), kind))
        }
    }
}

/// Whether the `coordinates` are displacements, all of them.
pub(super) fn one_origin<'a>(
    file: &Path,
    heads: &Record,
    coordinates: impl Iterator<Item = &'a Coordinate>,
) -> Result<bool> {
    let mut displacements = coordinates.map(|c| c.displacement);
    let first = displacements.next().unwrap_or(false);
    if displacements.all(|d| d == first) {
        return Ok(first);
    }
    let (value, accepted) = ("x beside dx".to_owned(), "give positions or displacements, not both");
    let kind = RecordingFileErrorKind::Value { value, accepted };
    Err(RecordingFileError::new(Location::file(file).at_line(heads.line), kind))
}

/// Tells of the columns `others` of `heads` that hold no position.
pub(super) fn left_out(heads: &Record, others: &[usize], warnings: &mut Vec<RecordingFileWarning>) {
    if !others.is_empty() {
        let names = listed(others.iter().map(|&k| heads.entries[k].as_str()));
        warnings.push(RecordingFileWarning::Columns { count: others.len(), names });
    }
}

/// What a table says of the times of its frames.
pub(super) enum Times {
    /// Nothing; there are so many.
    Index(usize),
    /// Numbers of frames.
    Frames(Vec<f64>),
    /// Times, of which so many `seconds` are one; in `column`, where that does not say its unit.
    Time { values: Vec<f64>, seconds: f64, column: Option<String> },
}

impl Times {
    /// Times of the frames, s; numbered ones count from the first.
    pub(super) fn in_seconds(
        self,
        file: &Path,
        options: &ReadOptions,
        warnings: &mut Vec<RecordingFileWarning>,
    ) -> Result<Vec<f64>> {
        match self {
            Self::Index(n) => Ok((0..n).map(|k| k as f64).collect()),
            Self::Time { values, seconds, column } => {
                if let Some(column) = column {
                    warnings.push(RecordingFileWarning::TimeUnit { column: shown(&column) });
                }
                Ok(values.into_iter().map(|t| t * seconds).collect())
            }
            Self::Frames(values) if values.len() == 1 => Ok(vec![0.]),
            Self::Frames(values) => {
                let at = || Location::file(file);
                let rate = options
                    .rate_hz
                    .ok_or_else(|| RecordingFileError::new(at(), RecordingFileErrorKind::AbsentTime))?;
                let first = values.first().copied().unwrap_or(0.);
                Ok(values.into_iter().map(|k| (k - first) / rate).collect())
            }
        }
    }
}
