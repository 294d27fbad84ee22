//! Data arrays of VTK's XML: ASCII, base64 and raw, plain and compressed.

use std::cell::Cell;

use base64::Engine;
use base64::alphabet::STANDARD;
use base64::engine::{DecodePaddingMode, GeneralPurpose, GeneralPurposeConfig};
use roxmltree::Node;

use super::super::lines::Lines;
use super::super::mesh_file_error::{MeshFileError, MeshFileErrorKind};
use super::super::{Location, text};
use super::compression::Compression;

type Result<T> = std::result::Result<T, MeshFileError>;

/// Most bytes that the arrays of a small file may have when they are unpacked: 256 MiB. A larger file may have
/// as many times its size more as arrays of zeros and ones take.
pub(super) const ARRAYS: usize = 1 << 28;
pub(super) const ARRAYS_PER_BYTE: usize = 8;

/// Header and data may be encoded apart, each with its own padding, or together.
const BASE64: GeneralPurpose = GeneralPurpose::new(
    &STANDARD,
    GeneralPurposeConfig::new()
        .with_decode_padding_mode(DecodePaddingMode::Indifferent)
        .with_decode_allow_trailing_bits(true),
);

/// How the arrays of a file are stored.
pub(super) struct Encoding<'a> {
    pub(super) big_endian: bool,
    pub(super) wide_header: bool,
    pub(super) compression: Option<Compression>,
    /// Bytes that the arrays of the file may still have: they may all be the same few.
    pub(super) left: Cell<usize>,
    pub(super) appended: Option<Appended<'a>>,
}

/// The appended section: what follows its underscore.
pub(super) struct Appended<'a> {
    pub(super) bytes: &'a [u8],
    pub(super) base64: bool,
    /// Byte of the file at which it starts, for messages.
    pub(super) start: usize,
}

/// The numbers of an array.
#[derive(Clone, Debug, PartialEq)]
pub(super) enum Values {
    Int(Vec<i64>),
    Float(Vec<f64>),
}

/// How many entries an array must have, of how many numbers each, and what they are called.
#[derive(Clone, Copy)]
pub(super) struct Expected<'a> {
    pub(super) what: &'a str,
    pub(super) entries: usize,
    pub(super) each: usize,
}

impl Expected<'_> {
    /// Refuses an array of `found` numbers, if it is not as expected.
    fn check(&self, found: usize, at: &Location) -> Result<()> {
        if self.entries.checked_mul(self.each) == Some(found) {
            return Ok(());
        }
        let each = self.each.max(1);
        let what = match each {
            1 => self.what.to_owned(),
            _ => format!("{} ({each} numbers each)", self.what),
        };
        let (declared, found) = (self.entries as u64, (found / each) as u64);
        Err(MeshFileError::new(at.clone(), MeshFileErrorKind::CountMismatch { what, declared, found }))
    }
}

#[derive(Clone, Copy)]
enum Scalar {
    Int { bytes: usize, signed: bool },
    Float { bytes: usize },
}

impl Scalar {
    fn parse(name: &str) -> Option<Self> {
        let bits = |digits: &str| match digits {
            "8" => Some(1),
            "16" => Some(2),
            "32" => Some(4),
            "64" => Some(8),
            _ => None,
        };
        if let Some(digits) = name.strip_prefix("UInt") {
            return Some(Self::Int { bytes: bits(digits)?, signed: false });
        }
        if let Some(digits) = name.strip_prefix("Int") {
            return Some(Self::Int { bytes: bits(digits)?, signed: true });
        }
        let bytes = bits(name.strip_prefix("Float")?).filter(|b| *b >= 4)?;
        Some(Self::Float { bytes })
    }

    fn bytes(self) -> usize {
        match self {
            Self::Int { bytes, .. } | Self::Float { bytes } => bytes,
        }
    }
}

/// The numbers of `DataArray` element `node`, as many as `expected`; `at` is the place of the element.
pub(super) fn values(
    node: Node<'_, '_>,
    encoding: &Encoding<'_>,
    lines: &Lines,
    expected: Expected<'_>,
    at: &Location,
) -> Result<Values> {
    let fail = |kind| Err(MeshFileError::new(at.clone(), kind));
    let kind = attribute(node, "type").unwrap_or("none");
    let Some(scalar) = Scalar::parse(kind) else {
        let expected = "type Float32, Float64, Int8..Int64 or UInt8..UInt64".to_owned();
        return fail(MeshFileErrorKind::Syntax { expected, found: text::shown(kind) });
    };
    match attribute(node, "format").unwrap_or("ascii") {
        "ascii" => ascii(node, scalar, lines, expected, at),
        "binary" => {
            let text: Vec<u8> = node_text(node).bytes().filter(|b| !b.is_ascii_whitespace()).collect();
            let bytes = decode(&Stream { bytes: &text, base64: true, at }, encoding, scalar, expected)?;
            numbers(&bytes, scalar, encoding.big_endian, at)
        }
        "appended" => {
            let Some(section) = &encoding.appended else {
                let expected = "an AppendedData section".to_owned();
                return fail(MeshFileErrorKind::Truncated { expected });
            };
            let offset = attribute(node, "offset").unwrap_or("none");
            let start = text::integer(offset, || at.clone().in_field("offset"))?;
            let Some(bytes) = usize::try_from(start).ok().and_then(|start| section.bytes.get(start..)) else {
                let expected = format!("offset {start} of the appended data");
                return fail(MeshFileErrorKind::Truncated { expected });
            };
            let at = at.clone().at_byte(section.start + section.bytes.len() - bytes.len());
            let stream = Stream { bytes, base64: section.base64, at: &at };
            let bytes = decode(&stream, encoding, scalar, expected)?;
            numbers(&bytes, scalar, encoding.big_endian, &at)
        }
        other => {
            let expected = "format ascii, binary or appended".to_owned();
            fail(MeshFileErrorKind::Syntax { expected, found: text::shown(other) })
        }
    }
}

