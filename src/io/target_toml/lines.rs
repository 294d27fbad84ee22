//! The line of every field of a TOML file.

use std::collections::BTreeMap;
use std::path::{Path, PathBuf};

use toml::de::{DeTable, DeValue};

use super::file::SINGULAR;
use crate::io::Location;
use crate::io::lines::Lines;

/// Where each field of a file stands, by its path: `markers[2].landmark`.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub struct FieldLines {
    file: PathBuf,
    lines: BTreeMap<String, usize>,
}

impl FieldLines {
    pub(in crate::io) fn of(file: &Path, text: &str, root: &DeTable<'_>) -> Self {
        let mut lines = Self { file: file.to_owned(), lines: BTreeMap::new() };
        lines.add_table(&Lines::new(text), "", root);
        lines
    }

    /// The place of `field`; of the table that would hold it when the field itself is absent.
    pub fn location(&self, field: &str) -> Location {
        let at = Location::file(&self.file).in_field(field);
        let mut path = field;
        loop {
            if let Some(&line) = self.lines.get(path) {
                return at.at_line(line);
            }
            match path.rfind(['.', '[']) {
                Some(end) => path = &path[..end],
                None => return at,
            }
        }
    }

    /// Gives the fields under `to` the lines of those under `from`.
    pub(super) fn copy(&mut self, source: &Self, from: &str, to: &str) {
        for (path, &line) in source.lines.range(from.to_owned()..) {
            match path.strip_prefix(from) {
                Some(rest) if rest.is_empty() || rest.starts_with(['.', '[']) => {
                    self.lines.insert(format!("{to}{rest}"), line);
                }
                Some(_) => {}
                None => break,
            }
        }
    }

    /// Forgets the fields under the list `list`.
    pub(super) fn forget(&mut self, list: &str) {
        let prefix = format!("{list}[");
        self.lines.retain(|path, _| !path.starts_with(&prefix));
    }

    fn add_table(&mut self, text: &Lines, path: &str, table: &DeTable<'_>) {
        for (key, value) in table {
            let path = join(path, plural(path, key.get_ref()));
            self.lines.insert(path.clone(), text.of(key.span().start));
            self.add_value(text, &path, value.get_ref());
        }
    }

    fn add_value(&mut self, text: &Lines, path: &str, value: &DeValue<'_>) {
        match value {
            DeValue::Table(table) => self.add_table(text, path, table),
            DeValue::Array(items) => {
                for (i, item) in items.iter().enumerate() {
                    let path = format!("{path}[{i}]");
                    self.lines.insert(path.clone(), text.of(item.span().start));
                    self.add_value(text, &path, item.get_ref());
                }
            }
            _ => {}
        }
    }
}

/// The path of `key` in the table at `path`.
pub(super) fn join(path: &str, key: &str) -> String {
    if path.is_empty() { key.to_owned() } else { format!("{path}.{key}") }
}

/// The line (from 1) of byte `offset`.
pub(in crate::io) fn line_of(text: &str, offset: usize) -> usize {
    1 + text.as_bytes().iter().take(offset).filter(|&&b| b == b'\n').count()
}

/// The list's own name when the file uses the singular, `[[marker]]`.
pub(super) fn plural<'a>(path: &str, key: &'a str) -> &'a str {
    match SINGULAR.iter().find(|(singular, _)| path.is_empty() && *singular == key) {
        Some((_, plural)) => plural,
        None => key,
    }
}
