//! Tables with a row a frame: `time_s,LAB_x_mm,LAB_y_mm,LAB_z_mm,...`.

use std::collections::HashMap;
use std::path::Path;

use super::cell::{self, Cells};
use super::column::{Column, Coordinate};
use super::draft::Draft;
use super::error::{RecordingFileError, RecordingFileErrorKind};
use super::format::RecordingFormat;
use super::options::ReadOptions;
use super::subject::without_subject;
use super::table::{self, Times};
use crate::io::Location;
use crate::io::csv::Record;
use crate::io::text::shown;
use crate::units::LengthUnit;

type Result<T> = std::result::Result<T, RecordingFileError>;

/// What the columns of a wide table are.
pub(super) struct WideColumns {
    /// The row that names them.
    pub(super) line: usize,
    pub(super) heads: Vec<String>,
    pub(super) names: Vec<String>,
    /// Where the coordinates of each marker stand.
    pub(super) axes: Vec<[usize; 3]>,
    pub(super) time: Option<(usize, f64, bool)>,
    pub(super) frame: Option<usize>,
    pub(super) pose: Option<usize>,
    pub(super) unit: Option<LengthUnit>,
    pub(super) displacement: bool,
    /// Columns that hold no position.
    pub(super) others: Vec<usize>,
}

impl WideColumns {
    /// The columns of `heads`, if those name markers and axes.
    pub(super) fn of(file: &Path, heads: &Record) -> Result<Option<Self>> {
        let columns: Vec<Column> = heads.entries.iter().map(|head| Column::parse(head)).collect();
        let named = |c: &&Coordinate| !c.marker.is_empty();
        let coordinates = || {
            columns
                .iter()
                .filter_map(|c| if let Column::Coordinate(c) = c { Some(c) } else { None })
                .filter(named)
        };
        if coordinates().next().is_none() {
            return Ok(None);
        }
        let refused = |kind| Err(RecordingFileError::new(Location::file(file).at_line(heads.line), kind));
        let unit = table::one_unit(file, heads, coordinates())?;
        let displacement = table::one_origin(file, heads, coordinates())?;
        let (mut names, mut places): (Vec<String>, Vec<[Option<usize>; 3]>) = Default::default();
        let mut marker_of: HashMap<&str, usize> = HashMap::new();
        let mut others = Vec::new();
        for (k, column) in columns.iter().enumerate() {
            match column {
                Column::Coordinate(c) if !c.marker.is_empty() => {
                    let m = *marker_of.entry(&c.marker).or_insert_with(|| {
                        names.push(c.marker.clone());
                        places.push([None; 3]);
                        names.len() - 1
                    });
                    if places[m][c.axis].replace(k).is_some() {
                        let name = shown(&heads.entries[k]);
                        return refused(RecordingFileErrorKind::DuplicateColumn { name });
                    }
                }
                Column::Time { .. } | Column::Frame | Column::Pose | Column::Label => {}
                _ => others.push(k),
            }
        }
        let mut axes = Vec::with_capacity(places.len());
        for (name, place) in names.iter().zip(places) {
            match place {
                [Some(x), Some(y), Some(z)] => axes.push([x, y, z]),
                _ => {
                    let missing = place.iter().position(Option::is_none).unwrap_or(0);
                    let name = format!("{} {}", shown(name), ["x", "y", "z"][missing]);
                    return refused(RecordingFileErrorKind::MissingColumn { name, nearest: None });
                }
            }
        }
        let find = |wanted: &Column| columns.iter().position(|c| c == wanted);
        let time = columns.iter().enumerate().find_map(|(k, c)| match c {
            Column::Time { seconds, stated } => Some((k, *seconds, *stated)),
            _ => None,
        });
        without_subject(&mut names);
        Ok(Some(Self {
            line: heads.line,
            heads: heads.entries.clone(),
            names,
            axes,
            time,
            frame: find(&Column::Frame),
            pose: find(&Column::Pose).or(find(&Column::Label)),
            unit,
            displacement,
            others,
        }))
    }
}

/// The recording in `rows`, whose columns are `columns`, as if in mm; `rate_hz` is what the file states beside the table.
/// The table ends where a row begins with a word: an export may hold others below.
pub(super) fn parse(
    file: &Path,
    columns: WideColumns,
    rate_hz: Option<f64>,
    rows: impl Iterator<Item = std::result::Result<Record, usize>>,
    options: &ReadOptions,
) -> Result<Draft> {
    let n = columns.names.len();
    let (mut values, mut poses, mut positions, mut lines) = (Vec::new(), Vec::new(), Vec::new(), Vec::new());
    let mut cells = Cells::new(file, n);
    for record in rows {
        let record = record.map_err(|line| table::open_quote(file, line))?;
        // Of a table that only counts its rows, one of blanks is a frame in which nothing was seen.
        let counts = columns.time.is_none() && columns.frame.is_none() && columns.pose.is_none();
        if !counts && record.entries.iter().all(String::is_empty) {
            continue;
        }
        let is_title = |entry: &String| entry.starts_with(|c: char| c.is_alphabetic());
        if rate_hz.is_some() && record.entries.first().is_some_and(is_title) {
            break;
        }
        let (line, frame) = (record.line, lines.len());
        let entries = cell::row(file, &record, columns.heads.len())?;
        if let Some(k) = columns.pose {
            poses.push(entries[k].clone());
        }
        if let Some(k) = columns.time.map(|(k, ..)| k).or(columns.frame) {
            values.push(cells.time(&entries[k], line, &columns.heads[k])?);
        }
        for (m, (axes, name)) in columns.axes.iter().zip(&columns.names).enumerate() {
            positions.push(cells.position(axes.map(|k| entries[k].as_str()), line, frame, m, name)?);
        }
        lines.push(line);
    }
    let mut warnings = cells.warnings(&columns.names);
    let times = match (columns.pose, columns.time, columns.frame) {
        (Some(_), ..) => Times::Index(lines.len()),
        (_, Some((k, seconds, stated)), _) => {
            let column = (!stated).then(|| columns.heads[k].clone());
            Times::Time { values, seconds, column }
        }
        (_, _, Some(_)) => Times::Frames { values, rate_hz },
        _ => Times::Unsaid(lines.len()),
    };
    let times_s = times.in_seconds(file, options, &mut warnings)?;
    table::left_out(&columns.heads, &columns.others, &mut warnings);
    Ok(Draft {
        format: RecordingFormat::WideTable,
        unit: LengthUnit::Millimetre,
        names: columns.names,
        times_s,
        positions,
        frame_names: poses,
        depth_weight: 1.,
        warnings,
        names_at: Location::file(file).at_line(columns.line),
        lines,
        marker_lines: Vec::new(),
    })
}
