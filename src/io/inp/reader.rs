//! Reads INP files into scopes.

use std::collections::HashMap;
use std::path::Path;

use super::super::mesh_document::MeshDocument;
use super::super::mesh_file_error::{MeshFileError, MeshFileErrorKind};
use super::super::{InputFile, Location, text};
use super::assembly::{Instance, assemble};
use super::element::{ElementKind, element_kind};
use super::keyword::Keyword;
use super::scope::{Entry, Member, Scope, SetKind, Spot};

type Result<T> = std::result::Result<T, MeshFileError>;

/// Keywords that make nodes, elements or places in ways that are not read.
const GENERATORS: [&str; 10] =
    ["NGEN", "NFILL", "NCOPY", "NMAP", "ELGEN", "ELCOPY", "SYSTEM", "SUBMODEL", "SUPER", "MESHGEN"];
const WRITE_OUT: &str = "export the nodes and elements written out";
/// How deep files may include each other.
const MAX_DEPTH: usize = 8;
/// Most bytes of all included files together: 512 MiB.
const MAX_INCLUDED: u64 = super::super::input::MESH_BYTES;
/// Most nodes, or elements, of all instances together; a set counts for as much as it takes.
const MAX_PLACED: usize = 5_000_000;

/// The mesh in the INP file `file` whose content is `bytes`, in the file's unit.
pub(in super::super) fn parse(file: &Path, bytes: &[u8]) -> Result<MeshDocument> {
    let text = text::text(file, bytes)?;
    let mut reader = Reader::new(file, bytes);
    reader.lines(&text, 0)?;
    reader.check_finished()?;
    let Reader { files, scopes, instances, instance_of, mentioned, .. } = reader;
    let mut mentions = vec![Ok(0); mentioned.len()];
    for (name, k) in mentioned {
        mentions[k as usize] = instance_of.get(&name).copied().ok_or(name);
    }
    assemble(files, &scopes, instances, &mentions)
}

/// What the data lines that follow mean.
#[derive(Clone)]
pub(super) enum Block {
    /// Nothing that is read.
    Other,
    /// The placing of an instance.
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
        kind: SetKind,
        name: String,
        generate: bool,
        instance: Option<u32>,
    },
    /// A surface of element faces, or of nodes.
    Surface {
        name: String,
        of_nodes: bool,
        instance: Option<u32>,
    },
}

pub(super) struct Reader {
    pub(super) files: Vec<InputFile>,
    pub(super) included: u64,
    pub(super) spot: Spot,
    pub(super) block: Block,
    /// The model first, then parts and instances with content of their own.
    pub(super) scopes: Vec<Scope>,
    pub(super) scope: usize,
    /// Parts by their names in capitals.
    pub(super) parts: HashMap<String, usize>,
    pub(super) instances: Vec<Instance>,
    /// Positions in `instances`, and in the list of names that sets mention, by names in capitals.
    pub(super) instance_of: HashMap<String, usize>,
    pub(super) mentioned: HashMap<String, u32>,
    /// The instance whose lines these are, until it defines something itself.
    pub(super) open_instance: Option<usize>,
    pub(super) placed: usize,
    /// Words of an element whose data goes on in the next line, with its first line.
    pub(super) unfinished: Option<(Spot, Vec<String>)>,
}

impl Reader {
    fn new(file: &Path, bytes: &[u8]) -> Self {
        Self {
            files: vec![InputFile::new(file, bytes)],
            included: 0,
            spot: Spot::default(),
            block: Block::Other,
            scopes: vec![Scope { name: "Assembly".to_owned(), ..Scope::default() }],
            scope: 0,
            parts: HashMap::new(),
            instances: Vec::new(),
            instance_of: HashMap::new(),
            mentioned: HashMap::new(),
            open_instance: None,
            placed: 0,
            unfinished: None,
        }
    }

    pub(super) fn at(&self, field: &str) -> Location {
        at(&self.files, self.spot).in_field(field)
    }

    pub(super) fn fail<T>(&self, field: &str, kind: MeshFileErrorKind) -> Result<T> {
        Err(MeshFileError::new(self.at(field), kind))
    }

    pub(super) fn syntax<T>(&self, field: &str, expected: &str, found: &str) -> Result<T> {
        let (expected, found) = (expected.to_owned(), text::shown(found));
        self.fail(field, MeshFileErrorKind::Syntax { expected, found })
    }

    fn unsupported<T>(&self, field: &str, what: impl Into<String>, fix: &'static str) -> Result<T> {
        self.fail(field, MeshFileErrorKind::UnsupportedFormat { what: what.into(), fix })
    }

