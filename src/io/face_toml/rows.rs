//! Comma-separated tables with a header.

use std::path::{Path, PathBuf};

use super::error::{FaceFileError, FaceFileErrorKind};
use super::frame::Frame;
use crate::io::Location;
use crate::io::nearest::nearest;
use crate::units::Vec3;

/// A comma-separated table: a header line, then rows of as many entries.
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
        let split = |line: &str| -> Vec<String> { line.split(',').map(|e| e.trim().to_owned()).collect() };
        let mut lines = text.lines().enumerate().filter(|(_, line)| !line.trim().is_empty());
        let Some((_, header)) = lines.next() else {
            let kind = FaceFileErrorKind::Syntax { reason: "the table is empty".to_owned() };
            return Err(FaceFileError::new(Location::file(file), kind));
        };
        let columns = split(header);
        let mut rows = Vec::new();
        for (k, line) in lines {
            let entries = split(line);
            if entries.len() != columns.len() {
                let kind = FaceFileErrorKind::RowLength { found: entries.len(), expected: columns.len() };
                return Err(FaceFileError::new(Location::file(file).at_line(k + 1), kind));
            }
            rows.push((k + 1, entries));
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
            let kind = FaceFileErrorKind::UnknownName {
                what: "column",
                name: name.to_owned(),
                nearest: nearest(name, self.columns.iter().map(String::as_str)).map(str::to_owned),
                known: self.columns.clone(),
            };
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
            *x = value.parse().ok().filter(|x: &f64| x.is_finite()).ok_or_else(|| {
                let value = value.to_owned();
                let accepted = "a finite number with a decimal point".to_owned();
                FaceFileError::new(self.at(column), FaceFileErrorKind::Value { value, accepted })
            })?;
        }
        Ok(if in_mm { frame.point_in_mm(p) } else { frame.point(p) })
    }
}
