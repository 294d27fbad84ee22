//! The embedded standard face: a lower face in code, so that the main job needs no file.
//!
//! A featureless head (one smooth section curve per height) carries a relief of nose, lips and chin;
//! under it lie the skull at tabulated soft-tissue depths and, behind lips and cheeks, the free
//! mucosa on the dental arches. Columns, rows and layers between the two are the hexes.

mod arches;
mod builder;
mod curve;
mod grid;
mod landmarks;
mod muscles;
mod parameters;
mod relief;
mod resolution;
mod sample;
mod section;
mod thickness;

pub use parameters::{ParameterError, Parameters, Proportion};
pub use resolution::Resolution;
pub use sample::sample;

use std::collections::BTreeMap;

use self::grid::{Grid, Place};
use self::relief::Relief;
use super::{Face, Landmark, MuscleTissue, Support, Tissue};
use crate::mesh::{Cell, CellKind, Mesh, Site};
use crate::units::Vec3;

/// Share of vestibule above which an inner node is free mucosa: short of whole the inner surface
/// already leaves the arch for the bone behind the fornix.
const FREE: f64 = 0.97;

/// Height, mm, above and below the line of the slit within which neither jaw holds the tissue behind the
/// vestibule: masseter and the raphe of the buccinator span there, and must stretch when the jaw opens.
const BETWEEN_JAWS_MM: f64 = 8.0;

/// Name of a face that is not built in.
const OTHER: &str = "standard_varied";

/// The standard face at `resolution` with the default [`Parameters`], under the name of the
/// [built-in face](Resolution::FACES) where it is one.
pub fn standard(resolution: &Resolution) -> Face {
    let name = resolution.face_name().unwrap_or(OTHER);
    Face { name: name.into(), ..build(&Parameters::default(), resolution) }
}

/// The standard face at `resolution` with other proportions, called `standard_varied`.
///
/// # Errors
/// [`ParameterError`] when a parameter is not finite or outside the range in which the shape
/// keeps its element quality.
pub fn parametric(parameters: &Parameters, resolution: &Resolution) -> Result<Face, ParameterError> {
    parameters.check()?;
    resolution.check()?;
    Ok(build(parameters, resolution))
}

/// Names of a face's nodes on both halves.
struct Nodes<'a> {
    grid: &'a Grid,
    /// Node of (column, row, layer, upper); negative columns are the right half.
    ids: BTreeMap<(isize, usize, usize, bool), usize>,
    points: Vec<Vec3>,
}

impl<'a> Nodes<'a> {
    fn new(grid: &'a Grid) -> Self {
        let mut nodes = Self { grid, ids: BTreeMap::new(), points: Vec::new() };
        let half = grid.columns as isize - 1;
        for column in -half..=half {
            for row in 0..grid.rows {
                for layer in 0..=grid.layers {
                    let split = grid.is_split(column.unsigned_abs(), row);
                    for upper in [false, true] {
                        if split || !upper {
                            nodes.put(column, row, layer, upper);
                        } else {
                            let id = nodes.points.len() - 1;
                            nodes.ids.insert((column, row, layer, true), id);
                        }
                    }
                }
            }
        }
        nodes
    }

    fn put(&mut self, column: isize, row: usize, layer: usize, upper: bool) {
        let depth = layer as f64 / self.grid.layers as f64;
        let mut point = self.grid.point(column.unsigned_abs(), row, depth, upper);
        if column < 0 {
            point.x = -point.x;
        }
        self.ids.insert((column, row, layer, upper), self.points.len());
        self.points.push(point);
    }

    fn id(&self, column: isize, row: usize, layer: usize, upper: bool) -> usize {
        self.ids[&(column, row, layer, upper)]
    }

    /// Ascending nodes whose (column, row, layer, upper) satisfy `keep`.
    fn select(&self, keep: impl Fn(usize, usize, usize, bool) -> bool) -> Vec<usize> {
        let chosen = self.ids.iter().filter(|((c, r, l, u), _)| keep(c.unsigned_abs(), *r, *l, *u));
        let mut nodes: Vec<usize> = chosen.map(|(_, &id)| id).collect();
        nodes.sort_unstable();
        nodes.dedup();
        nodes
    }