    fn lines(&mut self, text: &str, depth: usize) -> Result<()> {
        let file = self.spot.file;
        let mut lines = text.lines().enumerate().peekable();
        while let Some((k, line)) = lines.next() {
            self.spot = Spot { file, line: k as u32 + 1 };
            let line = line.trim();
            if line.is_empty() || line.starts_with("**") {
                continue;
            }
            let Some(keyword) = line.strip_prefix('*') else {
                self.data(line)?;
                continue;
            };
            let mut keyword = keyword.to_owned();
            // A comma at its end continues a keyword line, unless some program only left it there.
            while keyword.ends_with(',') {
                let more =
                    |line: &str| line.starts_with("**") || line.starts_with(|c: char| c.is_alphabetic());
                let Some((_, next)) = lines.next_if(|(_, next)| more(next.trim())) else { break };
                if !next.trim().starts_with("**") {
                    keyword += next.trim();
                }
            }
            self.keyword(&keyword, depth)?;
        }
        Ok(())
    }

    /// Reads the lines of the file `name` as if they stood here.
    fn include(&mut self, name: &str, depth: usize) -> Result<()> {
        let near = |file: &InputFile| file.path.parent().unwrap_or(Path::new("")).join(name);
        let (here, beside) = (near(&self.files[0]), near(&self.files[self.spot.file as usize]));
        let path = if here.exists() { here } else { beside };
        if depth + 1 >= MAX_DEPTH {
            return self.unsupported(
                "INPUT",
                "an include within eight others",
                "include it from the first file",
            );
        }
        let bytes = text::read_bytes(&path)?;
        self.included += bytes.len() as u64;
        if self.included > MAX_INCLUDED {
            let (what, most) = ("bytes of included files".to_owned(), MAX_INCLUDED);
            return self.fail("INPUT", MeshFileErrorKind::TooMuch { what, most });
        }
        let text = text::text(&path, &bytes)?;
        let plausible = |c: char| c == '*' || c.is_ascii_digit() || "+-.".contains(c);
        if !text.trim_start().starts_with(plausible) {
            return self.fail("INPUT", MeshFileErrorKind::Unrecognised { formats: "Abaqus file".to_owned() });
        }
        let back = self.spot;
        self.spot.file = self.files.len() as u32;
        self.files.push(InputFile::new(&path, &bytes));
        self.lines(&text, depth + 1)?;
        self.spot = back;
        Ok(())
    }

    fn keyword(&mut self, line: &str, depth: usize) -> Result<()> {
        self.check_finished()?;
        let keyword = Keyword::parse(line);
        let name = keyword.name.as_str();
        if GENERATORS.contains(&name) {
            return self.unsupported(name, format!("*{name}"), WRITE_OUT);
        }
        if let Some((parameter, known)) = keyword.unknown() {
            let (expected, found) =
                (format!("a parameter of *{name} that is read ({known})"), text::shown(parameter));
            return self.fail(parameter, MeshFileErrorKind::Syntax { expected, found });
        }
        let instance = keyword.get("INSTANCE").map(|instance| self.mention(instance));
        if matches!(name, "NODE" | "ELEMENT" | "NSET" | "ELSET" | "SURFACE") {
            self.own_scope()?;
        }
        let text = |key: &str| keyword.get(key).map(str::to_owned);
        self.block = match name {
            "PART" => self.part(&keyword, line)?,
            "ENDPART" | "ASSEMBLY" | "ENDASSEMBLY" | "ENDINSTANCE" => {
                (self.scope, self.open_instance) = (0, None);
                if let Some(assembly) = text("NAME").filter(|_| name == "ASSEMBLY") {
                    self.scopes[0].name = assembly;
                }
                Block::Other
            }
            "INSTANCE" => self.instance(&keyword, line)?,
            "INCLUDE" => {
                let Some(input) = text("INPUT") else { return self.syntax("INCLUDE", "INPUT=file", line) };
                // Data of the block that is open may go on in the file, and after it.
                return self.include(&input, depth);
            }
            "NODE" => {
                if keyword.get("SYSTEM").is_some_and(|s| !s.eq_ignore_ascii_case("R")) {
                    return self.unsupported("SYSTEM", "a curvilinear coordinate system", WRITE_OUT);
                }
                Block::Nodes { set: text("NSET") }
            }
            "ELEMENT" => {
                let Some(kind_name) = text("TYPE") else { return self.syntax("ELEMENT", "TYPE=", line) };
                let Some(kind) = element_kind(&kind_name) else {
                    let id = format!("(block of line {})", self.spot.line);
                    return self.fail("TYPE", MeshFileErrorKind::UnsupportedElement { id, name: kind_name });
                };
                Block::Elements { kind, name: kind_name, set: text("ELSET") }
            }
            "NSET" | "ELSET" => {
                let Some(set) = text(name).filter(|set| !set.is_empty()) else {
                    return self.syntax(name, &format!("{name}=name"), line);
                };
                let kind = if name == "NSET" { SetKind::Nodes } else { SetKind::Elements };
                self.scopes[self.scope].set(kind, &set);
                if let Some(elements) = keyword.get("ELSET").filter(|_| kind == SetKind::Nodes) {
                    self.entry(kind, &set, Member::NodesOf(elements.into()), instance);
                }
                Block::Set { kind, name: set, generate: keyword.has("GENERATE"), instance }
            }
            "SURFACE" => {
                let Some(set) = text("NAME").filter(|set| !set.is_empty()) else {
                    return self.syntax("SURFACE", "NAME=name", line);
                };
                let of_nodes = keyword.get("TYPE").is_some_and(|t| t.eq_ignore_ascii_case("NODE"));
                let of_faces = keyword.get("TYPE").is_none_or(|t| t.eq_ignore_ascii_case("ELEMENT"));
                // Combined and analytical surfaces are no lists of faces.
                if keyword.has("COMBINE") || !(of_nodes || of_faces) {
                    Block::Other
                } else {
                    self.scopes[self.scope].set(SetKind::Surface, &set);
                    Block::Surface { name: set, of_nodes, instance }
                }
            }
            _ => Block::Other,
        };
        match keyword.get("INPUT") {
            Some(input) if matches!(name, "NODE" | "ELEMENT" | "NSET" | "ELSET") => {
                self.include(input, depth)
            }
            _ => Ok(()),
        }
    }