/// Attribute `name` of `node` without the blanks that some writers pad it with.
pub(super) fn attribute<'a>(node: Node<'a, '_>, name: &str) -> Option<&'a str> {
    node.attribute(name).map(str::trim)
}

fn node_text(node: Node<'_, '_>) -> String {
    node.children().filter(Node::is_text).filter_map(|child| child.text()).collect()
}

/// The words of the text `body` of `node`, each with its line.
fn words<'a>(body: &'a str, node: Node<'_, '_>, lines: &Lines) -> impl Iterator<Item = (usize, &'a str)> {
    // The text starts on the line where the opening tag ends.
    let first = node.children().find(Node::is_text).map_or(1, |child| lines.of(child.range().start));
    let numbered = body.split('\n').enumerate();
    numbered.flat_map(move |(k, line)| line.split_whitespace().map(move |word| (first + k, word)))
}

/// Number `k` of the array `node` as its file has it, and its line, where numbers are written as text.
pub(super) fn written(node: Node<'_, '_>, lines: &Lines, k: usize) -> Option<(usize, String)> {
    if attribute(node, "format").unwrap_or("ascii") != "ascii" {
        return None;
    }
    words(&node_text(node), node, lines).nth(k).map(|(line, word)| (line, text::shown(word)))
}

fn ascii(
    node: Node<'_, '_>,
    scalar: Scalar,
    lines: &Lines,
    expected: Expected<'_>,
    at: &Location,
) -> Result<Values> {
    let body = node_text(node);
    let words = || words(&body, node, lines);
    match scalar {
        Scalar::Float { .. } => {
            let parse = |(line, word): (usize, &str)| match word.parse() {
                Ok(number) => Ok(number),
                Err(_) => text::number(word, || at.clone().at_line(line)),
            };
            let numbers: Vec<f64> = words().map(parse).collect::<Result<_>>()?;
            expected.check(numbers.len(), at)?;
            Ok(Values::Float(numbers))
        }
        Scalar::Int { .. } => {
            let parse = |(line, word)| text::integer(word, || at.clone().at_line(line)).map(saturated);
            let numbers: Vec<i64> = words().map(parse).collect::<Result<_>>()?;
            expected.check(numbers.len(), at)?;
            Ok(Values::Int(numbers))
        }
    }
}

/// `value`, or the nearest number that fits: no number of a node or a cell is anywhere near.
fn saturated(value: i128) -> i64 {
    value.clamp(i128::from(i64::MIN), i128::from(i64::MAX)) as i64
}

/// Encoded bytes that can be read from their start.
struct Stream<'a> {
    bytes: &'a [u8],
    base64: bool,
    at: &'a Location,
}

impl Stream<'_> {
    /// Most bytes that it can hold.
    fn capacity(&self) -> u64 {
        let n = self.bytes.len() as u64;
        if self.base64 { n / 4 * 3 + 3 } else { n }
    }

    /// The first `n` bytes.
    fn take(&self, n: usize, what: &str) -> Result<Vec<u8>> {
        let fail = |kind| Err(MeshFileError::new(self.at.clone(), kind));
        let short = || MeshFileErrorKind::Truncated { expected: format!("the {n} bytes of {what}") };
        if !self.base64 {
            return match self.bytes.get(..n) {
                Some(bytes) => Ok(bytes.to_vec()),
                None => fail(short()),
            };
        }
        let mut decoded = Vec::new();
        let mut rest = self.bytes;
        while decoded.len() < n {
            let wanted = (n - decoded.len()).div_ceil(3).saturating_mul(4).min(rest.len());
            let padding = rest[..wanted].iter().position(|b| *b == b'=');
            // Padding ends a piece, always at a multiple of four characters.
            let end = padding.map_or(wanted, |k| ((k / 4 + 1) * 4).min(rest.len()));
            if end == 0 {
                return fail(short());
            }
            let (piece, after) = rest.split_at(end);
            match BASE64.decode(piece) {
                Ok(bytes) => decoded.extend(bytes),
                Err(e) => {
                    let found = e.to_string();
                    return fail(MeshFileErrorKind::Syntax { expected: "base64".into(), found });
                }
            }
            rest = after;
        }
        decoded.truncate(n);
        Ok(decoded)
    }
}

