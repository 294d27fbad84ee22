//! PLY: polygons, ASCII and binary.

use std::path::Path;

use super::mesh_file_error::{MeshFileError, MeshFileErrorKind};
use super::polygons::Polygons;
use super::{Location, text};
use crate::mesh::Surface;
use crate::units::Vec3;

type Result<T> = std::result::Result<T, MeshFileError>;

/// A type of numbers.
#[derive(Clone, Copy)]
enum Scalar {
    Int { bytes: usize, signed: bool },
    Float { bytes: usize },
}

impl Scalar {
    fn parse(name: &str) -> Option<Self> {
        Some(match name {
            "char" | "int8" => Self::Int { bytes: 1, signed: true },
            "uchar" | "uint8" => Self::Int { bytes: 1, signed: false },
            "short" | "int16" => Self::Int { bytes: 2, signed: true },
            "ushort" | "uint16" => Self::Int { bytes: 2, signed: false },
            "int" | "int32" => Self::Int { bytes: 4, signed: true },
            "uint" | "uint32" => Self::Int { bytes: 4, signed: false },
            "float" | "float32" => Self::Float { bytes: 4 },
            "double" | "float64" => Self::Float { bytes: 8 },
            _ => return None,
        })
    }
}

struct Property {
    name: String,
    /// The type of the length, for a list.
    length: Option<Scalar>,
    scalar: Scalar,
}

struct Element {
    name: String,
    count: usize,
    properties: Vec<Property>,
}

/// The surface in the PLY file `file` whose content is `bytes`, in the file's unit: vertices with `x`, `y`, `z`,
/// faces with `vertex_indices` or `vertex_index`.
pub(super) fn parse(file: &Path, bytes: &[u8]) -> Result<Surface> {
    let mut body = Body { file, bytes, at: 0, line: 0, encoding: Encoding::Ascii };
    let elements = body.header()?;
    let mut polygons = Polygons::default();
    for element in &elements {
        let list =
            |p: &Property| p.length.is_some() && matches!(p.name.as_str(), "vertex_indices" | "vertex_index");
        for k in 0..element.count {
            body.begin_row(&element.name, k, element.count)?;
            let mut p = [None; 3];
            for property in &element.properties {
                let field = property.name.as_str();
                let Some(length) = property.length else {
                    let value = body.number(property.scalar, field)?;
                    if let Some(k) = ["x", "y", "z"].iter().position(|axis| *axis == field) {
                        p[k] = Some(value);
                    }
                    continue;
                };
                let n = body.index(length, field, MAX_LIST)?;
                let corners = element.name == "face" && list(property);
                let mut all = Vec::new();
                for _ in 0..n {
                    let at = body.location(field);
                    if !corners {
                        body.number(property.scalar, field)?;
                        continue;
                    }
                    let vertex = body.index(property.scalar, field, usize::MAX)?;
                    if vertex >= polygons.n_vertices() {
                        let (what, id, node) = ("face", k.to_string(), vertex.to_string());
                        return Err(MeshFileError::new(
                            at,
                            MeshFileErrorKind::MissingNode { what, id, node },
                        ));
                    }
                    all.push(vertex);
                }
                // A face of two corners is an edge.
                if corners && all.len() > 2 {
                    let at = body.location(field);
                    polygons.polygon(&all, || at)?;
                }
            }
            if element.name == "vertex" {
                let [Some(x), Some(y), Some(z)] = p else {
                    return body.syntax("vertex", "properties x, y and z", "others");
                };
                if let Some(value) = [x, y, z].into_iter().find(|x| !x.is_finite()) {
                    return body.fail("vertex", MeshFileErrorKind::NotFinite { value: value.to_string() });
                }
                polygons.vertex(Vec3::new(x, y, z));
            }
        }
    }
    polygons.surface(&Location::file(file))
}

/// Longest list of a face or another element.
const MAX_LIST: usize = 1 << 20;

#[derive(Clone, Copy, PartialEq)]
enum Encoding {
    Ascii,
    Little,
    Big,
}

struct Body<'a> {
    file: &'a Path,
    bytes: &'a [u8],
    at: usize,
    line: usize,
    encoding: Encoding,
}

impl<'a> Body<'a> {
    fn location(&self, field: &str) -> Location {
        let at = Location::file(self.file).in_field(text::shown(field));
        if self.encoding == Encoding::Ascii { at.at_line(self.line) } else { at.at_byte(self.at) }
    }

    fn fail<T>(&self, field: &str, kind: MeshFileErrorKind) -> Result<T> {
        Err(MeshFileError::new(self.location(field), kind))
    }

    fn syntax<T>(&self, field: &str, expected: &str, found: &str) -> Result<T> {
        let (expected, found) = (expected.to_owned(), text::shown(found));
        self.fail(field, MeshFileErrorKind::Syntax { expected, found })
    }

