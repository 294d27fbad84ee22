//! The entries of tables of markers.

use std::path::Path;

use super::error::{RecordingFileError, RecordingFileErrorKind};
use super::warning::RecordingFileWarning;
use crate::io::Location;
use crate::io::csv::{self, Record};
use crate::io::text::shown;
use crate::units::Vec3;

type Result<T> = std::result::Result<T, RecordingFileError>;

/// The entries of `record`, of which there are `expected` and blank ones after them.
pub(super) fn row<'a>(file: &Path, record: &'a Record, expected: usize) -> Result<&'a [String]> {
    let found = record.entries.iter().rposition(|entry| !entry.is_empty()).map_or(0, |last| last + 1);
    if found > expected || record.entries.len() < expected {
        let found = if found > expected { found } else { record.entries.len() };
        let kind = RecordingFileErrorKind::RowLength { found, expected };
        return Err(RecordingFileError::new(Location::file(file).at_line(record.line), kind));
    }
    Ok(&record.entries[..expected])
}

/// The number that `entry` is; `None` where it is blank or says that it is none.
pub(super) fn number(entry: &str, at: impl FnOnce() -> Location) -> Result<Option<f64>> {
    if entry.is_empty()
        || ["nan", "na", "n/a", "null", "none", "-"].iter().any(|no| entry.eq_ignore_ascii_case(no))
    {
        return Ok(None);
    }
    match csv::number(entry) {
        Some(x) if x.is_nan() => Ok(None),
        Some(x) if x.is_finite() => Ok(Some(x)),
        _ => {
            let kind = RecordingFileErrorKind::NotANumber { value: shown(entry) };
            Err(RecordingFileError::new(at(), kind))
        }
    }
}

/// Positions in the rows of a table, with those counted of which only a part is there.
pub(super) struct Cells<'a> {
    file: &'a Path,
    /// First frame and number of frames, by marker.
    partial: Vec<(usize, usize)>,
}

impl<'a> Cells<'a> {
    pub(super) fn new(file: &'a Path, markers: usize) -> Self {
        Self { file, partial: vec![(0, 0); markers] }
    }

    /// The time that `entry` is, in the unit of its column.
    pub(super) fn time(&self, entry: &str, line: usize, column: &str) -> Result<f64> {
        let at = || Location::file(self.file).at_line(line).in_field(shown(column));
        number(entry, at)?.ok_or_else(|| {
            let kind = RecordingFileErrorKind::NotANumber { value: shown(entry) };
            RecordingFileError::new(at(), kind)
        })
    }

    /// The position of marker `m`, called `name`, that `entries` are.
    pub(super) fn position(
        &mut self,
        entries: [&str; 3],
        line: usize,
        frame: usize,
        m: usize,
        name: &str,
    ) -> Result<Option<Vec3>> {
        let mut p = [None; 3];
        for (k, (x, entry)) in p.iter_mut().zip(entries).enumerate() {
            *x = number(entry, || {
                Location::file(self.file).at_line(line).in_field(format!(
                    "{} {}",
                    shown(name),
                    ["x", "y", "z"][k]
                ))
            })?;
        }
        if let [Some(x), Some(y), Some(z)] = p {
            return Ok(Some(Vec3::new(x, y, z)));
        }
        if p.iter().any(Option::is_some) {
            if self.partial.len() <= m {
                self.partial.resize(m + 1, (0, 0));
            }
            let (first, frames) = &mut self.partial[m];
            if *frames == 0 {
                *first = frame;
            }
            *frames += 1;
        }
        Ok(None)
    }

    /// What was taken as not seen because a part of it was missing.
    pub(super) fn warnings(&self, names: &[String]) -> Vec<RecordingFileWarning> {
        let some = self.partial.iter().zip(names).filter(|((_, frames), _)| *frames > 0);
        some.map(|(&(first, frames), marker)| RecordingFileWarning::Partial {
            marker: marker.clone(),
            first,
            frames,
        })
        .collect()
    }
}
