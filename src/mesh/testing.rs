//! Small meshes for the unit tests of this module.

use super::{Cell, CellKind, Mesh};
use crate::units::Vec3;

/// A block of `n` unit hexes per axis, 10 mm each.
pub(crate) fn block(n: [usize; 3]) -> Mesh {
    let [nx, ny, nz] = n;
    let at = |i: usize, j: usize, k: usize| i + (nx + 1) * (j + (ny + 1) * k);
    let mut points = Vec::new();
    for k in 0..=nz {
        for j in 0..=ny {
            for i in 0..=nx {
                points.push(10. * Vec3::new(i as f64, j as f64, k as f64));
            }
        }
    }
    let mut cells = Vec::new();
    for k in 0..nz {
        for j in 0..ny {
            for i in 0..nx {
                let quad = |k: usize| [at(i, j, k), at(i + 1, j, k), at(i + 1, j + 1, k), at(i, j + 1, k)];
                cells.push(Cell::new(CellKind::Hex8, &[quad(k), quad(k + 1)].concat()));
            }
        }
    }
    Mesh::new(points, cells)
}

/// One cell of `kind` on its reference nodes, 10 mm a unit.
pub(crate) fn single(kind: CellKind) -> Mesh {
    let points = kind.node_positions().iter().map(|p| 10. * Vec3::from(*p)).collect();
    let nodes: Vec<usize> = (0..kind.n_nodes()).collect();
    Mesh::new(points, vec![Cell::new(kind, &nodes)])
}

/// One straight quadratic tetrahedron.
pub(crate) fn tet10() -> Mesh {
    single(CellKind::Tet10)
}