    fn part(&mut self, keyword: &Keyword, line: &str) -> Result<Block> {
        let Some(name) = keyword.get("NAME").filter(|name| !name.is_empty()) else {
            return self.syntax("PART", "NAME=name", line);
        };
        self.scope = self.scopes.len();
        if self.parts.insert(name.to_ascii_uppercase(), self.scope).is_some() {
            return self.syntax("NAME", "another name for a second part", name);
        }
        self.scopes.push(Scope { name: name.to_owned(), ..Scope::default() });
        Ok(Block::Other)
    }

    fn instance(&mut self, keyword: &Keyword, line: &str) -> Result<Block> {
        let (Some(name), Some(part)) = (keyword.get("NAME"), keyword.get("PART")) else {
            return self.syntax("INSTANCE", "NAME=name, PART=part", line);
        };
        let Some(&scope) = self.parts.get(&part.to_ascii_uppercase()) else {
            return self.syntax("PART", "the name of a *PART above", part);
        };
        if self.instance_of.insert(name.to_ascii_uppercase(), self.instances.len()).is_some() {
            return self.syntax("NAME", "another name for a second instance", name);
        }
        self.place(scope)?;
        (self.scope, self.open_instance) = (0, Some(self.instances.len()));
        self.instances.push(Instance::new(name, scope));
        Ok(Block::Instance)
    }

    /// Counts what another instance of scope `scope` adds to the mesh.
    fn place(&mut self, scope: usize) -> Result<()> {
        let scope = &self.scopes[scope];
        // An instance of nothing costs something too.
        self.placed += 1 + scope.points.len().max(scope.elements.len()) + 16 * scope.sets.len();
        if self.placed > MAX_PLACED {
            let (what, most) = ("nodes of all instances".to_owned(), MAX_PLACED as u64);
            return self.fail("INSTANCE", MeshFileErrorKind::TooMuch { what, most });
        }
        Ok(())
    }

    /// Gives an instance that defines something itself a scope of its own, a copy of its part's.
    fn own_scope(&mut self) -> Result<()> {
        let Some(instance) = self.open_instance.take() else { return Ok(()) };
        let part = self.instances[instance].scope;
        self.place(part)?;
        self.scope = self.scopes.len();
        self.scopes.push(self.scopes[part].clone());
        self.instances[instance].scope = self.scope;
        Ok(())
    }

    fn mention(&mut self, instance: &str) -> u32 {
        let next = self.mentioned.len() as u32;
        *self.mentioned.entry(instance.to_ascii_uppercase()).or_insert(next)
    }

    pub(super) fn entry(&mut self, kind: SetKind, name: &str, member: Member, instance: Option<u32>) {
        let entry = Entry { member, instance, spot: self.spot };
        self.scopes[self.scope].set(kind, name).entries.push(entry);
    }
}

/// The place `spot` of `files`.
pub(super) fn at(files: &[InputFile], spot: Spot) -> Location {
    Location::file(&files[spot.file as usize].path).at_line(spot.line as usize)
}

/// Whether a member of a set is a number and no name.
pub(super) fn is_number(word: &str) -> bool {
    word.starts_with(|c: char| c.is_ascii_digit() || c == '-' || c == '+')
}
