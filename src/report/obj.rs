//! The surface of a moved face as Wavefront OBJ.

use std::fmt::Write;

use super::Motion;
use crate::face::Face;
use crate::render::{Refined, Scene};
use crate::units::Vec3;

/// `face` at the answer of `motion` as OBJ, mm: the smooth skin with the lining of the mouth, and the teeth, each an object.
pub fn obj_text(face: &Face, motion: &Motion) -> String {
    let scene = Scene::new(face);
    let Refined { sites, quads } = scene.surface();
    let u = motion.answer.displacement.as_deref();
    let moved = sites.iter().map(|s| s.position + u.map_or_else(Vec3::zeros, |u| s.displacement(u)));
    let mut text = String::from("# mm; x the subject's left, y up, z forward\n");
    let mut first = 1;
    let mut object = |name: &str, points: Vec<Vec3>, faces: &mut dyn Iterator<Item = Vec<usize>>| {
        // Writing to a string cannot fail.
        let _ = writeln!(text, "o {name}");
        for p in &points {
            let _ = writeln!(text, "v {:.4} {:.4} {:.4}", p.x, p.y, p.z);
        }
        for corners in faces {
            let corners: Vec<String> = corners.iter().map(|v| (first + v).to_string()).collect();
            let _ = writeln!(text, "f {}", corners.join(" "));
        }
        first += points.len();
    };
    object("skin", moved.collect(), &mut quads.iter().map(|q| q.to_vec()));
    for teeth in face.teeth_at(&motion.answer.pose) {
        let name = if teeth.upper { "upper_teeth" } else { "lower_teeth" };
        object(name, teeth.surface.points, &mut teeth.surface.triangles.iter().map(|t| t.to_vec()));
    }
    text
}
