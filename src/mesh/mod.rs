//! Volume meshes: cells, surfaces, quality, point location and validation.

mod bvh;
mod cell;
mod closest;
mod connectivity;
mod dilatation_patches;
mod error;
mod extent;
mod facet;
mod free_mode;
mod locate;
mod quality;
mod site;
mod solid;
mod surface;
#[cfg(test)]
mod testing;
mod validate;
mod winding;

pub(crate) use bvh::{Aabb, Bvh};
pub use cell::{Cell, CellKind, MAX_NODES};
pub use dilatation_patches::DilatationPatches;
pub use error::{MeshError, MeshWarning};
pub use extent::Extent;
pub use facet::{Facet, boundary_facets};
pub use free_mode::FreeMode;
pub use locate::{Located, Locator};
pub use quality::Quality;
pub(crate) use quality::corner_neighbours;
pub use site::Site;
pub use solid::Mesh;
pub(crate) use solid::WEDGE_OTHER_ORDER;
pub(crate) use surface::first_diagonal;
pub use surface::{Skin, Surface};
pub(crate) use validate::MAX_EXTENT_MM;
pub use validate::{validate, validate_shape};
pub use winding::Winding;
