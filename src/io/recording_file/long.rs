//! Tables with a row a marker: `time_s,marker,x_mm,y_mm,z_mm`, or of expressions instead of times.

use std::collections::HashMap;
use std::path::Path;

use super::cell::{self, Cells};
use super::column::{Column, Coordinate};
use super::draft::Draft;
use super::error::{RecordingFileError, RecordingFileErrorKind};
use super::format::RecordingFormat;
use super::options::ReadOptions;
use super::table::{self, Times};
use crate::io::Location;
use crate::io::csv::{self, Record};
use crate::io::text::shown;
use crate::units::{LengthUnit, Vec3};

type Result<T> = std::result::Result<T, RecordingFileError>;

/// Cells that a table may have without many of them being filled.
const FREE_CELLS: usize = 1 << 16;
/// One in so many cells must be filled beyond that.
const SPARSEST: usize = 64;

/// What the columns of a long table are.
pub(super) struct LongColumns {
    marker: usize,
    axes: [usize; 3],
    /// What tells the frames apart: a time, a number or a name.
    frame: Option<(usize, Column)>,
    pub(super) unit: Option<LengthUnit>,
    pub(super) displacement: bool,
    others: Vec<usize>,
}

impl LongColumns {
    /// The columns of `heads`, if those are of a long table: a marker's name and its coordinates.
    pub(super) fn of(file: &Path, heads: &Record) -> Result<Option<Self>> {
        let columns: Vec<Column> = heads.entries.iter().map(|head| Column::parse(head)).collect();
        let find = |wanted: &Column| columns.iter().position(|c| c == wanted);
        let label = find(&Column::Label);
        let Some(marker) = find(&Column::Marker).or(label) else { return Ok(None) };
        let bare = |k: usize, axis: usize| match &columns[k] {
            Column::Coordinate(c) => c.marker.is_empty() && c.axis == axis,
            _ => false,
        };
        if !(0..columns.len()).any(|k| (0..3).any(|axis| bare(k, axis))) {
            return Ok(None);
        }
        let mut axes = [0; 3];
        for (axis, at) in axes.iter_mut().enumerate() {
            let mut all = (0..columns.len()).filter(|&k| bare(k, axis));
            let at_heads = || Location::file(file).at_line(heads.line);
            let name = ["x", "y", "z"][axis].to_owned();
            let Some(first) = all.next() else {
                let kind = RecordingFileErrorKind::MissingColumn { name, nearest: None };
                return Err(RecordingFileError::new(at_heads(), kind));
            };
            if all.next().is_some() {
                let kind = RecordingFileErrorKind::DuplicateColumn { name };
                return Err(RecordingFileError::new(at_heads(), kind));
            }
            *at = first;
        }
        let coordinates = axes.map(|k| match &columns[k] {
            Column::Coordinate(c) => c.clone(),
            _ => Coordinate { marker: String::new(), axis: 0, displacement: false, unit: None },
        });
        let unit = table::one_unit(file, heads, coordinates.iter())?;
        let displacement = table::one_origin(file, heads, coordinates.iter())?;
        let pose = find(&Column::Pose).or(label.filter(|&l| l != marker));
        let time = columns.iter().position(|c| matches!(c, Column::Time { .. }));
        let frame = match (pose, time, find(&Column::Frame)) {
            (Some(k), ..) => Some((k, Column::Pose)),
            (_, Some(k), _) | (_, _, Some(k)) => Some((k, columns[k].clone())),
            _ => None,
        };
        let used = |k: usize| {
            k == marker
                || axes.contains(&k)
                || frame.as_ref().is_some_and(|(f, _)| *f == k)
                || matches!(columns[k], Column::Frame | Column::Time { .. })
        };
        let others = (0..columns.len()).filter(|&k| !used(k)).collect();
        Ok(Some(Self { marker, axes, frame, unit, displacement, others }))
    }
}

#[derive(PartialEq, Eq, Hash)]
enum Key {
    Number(u64),
    Name(String),
}

