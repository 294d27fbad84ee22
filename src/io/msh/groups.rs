//! Physical groups: which entities they have, their names, and the sets that they make.

use std::collections::HashMap;

use super::super::mesh_file_error::{MAX_MEMBERS, MeshFileError, MeshFileErrorKind};
use super::super::numbered::NumberedMesh;
use super::super::text;
use super::reader::{DIMENSIONS, Reader};

type Result<T> = std::result::Result<T, MeshFileError>;

impl Reader<'_> {
    pub(super) fn physical_names(&mut self) -> Result<()> {
        let count = self.cursor.line().unwrap_or_default();
        let n = text::integer(&count, || self.cursor.location("count"))?;
        let n = self.cursor.count(n, "names", 2)?;
        for k in 0..n {
            self.cursor.skip_blank();
            let at = self.cursor.location("name");
            let line = self.cursor.line().unwrap_or_default();
            if line.starts_with('$') || line.is_empty() {
                let (what, declared, found) = ("names".to_owned(), n as u64, k as u64);
                return Err(MeshFileError::new(
                    at,
                    MeshFileErrorKind::CountMismatch { what, declared, found },
                ));
            }
            let Some((dimension, tag, name)) = physical_name(&line) else {
                let expected = "dimension, number and \"name\"".to_owned();
                let found = text::shown(&line);
                return Err(MeshFileError::new(at, MeshFileErrorKind::Syntax { expected, found }));
            };
            self.names.insert((dimension, tag), name.to_owned());
        }
        self.cursor.end_section("names", n)
    }

    /// Entities of a partition, each of which is a part of a parent entity.
    pub(super) fn partitioned_entities(&mut self) -> Result<()> {
        let c = &mut self.cursor;
        c.begin_row("partitions", 0, 1)?;
        c.size("partitions")?;
        c.end_row()?;
        c.begin_row("ghost entities", 0, 1)?;
        let declared = c.size("ghost entities")?;
        let n = c.count(declared, "ghost entities", 8)?;
        c.end_row()?;
        for k in 0..n {
            c.begin_row("ghost entities", k, n)?;
            c.int("ghost entity")?;
            c.int("partition")?;
            c.end_row()?;
        }
        self.entities(true)
    }

    pub(super) fn entities(&mut self, partitioned: bool) -> Result<()> {
        let c = &mut self.cursor;
        c.begin_row("entities", 0, 1)?;
        let mut counts = [0; 4];
        for (count, name) in counts.iter_mut().zip(DIMENSIONS) {
            let declared = c.size(name)?;
            *count = c.count(declared, name, 4)?;
        }
        c.end_row()?;
        for (dimension, &count) in counts.iter().enumerate() {
            for k in 0..count {
                c.begin_row(DIMENSIONS[dimension], k, count)?;
                let tag = c.int("entity")?;
                let mut parent = None;
                if partitioned {
                    let (parent_dimension, parent_tag) =
                        (c.int("parent dimension")?, c.int("parent entity")?);
                    parent = Some((usize::try_from(parent_dimension).unwrap_or(usize::MAX), parent_tag));
                    let declared = c.size("partitions")?;
                    for _ in 0..c.count(declared, "partitions", 4)? {
                        c.int("partition")?;
                    }
                }
                for _ in 0..if dimension == 0 { 3 } else { 6 } {
                    c.double("bounds")?;
                }
                let declared = c.size("physical groups")?;
                let n = c.count(declared, "physical groups", 4)?;
                let mut groups = (0..n).map(|_| c.int("physical group")).collect::<Result<Vec<_>>>()?;
                // What lies between two partitions has a parent of a higher dimension, whose groups it is not in.
                if let Some(parent) = parent.filter(|(of, _)| *of == dimension) {
                    groups.extend(self.physical.get(&parent).into_iter().flatten());
                }
                groups.iter_mut().for_each(|group| *group = group.abs());
                groups.sort_unstable();
                groups.dedup();
                self.n_members += groups.len();
                if self.n_members > MAX_MEMBERS {
                    let (what, most) = ("members of all groups together".to_owned(), MAX_MEMBERS as u64);
                    return c.fail("physical groups", MeshFileErrorKind::TooMuch { what, most });
                }
                self.physical.insert((dimension, tag), groups);
                if dimension > 0 {
                    let declared = c.size("bounding entities")?;
                    for _ in 0..c.count(declared, "bounding entities", 4)? {
                        c.int("bounding entity")?;
                    }
                }
                c.end_row()?;
            }
        }
        c.end_section("entities", counts.iter().sum())
    }

    /// Makes sets of the groups, whose names may have come after them. Groups of one name are not united:
    /// they go by their numbers.
    pub(super) fn named_groups(&mut self) -> Result<()> {
        let numbered = |&(dimension, group): &(usize, i128)| format!("{}={group}", DIMENSIONS[dimension]);
        let mut of_name: HashMap<(bool, &str), usize> = HashMap::new();
        for key in self.groups.keys() {
            if let Some(name) = self.names.get(key) {
                *of_name.entry((key.0 == 3, name)).or_default() += 1;
            }
        }
        for (key, members) in &self.groups {
            let cells = key.0 == 3;
            let name = self.names.get(key).filter(|name| of_name.get(&(cells, name.as_str())) == Some(&1));
            let name = name.cloned().unwrap_or_else(|| numbered(key));
            let add = if cells { NumberedMesh::add_to_element_set } else { NumberedMesh::add_to_node_set };
            add(&mut self.mesh, &name, members)?;
        }
        Ok(())
    }
}

/// Dimension, number and name of a physical group: the name is what stands between the first and the last quote.
fn physical_name(line: &str) -> Option<(usize, i128, &str)> {
    let (dimension, rest) = line.trim().split_once(char::is_whitespace)?;
    let rest = rest.trim_start();
    let (tag, name) = rest.split_at(rest.find(|c: char| c.is_whitespace() || c == '"')?);
    let name = name.trim();
    let name = match (name.find('"'), name.rfind('"')) {
        (Some(first), Some(last)) if first < last => &name[first + 1..last],
        _ => name.trim_matches('"'),
    };
    let dimension = dimension.parse().ok().filter(|dimension| *dimension < DIMENSIONS.len())?;
    Some((dimension, tag.parse().ok()?, name))
}
