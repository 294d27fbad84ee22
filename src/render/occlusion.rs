//! How much of its surroundings a sample sees.

use rayon::prelude::*;

use super::Layer;
use crate::units::Vec3;

/// Looks around each sample, and the turn from one to the next: the golden angle spreads them evenly.
const LOOKS: usize = 20;
const TURN: f64 = 2.399_963;
/// Reach of the looks, mm.
const REACH_MM: f64 = 11.;
/// Rise above the tangent plane (sine) that is taken for the facets' own roughness.
const ROUGH: f64 = 0.12;
/// Darkening where everything around rises.
const STRENGTH: f64 = 1.5;

/// Share of the surroundings that each sample of `layer` sees past `around`, 0 to 1; 1 where there is nothing.
/// `normals` are in the picture's axes, `pixels_per_mm` in samples.
pub(super) fn openness(layer: &Layer, around: &Layer, normals: &[Vec3], pixels_per_mm: f64) -> Vec<f32> {
    let (width, height) = (layer.width as i64, layer.height as i64);
    let offsets: Vec<(i64, i64)> = (0..LOOKS)
        .map(|k| {
            let radius = REACH_MM * pixels_per_mm * (k as f64 + 0.7) / LOOKS as f64;
            let (sin, cos) = (TURN * k as f64).sin_cos();
            ((radius * cos).round() as i64, (radius * sin).round() as i64)
        })
        .collect();
    let open = |index: usize| {
        let Some(hit) = layer.hits[index] else { return 1. };
        let (x, y) = (index as i64 % width, index as i64 / width);
        let n = normals[index];
        let mut hidden = 0.;
        for &(dx, dy) in &offsets {
            let (u, v) = (x + dx, y + dy);
            if u < 0 || v < 0 || u >= width || v >= height {
                continue;
            }
            let Some(other) = around.hits[(v * width + u) as usize] else { continue };
            let rise = f64::from(other.depth - hit.depth);
            let way = Vec3::new(dx as f64 / pixels_per_mm, -dy as f64 / pixels_per_mm, rise);
            let length = way.norm();
            let fade = 1. / (1. + (length / REACH_MM).powi(2));
            hidden += (n.dot(&way) / length.max(1e-9) - ROUGH).max(0.) * fade;
        }
        (1. - STRENGTH * hidden / LOOKS as f64).clamp(0., 1.) as f32
    };
    (0..layer.hits.len()).into_par_iter().map(open).collect()
}
