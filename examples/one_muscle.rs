//! What one muscle does, and what the others would add: `cargo run --release --example one_muscle`.
#![allow(clippy::print_stdout, reason = "an example shows what it finds")]

use std::error::Error;

use modiolus::face::{Pose, standard, standard::Resolution};
use modiolus::study::{Mechanics, Mover, muscle_stretches};

fn main() -> Result<(), Box<dyn Error>> {
    let face = standard(&Resolution::COARSE);
    let mover = Mover::new(&face, Mechanics { contact: true, ..Mechanics::default() })?;

    // Both zygomatici majores at 30 per cent.
    let acts = |name: &str| name.starts_with("zygomaticus_major");
    let activation: Vec<f64> = face.muscles.iter().map(|m| if acts(&m.name) { 0.3 } else { 0. }).collect();
    let moved = mover.tangent(&activation, &Pose::rest())?;

    let corner = face.landmark("cheilion_l").ok_or("the standard face has one")?;
    let u = corner.site.displacement(&moved.moved.displacement);
    println!("the left corner of the mouth goes {:.2} mm to the left, {:.2} up, {:.2} back", u.x, u.y, -u.z);
    assert!((u.y - 1.624).abs() < 0.005);

    // What each muscle would add from here, in mm per unit activation.
    for (muscle, field) in face.muscles.iter().zip(&moved.fields).filter(|(m, _)| m.name.ends_with("_l")) {
        println!("{:44} {:5.1}", muscle.name, corner.site.displacement(field).norm());
    }
    let lengths = muscle_stretches(&face, &moved.moved.displacement);
    let shortest = face.muscles.iter().zip(&lengths).min_by(|a, b| a.1.total_cmp(b.1));
    let (muscle, length) = shortest.ok_or("the standard face has muscles")?;
    println!("{} is shortened most, to {:.0} % of its length", muscle.name, 100. * length);
    Ok(())
}
