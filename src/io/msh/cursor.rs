//! Numbers one after the other, from text or from bytes.

use std::path::Path;

use super::super::mesh_file_error::{MeshFileError, MeshFileErrorKind};
use super::super::numbered::Place;
use super::super::{Location, text};

type Result<T> = std::result::Result<T, MeshFileError>;

/// A position in an MSH file.
///
/// In text every record is a row of its own: a number that is missing from a row must not be taken from
/// the next.
pub(super) struct Cursor<'a> {
    file: &'a Path,
    bytes: &'a [u8],
    at: usize,
    line: usize,
    /// Big-endian or not, in a binary file.
    pub(super) binary: Option<bool>,
    /// Whether a binary file refers to nodes by `size_t` (version 4) or by `int`.
    pub(super) wide_nodes: bool,
    section: String,
}

impl<'a> Cursor<'a> {
    pub(super) fn new(file: &'a Path, bytes: &'a [u8]) -> Self {
        Self { file, bytes, at: 0, line: 1, binary: None, wide_nodes: false, section: "MeshFormat".into() }
    }

    pub(super) fn place(&self) -> Place {
        if self.binary.is_some() { Place::Byte(self.at) } else { Place::Line(self.line) }
    }

    pub(super) fn location(&self, field: &str) -> Location {
        self.place().of(self.file).in_field(format!("${} {field}", self.section))
    }

    pub(super) fn fail<T>(&self, field: &str, kind: MeshFileErrorKind) -> Result<T> {
        Err(MeshFileError::new(self.location(field), kind))
    }

    fn truncated<T>(&self, field: &str) -> Result<T> {
        self.fail(field, MeshFileErrorKind::Truncated { expected: field.to_owned() })
    }

