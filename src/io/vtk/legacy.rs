//! Reads VTK's legacy format, `.vtk`: unstructured grids and polygons, ASCII and binary.

use std::path::Path;

use super::super::lines::Lines;
use super::super::mesh_document::MeshDocument;
use super::super::mesh_file_error::{MeshFileError, MeshFileErrorKind};
use super::super::{Location, text};
use super::array::Values;
use super::cell_type::{POLYGON, STRIP};
use super::grid::Grid;
use super::labels::Labels;
use crate::mesh::Surface;
use crate::units::Vec3;

type Result<T> = std::result::Result<T, MeshFileError>;

/// The volume mesh in the legacy file `file` whose content is `bytes`, in the file's unit.
pub(in super::super) fn parse(file: &Path, bytes: &[u8]) -> Result<MeshDocument> {
    let (grid, at) = read(file, bytes, "UNSTRUCTURED_GRID", "save the volume as an unstructured grid")?;
    grid.mesh(&at, &at)
}

/// The polygons of the legacy file `file` whose content is `bytes`, in the file's unit.
pub(in super::super) fn polygons(file: &Path, bytes: &[u8]) -> Result<Surface> {
    let (grid, at) = read(file, bytes, "POLYDATA", "save the surface as polygons")?;
    grid.surface(&at)
}

fn read(file: &Path, bytes: &[u8], data_set: &str, fix: &'static str) -> Result<(Grid, Location)> {
    let mut reader = Reader::new(file, text::without_bom(bytes));
    // The version, then a title.
    reader.line();
    reader.line();
    reader.binary = match reader.word("ASCII or BINARY")?.to_ascii_uppercase().as_str() {
        "ASCII" => false,
        "BINARY" => true,
        other => return reader.syntax("ASCII or BINARY", other),
    };
    if !reader.binary {
        text::text(file, bytes)?;
    }
    let word = reader.word("DATASET")?;
    if !word.eq_ignore_ascii_case("DATASET") {
        return reader.syntax("DATASET", &word);
    }
    let kind = reader.word("the kind of the data set")?.to_ascii_uppercase();
    // Triangles are often saved as an unstructured grid.
    if kind != data_set && !(data_set == "POLYDATA" && kind == "UNSTRUCTURED_GRID") {
        let what = format!("a VTK file of kind {}", text::shown(&kind));
        return reader.fail(MeshFileErrorKind::UnsupportedFormat { what, fix });
    }
    let mut grid = Grid::default();
    let mut connectivity: Vec<(Vec<i64>, Vec<i64>, Option<i64>)> = Vec::new();
    let mut types = Vec::new();
    let mut of_points = None;
    while let Some(section) = reader.next_word() {
        match section.to_ascii_uppercase().as_str() {
            "POINTS" => {
                let n = reader.count("points", 3)?;
                let kind = reader.word("a type")?;
                for p in reader.floats(3 * n, &kind)?.chunks_exact(3) {
                    if let Some(x) = p.iter().find(|x| !x.is_finite()) {
                        let value = format!("{x} (node {})", grid.points.len());
                        return reader.fail(MeshFileErrorKind::NotFinite { value });
                    }
                    grid.points.push(Vec3::from_column_slice(p));
                }
            }
            "CELLS" => connectivity.push(reader.cells(None)?),
            "POLYGONS" => connectivity.push(reader.cells(Some(POLYGON))?),
            "TRIANGLE_STRIPS" => connectivity.push(reader.cells(Some(STRIP))?),
            "LINES" | "VERTICES" => drop(reader.cells(Some(0))?),
            "CELL_TYPES" => {
                let n = reader.count("cell types", 1)?;
                types = reader.ints(n, "int")?;
            }
            "METADATA" => reader.skip_metadata(),
            "POINT_DATA" => of_points = Some((true, reader.count("point data", 0)?)),
            "CELL_DATA" => of_points = Some((false, reader.count("cell data", 0)?)),
            // What belongs to the whole file, such as a time.
            "FIELD" if of_points.is_none() => drop(reader.attribute("FIELD", usize::MAX)?),
            name => {
                let Some((points, n)) = of_points else {
                    return reader.syntax("a section of the grid", name);
                };
                for (name, labels) in reader.attribute(name, n)? {
                    let sets = if points { &mut grid.point_labels } else { &mut grid.cell_labels };
                    sets.insert(name, labels);
                }
            }
        }
    }
    for (ends, nodes, kind) in connectivity {
        reader.add_cells(&mut grid, &ends, &nodes, kind, &types)?;
    }
    for (labels, n, what) in [
        (&grid.point_labels, grid.points.len(), "point data"),
        (&grid.cell_labels, grid.cells.len(), "cell data"),
    ] {
        let found = labels.values().find_map(|l| match l {
            Labels::Of { codes, .. } if codes.len() != n => Some(codes.len() as u64),
            _ => None,
        });
        if let Some(declared) = found {
            let (what, found) = (what.to_owned(), n as u64);
            return reader.fail(MeshFileErrorKind::CountMismatch { what, declared, found });
        }
    }
    Ok((grid, Location::file(file)))
}

