//! The published JSON schemas are the ones of the code.
//!
//! After a change of a format, `MODIOLUS_BLESS=1 cargo test --release --test files schemas` writes them anew.

use std::path::PathBuf;

use modiolus::io::{
    calibration_schema, comparison_schema, face_schema, marker_map_schema, plan_schema, registration_schema,
    solution_schema, suite_schema, symmetry_schema, target_schema, track_schema,
};

fn holds(file: &str, derived: &str) {
    let path = PathBuf::from(env!("CARGO_MANIFEST_DIR")).join("schemas").join(file);
    if std::env::var_os("MODIOLUS_BLESS").is_some() {
        std::fs::write(&path, derived).expect("written");
    }
    let published = std::fs::read_to_string(&path).unwrap_or_default().replace("\r\n", "\n");
    assert!(published == derived, "{} is out of date: run with MODIOLUS_BLESS=1", path.display());
}

#[test]
fn the_target_schema_is_published() {
    holds("target.schema.json", &target_schema());
}

#[test]
fn the_solution_schema_is_published() {
    holds("solution.schema.json", &solution_schema());
}

#[test]
fn the_calibration_schema_is_published() {
    holds("calibration.schema.json", &calibration_schema());
}

#[test]
fn the_suite_schema_is_published() {
    holds("suite.schema.json", &suite_schema());
}

#[test]
fn the_comparison_schema_is_published() {
    holds("comparison.schema.json", &comparison_schema());
}

#[test]
fn the_plan_schema_is_published() {
    holds("plan.schema.json", &plan_schema());
}

#[test]
fn the_face_schema_is_published() {
    holds("face.schema.json", &face_schema());
}

#[test]
fn the_symmetry_schema_is_published() {
    holds("symmetry.schema.json", &symmetry_schema());
}

#[test]
fn the_track_schema_is_published() {
    holds("track.schema.json", &track_schema());
}

#[test]
fn the_marker_map_schema_is_published() {
    holds("map.schema.json", &marker_map_schema());
}

#[test]
fn the_registration_schema_is_published() {
    holds("registration.schema.json", &registration_schema());
}