    fn rest(&self) -> &'a [u8] {
        &self.bytes[self.at..]
    }

    fn next_line(&mut self) -> Option<String> {
        if self.rest().is_empty() {
            return None;
        }
        let n = self.rest().iter().position(|b| *b == b'\n').map_or(self.rest().len(), |k| k + 1);
        let line = String::from_utf8_lossy(&self.rest()[..n]).trim().to_owned();
        self.at += n;
        self.line += 1;
        Some(line)
    }

    fn header(&mut self) -> Result<Vec<Element>> {
        let mut elements: Vec<Element> = Vec::new();
        let mut encoding = Encoding::Ascii;
        loop {
            let Some(line) = self.next_line() else {
                return self
                    .fail("header", MeshFileErrorKind::Truncated { expected: "end_header".to_owned() });
            };
            let words: Vec<&str> = line.split_whitespace().collect();
            match words[..] {
                ["ply"] | ["comment" | "obj_info", ..] | [] => {}
                ["format", name, _] => {
                    encoding = match name {
                        "ascii" => Encoding::Ascii,
                        "binary_little_endian" => Encoding::Little,
                        "binary_big_endian" => Encoding::Big,
                        _ => {
                            return self.syntax(
                                "format",
                                "ascii, binary_little_endian or binary_big_endian",
                                name,
                            );
                        }
                    };
                }
                ["element", name, count] => {
                    let declared = text::integer(count, || self.location("element"))?;
                    // A row takes a byte at the least.
                    let count = text::count(declared, "rows of an element", self.bytes.len(), 1, || {
                        self.location("element")
                    })?;
                    elements.push(Element { name: name.to_owned(), count, properties: Vec::new() });
                }
                ["property", ref kind @ .., name] if !kind.is_empty() => {
                    let (length, scalar) = match *kind {
                        [scalar] => (Some(None), Scalar::parse(scalar)),
                        ["list", length, scalar] => (Scalar::parse(length).map(Some), Scalar::parse(scalar)),
                        _ => (None, None),
                    };
                    let (Some(length), Some(scalar)) = (length, scalar) else {
                        return self.syntax("property", "a type (float, double, uchar, int, ...)", &line);
                    };
                    let Some(element) = elements.last_mut() else {
                        return self.syntax("property", "an element before its properties", &line);
                    };
                    element.properties.push(Property { name: name.to_owned(), length, scalar });
                }
                ["end_header"] => break,
                _ => return self.syntax("header", "a statement of a PLY header", &line),
            }
        }
        // What follows is on the next line.
        self.line += 1;
        self.encoding = encoding;
        if encoding == Encoding::Ascii {
            text::text(self.file, self.bytes)?;
        }
        // Rows without properties are no bytes, and could be as many as a header likes.
        elements.retain(|element| !element.properties.is_empty());
        Ok(elements)
    }

    fn begin_row(&mut self, what: &str, k: usize, declared: usize) -> Result<()> {
        self.skip_blank();
        if self.rest().is_empty() {
            let (what, declared, found) = (text::shown(what), declared as u64, k as u64);
            return self.fail("count", MeshFileErrorKind::CountMismatch { what, declared, found });
        }
        Ok(())
    }

    /// In text, goes to the next word.
    fn skip_blank(&mut self) {
        if self.encoding == Encoding::Ascii {
            let blank = self.rest().iter().take_while(|b| b.is_ascii_whitespace());
            let (mut n, mut lines) = (0, 0);
            for b in blank {
                n += 1;
                lines += usize::from(*b == b'\n');
            }
            self.at += n;
            self.line += lines;
        }
    }

    fn word(&mut self, field: &str) -> Result<String> {
        self.skip_blank();
        let n = self.rest().iter().take_while(|b| !b.is_ascii_whitespace()).count();
        if n == 0 {
            return self.fail(field, MeshFileErrorKind::Truncated { expected: text::shown(field) });
        }
        let word = String::from_utf8_lossy(&self.rest()[..n]).into_owned();
        self.at += n;
        Ok(word)
    }

    fn raw(&mut self, bytes: usize, field: &str) -> Result<u64> {
        let Some(word) = self.rest().get(..bytes) else {
            return self.fail(field, MeshFileErrorKind::Truncated { expected: text::shown(field) });
        };
        self.at += bytes;
        let join = |value: u64, byte: &u8| value << 8 | u64::from(*byte);
        Ok(match self.encoding {
            Encoding::Big => word.iter().fold(0, join),
            _ => word.iter().rev().fold(0, join),
        })
    }

    fn number(&mut self, scalar: Scalar, field: &str) -> Result<f64> {
        if self.encoding == Encoding::Ascii {
            let word = self.word(field)?;
            return text::number(&word, || self.location(field));
        }
        Ok(match scalar {
            Scalar::Float { bytes: 4 } => f64::from(f32::from_bits(self.raw(4, field)? as u32)),
            Scalar::Float { bytes } => f64::from_bits(self.raw(bytes, field)?),
            Scalar::Int { .. } => self.integer(scalar, field)? as f64,
        })
    }

    fn integer(&mut self, scalar: Scalar, field: &str) -> Result<i64> {
        match scalar {
            Scalar::Int { bytes, signed } => {
                let (word, unused) = (self.raw(bytes, field)?, 64 - 8 * bytes as u32);
                Ok(if signed { (word << unused) as i64 >> unused } else { word as i64 })
            }
            Scalar::Float { .. } => self.syntax(field, "an integer type", "a float type"),
        }
    }

    /// A length or a position, of at most `most`.
    fn index(&mut self, scalar: Scalar, field: &str, most: usize) -> Result<usize> {
        let at = self.location(field);
        let value = if self.encoding == Encoding::Ascii {
            let word = self.word(field)?;
            text::integer(&word, || at.clone())?
        } else {
            i128::from(self.integer(scalar, field)?)
        };
        match usize::try_from(value) {
            Ok(index) if index <= most => Ok(index),
            _ => {
                let expected = format!("a number from 0 to {}", most.min(i32::MAX as usize));
                let kind = MeshFileErrorKind::Syntax { expected, found: value.to_string() };
                Err(MeshFileError::new(at, kind))
            }
        }
    }
}
