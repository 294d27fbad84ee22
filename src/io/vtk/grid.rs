//! Points, cells and labels as VTK has them, and the mesh or the polygons that they are.

use std::collections::BTreeMap;

use super::super::mesh_document::{Corners, MeshDocument, MeshFileWarning, NoSet, remove_nodes};
use super::super::mesh_file_error::{MAX_MEMBERS, MeshFileError, MeshFileErrorKind};
use super::super::polygons::Polygons;
use super::super::{Location, text};
use super::cell_type::{CellType, cell_type};
use super::labels::Labels;
use crate::mesh::{Cell, Surface};
use crate::units::Vec3;

type Result<T> = std::result::Result<T, MeshFileError>;

/// The arrays by which VTK marks what belongs to another piece.
const GHOSTS: [&str; 2] = ["vtkGhostType", "vtkGhostLevels"];

/// An unstructured grid, of all pieces of a file.
#[derive(Default)]
pub(super) struct Grid {
    pub(super) points: Vec<Vec3>,
    /// VTK's type of each cell and where its nodes end in `connectivity`.
    pub(super) cells: Vec<(i64, usize)>,
    pub(super) connectivity: Vec<usize>,
    pub(super) point_labels: BTreeMap<String, Labels>,
    pub(super) cell_labels: BTreeMap<String, Labels>,
}

impl Grid {
    /// Adds the labels of `n` entries that follow `before` others; an array that a piece has not is none.
    pub(super) fn add_labels(
        all: &mut BTreeMap<String, Labels>,
        before: usize,
        arrays: Vec<(String, Labels)>,
        first_piece: bool,
    ) {
        let missing = || Labels::No("it is not in every piece of the file".to_owned());
        let mut arrays: BTreeMap<String, Labels> = arrays.into_iter().collect();
        if !first_piece || before > 0 {
            for (name, labels) in all.iter_mut() {
                labels.append(arrays.remove(name).unwrap_or_else(missing));
            }
        }
        for (name, labels) in arrays {
            let labels = if first_piece { labels } else { missing() };
            all.entry(name).or_insert(labels);
        }
    }

    /// The type and the nodes of each cell.
    fn each_cell(&self) -> impl Iterator<Item = (i64, &[usize])> {
        let mut start = 0;
        self.cells.iter().map(move |&(kind, end)| {
            let nodes = &self.connectivity[start..end];
            start = end;
            (kind, nodes)
        })
    }

    /// The volume mesh, with `at_types` and `at_offsets` for what is wrong with cells.
    pub(super) fn mesh(mut self, at_types: &Location, at_offsets: &Location) -> Result<MeshDocument> {
        let ghosts = self.ghosts();
        let mut document = MeshDocument::default();
        let mut corners = Corners::default();
        let mut position: Vec<Option<usize>> = Vec::with_capacity(self.cells.len());
        let mut left_out = vec![false; self.points.len()];
        let mut n_ghosts = 0;
        let mesh = &mut document.mesh;
        for (k, (number, nodes)) in self.each_cell().enumerate() {
            let (kind, n, name) = match cell_type(number) {
                CellType::Cell(kind, n, name) => (kind, n, name),
                CellType::Unsupported(name) => {
                    let (id, name) = (k.to_string(), format!("{name} (VTK type {number})"));
                    let kind = MeshFileErrorKind::UnsupportedElement { id, name };
                    return Err(MeshFileError::new(at_types.clone(), kind));
                }
                _ => {
                    position.push(None);
                    continue;
                }
            };
            if nodes.len() != n {
                let (expected, found) =
                    (format!("{n} nodes in cell {k} of type {number}"), nodes.len().to_string());
                let kind = MeshFileErrorKind::Syntax { expected, found };
                return Err(MeshFileError::new(at_offsets.clone(), kind));
            }
            if ghosts.get(k) == Some(&true) {
                position.push(None);
                n_ghosts += 1;
                nodes.iter().for_each(|&node| left_out[node] = true);
                continue;
            }
            let (own, between) = nodes.split_at(kind.n_nodes());
            if !between.is_empty() {
                corners.add(name, k as u64, between.iter().copied());
            }
            position.push(Some(mesh.cells.len()));
            mesh.cells.push(Cell::new(kind, own));
            mesh.cell_ids.push(k as u64);
        }
        self.sets(&position, &ghosts, at_types, &mut document)?;
        let mesh = &mut document.mesh;
        mesh.node_ids = (0..self.points.len() as u64).collect();
        mesh.points = self.points;
        if n_ghosts > 0 {
            for &node in mesh.cells.iter().flat_map(Cell::nodes) {
                left_out[node] = false;
            }
            remove_nodes(mesh, |node| left_out[node]);
            document.warnings.push(MeshFileWarning::Ghosts { count: n_ghosts });
        }
        corners.finish(&mut document);
        Ok(document)
    }

