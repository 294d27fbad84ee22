//! Reads MSH files.

use std::collections::{BTreeMap, HashMap};
use std::path::Path;

use super::super::mesh_document::MeshDocument;
use super::super::mesh_file_error::{MAX_MEMBERS, MeshFileError, MeshFileErrorKind};
use super::super::numbered::{NumberedMesh, Place};
use super::super::text;
use super::cursor::Cursor;
use super::element::{ElementType, element_type, reorder};
use crate::mesh::{CellKind, MAX_NODES};
use crate::units::Vec3;

type Result<T> = std::result::Result<T, MeshFileError>;

/// What a group without a name is called, by dimension, before `=` and its number.
pub(super) const DIMENSIONS: [&str; 4] = ["point", "curve", "surface", "volume"];
const EXPORT: &str = "save as MSH 2.2 or 4.1 (`gmsh -3 -format msh41`)";

/// The mesh in the MSH file `file` whose content is `bytes`, in the file's unit.
pub(in super::super) fn parse(file: &Path, bytes: &[u8]) -> Result<MeshDocument> {
    let bytes = text::without_bom(bytes);
    let mut reader = Reader {
        cursor: Cursor::new(file, bytes),
        mesh: NumberedMesh::new(file),
        names: HashMap::new(),
        physical: HashMap::new(),
        groups: BTreeMap::new(),
        n_members: 0,
        cells: HashMap::new(),
    };
    let four = reader.format(file, bytes)?;
    while let Some(section) = reader.cursor.section()? {
        match section.as_str() {
            "PhysicalNames" => reader.physical_names()?,
            "Entities" if four => reader.entities(false)?,
            "PartitionedEntities" if four => reader.partitioned_entities()?,
            "Nodes" if four => reader.nodes_4()?,
            "Elements" if four => reader.elements_4()?,
            "Nodes" => reader.nodes_2()?,
            "Elements" => reader.elements_2()?,
            _ => reader.cursor.skip_section()?,
        }
    }
    reader.named_groups()?;
    reader.mesh.finish()
}

pub(super) struct Reader<'a> {
    pub(super) cursor: Cursor<'a>,
    pub(super) mesh: NumberedMesh<'a>,
    /// Names of physical groups by dimension and number.
    pub(super) names: HashMap<(usize, i128), String>,
    /// Physical groups of entities by dimension and number.
    pub(super) physical: HashMap<(usize, i128), Vec<i128>>,
    /// Nodes or, of dimension 3, elements of each physical group, with the places of the elements.
    pub(super) groups: BTreeMap<(usize, i128), Vec<(u64, Place)>>,
    pub(super) n_members: usize,
    /// The element that has these nodes: version 2 repeats a cell that is in two groups.
    pub(super) cells: HashMap<(CellKind, [u64; MAX_NODES]), u64>,
}