struct Reader<'a> {
    file: &'a Path,
    bytes: &'a [u8],
    at: usize,
    binary: bool,
    lines: Lines,
}

impl<'a> Reader<'a> {
    fn new(file: &'a Path, bytes: &'a [u8]) -> Self {
        // Only places in text are told by their lines.
        let lines = Lines::new(&String::from_utf8_lossy(bytes));
        Self { file, bytes, at: 0, binary: false, lines }
    }

    fn location(&self) -> Location {
        let at = Location::file(self.file);
        if self.binary { at.at_byte(self.at) } else { at.at_line(self.lines.of(self.at)) }
    }

    fn fail<T>(&self, kind: MeshFileErrorKind) -> Result<T> {
        Err(MeshFileError::new(self.location(), kind))
    }

    fn syntax<T>(&self, expected: &str, found: &str) -> Result<T> {
        self.fail(MeshFileErrorKind::Syntax { expected: expected.to_owned(), found: text::shown(found) })
    }

    fn rest(&self) -> &'a [u8] {
        &self.bytes[self.at..]
    }

    /// The rest of the line, trimmed.
    fn line(&mut self) -> Option<String> {
        if self.rest().is_empty() {
            return None;
        }
        let n = self.rest().iter().position(|b| *b == b'\n').map_or(self.rest().len(), |k| k + 1);
        let line = String::from_utf8_lossy(&self.rest()[..n]).trim().to_owned();
        self.at += n;
        Some(line)
    }

    /// Goes past what ends with an empty line.
    fn skip_metadata(&mut self) {
        self.line();
        while self.line().is_some_and(|line| !line.is_empty()) {}
    }

    fn next_word(&mut self) -> Option<String> {
        self.at += self.rest().iter().take_while(|b| b.is_ascii_whitespace()).count();
        let n = self.rest().iter().take_while(|b| !b.is_ascii_whitespace()).count();
        let word = String::from_utf8_lossy(&self.rest()[..n]).into_owned();
        self.at += n;
        (n > 0).then_some(word)
    }

    fn word(&mut self, expected: &str) -> Result<String> {
        match self.next_word() {
            Some(word) => Ok(word),
            None => self.fail(MeshFileErrorKind::Truncated { expected: expected.to_owned() }),
        }
    }

    /// A count of entries of at least `each` numbers.
    fn count(&mut self, what: &str, each: usize) -> Result<usize> {
        let word = self.word(what)?;
        let value = text::integer(&word, || self.location())?;
        // A number takes a byte at least, and in text a blank.
        text::count(value, what, self.bytes.len(), each.max(1), || self.location())
    }

    /// Goes past the end of the line after which binary numbers begin.
    fn begin_binary(&mut self) {
        let n = self.rest().iter().take_while(|b| **b != b'\n').count();
        self.at = (self.at + n + 1).min(self.bytes.len());
    }

    /// Goes past `n` strings: in text one a line, in binary each after its length, whose first two bits tell in how many
    /// bytes it is.
    fn skip_strings(&mut self, n: usize) -> Result<()> {
        self.begin_binary();
        for _ in 0..n {
            let passed = if self.binary { self.string_bytes() } else { self.line().map(|_| 0) };
            let Some(bytes) = passed else {
                return self.fail(MeshFileErrorKind::Truncated { expected: format!("{n} strings") });
            };
            self.at += bytes;
        }
        Ok(())
    }

    /// How many bytes the next binary string and its length take; `None` where there are fewer.
    fn string_bytes(&self) -> Option<usize> {
        let of_length = [8, 4, 2, 1][usize::from(self.rest().first()? >> 6)];
        let word =
            self.rest().get(..of_length)?.iter().fold(0_u64, |word, byte| word << 8 | u64::from(*byte));
        let length = word & (u64::MAX >> (66 - 8 * of_length));
        let bytes = of_length.checked_add(usize::try_from(length).ok()?)?;
        (bytes <= self.rest().len()).then_some(bytes)
    }

    /// `n` bits, in binary eight a byte, the highest first.
    fn bits(&mut self, n: usize) -> Result<Values> {
        if !self.binary {
            return self.numbers(n, "char");
        }
        let bytes = self.numbers(n.div_ceil(8), "unsigned_char")?;
        let bit = |k: usize| match &bytes {
            Values::Int(bytes) => bytes[k / 8] >> (7 - k % 8) & 1,
            Values::Float(_) => 0,
        };
        Ok(Values::Int((0..n).map(bit).collect()))
    }

    /// `n` numbers of type `kind`.
    fn numbers(&mut self, n: usize, kind: &str) -> Result<Values> {
        let kind = kind.to_ascii_lowercase();
        if kind == "bit" {
            return self.bits(n);
        }
        let bytes = match kind.as_str() {
            "char" | "unsigned_char" | "signed_char" | "vtktypeint8" | "vtktypeuint8" => 1,
            "short" | "unsigned_short" | "vtktypeint16" | "vtktypeuint16" => 2,
            "int" | "unsigned_int" | "float" | "vtktypeint32" | "vtktypeuint32" => 4,
            "long" | "unsigned_long" | "double" | "vtkidtype" | "vtktypeint64" | "vtktypeuint64" => 8,
            _ => return self.syntax("a type (float, double, int, vtktypeint64, ...)", &kind),
        };
        let float = matches!(kind.as_str(), "float" | "double");
        if !self.binary {
            let (mut floats, mut ints) = (Vec::new(), Vec::new());
            for _ in 0..n {
                let word = self.word("numbers")?;
                if float {
                    floats.push(word.parse().map_or_else(|_| text::number(&word, || self.location()), Ok)?);
                } else {
                    let value = text::integer(&word, || self.location())?;
                    ints.push(value.clamp(i128::from(i64::MIN), i128::from(i64::MAX)) as i64);
                }
            }
            return Ok(if float { Values::Float(floats) } else { Values::Int(ints) });
        }
        self.begin_binary();
        let Some(data) = n.checked_mul(bytes).and_then(|n| self.rest().get(..n)) else {
            return self
                .fail(MeshFileErrorKind::Truncated { expected: format!("{n} numbers of {bytes} bytes") });
        };
        self.at += data.len();
        let unsigned = |w: &[u8]| w.iter().fold(0_u64, |value, byte| value << 8 | u64::from(*byte));
        let words = data.chunks_exact(bytes);
        let signed = !(kind.starts_with("unsigned") || kind.starts_with("vtktypeuint"));
        let unused = 64 - 8 * bytes as u32;
        Ok(match (float, bytes) {
            (true, 4) => {
                Values::Float(words.map(|w| f64::from(f32::from_bits(unsigned(w) as u32))).collect())
            }
            (true, _) => Values::Float(words.map(|w| f64::from_bits(unsigned(w))).collect()),
            _ if signed => Values::Int(words.map(|w| (unsigned(w) << unused) as i64 >> unused).collect()),
            _ => Values::Int(words.map(|w| i64::try_from(unsigned(w)).unwrap_or(i64::MAX)).collect()),
        })
    }

    fn floats(&mut self, n: usize, kind: &str) -> Result<Vec<f64>> {
        Ok(match self.numbers(n, kind)? {
            Values::Float(v) => v,
            Values::Int(v) => v.into_iter().map(|x| x as f64).collect(),
        })
    }

    fn ints(&mut self, n: usize, kind: &str) -> Result<Vec<i64>> {
        match self.numbers(n, kind)? {
            Values::Int(v) => Ok(v),
            Values::Float(_) => self.syntax("whole numbers", kind),
        }
    }

    /// The cells of a section: where each one's nodes end, the nodes, and `kind`.
    #[allow(clippy::type_complexity, reason = "ends, nodes and the kind as they are")]
    fn cells(&mut self, kind: Option<i64>) -> Result<(Vec<i64>, Vec<i64>, Option<i64>)> {
        let (n, size) = (self.count("cells", 1)?, self.count("cell nodes", 1)?);
        let before = self.at;
        // Since version 5 ends and nodes are arrays of their own, and there is one end more than cells.
        if self.next_word().is_some_and(|word| word.eq_ignore_ascii_case("OFFSETS")) {
            let kind_of_ends = self.word("a type")?;
            let ends = self.ints(n, &kind_of_ends)?;
            let word = self.word("CONNECTIVITY")?;
            if !word.eq_ignore_ascii_case("CONNECTIVITY") {
                return self.syntax("CONNECTIVITY", &word);
            }
            let kind_of_nodes = self.word("a type")?;
            let nodes = self.ints(size, &kind_of_nodes)?;
            return Ok((ends.into_iter().skip(1).collect(), nodes, kind));
        }
        self.at = before;
        let (mut ends, mut nodes) = (Vec::with_capacity(n), Vec::with_capacity(size.saturating_sub(n)));
        let numbers = self.ints(size, "int")?;
        let mut rest = numbers.as_slice();
        for k in 0..n {
            let own = rest.split_first().and_then(|(count, after)| {
                let count = usize::try_from(*count).ok()?;
                Some((after.get(..count)?, &after[count..]))
            });
            let Some((own, after)) = own else {
                return self.syntax(&format!("the nodes of cell {k} within {size} numbers"), "too few");
            };
            nodes.extend(own);
            ends.push(nodes.len() as i64);
            rest = after;
        }
        Ok((ends, nodes, kind))
    }

    fn add_cells(
        &self,
        grid: &mut Grid,
        ends: &[i64],
        nodes: &[i64],
        kind: Option<i64>,
        types: &[i64],
    ) -> Result<()> {
        if kind.is_none() && types.len() != ends.len() {
            let (what, declared, found) = ("cell types".to_owned(), ends.len() as u64, types.len() as u64);
            return self.fail(MeshFileErrorKind::CountMismatch { what, declared, found });
        }
        let mut start = 0;
        for (k, &end) in ends.iter().enumerate() {
            let Some(own) = usize::try_from(end).ok().and_then(|end| nodes.get(start..end)) else {
                return self
                    .syntax(&format!("offset {start} to {} for cell {k}", nodes.len()), &end.to_string());
            };
            start += own.len();
            for &node in own {
                let id = text::id(i128::from(node), "node", || self.location())? as usize;
                if id >= grid.points.len() {
                    let (what, id, node) = ("element", k.to_string(), node.to_string());
                    return self.fail(MeshFileErrorKind::MissingNode { what, id, node });
                }
                grid.connectivity.push(id);
            }
            grid.cells.push((kind.unwrap_or_else(|| types[k]), grid.connectivity.len()));
        }
        Ok(())
    }

    /// The labels of the next attribute, which begins with `word` and has `n` entries.
    fn attribute(&mut self, word: &str, n: usize) -> Result<Vec<(String, Labels)>> {
        let components = match word {
            "SCALARS" => {
                let (name, kind) = (self.word("a name")?, self.word("a type")?);
                let rest = self.line().unwrap_or_default();
                let components = rest.parse::<usize>().unwrap_or(1);
                let before = self.at;
                if self.next_word().is_some_and(|word| word.eq_ignore_ascii_case("LOOKUP_TABLE")) {
                    self.word("a table")?;
                } else {
                    self.at = before.saturating_sub(1);
                }
                return Ok(vec![(name, self.array(n, components, &kind)?)]);
            }
            "FIELD" => {
                self.word("a name")?;
                let arrays = self.count("arrays", 1)?;
                let mut all = Vec::new();
                for _ in 0..arrays {
                    let name = self.word("a name")?;
                    if name.eq_ignore_ascii_case("METADATA") {
                        self.skip_metadata();
                        continue;
                    }
                    let (components, tuples) = (self.count("components", 1)?, self.count("tuples", 1)?);
                    let kind = self.word("a type")?;
                    let labels = self.array(tuples, components, &kind)?;
                    all.push((
                        name,
                        if tuples == n { labels } else { Labels::No(format!("it has {tuples} entries")) },
                    ));
                }
                return Ok(all);
            }
            "LOOKUP_TABLE" => {
                self.word("a name")?;
                let size = self.count("colours", 1)?;
                self.numbers(4 * size, if self.binary { "unsigned_char" } else { "float" })?;
                return Ok(Vec::new());
            }
            "COLOR_SCALARS" => {
                let name = self.word("a name")?;
                let components = self.count("components", 1)?;
                let kind = if self.binary { "unsigned_char" } else { "float" };
                return Ok(vec![(name, self.array(n, components, kind)?)]);
            }
            "TEXTURE_COORDINATES" => {
                let name = self.word("a name")?;
                let components = self.count("components", 1)?;
                let kind = self.word("a type")?;
                return Ok(vec![(name, self.array(n, components, &kind)?)]);
            }
            "VECTORS" | "NORMALS" => 3,
            "TENSORS" => 9,
            "TENSORS6" => 6,
            "GLOBAL_IDS" | "PEDIGREE_IDS" => 1,
            other => return self.syntax("an attribute (SCALARS, VECTORS, FIELD, ...)", other),
        };
        let (name, kind) = (self.word("a name")?, self.word("a type")?);
        Ok(vec![(name, self.array(n, components, &kind)?)])
    }

    fn array(&mut self, n: usize, components: usize, kind: &str) -> Result<Labels> {
        let n = n.saturating_mul(components);
        if ["string", "utf8_string"].iter().any(|name| kind.eq_ignore_ascii_case(name)) {
            self.skip_strings(n)?;
            return Ok(Labels::No("its values are strings".to_owned()));
        }
        let values = self.numbers(n, kind)?;
        Ok(if components == 1 {
            Labels::new(&values)
        } else {
            Labels::No(format!("it has {components} components"))
        })
    }
}
