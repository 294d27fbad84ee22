//! Gmsh's element types.

use crate::mesh::CellKind;

/// What an element type of Gmsh is here.
pub(super) enum ElementType {
    /// A cell, and how many nodes Gmsh gives it: those past the kind's own lie between its corners.
    Cell(CellKind, usize, &'static str),
    /// A point, line or face with this dimension and number of nodes.
    Lower(usize, usize),
    /// Not read; its name.
    Unsupported(String),
}

/// What Gmsh type `number` is.
pub(super) fn element_type(number: i128) -> ElementType {
    let name = match number {
        4 => return ElementType::Cell(CellKind::Tet4, 4, ""),
        5 => return ElementType::Cell(CellKind::Hex8, 8, ""),
        6 => return ElementType::Cell(CellKind::Wedge6, 6, ""),
        11 => return ElementType::Cell(CellKind::Tet10, 10, ""),
        12 => return ElementType::Cell(CellKind::Hex8, 27, "27-node hexahedron"),
        13 => return ElementType::Cell(CellKind::Wedge6, 18, "18-node wedge"),
        17 => return ElementType::Cell(CellKind::Hex8, 20, "20-node hexahedron"),
        18 => return ElementType::Cell(CellKind::Wedge6, 15, "15-node wedge"),
        15 => return ElementType::Lower(0, 1),
        1 => return ElementType::Lower(1, 2),
        8 => return ElementType::Lower(1, 3),
        26 => return ElementType::Lower(1, 4),
        2 => return ElementType::Lower(2, 3),
        3 => return ElementType::Lower(2, 4),
        9 => return ElementType::Lower(2, 6),
        10 => return ElementType::Lower(2, 9),
        16 => return ElementType::Lower(2, 8),
        20 => return ElementType::Lower(2, 9),
        21 => return ElementType::Lower(2, 10),
        7 => "5-node pyramid",
        14 => "14-node pyramid",
        19 => "13-node pyramid",
        29 => "20-node tetrahedron",
        _ => "unknown",
    };
    ElementType::Unsupported(format!("{name} (Gmsh type {number})"))
}

/// Puts the nodes of a cell from Gmsh's order into that of `kind`.
pub(super) fn reorder(kind: CellKind, nodes: &mut [u64]) {
    // Gmsh numbers the last two edges of a tetrahedron the other way round.
    if kind == CellKind::Tet10 {
        nodes.swap(8, 9);
    }
}
