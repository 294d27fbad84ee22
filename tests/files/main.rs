//! Files that are read and written, good and bad.

#[path = "../mesh_files/mod.rs"]
mod mesh_files;

mod bad_face;
mod bad_mesh;
mod bad_target;
mod bad_teeth;
mod badin;
mod cases;
mod formats;
mod fuzz_smoke;
mod mesh_formats;
mod recordings;
mod results;
mod schemas;
