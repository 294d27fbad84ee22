//! VTK's cell types.

use crate::mesh::CellKind;

/// What a cell type is here.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum CellType {
    /// A cell, how many nodes VTK gives it (those past the kind's own lie between its corners), and its name.
    Cell(CellKind, usize, &'static str),
    /// A polygon, whose first nodes are its corners, as many as are given or all.
    Polygon(Option<usize>),
    /// A strip of triangles.
    Strip,
    /// A point or a line.
    Lower,
    /// Not read.
    Unsupported(&'static str),
}

pub(super) const POLYGON: i64 = 7;
pub(super) const STRIP: i64 = 6;

/// What VTK type `number` is.
pub(super) fn cell_type(number: i64) -> CellType {
    use CellType::{Cell, Lower, Polygon, Strip, Unsupported};
    match number {
        10 => Cell(CellKind::Tet4, 4, "tetrahedron"),
        12 => Cell(CellKind::Hex8, 8, "hexahedron"),
        13 => Cell(CellKind::Wedge6, 6, "wedge"),
        24 => Cell(CellKind::Tet10, 10, "10-node tetrahedron"),
        25 => Cell(CellKind::Hex8, 20, "20-node hexahedron"),
        26 => Cell(CellKind::Wedge6, 15, "15-node wedge"),
        29 => Cell(CellKind::Hex8, 27, "27-node hexahedron"),
        32 => Cell(CellKind::Wedge6, 18, "18-node wedge"),
        33 => Cell(CellKind::Hex8, 24, "24-node hexahedron"),
        STRIP => Strip,
        5 | POLYGON | 9 => Polygon(None),
        22 | 34 => Polygon(Some(3)),
        23 | 28 => Polygon(Some(4)),
        0..=4 | 8 | 21 | 30 | 35 | 36 => Lower,
        11 => Unsupported("voxel"),
        14 => Unsupported("5-node pyramid"),
        27 => Unsupported("13-node pyramid"),
        37 => Unsupported("19-node pyramid"),
        42 => Unsupported("polyhedron"),
        72 => Unsupported("Lagrange hexahedron"),
        _ => Unsupported("unknown"),
    }
}
