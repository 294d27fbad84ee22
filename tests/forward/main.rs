//! The model that moves a face: elements, muscles, bones, strain.

#[path = "../common/mod.rs"]
mod common;

mod activated;
mod activation_map;
mod benchmarks;
mod convergence;
mod fibres_and_stress;
mod finite_strain;
mod jaw_opening;
mod moved_bones;
mod muscle_function;
mod muscle_material;
mod nafems;
mod patch;
mod reference_block;
mod standard_face;
mod surgery;
