//! Abaqus INP: nodes, elements and sets of one flat mesh.

use std::collections::BTreeMap;
use std::path::Path;

use super::mesh_file_error::{MeshFileError, MeshFileErrorKind};
use super::numbered::{NumberedMesh, Place};
use super::{Location, text};
use crate::mesh::{CellKind, Mesh};
use crate::units::Vec3;

type Result<T> = std::result::Result<T, MeshFileError>;

/// Keywords that make nodes, elements or places in ways that are not read.
const GENERATORS: [&str; 11] = [
    "INCLUDE", "NGEN", "NFILL", "NCOPY", "NMAP", "ELGEN", "ELCOPY", "SYSTEM", "SUBMODEL", "SUPER", "MESHGEN",
];
const FLATTEN: &str = "export one flat part with its nodes and elements written out";

/// The mesh in the INP file `file` whose content is `bytes`, in the file's unit.
pub(super) fn parse(file: &Path, bytes: &[u8]) -> Result<Mesh> {
    let text = text::text(file, bytes)?;
    let mut reader = Reader::new(file);
    for (k, line) in text.lines().enumerate() {
        reader.line = k + 1;
        let line = line.trim();
        if line.is_empty() || line.starts_with("**") {
            continue;
        }
        match line.strip_prefix('*') {
            Some(keyword) => reader.keyword(keyword)?,
            None => reader.data(line)?,
        }
    }
    reader.finish()
}

/// What the data lines that follow mean.
enum Block {
    /// Nothing that is read.
    Other,
    /// An instance, whose data lines would move it.
    Instance,
    Nodes {
        set: Option<String>,
    },
    Elements {
        kind: ElementKind,
        name: String,
        set: Option<String>,
    },
    Set {
        nodes: bool,
        name: String,
        generate: bool,
    },
}

enum ElementKind {
    Cell(CellKind),
    /// A spring, line, shell or surface element, of which only the nodes are kept, as a set.
    Lower,
}

#[derive(Default)]
struct Named {
    /// Numbers with the line that lists them.
    members: Vec<(u64, usize)>,
    /// Names of other sets with the line that lists them.
    sets: Vec<(String, usize)>,
}

struct Reader<'a> {
    file: &'a Path,
    line: usize,
    mesh: NumberedMesh<'a>,
    block: Block,
    parts: usize,
    instances: usize,
    /// Words of an element whose data goes on in the next line, with its first line.
    unfinished: Option<(usize, Vec<String>)>,
    /// Sets by whether they hold nodes and by upper-case name, with the name as first written.
    sets: BTreeMap<(bool, String), (String, Named)>,
}

impl<'a> Reader<'a> {
    fn new(file: &'a Path) -> Self {
        Self {
            file,
            line: 0,
            mesh: NumberedMesh::new(file),
            block: Block::Other,
            parts: 0,
            instances: 0,
            unfinished: None,
            sets: BTreeMap::new(),
        }
    }

    fn at(&self, field: &str) -> Location {
        Location::file(self.file).at_line(self.line).in_field(field)
    }

    fn fail<T>(&self, field: &str, kind: MeshFileErrorKind) -> Result<T> {
        Err(MeshFileError::new(self.at(field), kind))
    }

    fn syntax<T>(&self, field: &str, expected: &str, found: &str) -> Result<T> {
        let (expected, found) = (expected.to_owned(), found.to_owned());
        self.fail(field, MeshFileErrorKind::Syntax { expected, found })
    }

    fn set(&mut self, nodes: bool, name: &str) -> &mut Named {
        let key = (nodes, name.to_ascii_uppercase());
        &mut self.sets.entry(key).or_insert_with(|| (name.to_owned(), Named::default())).1
    }

