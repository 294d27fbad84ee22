//! Tables of markers: which kind a table is, and what all kinds have in common.

use std::path::Path;

use super::column::Coordinate;
use super::draft::Draft;
use super::error::{RecordingFileError, RecordingFileErrorKind};
use super::headed::{self, Headed};
use super::long::{self, LongColumns};
use super::options::ReadOptions;
use super::warning::RecordingFileWarning;
use super::wide::{self, WideColumns};
use super::{displacement, mediapipe, unit};
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
    let heads = match rows.next() {
        Some(heads) => heads.map_err(|line| open_quote(file, line))?,
        None => return Err(RecordingFileError::new(Location::file(file), RecordingFileErrorKind::Empty)),
    };
    let mut warnings = Vec::new();
    let mut at = Location::file(file).at_line(heads.line);
    let (mut draft, stated, displaced) = if let Some(columns) = LongColumns::of(file, &heads)? {
        let draft = long::parse(file, &heads, &columns, rows, options)?;
        (draft, columns.unit.map(unit::name).map(str::to_owned), columns.displacement)
    } else if let Some(columns) = WideColumns::of(file, &heads)? {
        let (stated, displaced) = (columns.unit.map(unit::name).map(str::to_owned), columns.displacement);
        (wide::parse(file, columns, None, rows, options)?, stated, displaced)
    } else {
        let Headed { columns, unit, rate_hz, first } = headed::of(file, heads, &mut rows)?;
        let stated = unit.map(|(word, line)| {
            at = Location::file(file).at_line(line);
            word
        });
        let rows = first.map(Ok).into_iter().chain(rows);
        (wide::parse(file, columns, rate_hz, rows, options)?, stated, false)
    };
    if stated.is_none() && options.unit.is_none() && mediapipe::are_landmarks(&draft.names) {
        return mediapipe::from_table(draft, options);
    }
    draft.unit = unit::resolve(options, stated.as_deref(), at, UNIT, &mut warnings)?;
    draft.warnings.splice(0..0, warnings);
    if displaced {
        return displacement::from_neutral(file, draft, options, files);
    }
    if options.neutral.is_some() {
        return Err(RecordingFileError::new(Location::file(file), RecordingFileErrorKind::NeutralUnused));
    }
    Ok(draft)
}

/// A quote that is never closed begins on `line`.
pub(super) fn open_quote(file: &Path, line: usize) -> RecordingFileError {
    RecordingFileError::new(Location::file(file).at_line(line), RecordingFileErrorKind::OpenQuote)
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
pub(super) fn left_out(heads: &[String], others: &[usize], warnings: &mut Vec<RecordingFileWarning>) {
    if !others.is_empty() {
        let names = listed(others.iter().map(|&k| heads[k].as_str()));
        warnings.push(RecordingFileWarning::Columns { count: others.len(), names });
    }
}

/// What a table says of the times of its frames.
pub(super) enum Times {
    /// Nothing, and they are no moments: there are so many.
    Index(usize),
    /// Nothing; there are so many.
    Unsaid(usize),
    /// Numbers of frames, of which the first of the recording is 1 where the file states a rate.
    Frames { values: Vec<f64>, rate_hz: Option<f64> },
    /// Times, of which so many `seconds` are one; in `column`, where that does not say its unit.
    Time { values: Vec<f64>, seconds: f64, column: Option<String> },
}

impl Times {
    /// Times of the frames, s.
    pub(super) fn in_seconds(
        self,
        file: &Path,
        options: &ReadOptions,
        warnings: &mut Vec<RecordingFileWarning>,
    ) -> Result<Vec<f64>> {
        let asked = || {
            let absent = || RecordingFileError::new(Location::file(file), RecordingFileErrorKind::AbsentTime);
            options.rate_hz.ok_or_else(absent)
        };
        match self {
            Self::Index(n) => Ok((0..n).map(|k| k as f64).collect()),
            Self::Unsaid(0) => Ok(Vec::new()),
            Self::Unsaid(1) => Ok(vec![0.]),
            Self::Unsaid(n) => {
                let rate = asked()?;
                Ok((0..n).map(|k| k as f64 / rate).collect())
            }
            Self::Time { values, seconds, column } => {
                if let Some(column) = column {
                    warnings.push(RecordingFileWarning::TimeUnit { column: shown(&column) });
                }
                Ok(values.into_iter().map(|t| t * seconds).collect())
            }
            Self::Frames { values, rate_hz: Some(rate) } => {
                let rate = options.rate_hz.unwrap_or(rate);
                Ok(values.into_iter().map(|k| (k - 1.) / rate).collect())
            }
            Self::Frames { values, .. } if values.len() < 2 => Ok(vec![0.; values.len()]),
            Self::Frames { values, .. } => {
                let (rate, first) = (asked()?, values[0]);
                Ok(values.into_iter().map(|k| (k - first) / rate).collect())
            }
        }
    }
}
