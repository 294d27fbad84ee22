//! TRC: tables of positions as motion-capture programs and OpenSim write them.

use std::path::Path;

use super::cell::{self, Cells};
use super::draft::Draft;
use super::error::{RecordingFileError, RecordingFileErrorKind};
use super::format::RecordingFormat;
use super::options::ReadOptions;
use super::subject::without_subject;
use super::unit;
use crate::io::csv::{self, Record};
use crate::io::text::shown;
use crate::io::{Location, nearest};

type Result<T> = std::result::Result<T, RecordingFileError>;

/// The recording in the TRC `text` of `file`: a line that says so, names and values of the file, names of the markers over
/// three columns each, names of the columns, and a row a frame, parted by tabs, commas or semicolons.
pub(super) fn parse(file: &Path, text: &str, options: &ReadOptions) -> Result<Draft> {
    let mut rows = csv::rows(text);
    let mut next = |expected: &str| -> Result<Record> {
        for record in rows.by_ref() {
            let record = record.map_err(|line| {
                RecordingFileError::new(Location::file(file).at_line(line), RecordingFileErrorKind::OpenQuote)
            })?;
            if record.entries.iter().any(|entry| !entry.is_empty()) {
                return Ok(record);
            }
        }
        let kind = RecordingFileErrorKind::Truncated { expected: expected.to_owned() };
        Err(RecordingFileError::new(Location::file(file), kind))
    };
    next("its first line")?;
    let fields = next("the names of its fields")?;
    let values = next("the values of its fields")?;
    let heads = next("the names of its markers")?;
    let columns = next("the names of its columns")?;

    let value = |name: &str| -> Result<&str> {
        let at = Location::file(file).at_line(fields.line);
        let Some(column) = fields.entries.iter().position(|field| field.eq_ignore_ascii_case(name)) else {
            let nearest = nearest(name, fields.entries.iter().map(String::as_str)).map(shown);
            let kind = RecordingFileErrorKind::MissingColumn { name: name.to_owned(), nearest };
            return Err(RecordingFileError::new(at, kind));
        };
        Ok(values.entries.get(column).map_or("", String::as_str))
    };
    let value_at = |name: &str| Location::file(file).at_line(values.line).in_field(name);
    let count = |name: &str| -> Result<u64> {
        let value = value(name)?;
        csv::number(value).filter(|n| *n >= 0. && n.fract() == 0. && *n < 1e15).map(|n| n as u64).ok_or_else(
            || {
                let (value, accepted) = (shown(value), "write a whole number");
                let value = if value.is_empty() { "nothing".to_owned() } else { value };
                RecordingFileError::new(value_at(name), RecordingFileErrorKind::Value { value, accepted })
            },
        )
    };
    let (declared_frames, declared_markers) = (count("NumFrames")?, count("NumMarkers")?);
    let mut warnings = Vec::new();
    let unit = unit::resolve(
        options,
        Some(value("Units")?),
        value_at("Units"),
        "write it below Units",
        &mut warnings,
    )?;

    let mut names: Vec<String> =
        heads.entries.iter().skip(2).filter(|name| !name.is_empty()).cloned().collect();
    let mismatch = |what, declared, found: usize| {
        let kind = RecordingFileErrorKind::CountMismatch { what, declared, found: found as u64 };
        let field = if what == "frames" { "NumFrames" } else { "NumMarkers" };
        Err(RecordingFileError::new(value_at(field), kind))
    };
    if names.len() as u64 != declared_markers {
        return mismatch("markers", declared_markers, names.len());
    }
    without_subject(&mut names);
    let n = names.len();
    // A file without the row of column names has the first frame there.
    let is_axis = |entry: &String| entry.starts_with(['X', 'Y', 'Z', 'x', 'y', 'z']);
    let mut first = (!columns.entries.iter().any(is_axis)).then_some(columns);

    let (mut times_s, mut positions, mut lines) = (Vec::new(), Vec::new(), Vec::new());
    let mut cells = Cells::new(file, n);
    loop {
        let record = match first.take() {
            Some(record) => record,
            None => match next("") {
                Ok(record) => record,
                Err(e) if matches!(e.kind, RecordingFileErrorKind::Truncated { .. }) => break,
                Err(e) => return Err(e),
            },
        };
        let entries = cell::row(file, &record, 2 + 3 * n)?;
        let frame = times_s.len();
        times_s.push(cells.time(&entries[1], record.line, "Time")?);
        for (m, name) in names.iter().enumerate() {
            let entries = [0, 1, 2].map(|k| entries.get(2 + 3 * m + k).map_or("", String::as_str));
            positions.push(cells.position(entries, record.line, frame, m, name)?);
        }
        lines.push(record.line);
    }
    if times_s.len() as u64 != declared_frames {
        return mismatch("frames", declared_frames, times_s.len());
    }
    warnings.extend(cells.warnings(&names));
    Ok(Draft {
        format: RecordingFormat::Trc,
        unit,
        names,
        times_s,
        positions,
        frame_names: Vec::new(),
        depth_weight: 1.,
        warnings,
        names_at: Location::file(file).at_line(heads.line),
        lines,
        marker_lines: Vec::new(),
    })
}
