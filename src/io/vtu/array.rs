//! VTU data arrays: ASCII, base64 and raw, plain and zlib.

use std::io::Read;

use base64::Engine;
use base64::alphabet::STANDARD;
use base64::engine::{DecodePaddingMode, GeneralPurpose, GeneralPurposeConfig};
use flate2::read::ZlibDecoder;
use roxmltree::Node;

use super::super::mesh_file_error::{MeshFileError, MeshFileErrorKind};
use super::super::{Location, text};

type Result<T> = std::result::Result<T, MeshFileError>;

/// Most bytes that one byte of a zlib stream can become.
pub(super) const ZLIB_RATIO: u64 = 1032;

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
    pub(super) zlib: bool,
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
    Int(Vec<i128>),
    Float(Vec<f64>),
}

impl Values {
    pub(super) fn len(&self) -> usize {
        match self {
            Self::Int(v) => v.len(),
            Self::Float(v) => v.len(),
        }
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

/// The numbers of `DataArray` element `node`; `at` is the place of the element.
pub(super) fn values(node: Node<'_, '_>, encoding: &Encoding<'_>, at: &Location) -> Result<Values> {
    let fail = |kind| Err(MeshFileError::new(at.clone(), kind));
    let kind = node.attribute("type").unwrap_or("none");
    let Some(scalar) = Scalar::parse(kind) else {
        let expected = "type Float32, Float64, Int8..Int64 or UInt8..UInt64".to_owned();
        return fail(MeshFileErrorKind::Syntax { expected, found: kind.to_owned() });
    };
    match node.attribute("format").unwrap_or("ascii") {
        "ascii" => ascii(node, scalar, at),
        "binary" => {
            let text: Vec<u8> = node_text(node).bytes().filter(|b| !b.is_ascii_whitespace()).collect();
            let bytes = decode(&Stream { bytes: &text, base64: true, at }, encoding)?;
            numbers(&bytes, scalar, encoding.big_endian, at)
        }
        "appended" => {
            let Some(section) = &encoding.appended else {
                let expected = "an AppendedData section".to_owned();
                return fail(MeshFileErrorKind::Truncated { expected });
            };
            let offset = node.attribute("offset").unwrap_or("none");
            let start = text::integer(offset, || at.clone().in_field("offset"))?;
            let Some(bytes) = usize::try_from(start).ok().and_then(|start| section.bytes.get(start..)) else {
                let expected = format!("offset {start} of the appended data");
                return fail(MeshFileErrorKind::Truncated { expected });
            };
            let at = at.clone().at_byte(section.start + section.bytes.len() - bytes.len());
            let bytes = decode(&Stream { bytes, base64: section.base64, at: &at }, encoding)?;
            numbers(&bytes, scalar, encoding.big_endian, &at)
        }
        other => {
            let expected = "format ascii, binary or appended".to_owned();
            fail(MeshFileErrorKind::Syntax { expected, found: other.to_owned() })
        }
    }
}

fn node_text(node: Node<'_, '_>) -> String {
    node.children().filter_map(|child| child.text()).collect()
}

fn ascii(node: Node<'_, '_>, scalar: Scalar, at: &Location) -> Result<Values> {
    let body = node_text(node);
    // The text starts on the line where the opening tag ends.
    let first =
        node.first_child().map_or(1, |child| node.document().text_pos_at(child.range().start).row as usize);
    let words = || {
        let lines = body.split('\n').enumerate();
        lines.flat_map(|(k, line)| line.split_whitespace().map(move |word| (first + k, word)))
    };
    match scalar {
        Scalar::Float { .. } => {
            let parse = |(line, word)| text::number(word, || at.clone().at_line(line));
            Ok(Values::Float(words().map(parse).collect::<Result<_>>()?))
        }
        Scalar::Int { .. } => {
            let parse = |(line, word)| text::integer(word, || at.clone().at_line(line));
            Ok(Values::Int(words().map(parse).collect::<Result<_>>()?))
        }
    }
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

fn decode(stream: &Stream<'_>, encoding: &Encoding<'_>) -> Result<Vec<u8>> {
    if stream.bytes.is_empty() {
        return Ok(Vec::new());
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
    if !encoding.zlib {
        let size = header(1)?[0];
        if size > capacity {
            return Err(too_many("bytes", size, capacity));
        }
        return Ok(stream.take(word + size as usize, "the array")?.split_off(word));
    }
    let n_blocks = header(1)?[0];
    if n_blocks == 0 {
        return Ok(Vec::new());
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
    if size > total.saturating_mul(ZLIB_RATIO) {
        return Err(too_many("bytes", size, total.saturating_mul(ZLIB_RATIO)));
    }
    let start = head.len() * word;
    let data = stream.take(start + total as usize, "the array")?;
    let mut rest = &data[start..];
    let mut all = Vec::new();
    for (k, packed) in packed.iter().enumerate() {
        let (piece, after) = rest.split_at(*packed as usize);
        rest = after;
        let expected = if k + 1 == head.len() - 3 { last } else { block };
        let before = all.len() as u64;
        let read = ZlibDecoder::new(piece).take(expected + 1).read_to_end(&mut all);
        let found = all.len() as u64 - before;
        if read.is_err() || found != expected {
            let kind = match read {
                Ok(_) => MeshFileErrorKind::CountMismatch {
                    what: format!("bytes in block {k}"),
                    declared: expected,
                    found,
                },
                Err(e) => MeshFileErrorKind::Syntax { expected: "zlib data".into(), found: e.to_string() },
            };
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
            Values::Int(words.map(|w| i128::from((w << unused) as i64 >> unused)).collect())
        }
        Scalar::Int { .. } => Values::Int(words.map(i128::from).collect()),
    })
}
