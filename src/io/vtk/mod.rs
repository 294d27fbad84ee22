//! VTK's files: XML (`.vtu`, `.vtp`) and legacy (`.vtk`).

mod array;
mod cell_type;
mod compression;
mod grid;
mod labels;
mod legacy;
mod writer;
mod xml;

pub(super) use legacy::{parse as parse_legacy, polygons as legacy_polygons};
pub use writer::{VtuData, vtu_text, write_vtu};
pub(super) use xml::{parse as parse_xml, point_scalars, point_vectors, polygons as xml_polygons};