    fn rest(&self) -> &'a [u8] {
        &self.bytes[self.at..]
    }

    fn advance(&mut self, n: usize) -> &'a [u8] {
        let passed = &self.rest()[..n];
        self.at += n;
        if self.binary.is_none() {
            self.line += passed.iter().filter(|b| **b == b'\n').count();
        }
        passed
    }

    /// The rest of the line, trimmed, or `None` at the end of the file.
    pub(super) fn line(&mut self) -> Option<String> {
        if self.rest().is_empty() {
            return None;
        }
        let end = self.rest().iter().position(|b| *b == b'\n').map_or(self.rest().len(), |k| k + 1);
        Some(String::from_utf8_lossy(self.advance(end)).trim().to_owned())
    }

    /// Goes to the next section and returns its name, or `None` at the end of the file.
    pub(super) fn section(&mut self) -> Result<Option<String>> {
        loop {
            let start = self.place();
            match self.line() {
                None => return Ok(None),
                Some(line) if line.is_empty() => {}
                Some(line) => match line.strip_prefix('$') {
                    Some(name) => {
                        self.section = name.to_owned();
                        return Ok(Some(name.to_owned()));
                    }
                    None => {
                        let found = text::shown(&line);
                        let kind = MeshFileErrorKind::Syntax { expected: "a $ section".into(), found };
                        return Err(MeshFileError::new(start.of(self.file), kind));
                    }
                },
            }
        }
    }

    /// Passes the `$End` line of this section, before which there must be nothing else.
    pub(super) fn end_section(&mut self, what: &str, declared: usize) -> Result<()> {
        let end = format!("$End{}", self.section);
        self.skip_blank();
        let at = self.location("end");
        let word = String::from_utf8_lossy(&self.rest()[..self.rest().len().min(end.len())]).into_owned();
        if word == end {
            self.line();
            return Ok(());
        }
        if self.rest().is_empty() || end.starts_with(&word) {
            return self.truncated(&end);
        }
        let mut found = declared as u64;
        if self.binary.is_some() || word.starts_with('$') {
            let kind = MeshFileErrorKind::Syntax { expected: end, found: word };
            return Err(MeshFileError::new(at, kind));
        }
        while let Some(line) = self.line().filter(|line| !line.starts_with('$')) {
            found += u64::from(!line.is_empty());
        }
        let (what, declared) = (what.to_owned(), declared as u64);
        Err(MeshFileError::new(at, MeshFileErrorKind::CountMismatch { what, declared, found }))
    }

    /// Passes everything up to the end of this section.
    pub(super) fn skip_section(&mut self) -> Result<()> {
        let end = format!("$End{}", self.section);
        match self.rest().windows(end.len()).position(|w| w == end.as_bytes()) {
            Some(k) => {
                self.advance(k);
                self.line();
                Ok(())
            }
            None => self.truncated(&end),
        }
    }

    /// Goes to the line that is `what`; returns whether there is one.
    pub(super) fn go_to(&mut self, what: &[u8]) -> bool {
        let mut passed = 0;
        for line in self.rest().split_inclusive(|b| *b == b'\n') {
            if line.trim_ascii() == what {
                self.advance(passed);
                return true;
            }
            passed += line.len();
        }
        false
    }

    pub(super) fn skip_blank(&mut self) {
        let n = self.rest().iter().take_while(|b| b.is_ascii_whitespace()).count();
        self.advance(n);
    }

    /// Starts record `k` of `declared`; in text it must not be the end of the section.
    pub(super) fn begin_row(&mut self, what: &str, k: usize, declared: usize) -> Result<()> {
        if self.binary.is_some() {
            return Ok(());
        }
        self.skip_blank();
        if self.rest().first() == Some(&b'$') {
            let (what, declared, found) = (what.to_owned(), declared as u64, k as u64);
            return self.fail("count", MeshFileErrorKind::CountMismatch { what, declared, found });
        }
        Ok(())
    }

    /// Ends a record: in text the row must be used up.
    pub(super) fn end_row(&mut self) -> Result<()> {
        if self.binary.is_some() || self.at_row_end() {
            return Ok(());
        }
        let found = text::shown(self.word("row")?);
        self.fail("row", MeshFileErrorKind::Syntax { expected: "the end of the row".into(), found })
    }

    /// Whether nothing is left of a row of text.
    pub(super) fn at_row_end(&mut self) -> bool {
        let n = self.rest().iter().take_while(|b| matches!(b, b' ' | b'\t' | b'\r')).count();
        self.advance(n);
        self.rest().first().is_none_or(|b| *b == b'\n')
    }

    fn word(&mut self, field: &str) -> Result<&'a str> {
        if self.at_row_end() {
            if self.rest().is_empty() {
                return self.truncated(field);
            }
            let (expected, found) = (field.to_owned(), "the end of the row".to_owned());
            return self.fail(field, MeshFileErrorKind::Syntax { expected, found });
        }
        let n = self.rest().iter().take_while(|b| !b.is_ascii_whitespace()).count();
        let word = self.advance(n);
        match std::str::from_utf8(word) {
            Ok(word) => Ok(word),
            Err(_) => {
                let value = word.iter().copied().find(|b| !b.is_ascii()).unwrap_or_default();
                self.fail(field, MeshFileErrorKind::BinaryAsText { value })
            }
        }
    }

    fn raw<const N: usize>(&mut self, field: &str, big_endian: bool) -> Result<[u8; N]> {
        match self.rest().first_chunk::<N>() {
            Some(chunk) => {
                self.at += N;
                let mut chunk = *chunk;
                if big_endian {
                    chunk.reverse();
                }
                Ok(chunk)
            }
            None => self.truncated(field),
        }
    }

    /// An `int`.
    pub(super) fn int(&mut self, field: &str) -> Result<i128> {
        match self.binary {
            Some(big) => Ok(i128::from(i32::from_le_bytes(self.raw(field, big)?))),
            None => {
                let word = self.word(field)?;
                text::integer(word, || self.location(field))
            }
        }
    }

    /// A `size_t`.
    pub(super) fn size(&mut self, field: &str) -> Result<i128> {
        match self.binary {
            Some(big) => Ok(i128::from(u64::from_le_bytes(self.raw(field, big)?))),
            None => self.int(field),
        }
    }

    /// A reference to a node.
    pub(super) fn node_number(&mut self) -> Result<i128> {
        if self.wide_nodes { self.size("nodes") } else { self.int("nodes") }
    }

    /// A finite `double`.
    pub(super) fn double(&mut self, field: &str) -> Result<f64> {
        match self.binary {
            Some(big) => {
                let at = self.location(field);
                let value = f64::from_le_bytes(self.raw(field, big)?);
                text::number(&value.to_string(), || at)
            }
            None => {
                let word = self.word(field)?;
                text::number(word, || self.location(field))
            }
        }
    }

    /// A node or element number.
    pub(super) fn id(&mut self, value: i128, what: &'static str) -> Result<u64> {
        text::id(value, what, || self.location(what))
    }

    /// A count of records that take at least `bytes_each` bytes in a binary file.
    pub(super) fn count(&self, value: i128, what: &str, bytes_each: usize) -> Result<usize> {
        // A record of text is at least one digit and one blank.
        let each = if self.binary.is_some() { bytes_each } else { 2 };
        text::count(value, what, self.rest().len(), each, || self.location(what))
    }
}