    fn keyword(&mut self, line: &str) -> Result<()> {
        self.check_finished()?;
        let mut words = line.split(',').map(str::trim);
        let keyword = words.next().unwrap_or_default().to_ascii_uppercase();
        let parameters: Vec<(String, &str)> = words
            .map(|word| match word.split_once('=') {
                Some((key, value)) => (key.trim().to_ascii_uppercase(), value.trim().trim_matches('"')),
                None => (word.to_ascii_uppercase(), ""),
            })
            .collect();
        let parameter = |key: &str| parameters.iter().find(|(k, _)| k == key).map(|(_, v)| (*v).to_owned());
        let unsupported = |what: &str| {
            let what = what.to_owned();
            MeshFileErrorKind::UnsupportedFormat { what, fix: FLATTEN }
        };
        if GENERATORS.contains(&keyword.as_str()) {
            return self.fail(&keyword, unsupported(&format!("*{keyword}")));
        }
        if parameter("INPUT").is_some() && matches!(keyword.as_str(), "NODE" | "ELEMENT" | "NSET" | "ELSET") {
            return self.fail(&keyword, unsupported("INPUT= of another file"));
        }
        self.block = match keyword.as_str() {
            "PART" => {
                self.parts += 1;
                if self.parts > 1 {
                    return self.fail("PART", unsupported("a second *PART"));
                }
                Block::Other
            }
            "INSTANCE" => {
                self.instances += 1;
                if self.instances > 1 {
                    return self.fail("INSTANCE", unsupported("a second *INSTANCE"));
                }
                Block::Instance
            }
            "NODE" => {
                if parameter("SYSTEM").is_some_and(|s| !s.eq_ignore_ascii_case("R")) {
                    return self.fail("SYSTEM", unsupported("a curvilinear coordinate system"));
                }
                Block::Nodes { set: parameter("NSET") }
            }
            "ELEMENT" => {
                let Some(name) = parameter("TYPE") else {
                    return self.syntax("ELEMENT", "TYPE=", line);
                };
                match element_kind(&name.to_ascii_uppercase()) {
                    Some(kind) => Block::Elements { kind, name, set: parameter("ELSET") },
                    None => {
                        let id = format!("(block of line {})", self.line);
                        return self.fail("TYPE", MeshFileErrorKind::UnsupportedElement { id, name });
                    }
                }
            }
            "NSET" | "ELSET" => {
                let Some(name) = parameter(&keyword).filter(|name| !name.is_empty()) else {
                    return self.syntax(&keyword, &format!("{keyword}=name"), line);
                };
                let nodes = keyword == "NSET";
                self.set(nodes, &name);
                Block::Set { nodes, name, generate: parameter("GENERATE").is_some() }
            }
            _ => Block::Other,
        };
        Ok(())
    }

    fn data(&mut self, line: &str) -> Result<()> {
        let words: Vec<&str> = line.trim_end_matches(',').split(',').map(str::trim).collect();
        // Taken out so that the block can be read while the mesh is written.
        let block = std::mem::replace(&mut self.block, Block::Other);
        let done = match &block {
            Block::Other => Ok(()),
            Block::Instance => {
                let what = "an instance that is moved".to_owned();
                self.fail("INSTANCE", MeshFileErrorKind::UnsupportedFormat { what, fix: FLATTEN })
            }
            Block::Nodes { set } => self.node(&words, set.as_deref()),
            Block::Elements { kind, name, set } => {
                self.element_words(&words, kind, name, set.as_deref(), line.ends_with(','))
            }
            Block::Set { nodes, name, generate: true } => self.generate(&words, *nodes, name),
            Block::Set { nodes, name, generate: false } => self.members(&words, *nodes, name),
        };
        self.block = block;
        done
    }

    fn id(&self, word: &str, what: &'static str) -> Result<u64> {
        let value = text::integer(word, || self.at(what))?;
        text::id(value, what, || self.at(what))
    }

    fn node(&mut self, words: &[&str], set: Option<&str>) -> Result<()> {
        let id = self.id(words[0], "node")?;
        // Commas part the fields here, so decimal commas show as twice as many whole numbers.
        let digits =
            |w: &&str| !w.is_empty() && w.trim_start_matches('-').bytes().all(|b| b.is_ascii_digit());
        if words.len() > 4 && words[1..].iter().all(digits) {
            let (value, fixed) = (words[1..].join(","), words[1..3].join("."));
            return self.fail("x", MeshFileErrorKind::DecimalComma { value, fixed });
        }
        if words.len() != 4 && words.len() != 7 {
            return self.syntax("node", "number, x, y, z", &words.join(", "));
        }
        let mut point = Vec3::zeros();
        for ((x, word), field) in point.iter_mut().zip(&words[1..]).zip(["x", "y", "z"]) {
            *x = text::number(word, || self.at(field))?;
        }
        let line = self.line;
        self.mesh.node(id, point, Place::Line(line))?;
        if let Some(name) = set {
            self.set(true, name).members.push((id, line));
        }
        Ok(())
    }

    fn element_words(
        &mut self,
        words: &[&str],
        kind: &ElementKind,
        name: &str,
        set: Option<&str>,
        goes_on: bool,
    ) -> Result<()> {
        let (first, mut all) = self.unfinished.take().unwrap_or((self.line, Vec::new()));
        all.extend(words.iter().map(|w| (*w).to_owned()));
        let wanted = match kind {
            ElementKind::Cell(kind) => 1 + kind.n_nodes(),
            ElementKind::Lower if goes_on => usize::MAX,
            ElementKind::Lower => all.len(),
        };
        if all.len() < wanted && goes_on {
            self.unfinished = Some((first, all));
            return Ok(());
        }
        if all.len() != wanted {
            let expected = format!("a number and {} nodes of {name}", wanted - 1);
            return self.syntax("element", &expected, &format!("{} fields", all.len()));
        }
        let id = self.id(&all[0], "element")?;
        let nodes = all[1..].iter().map(|w| self.id(w, "node")).collect::<Result<Vec<u64>>>()?;
        let place = Place::Line(first);
        match kind {
            ElementKind::Cell(kind) => {
                self.mesh.element(id, *kind, &nodes, place)?;
                if let Some(name) = set {
                    self.set(false, name).members.push((id, first));
                }
            }
            ElementKind::Lower => {
                self.mesh.lower_element(id, place)?;
                if let Some(name) = set {
                    self.set(true, name).members.extend(nodes.into_iter().map(|node| (node, first)));
                }
            }
        }
        Ok(())
    }

