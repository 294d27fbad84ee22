//! Node sets by name, by place and by direction.

use std::collections::BTreeMap;
use std::path::Path;

use super::Reader;
use super::error::{FaceFileError, FaceFileErrorKind};
use super::file::SelectTable;
use super::scale;
use crate::contact::Facets;
use crate::io::Location;
use crate::io::nearest::nearest;
use crate::mesh::Mesh;
use crate::units::Vec3;

impl Reader<'_> {
    /// Adds the sets of the JSON file `file` to those of `mesh`; a set of the same name replaces it.
    pub(super) fn add_json_sets(&self, file: &Path, mesh: &mut Mesh) -> Result<(), FaceFileError> {
        let sets: BTreeMap<String, Vec<usize>> = serde_json::from_str(&self.text(file)?).map_err(|e| {
            let reason =
                format!("no JSON object of lists of nodes, `{{\"skin\": [0, 1]}}` (column {})", e.column());
            let kind = FaceFileErrorKind::Syntax { reason };
            FaceFileError::new(Location::file(file).at_line(e.line()), kind)
        })?;
        let n = mesh.n_nodes();
        for (name, mut nodes) in sets {
            nodes.sort_unstable();
            nodes.dedup();
            if let Some(node) = nodes.last().filter(|node| **node >= n) {
                let accepted = format!("nodes from 0 to {}", n.saturating_sub(1));
                let kind = FaceFileErrorKind::Value { value: node.to_string(), accepted };
                return Err(FaceFileError::new(Location::file(file).in_field(name), kind));
            }
            mesh.node_sets.insert(name, nodes);
        }
        Ok(())
    }

    /// Adds the sets that `select` describes to those of `mesh`.
    pub(super) fn add_selections(
        &self,
        select: &[SelectTable],
        mesh: &mut Mesh,
    ) -> Result<(), FaceFileError> {
        if select.is_empty() {
            return Ok(());
        }
        let normals = Facets::of(mesh).node_normals(mesh);
        for (k, table) in select.iter().enumerate() {
            if mesh.node_sets.contains_key(&table.name) {
                let kind = FaceFileErrorKind::Duplicate { what: "node set", name: table.name.clone() };
                return Err(self.error(&format!("select[{k}].name"), kind));
            }
            let [lo, hi] = table.within_mm.map(Vec3::from);
            if !(0..3).all(|axis| lo[axis] < hi[axis]) {
                let accepted = "the smallest corner, then the largest".to_owned();
                let kind = FaceFileErrorKind::Value { value: format!("{:?}", table.within_mm), accepted };
                return Err(self.error(&format!("select[{k}].within_mm"), kind));
            }
            let corners = [lo, hi];
            scale::check_least("the box", &corners, mesh)
                .map_err(|kind| self.error(&format!("select[{k}].within_mm"), kind))?;
            let facing = table.facing.map(|d| Vec3::from(d).try_normalize(1e-12));
            if facing == Some(None) {
                let accepted = "a direction that is not zero".to_owned();
                let kind = FaceFileErrorKind::Value { value: format!("{:?}", table.facing), accepted };
                return Err(self.error(&format!("select[{k}].facing"), kind));
            }
            let chosen = |(node, normal): (&usize, &Vec3)| {
                let p = mesh.points[*node];
                let inside = (0..3).all(|axis| lo[axis] <= p[axis] && p[axis] <= hi[axis]);
                let faces = facing.flatten().is_none_or(|d| normal.dot(&d) >= table.facing_cosine);
                (inside && faces).then_some(*node)
            };
            let nodes = normals.iter().filter_map(chosen).collect();
            mesh.node_sets.insert(table.name.clone(), nodes);
        }
        Ok(())
    }

    /// The nodes of set `name`, which `field` asks for; an empty one is refused. Where no set has exactly this name,
    /// one that differs in its case alone is meant: Abaqus's names have no case.
    pub(super) fn set(&self, mesh: &Mesh, name: &str, field: &str) -> Result<Vec<usize>, FaceFileError> {
        let sets = &mesh.node_sets;
        let mut alike = sets.iter().filter(|(other, _)| other.eq_ignore_ascii_case(name));
        let nodes = match (sets.get(name), alike.next(), alike.next()) {
            (Some(nodes), ..) | (None, Some((_, nodes)), None) => nodes,
            _ => return Err(self.unknown_set(mesh, name, field)),
        };
        if nodes.is_empty() {
            let accepted = "a node set that is not empty".to_owned();
            return Err(self.error(field, FaceFileErrorKind::Value { value: name.to_owned(), accepted }));
        }
        Ok(nodes.clone())
    }

    fn unknown_set(&self, mesh: &Mesh, name: &str, field: &str) -> FaceFileError {
        let all = || mesh.node_sets.keys().map(String::as_str);
        // A name that several parts of a file have stands for none of their sets.
        let of_part =
            |set: &&str| set.rsplit_once('.').is_some_and(|(_, own)| own.eq_ignore_ascii_case(name));
        let parts: Vec<String> = all().filter(of_part).map(str::to_owned).collect();
        let (nearest, known) = match parts[..] {
            [] => (nearest(name, all()).map(str::to_owned), all().map(str::to_owned).collect()),
            _ => (None, parts),
        };
        let (name, no_sets) = (name.to_owned(), self.no_sets.clone());
        self.error(field, FaceFileErrorKind::UnknownSet { name, nearest, known, no_sets })
    }
}
