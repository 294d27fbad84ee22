//! A target fitted, and its motion as a GLB file: `cargo run --release --example fit_and_export`. Everything that the program does is
//! in the library.
#![allow(clippy::print_stdout, reason = "an example shows what it finds")]

use std::error::Error;
use std::path::Path;

use modiolus::face::{Pose, standard, standard::Resolution};
use modiolus::inverse::{ContactMode, Observations, Status};
use modiolus::io::read_target;
use modiolus::report::{Motion, MotionState, glb};
use modiolus::study::{Mechanics, fit, residual_rms_mm};

fn main() -> Result<(), Box<dyn Error>> {
    let target = read_target(Path::new("targets/snarl.toml"))?.target;
    let face = standard(&Resolution::COARSE);
    let points = Observations::resolve(&target, &face, |_| Err(f64::INFINITY))?; // landmarks only
    let mechanics = Mechanics { contact: true, ..Mechanics::default() };
    let fitted = fit(&face, &target, &points, mechanics, ContactMode::Reactions, |step, objective| {
        println!("step {step}: {objective:.4}");
    })?;

    assert_eq!(fitted.solution.status, Status::Solved);
    let rms = residual_rms_mm(&fitted.solution);
    println!("markers are off by {rms:.3} mm");
    assert!((rms - 0.363).abs() < 0.005);

    // The way from rest to the answer, and what each muscle adds there: what a page or a GLB file shows.
    let answer = MotionState {
        activation: fitted.solution.activations.values.clone(),
        displacement: fitted.displacement,
        pose: Pose::rest(),
        ..MotionState::rest(&face)
    };
    let motion = Motion::loading(&face, mechanics, answer, 2)?;
    let bytes = glb(&face, &motion);
    println!(
        "{} states, {} muscles, a GLB file of {} kB",
        motion.states.len() + 1,
        motion.tangent.len(),
        bytes.len() / 1000
    );
    assert_eq!(&bytes[..4], b"glTF");
    Ok(())
}
