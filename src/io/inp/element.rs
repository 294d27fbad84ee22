//! Abaqus's element types.

use crate::mesh::CellKind;

/// What an element type is here.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum ElementKind {
    /// A cell, and how many nodes the file gives it: those past the kind's own lie between its corners.
    Cell(CellKind, usize),
    /// A shell, a membrane, a beam or a surface element, of which only the nodes are kept, as a set.
    Lower,
    /// A spring, a dashpot, a connector or a mass, which is no part of a mesh.
    Discrete,
}

const LOWER: [&str; 21] = [
    "S3", "S4", "S6", "S8", "S9", "STRI", "DS", "T2D", "T3D", "B2", "B3", "PIPE", "CPS", "CPE", "CAX", "M3D",
    "R2D", "R3D", "RAX", "SFM", "RB",
];
const DISCRETE: [&str; 13] = [
    "SPRING", "DASHPOT", "CONN", "MASS", "ROTARYI", "JOINTC", "GAP", "ITS", "DCOUP", "HEATCAP", "DRAG",
    "FRAME", "CAPPED",
];

/// What element `name` is, or `None` if it is not read.
pub(super) fn element_kind(name: &str) -> Option<ElementKind> {
    let name = name.to_ascii_uppercase();
    // Letters after the number of nodes choose the formulation (R, H, I, ...), which is ours anyway.
    Some(match name.trim_end_matches(|c: char| c.is_ascii_alphabetic()) {
        "C3D8" => ElementKind::Cell(CellKind::Hex8, 8),
        "C3D6" => ElementKind::Cell(CellKind::Wedge6, 6),
        "C3D4" => ElementKind::Cell(CellKind::Tet4, 4),
        "C3D10" => ElementKind::Cell(CellKind::Tet10, 10),
        "C3D20" => ElementKind::Cell(CellKind::Hex8, 20),
        "C3D27" => ElementKind::Cell(CellKind::Hex8, 27),
        "C3D15" => ElementKind::Cell(CellKind::Wedge6, 15),
        _ if DISCRETE.iter().any(|d| name.starts_with(d)) => ElementKind::Discrete,
        _ if LOWER.iter().any(|l| name.starts_with(l)) => ElementKind::Lower,
        _ => return None,
    })
}
