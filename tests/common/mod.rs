//! What several test files need.
#![allow(dead_code, unreachable_pub, unused_imports)]

pub mod block_face;
mod cuboid;
pub mod faces;
mod grids;
pub mod piece;
mod pressed;
mod random;
pub mod surfaces;

pub use cuboid::cuboid;
pub use grids::{
    add_quad_traction, add_traction_on_tetrahedra, cell_displacements, elements, five_tetrahedra, grid,
    solve, solve_with,
};
pub use pressed::{contact_column, contact_response, factor, half_space, isotropic};
pub use random::Random;