/// The recording in the `rows` below `heads`, whose columns are `columns`, as if in mm.
pub(super) fn parse(
    file: &Path,
    heads: &Record,
    columns: &LongColumns,
    rows: csv::Rows,
    options: &ReadOptions,
) -> Result<Draft> {
    let (mut names, mut marker_of): (Vec<String>, HashMap<String, usize>) = Default::default();
    let (mut frame_of, mut numbers, mut poses, mut lines): (
        HashMap<Key, usize>,
        Vec<f64>,
        Vec<String>,
        Vec<usize>,
    ) = Default::default();
    // Frame, marker, position and line of each row; of each marker the last number of a frame, and its first line.
    let mut seen: Vec<(usize, usize, Option<Vec3>, usize)> = Vec::new();
    let (mut last, mut marker_lines): (Vec<f64>, Vec<usize>) = Default::default();
    let mut cells = Cells::new(file, 0);
    for record in rows {
        let record = record.map_err(|line| {
            RecordingFileError::new(Location::file(file).at_line(line), RecordingFileErrorKind::OpenQuote)
        })?;
        let line = record.line;
        if record.entries.iter().all(String::is_empty) {
            continue;
        }
        let entries = cell::row(file, &record, heads.entries.len())?;
        let name = &entries[columns.marker];
        let m = *marker_of.entry(name.clone()).or_insert_with(|| {
            names.push(name.clone());
            names.len() - 1
        });
        let mut number = 0.;
        let key = match &columns.frame {
            None => Key::Number(0),
            Some((k, Column::Pose)) => Key::Name(entries[*k].clone()),
            Some((k, _)) => {
                // So that -0 is 0.
                number = cells.time(&entries[*k], line, &heads.entries[*k])? + 0.;
                Key::Number(number.to_bits())
            }
        };
        let frame = *frame_of.entry(key).or_insert_with(|| {
            numbers.push(number);
            if let Some((k, Column::Pose)) = &columns.frame {
                poses.push(entries[*k].clone());
            }
            lines.push(line);
            lines.len() - 1
        });
        if m == last.len() {
            last.push(number);
            marker_lines.push(line);
        } else if number < last[m] {
            let kind = RecordingFileErrorKind::TimeNotIncreasing { time_s: number, before_s: last[m] };
            return Err(RecordingFileError::new(Location::file(file).at_line(line), kind));
        }
        last[m] = number;
        let position = cells.position(columns.axes.map(|k| entries[k].as_str()), line, frame, m, name)?;
        seen.push((frame, m, position, line));
    }
    let (f, n) = (lines.len(), names.len());
    let cells_needed = f.saturating_mul(n);
    if cells_needed > FREE_CELLS.max(SPARSEST.saturating_mul(seen.len())) {
        let kind = RecordingFileErrorKind::Sparse { rows: seen.len(), frames: f, markers: n };
        return Err(RecordingFileError::new(Location::file(file), kind));
    }
    // Rows may be sorted by marker, so that the first rows of frames are in any order.
    let mut order: Vec<usize> = (0..f).collect();
    if poses.is_empty() {
        order.sort_by(|&a, &b| numbers[a].total_cmp(&numbers[b]));
    }
    let mut place = vec![0; f];
    for (to, &from) in order.iter().enumerate() {
        place[from] = to;
    }
    let mut positions = vec![None; cells_needed];
    let mut row_of = vec![0; cells_needed];
    for (frame, m, position, line) in seen {
        let at = place[frame] * n + m;
        if row_of[at] != 0 {
            let (marker, first_line) = (shown(&names[m]), row_of[at]);
            let kind = RecordingFileErrorKind::DuplicateRow { marker, first_line };
            return Err(RecordingFileError::new(Location::file(file).at_line(line), kind));
        }
        (positions[at], row_of[at]) = (position, line);
    }
    let sorted: Vec<f64> = order.iter().map(|&k| numbers[k]).collect();
    let mut warnings = cells.warnings(&names);
    let times = match &columns.frame {
        Some((_, Column::Pose)) | None => Times::Index(f),
        Some((k, Column::Time { seconds, stated })) => Times::Time {
            values: sorted,
            seconds: *seconds,
            column: (!stated).then(|| heads.entries[*k].clone()),
        },
        Some(_) => Times::Frames { values: sorted, rate_hz: None },
    };
    let times_s = times.in_seconds(file, options, &mut warnings)?;
    table::left_out(&heads.entries, &columns.others, &mut warnings);
    Ok(Draft {
        format: RecordingFormat::LongTable,
        unit: LengthUnit::Millimetre,
        names,
        times_s,
        positions,
        frame_names: poses,
        depth_weight: 1.,
        warnings,
        names_at: Location::file(file).in_field(shown(&heads.entries[columns.marker])),
        lines: order.iter().map(|&k| lines[k]).collect(),
        marker_lines,
    })
}
