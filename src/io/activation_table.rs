//! Activations over time as a table.

use std::path::Path;

use thiserror::Error;

use super::{Location, UnreadableText, csv, input_file, nearest};

/// The column of the times.
const TIME: &str = "time_s";

/// Activations of some muscles at some times.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct ActivationTable {
    /// Names of the muscles, one a column.
    pub muscles: Vec<String>,
    /// Times (t), s, ascending.
    pub times_s: Vec<f64>,
    /// Activations, 0 to 1: a row for each of the times, in the order of the muscles.
    pub rows: Vec<Vec<f64>>,
}

/// Why a table of activations was refused.
#[derive(Debug, Error)]
#[non_exhaustive]
pub enum ActivationTableError {
    /// It cannot be opened or is not text.
    #[error("{at}: {reason}")]
    Unreadable {
        /// The file.
        at: Box<Location>,
        /// Why not.
        reason: UnreadableText,
    },
    /// A quote that is never closed.
    #[error("{at}: the quote is never closed")]
    Quote {
        /// The line.
        at: Box<Location>,
    },
    /// No column of times, or no row.
    #[error(
        "{at}: {found}; the first row is time_s and names of muscles, and each further one a time with activations from 0 to 1"
    )]
    Form {
        /// The line.
        at: Box<Location>,
        /// What is there.
        found: String,
    },
    /// A column that is no muscle's.
    #[error("{at}: no muscle is called {name}{}", meant.as_ref().map_or_else(String::new, |m| format!("; did you mean {m}?")))]
    UnknownMuscle {
        /// The line.
        at: Box<Location>,
        /// The name.
        name: String,
        /// The muscle whose name is nearest.
        meant: Option<String>,
    },
}

/// The table in the CSV file `path`: a first row with `time_s` and names among the `muscles` of a face, then one row a time.
///
/// # Errors
/// [`ActivationTableError`] with file and line.
pub fn read_activations(path: &Path, muscles: &[String]) -> Result<ActivationTable, ActivationTableError> {
    let at = || Box::new(Location::file(path));
    let text = input_file::read_text(path)
        .map_err(|reason| ActivationTableError::Unreadable { at: at(), reason })?;
    parse_activations(path, &text, muscles)
}

/// The table that `text`, the content of `path`, holds.
///
/// # Errors
/// Those of [`read_activations`].
pub fn parse_activations(
    path: &Path,
    text: &str,
    muscles: &[String],
) -> Result<ActivationTable, ActivationTableError> {
    let line = |line: usize| Box::new(Location::file(path).at_line(line));
    let form = |at: usize, found: String| ActivationTableError::Form { at: line(at), found };
    let records = csv::records(text.trim_start_matches('\u{feff}'))
        .map_err(|at| ActivationTableError::Quote { at: line(at) })?;
    let Some((head, body)) = records.split_first() else { return Err(form(1, "it is empty".to_owned())) };
    let time = head.entries.iter().position(|name| name == TIME);
    let time = time.ok_or_else(|| form(head.line, format!("no column is called {TIME}")))?;
    let columns: Vec<(usize, &String)> =
        head.entries.iter().enumerate().filter(|(k, _)| *k != time).collect();
    for (k, (_, name)) in columns.iter().enumerate() {
        if !muscles.contains(name) {
            let meant = nearest(name, muscles.iter().map(String::as_str)).map(str::to_owned);
            return Err(ActivationTableError::UnknownMuscle {
                at: line(head.line),
                name: (*name).clone(),
                meant,
            });
        }
        if columns[..k].iter().any(|(_, other)| other == name) {
            return Err(form(head.line, format!("two columns are called {name}")));
        }
    }
    let mut table = ActivationTable {
        muscles: columns.iter().map(|(_, name)| (*name).clone()).collect(),
        ..Default::default()
    };
    for record in body {
        if record.entries.len() != head.entries.len() {
            let found = format!("{} entries under {} columns", record.entries.len(), head.entries.len());
            return Err(form(record.line, found));
        }
        let number = |k: usize| csv::number(&record.entries[k]).filter(|x| x.is_finite());
        let seen = |k: usize| format!("{} in column {}", csv::entry(&record.entries[k]), head.entries[k]);
        let now = number(time).filter(|now| table.times_s.last().is_none_or(|last| last < now));
        let Some(now) = now else {
            return Err(form(
                record.line,
                format!("{}, which is no time later than that before", seen(time)),
            ));
        };
        let mut row = Vec::with_capacity(columns.len());
        for &(k, _) in &columns {
            match number(k).filter(|a| (0. ..=1.).contains(a)) {
                Some(a) => row.push(a),
                None => return Err(form(record.line, seen(k))),
            }
        }
        table.times_s.push(now);
        table.rows.push(row);
    }
    if table.rows.is_empty() {
        return Err(form(head.line, "no row follows".to_owned()));
    }
    Ok(table)
}

impl ActivationTable {
    /// The row `k` for all the `muscles` of a face: those without a column are at rest.
    pub fn of(&self, k: usize, muscles: &[String]) -> Vec<f64> {
        let column = |name: &String| self.muscles.iter().position(|m| m == name);
        muscles.iter().map(|name| column(name).map_or(0., |c| self.rows[k][c])).collect()
    }

    /// The table as CSV.
    pub fn to_csv(&self) -> String {
        let mut text =
            format!("{TIME},{}\n", self.muscles.iter().map(|m| csv::entry(m)).collect::<Vec<_>>().join(","));
        for (time, row) in self.times_s.iter().zip(&self.rows) {
            let row: Vec<String> = row.iter().map(f64::to_string).collect();
            text += &format!("{time},{}\n", row.join(","));
        }
        text
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn muscles() -> Vec<String> {
        ["zygomaticus_major_l", "mentalis_r", "platysma"].map(str::to_owned).to_vec()
    }

    #[test]
    fn a_table_comes_back() {
        let table = ActivationTable {
            muscles: muscles()[1..].to_vec(),
            times_s: vec![0., 0.04, 1.],
            rows: vec![vec![0., 1.], vec![0.25, 0.1], vec![1. / 3., 0.]],
        };
        let read = parse_activations("t.csv".as_ref(), &table.to_csv(), &muscles()).expect("a table");
        assert_eq!(read, table);
        assert_eq!(read.of(1, &muscles()), [0., 0.25, 0.1]);
    }

    #[test]
    fn what_is_wrong_is_told_with_its_line() {
        let told = |text: &str| match parse_activations("t.csv".as_ref(), text, &muscles()) {
            Ok(_) => String::new(),
            Err(error) => error.to_string(),
        };
        assert!(told("").contains("it is empty"));
        assert!(told("time_s,platysma\n").contains("no row follows"));
        assert!(told("mentalis_r\n1\n").contains("no column is called time_s"));
        assert!(told("time_s,mentalis_x\n0,1\n").contains("did you mean mentalis_r?"));
        assert!(told("time_s,platysma,platysma\n0,1,1\n").contains("two columns"));
        assert!(
            told("time_s,platysma\n0,0.5\n0,0.5\n").contains("t.csv:3"),
            "{}",
            told("time_s,platysma\n0,0.5\n0,0.5\n")
        );
        assert!(told("time_s,platysma\n0,1.5\n").contains("1.5 in column platysma"));
        assert!(told("time_s,platysma\n0,nan\n").contains("column platysma"));
        assert!(told("time_s,platysma\n0\n").contains("1 entries under 2 columns"));
        assert!(told("time_s,platysma\n0,\"1\n").contains("never closed"));
    }
}
