//! Where in a file something is wrong.

use std::fmt;
use std::path::PathBuf;

/// A place in an input file, printed as `face.msh:12: field nodes` or `face.vtu: byte 120`.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub struct Location {
    /// The file.
    pub file: PathBuf,
    /// Line, from 1.
    pub line: Option<usize>,
    /// Byte offset, from 0, for binary files.
    pub byte: Option<usize>,
    /// Field, column, key or section.
    pub field: Option<String>,
}

impl Location {
    /// The file as a whole.
    pub fn file(file: impl Into<PathBuf>) -> Self {
        Self { file: file.into(), ..Self::default() }
    }

    /// The same file at line `line` (from 1).
    #[must_use]
    pub fn at_line(mut self, line: usize) -> Self {
        self.line = Some(line);
        self
    }

    /// The same file at byte `byte` (from 0).
    #[must_use]
    pub fn at_byte(mut self, byte: usize) -> Self {
        self.byte = Some(byte);
        self
    }

    /// The same place, in field `field`.
    #[must_use]
    pub fn in_field(mut self, field: impl Into<String>) -> Self {
        self.field = Some(field.into());
        self
    }
}

impl Location {
    /// `place: told`; the field stands once, where `told` names it itself.
    pub(super) fn before(&self, told: &impl fmt::Display) -> String {
        let told = told.to_string();
        let is_named = self.field.as_ref().is_some_and(|field| {
            let key = field.rsplit('.').next().unwrap_or(field);
            told.starts_with(field)
                || (key.contains('_') && told.contains(key))
                || told.contains(&format!("`{key}`"))
        });
        let place = if is_named { Self { field: None, ..self.clone() } } else { self.clone() };
        format!("{place}: {told}")
    }
}

impl fmt::Display for Location {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "{}", self.file.display())?;
        if let Some(line) = self.line {
            write!(f, ":{line}")?;
        }
        if let Some(byte) = self.byte {
            write!(f, ": byte {byte}")?;
        }
        match &self.field {
            Some(field) => write!(f, ": {field}"),
            None => Ok(()),
        }
    }
}

#[cfg(test)]
mod tests {
    use super::Location;

    #[test]
    fn a_field_is_named_once() {
        let at = |field: &str| Location::file("f.toml").at_line(3).in_field(field);
        for (field, told, expected) in [
            ("tissue.young_kpa", "tissue.young_kpa is 0 kPa", "f.toml:3: tissue.young_kpa is 0 kPa"),
            ("muscles[0].radius_mm", "muscle a: radius_mm is 0", "f.toml:3: muscle a: radius_mm is 0"),
            ("unit", "the field `unit` is missing", "f.toml:3: the field `unit` is missing"),
            ("skin", "there is no node set `skim`", "f.toml:3: skin: there is no node set `skim`"),
        ] {
            assert_eq!(at(field).before(&told), expected);
        }
    }
}
