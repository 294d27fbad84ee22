//! The parameters of a C3D file.

use std::collections::HashMap;
use std::path::Path;

use super::super::error::{RecordingFileError, RecordingFileErrorKind};
use super::Result;
use super::processor::Processor;
use crate::io::Location;
use crate::io::text::shown;

/// What stands in a parameter.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum Scalar {
    Text,
    Byte,
    Word,
    Float,
}

/// A parameter of a group.
pub(super) struct Parameter<'a> {
    scalar: Scalar,
    dimensions: &'a [u8],
    data: &'a [u8],
    processor: Processor,
    /// Where it begins in the file.
    pub(super) byte: usize,
}

impl Parameter<'_> {
    /// Its numbers; whole ones of two bytes count from 0 to 65535, as counts of points and frames do.
    pub(super) fn numbers(&self) -> Vec<f64> {
        match self.scalar {
            Scalar::Text => Vec::new(),
            Scalar::Byte => self.data.iter().map(|b| f64::from(*b)).collect(),
            Scalar::Word => {
                self.data.as_chunks().0.iter().map(|word| f64::from(self.processor.u16(*word))).collect()
            }
            Scalar::Float => self.data.as_chunks().0.iter().map(|word| self.processor.float(*word)).collect(),
        }
    }

    /// Whether its numbers are floating ones.
    pub(super) fn is_float(&self) -> bool {
        self.scalar == Scalar::Float
    }

    /// Its first number.
    pub(super) fn number(&self) -> Option<f64> {
        self.numbers().first().copied()
    }

    /// Its texts, without the blanks around them.
    pub(super) fn texts(&self) -> Vec<String> {
        let length = self.dimensions.first().map_or(0, |d| usize::from(*d));
        if self.scalar != Scalar::Text || length == 0 {
            return Vec::new();
        }
        let blank = |c: char| c.is_whitespace() || c == '\0';
        self.data
            .chunks(length)
            .map(|text| String::from_utf8_lossy(text).trim_matches(blank).to_owned())
            .collect()
    }
}

/// All parameters, by `GROUP:NAME` in capitals.
pub(super) struct Parameters<'a>(HashMap<String, Parameter<'a>>);

impl<'a> Parameters<'a> {
    /// The parameters that begin at byte `start` of `bytes`. How many blocks they claim is not heeded: writers get it wrong.
    pub(super) fn read(file: &Path, bytes: &'a [u8], start: usize, processor: Processor) -> Result<Self> {
        let mut groups: HashMap<u8, String> = HashMap::new();
        let mut found: Vec<(u8, String, Parameter)> = Vec::new();
        let mut at = start;
        loop {
            let begin = at;
            let past = |name: &str| {
                let kind = RecordingFileErrorKind::ParameterPastEnd { parameter: shown(name) };
                RecordingFileError::new(Location::file(file).at_byte(begin), kind)
            };
            let unnamed = || past("a parameter");
            // A name of no length ends the parameters, as does the end of the file behind them.
            let Some(length) = bytes.get(at).map(|b| (*b as i8).unsigned_abs()).filter(|n| *n > 0) else {
                break;
            };
            let id = *bytes.get(at + 1).ok_or_else(unnamed)? as i8;
            let name = bytes.get(at + 2..at + 2 + usize::from(length)).ok_or_else(unnamed)?;
            let name = String::from_utf8_lossy(name).trim().to_uppercase();
            at += 2 + usize::from(length);
            let offset = *bytes.get(at..).and_then(|rest| rest.first_chunk()).ok_or_else(|| past(&name))?;
            let next = at + usize::from(processor.u16(offset));
            if id < 0 {
                groups.insert(id.unsigned_abs(), name);
            } else {
                let told = |groups: &HashMap<u8, String>| match groups.get(&(id as u8)) {
                    Some(group) => format!("{group}:{name}"),
                    None => name.clone(),
                };
                let parameter =
                    parameter(bytes, at + 2, begin, processor).ok_or_else(|| past(&told(&groups)))?;
                found.push((id as u8, name, parameter));
            }
            if next == at {
                break;
            }
            if next > bytes.len() {
                return Err(unnamed());
            }
            at = next;
        }
        let mut all = HashMap::new();
        for (id, name, parameter) in found {
            if let Some(group) = groups.get(&id) {
                all.entry(format!("{group}:{name}")).or_insert(parameter);
            }
        }
        Ok(Self(all))
    }

    /// The parameter `name`, such as `POINT:USED`.
    pub(super) fn get(&self, name: &str) -> Option<&Parameter<'a>> {
        self.0.get(name)
    }

    /// The first number of parameter `name`.
    pub(super) fn number(&self, name: &str) -> Option<f64> {
        self.get(name)?.number()
    }

    /// Where parameter `name` stands in `file`.
    pub(super) fn location(&self, file: &Path, name: &str) -> Location {
        let byte = self.get(name).map(|p| p.byte);
        Location { byte, ..Location::file(file) }.in_field(name)
    }
}

/// The parameter whose type stands at byte `at`; `None` where it reaches past the end.
fn parameter(bytes: &[u8], at: usize, byte: usize, processor: Processor) -> Option<Parameter<'_>> {
    let (kind, n) = (*bytes.get(at)? as i8, *bytes.get(at + 1)?);
    let (scalar, size) = match kind {
        -1 => (Scalar::Text, 1),
        1 => (Scalar::Byte, 1),
        2 => (Scalar::Word, 2),
        // Of an unknown type only the place of the next one is of use.
        4 => (Scalar::Float, 4),
        _ => return Some(Parameter { scalar: Scalar::Byte, dimensions: &[], data: &[], processor, byte }),
    };
    let dimensions = bytes.get(at + 2..at + 2 + usize::from(n))?;
    let length = dimensions.iter().try_fold(size, |n: usize, d| n.checked_mul(usize::from(*d)))?;
    let start = at + 2 + usize::from(n);
    let data = bytes.get(start..start.checked_add(length)?)?;
    Some(Parameter { scalar, dimensions, data, processor, byte })
}
