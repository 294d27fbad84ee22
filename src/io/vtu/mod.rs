//! VTK XML unstructured grids.

mod array;
mod reader;
mod writer;

pub(super) use reader::{parse, point_vectors};
pub use writer::{VtuData, vtu_text, write_vtu};