    /// Which cells are ghosts; the arrays that say so are no labels.
    fn ghosts(&mut self) -> Vec<bool> {
        let mut ghosts = vec![false; self.cells.len()];
        for name in GHOSTS {
            self.point_labels.remove(name);
            if let Some(Labels::Of { distinct, codes }) = self.cell_labels.remove(name) {
                for (ghost, code) in ghosts.iter_mut().zip(codes) {
                    *ghost |= distinct[usize::from(code)] != 0;
                }
            }
        }
        ghosts
    }

    /// Makes sets of the labels: of points; of volume cells; and of the points of other cells, which are no cells here.
    fn sets(
        &self,
        position: &[Option<usize>],
        ghosts: &[bool],
        at: &Location,
        document: &mut MeshDocument,
    ) -> Result<()> {
        let MeshDocument { mesh, no_sets, .. } = document;
        for (name, labels) in self.point_labels.iter().chain(&self.cell_labels) {
            if let Labels::No(why) = labels {
                no_sets.push(NoSet { name: name.clone(), why: why.clone() });
            }
        }
        let mut left = MAX_MEMBERS;
        let mut spend = |n: usize, name: &str| match left.checked_sub(n) {
            Some(rest) => {
                left = rest;
                Ok(())
            }
            None => {
                let (what, most) = ("members of all sets together".to_owned(), MAX_MEMBERS as u64);
                let at = at.clone().in_field(text::shown(name));
                Err(MeshFileError::new(at, MeshFileErrorKind::TooMuch { what, most }))
            }
        };
        for (name, labels) in &self.point_labels {
            for (name, members) in labels.sets(name) {
                spend(members.len(), &name)?;
                mesh.node_sets.insert(name, members);
            }
        }
        let nodes: Vec<&[usize]> = self.each_cell().map(|(_, nodes)| nodes).collect();
        let lower = |k: &usize| position[*k].is_none() && !ghosts[*k];
        let has_lower = (0..nodes.len()).any(|k| lower(&k));
        for (array, labels) in &self.cell_labels {
            for (name, members) in labels.sets(array) {
                let cells: Vec<usize> = members.iter().filter_map(|&k| position[k]).collect();
                spend(cells.len(), &name)?;
                let faces = members.iter().copied().filter(lower);
                let mut of_faces: Vec<usize> = faces.flat_map(|k| nodes[k].iter().copied()).collect();
                of_faces.sort_unstable();
                of_faces.dedup();
                spend(of_faces.len(), &name)?;
                // Zeros and ones make a set of cells even where no cell is in it.
                if !cells.is_empty() || (name == *array && !has_lower) {
                    mesh.cell_sets.insert(name.clone(), cells);
                }
                if !of_faces.is_empty() {
                    match mesh.node_sets.get(&name) {
                        Some(same) if *same == of_faces => {}
                        Some(_) => drop(mesh.node_sets.insert(format!("faces={name}"), of_faces)),
                        None => drop(mesh.node_sets.insert(name, of_faces)),
                    }
                }
            }
        }
        Ok(())
    }

    /// The surface that its polygons are.
    pub(super) fn surface(&self, at: &Location) -> Result<Surface> {
        let mut polygons = Polygons::default();
        for p in &self.points {
            polygons.vertex(*p);
        }
        for (number, nodes) in self.each_cell() {
            match cell_type(number) {
                CellType::Polygon(corners) => {
                    polygons
                        .polygon(&nodes[..corners.unwrap_or(nodes.len()).min(nodes.len())], || at.clone())?;
                }
                CellType::Strip => {
                    for (k, t) in nodes.windows(3).enumerate() {
                        let t = if k % 2 == 0 { [t[0], t[1], t[2]] } else { [t[1], t[0], t[2]] };
                        polygons.polygon(&t, || at.clone())?;
                    }
                }
                _ => {}
            }
        }
        polygons.surface(at)
    }
}
