//! Tables with a header.

use std::path::{Path, PathBuf};

use super::error::{FaceFileError, FaceFileErrorKind};
use super::frame::Frame;
use crate::io::Location;
use crate::io::csv::{self, Record};
use crate::io::nearest::nearest;
use crate::io::text::shown;
use crate::units::Vec3;

/// A table: a header, then rows of as many entries.
pub(super) struct Rows {
    file: PathBuf,
    columns: Vec<String>,
    rows: Vec<(usize, Vec<String>)>,
}

/// A row of a [`Rows`].
pub(super) struct Row<'a> {
    table: &'a Rows,
    line: usize,
    entries: &'a [String],
}

impl Rows {
    /// The table in the `text` of `file`.
    pub(super) fn parse(file: &Path, text: &str) -> Result<Self, FaceFileError> {
        let syntax = |at: Location, reason: &str| {
            Err(FaceFileError::new(at, FaceFileErrorKind::Syntax { reason: reason.to_owned() }))
        };
        let mut records = match csv::records(text) {
            Ok(records) => records.into_iter(),
            Err(line) => {
                return syntax(Location::file(file).at_line(line), "a quote that begins here is not closed");
            }
        };
        let Some(header) = records.next() else {
            return syntax(Location::file(file), "the table is empty");
        };
        let columns = header.entries;
        let mut rows = Vec::new();
        for Record { line, entries } in records {
            if entries.len() != columns.len() {
                let kind = FaceFileErrorKind::RowLength { found: entries.len(), expected: columns.len() };
                return Err(FaceFileError::new(Location::file(file).at_line(line), kind));
            }
            rows.push((line, entries));
        }
        Ok(Self { file: file.to_owned(), columns, rows })
    }

    /// The table as a whole.
    pub(super) fn location(&self) -> Location {
        Location::file(&self.file)
    }

    pub(super) fn rows(&self) -> impl Iterator<Item = Row<'_>> {
        self.rows.iter().map(|(line, entries)| Row { table: self, line: *line, entries })
    }

    /// Whether there is a column `name`.
    pub(super) fn has(&self, name: &str) -> bool {
        self.columns.iter().any(|c| c == name)
    }

    fn column(&self, name: &str) -> Result<usize, FaceFileError> {
        self.columns.iter().position(|c| c == name).ok_or_else(|| {
            let nearest = nearest(name, self.columns.iter().map(String::as_str)).map(shown);
            let kind = FaceFileErrorKind::MissingColumn { name: name.to_owned(), nearest };
            FaceFileError::new(Location::file(&self.file).at_line(1), kind)
        })
    }
}

impl Row<'_> {
    pub(super) fn at(&self, column: &str) -> Location {
        Location::file(&self.table.file).at_line(self.line).in_field(column)
    }

    pub(super) fn text(&self, column: &str) -> Result<&str, FaceFileError> {
        Ok(&self.entries[self.table.column(column)?])
    }

    /// The point in columns `x_mm`, `y_mm`, `z_mm`, or `x`, `y`, `z` in the files' unit.
    pub(super) fn point(&self, frame: &Frame) -> Result<Vec3, FaceFileError> {
        let in_mm = self.table.columns.iter().any(|c| c == "x_mm");
        let columns = if in_mm { ["x_mm", "y_mm", "z_mm"] } else { ["x", "y", "z"] };
        let mut p = Vec3::zeros();
        for (x, column) in p.iter_mut().zip(columns) {
            let value = self.text(column)?;
            *x = csv::number(value).filter(|x| x.is_finite()).ok_or_else(|| {
                let value = shown(value);
                let accepted = "a finite number with a decimal point".to_owned();
                FaceFileError::new(self.at(column), FaceFileErrorKind::Value { value, accepted })
            })?;
        }
        Ok(if in_mm { frame.point_in_mm(p) } else { frame.point(p) })
    }
}