    fn members(&mut self, words: &[&str], nodes: bool, name: &str) -> Result<()> {
        let line = self.line;
        for word in words.iter().filter(|w| !w.is_empty()) {
            if word.starts_with(|c: char| c.is_ascii_digit() || c == '-' || c == '+') {
                let id = self.id(word, if nodes { "node" } else { "element" })?;
                self.set(nodes, name).members.push((id, line));
            } else {
                let other = word.trim_matches('"').to_owned();
                self.set(nodes, name).sets.push((other, line));
            }
        }
        Ok(())
    }

    fn generate(&mut self, words: &[&str], nodes: bool, name: &str) -> Result<()> {
        let what = if nodes { "node" } else { "element" };
        let (first, last, step) = match *words {
            [first, last] => (first, last, "1"),
            [first, last, step] => (first, last, step),
            _ => return self.syntax(name, "first, last, step", &words.join(", ")),
        };
        let (first, last) = (self.id(first, what)?, self.id(last, what)?);
        let step = self.id(step, "step")?;
        if step == 0 || last < first {
            return self.syntax(name, "first <= last and a step of 1 or more", &words.join(", "));
        }
        let declared = (last - first) / step + 1;
        let known = if nodes { self.mesh.n_nodes() } else { self.mesh.n_elements() } as u64;
        if declared > known {
            let what = format!("{what}s");
            return self.fail(name, MeshFileErrorKind::DeclaredTooMany { what, declared, most: known });
        }
        let line = self.line;
        let members = (0..declared).map(|k| (first + k * step, line));
        self.set(nodes, name).members.extend(members);
        Ok(())
    }

    fn check_finished(&mut self) -> Result<()> {
        match self.unfinished.take() {
            None => Ok(()),
            Some((line, words)) => {
                let expected = format!("the other nodes of element {} of line {line}", words[0]);
                self.fail("element", MeshFileErrorKind::Truncated { expected })
            }
        }
    }

    fn finish(mut self) -> Result<Mesh> {
        self.check_finished()?;
        for ((nodes, _), (name, set)) in &self.sets {
            let add = if *nodes { NumberedMesh::add_to_node_set } else { NumberedMesh::add_to_element_set };
            add(&mut self.mesh, name, &[], Place::Line(1));
            let mut open: Vec<&Named> = vec![set];
            let mut seen = vec![name.to_ascii_uppercase()];
            while let Some(set) = open.pop() {
                for &(id, line) in &set.members {
                    add(&mut self.mesh, name, &[id], Place::Line(line));
                }
                for (other, line) in &set.sets {
                    let key = other.to_ascii_uppercase();
                    if seen.contains(&key) {
                        continue;
                    }
                    let Some((_, other_set)) = self.sets.get(&(*nodes, key.clone())) else {
                        let of_kind = self.sets.iter().filter(|(k, _)| k.0 == *nodes);
                        let known: Vec<&str> = of_kind.map(|(_, (name, _))| name.as_str()).collect();
                        let at = Location::file(self.file).at_line(*line).in_field(name.clone());
                        let (name, known) = (other.clone(), known.join(", "));
                        return Err(MeshFileError::new(at, MeshFileErrorKind::UnknownSet { name, known }));
                    };
                    seen.push(key);
                    open.push(other_set);
                }
            }
        }
        self.mesh.finish()
    }
}

/// What Abaqus element `name` (upper case) is here, or `None` if it is not read.
fn element_kind(name: &str) -> Option<ElementKind> {
    const LOWER: [&str; 16] = [
        "S3", "S4", "S6", "S8", "STRI", "T2D", "T3D", "B2", "B3", "CPS", "CPE", "M3D", "R3D", "SFM3D",
        "SPRING", "MASS",
    ];
    // Letters after the number of nodes choose the formulation (R, H, I, ...), which is ours anyway.
    let kind = match name.trim_end_matches(|c: char| c.is_ascii_alphabetic()) {
        "C3D8" => CellKind::Hex8,
        "C3D6" => CellKind::Wedge6,
        "C3D4" => CellKind::Tet4,
        "C3D10" => CellKind::Tet10,
        _ => return LOWER.iter().any(|l| name.starts_with(l)).then_some(ElementKind::Lower),
    };
    Some(ElementKind::Cell(kind))
}