impl Reader<'_> {
    /// Reads the header; returns whether the version is 4.1.
    fn format(&mut self, file: &Path, bytes: &[u8]) -> Result<bool> {
        if !self.cursor.go_to(b"$MeshFormat") {
            text::text(file, bytes)?;
            let kind = match self.cursor.go_to(b"$NOD") {
                true => {
                    let what = "MSH version 1".to_owned();
                    MeshFileErrorKind::UnsupportedFormat { what, fix: EXPORT }
                }
                false => {
                    let expected = "$MeshFormat".to_owned();
                    MeshFileErrorKind::Syntax { expected, found: "another section".to_owned() }
                }
            };
            return self.cursor.fail("version", kind);
        }
        self.cursor.line();
        let at = self.cursor.location("version");
        let line = self.cursor.line().unwrap_or_default();
        let words: Vec<&str> = line.split_whitespace().collect();
        let unsupported = |what: String| {
            let kind = MeshFileErrorKind::UnsupportedFormat { what, fix: EXPORT };
            Err(MeshFileError::new(at.clone(), kind))
        };
        let [version, kind, size] = words[..] else {
            let expected = "version, file type and data size".to_owned();
            return Err(MeshFileError::new(
                at,
                MeshFileErrorKind::Syntax { expected, found: text::shown(&line) },
            ));
        };
        let four = match version {
            "2.2" | "2" | "2.0" | "2.1" => false,
            "4.1" => true,
            _ => return unsupported(format!("MSH version {}", text::shown(version))),
        };
        if kind == "1" {
            if size != "8" {
                return unsupported(format!("binary MSH with data size {}", text::shown(size)));
            }
            self.cursor.binary = Some(false);
            match self.cursor.int("byte order")? {
                1 => {}
                0x0100_0000 => self.cursor.binary = Some(true),
                one => return unsupported(format!("a byte order in which 1 reads {one}")),
            }
        } else {
            text::text(file, bytes)?;
        }
        self.cursor.end_section("rows", 0)?;
        Ok(four)
    }

    fn point(&mut self) -> Result<Vec3> {
        let c = &mut self.cursor;
        Ok(Vec3::new(c.double("x")?, c.double("y")?, c.double("z")?))
    }

    fn nodes_2(&mut self) -> Result<()> {
        let n = self.count_2("nodes", 28)?;
        for k in 0..n {
            self.cursor.begin_row("nodes", k, n)?;
            let place = self.cursor.place();
            let id = self.cursor.int("node")?;
            let id = self.cursor.id(id, "node")?;
            let point = self.point()?;
            self.mesh.node(id, point, place)?;
            self.cursor.end_row()?;
        }
        self.cursor.end_section("nodes", n)
    }

    /// The count at the start of a section of version 2, which is text even in a binary file.
    fn count_2(&mut self, what: &str, bytes_each: usize) -> Result<usize> {
        let at = self.cursor.location(what);
        let line = self.cursor.line().unwrap_or_default();
        let declared = text::integer(&line, || at.clone())?;
        self.cursor.count(declared, what, bytes_each).map_err(|e| MeshFileError::new(at, e.kind))
    }

    fn elements_2(&mut self) -> Result<()> {
        let n = self.count_2("elements", 4)?;
        let mut done = 0;
        while done < n {
            self.cursor.begin_row("elements", done, n)?;
            // In text each row has its own type; in binary a header stands for many rows.
            let binary = self.cursor.binary.is_some();
            let first = if binary { 0 } else { self.cursor.int("element")? };
            let kind = self.cursor.int("type")?;
            let rows = if binary {
                let declared = self.cursor.int("rows")?;
                self.cursor.count(declared, "elements", 4)?.max(1)
            } else {
                1
            };
            let declared = self.cursor.int("tags")?;
            let n_tags = self.cursor.count(declared, "tags", 4)?;
            for _ in 0..rows {
                let id = if binary { self.cursor.int("element")? } else { first };
                let mut groups = Vec::new();
                for tag in 0..n_tags {
                    let value = self.cursor.int("tag")?;
                    // The first tag is the physical group, 0 if there is none.
                    if tag == 0 && value != 0 {
                        groups.push(value.abs());
                    }
                }
                self.element(id, kind, &groups)?;
                self.cursor.end_row()?;
            }
            done += rows;
        }
        self.cursor.end_section("elements", n)
    }

    /// Reads the nodes of element `id` of Gmsh type `kind` and adds it.
    fn element(&mut self, id: i128, kind: i128, groups: &[i128]) -> Result<()> {
        let place = self.cursor.place();
        let id = self.cursor.id(id, "element")?;
        let element_type = element_type(kind);
        let (dimension, n) = match &element_type {
            ElementType::Cell(_, n, _) => (3, *n),
            ElementType::Lower(dimension, n) => (*dimension, *n),
            ElementType::Unsupported(name) => {
                let kind = MeshFileErrorKind::UnsupportedElement { id: id.to_string(), name: name.clone() };
                return self.cursor.fail("type", kind);
            }
        };
        let mut nodes = Vec::with_capacity(n);
        for _ in 0..n {
            let node = self.cursor.node_number()?;
            nodes.push(self.cursor.id(node, "node")?);
        }
        let mut member = id;
        match element_type {
            ElementType::Cell(kind, _, name) => {
                reorder(kind, &mut nodes);
                let mut key = [0; MAX_NODES];
                key.iter_mut().zip(&nodes).take(kind.n_nodes()).for_each(|(k, node)| *k = *node);
                let known = if self.cursor.wide_nodes { None } else { self.cells.get(&(kind, key)) };
                match known {
                    // Version 4 has an element once, with all its groups.
                    Some(same) if !groups.is_empty() => member = *same,
                    _ => {
                        self.mesh.element(id, kind, name, &nodes, place)?;
                        if !self.cursor.wide_nodes {
                            self.cells.insert((kind, key), id);
                        }
                    }
                }
            }
            _ if !self.cursor.wide_nodes && self.mesh.is_lower(id) => {}
            _ => self.mesh.lower_element(id, place)?,
        }
        for &group in groups {
            let members = self.groups.entry((dimension, group)).or_default();
            let before = members.len();
            match dimension {
                3 => members.push((member, place)),
                _ => members.extend(nodes.iter().map(|node| (*node, place))),
            }
            self.n_members += members.len() - before;
            if self.n_members > MAX_MEMBERS {
                let (what, most) = ("members of all groups together".to_owned(), MAX_MEMBERS as u64);
                return self.cursor.fail("physical group", MeshFileErrorKind::TooMuch { what, most });
            }
        }
        Ok(())
    }

    /// The header of nodes or elements of version 4: number of blocks and of entries.
    fn head_4(&mut self, what: &str) -> Result<(usize, usize)> {
        let c = &mut self.cursor;
        c.wide_nodes = true;
        c.begin_row(what, 0, 1)?;
        let (blocks, entries) = (c.size("blocks")?, c.size(what)?);
        let (blocks, entries) = (c.count(blocks, "blocks", 20)?, c.count(entries, what, 8)?);
        c.size("least number")?;
        c.size("greatest number")?;
        c.end_row()?;
        Ok((blocks, entries))
    }

    fn nodes_4(&mut self) -> Result<()> {
        let (blocks, entries) = self.head_4("nodes")?;
        let before = self.mesh.n_nodes();
        for block in 0..blocks {
            let c = &mut self.cursor;
            c.begin_row("node blocks", block, blocks)?;
            let (dimension, _) = (c.int("dimension")?, c.int("entity")?);
            let parametric = c.int("parametric")? != 0;
            let n = c.size("nodes")?;
            let n = c.count(n, "nodes", 32)?;
            c.end_row()?;
            let mut ids = Vec::with_capacity(n);
            for k in 0..n {
                c.begin_row("nodes", k, n)?;
                let id = c.size("node")?;
                ids.push((c.id(id, "node")?, c.place()));
                c.end_row()?;
            }
            for (k, (id, place)) in ids.into_iter().enumerate() {
                self.cursor.begin_row("node positions", k, n)?;
                let point = self.point()?;
                for _ in 0..if parametric { dimension.clamp(0, 3) } else { 0 } {
                    self.cursor.double("parameter")?;
                }
                self.cursor.end_row()?;
                self.mesh.node(id, point, place)?;
            }
        }
        let found = self.mesh.n_nodes() - before;
        self.end_4("nodes", entries, found)
    }

    fn elements_4(&mut self) -> Result<()> {
        let (blocks, entries) = self.head_4("elements")?;
        let before = self.mesh.n_elements();
        for block in 0..blocks {
            let c = &mut self.cursor;
            c.begin_row("element blocks", block, blocks)?;
            let (dimension, entity) = (c.int("dimension")?, c.int("entity")?);
            let kind = c.int("type")?;
            let n = c.size("elements")?;
            let n = c.count(n, "elements", 16)?;
            c.end_row()?;
            let key = (usize::try_from(dimension).unwrap_or(usize::MAX), entity);
            let groups: Vec<i128> = self.physical.get(&key).cloned().unwrap_or_default();
            for k in 0..n {
                self.cursor.begin_row("elements", k, n)?;
                let id = self.cursor.size("element")?;
                self.element(id, kind, &groups)?;
                self.cursor.end_row()?;
            }
        }
        let found = self.mesh.n_elements() - before;
        self.end_4("elements", entries, found)
    }

    fn end_4(&mut self, what: &str, declared: usize, found: usize) -> Result<()> {
        self.cursor.end_section(what, found)?;
        if declared == found {
            return Ok(());
        }
        let (what, declared, found) = (what.to_owned(), declared as u64, found as u64);
        self.cursor.fail("count", MeshFileErrorKind::CountMismatch { what, declared, found })
    }
}