    fn cells(&self) -> Vec<Cell> {
        let grid = self.grid;
        let half = grid.columns as isize - 1;
        let mut cells = Vec::new();
        for column in -half..half {
            for row in 0..grid.rows - 1 {
                for layer in 0..grid.layers {
                    let upper = row >= grid.slit;
                    let id = |c: isize, r: usize, l: usize| self.id(column + c, row + r, layer + l, upper);
                    let nodes = [
                        id(0, 0, 0),
                        id(1, 0, 0),
                        id(1, 1, 0),
                        id(0, 1, 0),
                        id(0, 0, 1),
                        id(1, 0, 1),
                        id(1, 1, 1),
                        id(0, 1, 1),
                    ];
                    cells.push(Cell::new(CellKind::Hex8, &nodes));
                }
            }
        }
        cells
    }

    /// The skin site at `place`, on the left or right half.
    fn site(&self, place: Place, upper: bool, right: bool) -> Site {
        let side = if right { -1 } else { 1 };
        let mut weights = Vec::new();
        for (column, row, weight) in self.grid.around(place) {
            if weight > 1e-9 {
                weights.push((self.id(side * column as isize, row, self.grid.layers, upper), weight));
            }
        }
        let total: f64 = weights.iter().map(|w| w.1).sum();
        for weight in &mut weights {
            weight.1 /= total;
        }
        let position = weights.iter().map(|&(node, weight)| weight * self.points[node]).sum();
        Site { position, weights }
    }
}

fn build(parameters: &Parameters, resolution: &Resolution) -> Face {
    let grid = Grid::new(parameters, resolution);
    let nodes = Nodes::new(&grid);
    let share = |column: usize, row: usize| grid.vestibule[column * grid.rows + row];
    let layers = grid.layers;

    let skin = nodes.select(|_, _, layer, _| layer == layers);
    let mucosa = nodes.select(|column, row, layer, _| layer == 0 && share(column, row) > FREE);
    // The side edge is held through the thickness by the parotid fascia and the ear, the top edge
    // under the skin by the orbital rim; the neck's skin below is free to slide.
    let height = |column: usize, row: usize, layer: usize| {
        grid.point(column, row, layer as f64 / layers as f64, row >= grid.slit).y
    };
    let held = |column: usize, row: usize, layer: usize| {
        let bone = (layer == 0 && share(column, row) <= FREE)
            || column == grid.columns - 1
            || (row == grid.rows - 1 && layer < layers);
        bone && (height(column, row, layer) - height(column, grid.slit, layer)).abs() > BETWEEN_JAWS_MM
    };
    let skull = nodes.select(|column, row, layer, _| held(column, row, layer) && row >= grid.slit);
    let mandible = nodes.select(|column, row, layer, _| held(column, row, layer) && row < grid.slit);
    // Half of the vermilion rolls over the slit.
    let reach = [resolution.rows_above[0].div_ceil(2), resolution.rows_below[0].div_ceil(2)];
    let faces = |column: usize, row: usize, layer: usize| {
        column < grid.corner && (row == grid.slit || layer == 0 || layer == layers)
    };
    let upper_lip = nodes.select(|column, row, layer, upper| {
        upper && (grid.slit..=grid.slit + reach[0]).contains(&row) && faces(column, row, layer)
    });
    let lower_lip = nodes.select(|column, row, layer, upper| {
        !upper && (grid.slit - reach[1]..=grid.slit).contains(&row) && faces(column, row, layer)
    });

    let mut found = Vec::new();
    for spot in landmarks::spots(&grid, parameters, &Relief::new(parameters)) {
        let mut add = |suffix: &str, right: bool| {
            let site = nodes.site(spot.place, spot.upper, right);
            found.push(Landmark { name: format!("{}{suffix}", spot.name), site });
        };
        if spot.paired {
            add("_l", false);
            add("_r", true);
        } else {
            add("", false);
        }
    }

    let muscles = muscles::muscles(&grid, parameters);
    let mut mesh = Mesh::new(nodes.points.clone(), nodes.cells());
    for (name, set) in [
        ("skin", &skin),
        ("mucosa", &mucosa),
        ("skull", &skull),
        ("mandible", &mandible),
        ("upper_lip", &upper_lip),
        ("lower_lip", &lower_lip),
    ] {
        mesh.node_sets.insert(name.into(), set.clone());
    }
    Face {
        name: OTHER.into(),
        mesh,
        tissue: Tissue::default(),
        muscle_tissue: MuscleTissue::default(),
        supports: vec![
            Support { bone: "skull".into(), part_of: None, nodes: skull },
            Support { bone: "mandible".into(), part_of: None, nodes: mandible },
        ],
        jaw: Some(arches::jaw(parameters)),
        muscles,
        teeth: arches::teeth(parameters),
        mucosa,
        upper_lip,
        lower_lip,
        skin,
        landmarks: found,
    }
}
