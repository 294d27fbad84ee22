//! Tables whose columns are named over several rows: exports of Motive and Nexus, and TRC without its first lines.
//!
//! Motive (OptiTrack, "Data Export: CSV"): a line of fields, then rows of types, names, numbers and quantities over a row of
//! axes. Nexus (Vicon, "ASCII"): a title, the rate, names over the first of three columns, axes, units.

use std::path::Path;

use super::column::Column;
use super::error::{RecordingFileError, RecordingFileErrorKind};
use super::format::RecordingFormat;
use super::subject::without_subject;
use super::table;
use super::wide::WideColumns;
use crate::io::Location;
use crate::io::csv::{self, Record};

type Result<T> = std::result::Result<T, RecordingFileError>;

/// Rows in which the axes must show, below a title or the first row.
const HEAD: usize = 12;
/// The section of an export of Nexus that has markers.
const MARKERS: &str = "Trajectories";

/// What stands over a table.
pub(super) struct Headed {
    pub(super) columns: WideColumns,
    /// The unit's word, and its line.
    pub(super) unit: Option<(String, usize)>,
    pub(super) rate_hz: Option<f64>,
    /// The first row of the table, where it had to be read.
    pub(super) first: Option<Record>,
}

/// What the rows over a table say, of which `first` is the first.
pub(super) fn of(file: &Path, first: Record, rows: &mut csv::Rows) -> Result<Headed> {
    let mut above = vec![first];
    let unrecognised = || {
        let kind = RecordingFileErrorKind::Unrecognised {
            formats: RecordingFormat::READ,
            why: "its first rows name no columns of markers, such as LAB_x_mm, or marker and x_mm",
        };
        RecordingFileError::new(Location::file(file), kind)
    };
    // Other sections of an export may come first.
    let is =
        |record: &Record, title: &str| record.entries.first().is_some_and(|e| e.eq_ignore_ascii_case(title));
    let sections = ["Devices", "Joints", "Segments", "Model Outputs", "Events"];
    if sections.iter().any(|title| is(&above[0], title)) {
        let mut found = None;
        for record in rows.by_ref() {
            let record = record.map_err(|line| table::open_quote(file, line))?;
            if is(&record, MARKERS) {
                found = Some(record);
                break;
            }
        }
        above = vec![found.ok_or_else(unrecognised)?];
    }
    let axes = loop {
        let record = rows.next().filter(|_| above.len() < HEAD).ok_or_else(unrecognised)?;
        let record = record.map_err(|line| table::open_quote(file, line))?;
        if !triples(&record.entries).is_empty() {
            break record;
        }
        above.push(record);
    };
    let next = rows.next().transpose().map_err(|line| table::open_quote(file, line))?;
    let first_x = triples(&axes.entries)[0];
    let is_unit =
        |record: &Record| record.entries.get(first_x).is_some_and(|e| e.starts_with(char::is_alphabetic));
    let (units, first) = match next {
        Some(record) if is_unit(&record) => (Some(record), None),
        other => (None, other),
    };
    let fields = &above[0].entries;
    let unit = match &units {
        Some(record) => Some((record.entries[first_x].clone(), record.line)),
        None => fields
            .iter()
            .position(|field| field.eq_ignore_ascii_case("Length Units"))
            .and_then(|k| Some((fields.get(k + 1)?.clone(), above[0].line))),
    };
    let rate_hz = match &above[..] {
        [title, rate, ..] if is(title, MARKERS) => rate.entries.first().and_then(|rate| csv::number(rate)),
        _ => None,
    };
    Ok(Headed { columns: columns(file, &above, &axes)?, unit, rate_hz, first })
}

/// Where X, Y and Z stand side by side in a row of such names alone.
fn triples(entries: &[String]) -> Vec<usize> {
    let axis = |entry: &str, axis: char| {
        let mut chars = entry.chars();
        chars.next().is_some_and(|c| c.eq_ignore_ascii_case(&axis)) && chars.all(|c| c.is_ascii_digit())
    };
    (0..entries.len().saturating_sub(2))
        .filter(|&k| ['x', 'y', 'z'].iter().enumerate().all(|(i, a)| axis(&entries[k + i], *a)))
        .collect()
}

/// The columns below the row `axes`, as the rows `above` it name them.
fn columns(file: &Path, above: &[Record], axes: &Record) -> Result<WideColumns> {
    let entry = |record: &Record, k: usize| record.entries.get(k).cloned().unwrap_or_default();
    let all = triples(&axes.entries);
    let titled = |title: &str| {
        above.iter().position(|r| r.entries.iter().take(2).any(|e| e.eq_ignore_ascii_case(title)))
    };
    let holds = |words: &[&str]| {
        above
            .iter()
            .position(|r| all.iter().any(|&k| words.iter().any(|w| entry(r, k).eq_ignore_ascii_case(w))))
    };
    let types = titled("Type").or(holds(&["Marker", "Rigid Body", "Rigid Body Marker"]));
    let quantities = holds(&["Position", "Rotation"]);
    // Below the types in Motive, else next to the axes.
    let names = titled("Name").or(types.map(|t| t + 1)).unwrap_or(above.len() - 1);
    let Some(names) = above.get(names) else {
        let kind = RecordingFileErrorKind::MissingColumn { name: "Name".to_owned(), nearest: None };
        return Err(RecordingFileError::new(Location::file(file).at_line(axes.line), kind));
    };
    let kind = |k: usize| types.map_or(String::new(), |t| entry(&above[t], k).to_lowercase());
    let is_position =
        |k: usize| quantities.is_none_or(|q| entry(&above[q], k).eq_ignore_ascii_case("Position"));
    // Markers as they were seen go before where a rigid body expects them.
    let seen = all.iter().any(|&k| kind(k) == "marker");
    let is_marker =
        |k: usize| types.is_none() || kind(k) == "marker" || (!seen && kind(k).ends_with("marker"));
    let taken: Vec<usize> = all.into_iter().filter(|&k| is_marker(k) && is_position(k)).collect();
    let mut found: Vec<String> = taken.iter().map(|&k| entry(names, k)).collect();
    without_subject(&mut found);
    let width = axes.entries.iter().rposition(|e| !e.is_empty()).map_or(0, |k| k + 1);
    // Frame and time are named beside the axes or, as in TRC, beside the markers.
    let heads: Vec<String> = (0..width)
        .map(|k| Some(entry(axes, k)).filter(|e| !e.is_empty()).unwrap_or_else(|| entry(names, k)))
        .collect();
    let first = taken.first().copied().unwrap_or(0);
    let parsed: Vec<Column> = heads[..first].iter().map(|head| Column::parse(head)).collect();
    let time = parsed.iter().enumerate().find_map(|(k, c)| match c {
        Column::Time { seconds, stated } => Some((k, *seconds, *stated)),
        _ => None,
    });
    Ok(WideColumns {
        line: names.line,
        names: found,
        axes: taken.iter().map(|&k| [k, k + 1, k + 2]).collect(),
        time,
        frame: parsed.iter().position(|c| *c == Column::Frame),
        pose: None,
        unit: None,
        displacement: false,
        others: Vec::new(),
        heads,
    })
}
