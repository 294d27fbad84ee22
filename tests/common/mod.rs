//! What several test files need.
#![allow(dead_code, unreachable_pub, unused_imports)]

pub mod block_face;
pub mod faces;
mod grids;
pub mod piece;
mod random;

pub use grids::{add_quad_traction, cell_displacements, grid, solve, solve_with};
pub use random::Random;