/// The bytes of an array, of which there must be as many as `expected` before anything is unpacked.
fn decode(
    stream: &Stream<'_>,
    encoding: &Encoding<'_>,
    scalar: Scalar,
    expected: Expected<'_>,
) -> Result<Vec<u8>> {
    let check = |size: u64| {
        let size = usize::try_from(size).unwrap_or(usize::MAX);
        expected.check(size / scalar.bytes(), stream.at)?;
        match encoding.left.get().checked_sub(size) {
            Some(left) => {
                encoding.left.set(left);
                Ok(())
            }
            None => {
                let (what, most) = ("bytes of arrays in a file of this size".to_owned(), ARRAYS as u64);
                Err(MeshFileError::new(stream.at.clone(), MeshFileErrorKind::TooMuch { what, most }))
            }
        }
    };
    if stream.bytes.is_empty() {
        return check(0).map(|()| Vec::new());
    }
    let too_many = |what: &str, declared: u64, most: u64| {
        let kind = MeshFileErrorKind::DeclaredTooMany { what: what.to_owned(), declared, most };
        MeshFileError::new(stream.at.clone(), kind)
    };
    let word = if encoding.wide_header { 8 } else { 4 };
    let header = |n: usize| -> Result<Vec<u64>> {
        let bytes = stream.take(n * word, "the array header")?;
        Ok(bytes.chunks_exact(word).map(|w| unsigned(w, encoding.big_endian)).collect())
    };
    let capacity = stream.capacity();
    let Some(compression) = encoding.compression else {
        let size = header(1)?[0];
        if size > capacity {
            return Err(too_many("bytes", size, capacity));
        }
        check(size)?;
        return Ok(stream.take(word + size as usize, "the array")?.split_off(word));
    };
    let n_blocks = header(1)?[0];
    if n_blocks == 0 {
        return check(0).map(|()| Vec::new());
    }
    if n_blocks > capacity / word as u64 {
        return Err(too_many("blocks", n_blocks, capacity / word as u64));
    }
    let head = header(3 + n_blocks as usize)?;
    let (block, last, packed) = (head[1], if head[2] == 0 { head[1] } else { head[2] }, &head[3..]);
    let total = packed.iter().fold(0_u64, |sum, size| sum.saturating_add(*size));
    if total > capacity {
        return Err(too_many("compressed bytes", total, capacity));
    }
    let size = (n_blocks - 1).saturating_mul(block).saturating_add(last);
    check(size)?;
    let start = head.len() * word;
    let data = stream.take(start + total as usize, "the array")?;
    let mut rest = &data[start..];
    let mut all = Vec::new();
    for (k, packed) in packed.iter().enumerate() {
        let (piece, after) = rest.split_at(*packed as usize);
        rest = after;
        let expected = if k + 1 == head.len() - 3 { last } else { block };
        let found = compression.unpack(piece, expected as usize, &mut all).map_err(|found| {
            let expected = compression.data().to_owned();
            MeshFileError::new(stream.at.clone(), MeshFileErrorKind::Syntax { expected, found })
        })? as u64;
        if found != expected {
            let what = format!("bytes in block {k}");
            let kind = MeshFileErrorKind::CountMismatch { what, declared: expected, found };
            return Err(MeshFileError::new(stream.at.clone(), kind));
        }
    }
    Ok(all)
}

fn unsigned(word: &[u8], big_endian: bool) -> u64 {
    let join = |value: u64, byte: &u8| value << 8 | u64::from(*byte);
    if big_endian { word.iter().fold(0, join) } else { word.iter().rev().fold(0, join) }
}

fn numbers(bytes: &[u8], scalar: Scalar, big_endian: bool, at: &Location) -> Result<Values> {
    let size = scalar.bytes();
    if !bytes.len().is_multiple_of(size) {
        let found = format!("{} bytes", bytes.len());
        let kind = MeshFileErrorKind::Syntax { expected: format!("a multiple of {size} bytes"), found };
        return Err(MeshFileError::new(at.clone(), kind));
    }
    let words = bytes.chunks_exact(size).map(|word| unsigned(word, big_endian));
    Ok(match scalar {
        Scalar::Float { bytes: 4 } => {
            Values::Float(words.map(|w| f64::from(f32::from_bits(w as u32))).collect())
        }
        Scalar::Float { .. } => Values::Float(words.map(f64::from_bits).collect()),
        Scalar::Int { bytes, signed: true } => {
            let unused = 64 - 8 * bytes as u32;
            Values::Int(words.map(|w| (w << unused) as i64 >> unused).collect())
        }
        Scalar::Int { .. } => Values::Int(words.map(|w| saturated(i128::from(w))).collect()),
    })
}
