//! Muscles as bundles of tubes, and the arrows of their forces.

use super::colour::{Rgb, distinct, mix, srgb};
use super::solid::Solid;
use crate::face::{Face, Fibre, Muscle, without_side};
use crate::forward::fibre_forces;
use crate::mesh::{Locator, Site};
use crate::units::Vec3;

/// Radius of a fibre's tube, mm.
const TUBE_MM: f64 = 0.55;
/// Points of a fibre that are left out between two that are drawn.
const STRIDE: usize = 2;
/// Length of fibre whose force one arrow shows, mm.
const ARROW_EVERY_MM: f64 = 4.;
/// Length of the longest arrow and radius of the shafts, mm, on a face of the size below.
const LONGEST_MM: f64 = 16.;
const SHAFT_MM: f64 = 0.42;
/// Arrows shorter than this say nothing, mm, on a face of the size below.
const SHORTEST_MM: f64 = 0.8;
/// Longest side of the box about the standard face, mm.
const SIZE_MM: f64 = 147.;

/// The muscles of a face, each fibre point carried by the tissue.
#[derive(Clone, Debug)]
pub(super) struct Bundles {
    /// By muscle and fibre; points outside the mesh stay where they are.
    pub(super) sites: Vec<Vec<Vec<Site>>>,
}

impl Bundles {
    pub(super) fn new(face: &Face) -> Self {
        let locator = Locator::new(&face.mesh);
        let site = |p: &Vec3| match locator.locate(*p) {
            Some(found) => Site { position: *p, ..found.site },
            None => Site { position: *p, weights: Vec::new() },
        };
        let fibre = |f: &Fibre| f.points.iter().map(site).collect();
        Self { sites: face.muscles.iter().map(|m| m.fibres.iter().map(fibre).collect()).collect() }
    }

    fn moved(&self, muscle: usize, fibre: usize, u: Option<&[f64]>) -> Vec<Vec3> {
        let at = |s: &Site| s.position + u.map_or_else(Vec3::zeros, |u| s.displacement(u));
        self.sites[muscle][fibre].iter().map(at).collect()
    }

    /// Adds the tubes of the muscles of `face` that `colour` gives a colour.
    pub(super) fn tubes(
        &self,
        face: &Face,
        u: Option<&[f64]>,
        colour: impl Fn(usize) -> Option<Rgb>,
        solid: &mut Solid,
    ) {
        for (m, muscle) in face.muscles.iter().enumerate() {
            let Some(colour) = colour(m) else { continue };
            for (f, fibre) in muscle.fibres.iter().enumerate() {
                let all = self.moved(m, f, u);
                let last = all.len().saturating_sub(1);
                let kept = |k: usize| k.is_multiple_of(STRIDE) || (k == last && !fibre.closed);
                let points: Vec<Vec3> = (0..all.len()).filter(|&k| kept(k)).map(|k| all[k]).collect();
                solid.tube(&points, fibre.closed, TUBE_MM, colour);
            }
        }
    }

    /// Adds the arrows of the forces at `activation` (m) and returns the length of one newton, mm; `None`
    /// when there is no force.
    pub(super) fn arrows(
        &self,
        face: &Face,
        u: Option<&[f64]>,
        activation: &[f64],
        solid: &mut Solid,
    ) -> Option<f64> {
        let mut arrows: Vec<(Vec3, Vec3)> = Vec::new();
        for (m, (muscle, &a)) in face.muscles.iter().zip(activation).enumerate() {
            if a > 0. {
                let moved: Vec<Vec<Vec3>> = (0..muscle.fibres.len()).map(|f| self.moved(m, f, u)).collect();
                arrows.extend(gathered(muscle, a, &moved));
            }
        }
        let strongest = arrows.iter().map(|(_, force)| force.norm()).fold(0., f64::max);
        if strongest <= 0. {
            return None;
        }
        let scale = size_mm(face) / SIZE_MM;
        let mm_per_n = scale * LONGEST_MM / strongest;
        let colour = srgb(24, 58, 140);
        for (at, force) in arrows {
            if force.norm() * mm_per_n >= scale * SHORTEST_MM {
                solid.arrow(at, force * mm_per_n, scale * SHAFT_MM, colour);
            }
        }
        Some(mm_per_n)
    }
}

/// Longest side of the box about the tissue, mm.
fn size_mm(face: &Face) -> f64 {
    let bound = |pick: fn(f64, f64) -> f64, start: f64| {
        face.mesh.points.iter().fold(Vec3::repeat(start), |bound, p| bound.zip_map(p, pick))
    };
    (bound(f64::max, f64::MIN) - bound(f64::min, f64::MAX)).max()
}

/// The forces of a bundle, N, summed over its fibres and over stretches of a few millimetres, each at the mean
/// of where its points have moved. The ends of open fibres stand alone: the bone takes the origin's force whole.
fn gathered(muscle: &Muscle, activation: f64, moved: &[Vec<Vec3>]) -> Vec<(Vec3, Vec3)> {
    let tension = activation * muscle.max_force_n / muscle.fibres.len() as f64;
    let arcs: Vec<Vec<f64>> = muscle.fibres.iter().map(arc_lengths).collect();
    let mean = arcs.iter().filter_map(|a| a.last()).sum::<f64>() / arcs.len().max(1) as f64;
    let body = ((mean / ARROW_EVERY_MM).round() as usize).max(1);
    let mut stretches = vec![(Vec3::zeros(), Vec3::zeros(), 0.); body + 2];
    for ((fibre, arc), moved) in muscle.fibres.iter().zip(&arcs).zip(moved) {
        let whole = arc.last().copied().unwrap_or(0.).max(1e-9);
        let last = fibre.points.len().saturating_sub(1);
        for (k, force) in fibre_forces(fibre, tension, muscle.insertion_mm).into_iter().enumerate() {
            let stretch = match k {
                0 if !fibre.closed => 0,
                k if k == last && !fibre.closed => body + 1,
                _ => 1 + ((arc[k] / whole * body as f64) as usize).min(body - 1),
            };
            let (at, sum, count) = &mut stretches[stretch];
            *at += moved[k];
            *sum += force;
            *count += 1.;
        }
    }
    stretches.into_iter().filter(|s| s.2 > 0.).map(|(at, sum, count)| (at / count, sum)).collect()
}

/// Length of the fibre up to each point, mm, and for a closed one at last the whole.
fn arc_lengths(fibre: &Fibre) -> Vec<f64> {
    let n = fibre.points.len();
    let mut arc = vec![0.; n];
    for k in 1..n {
        arc[k] = arc[k - 1] + (fibre.points[k] - fibre.points[k - 1]).norm();
    }
    if fibre.closed && n > 1 {
        arc.push(arc[n - 1] + (fibre.points[0] - fibre.points[n - 1]).norm());
    }
    arc
}

/// The colour of a muscle at activation `a`: grey at rest, then the redder the more.
pub(super) fn activation_colour(a: f64) -> Rgb {
    match a > 0. {
        true => mix(srgb(214, 150, 130), srgb(178, 24, 30), (a as f32).sqrt()),
        false => srgb(176, 168, 164),
    }
}

/// The colour of each muscle: by name without side at rest, by activation when any is active; muscles at rest
/// among active ones are grey.
pub(super) fn colours(face: &Face, stems: &[String], activation: Option<&[f64]>) -> Vec<Rgb> {
    let active = activation.filter(|a| a.iter().any(|a| *a > 0.));
    let of = |m: usize| match active {
        Some(a) => activation_colour(a[m]),
        None => {
            let name = without_side(&face.muscles[m].name);
            distinct(stems.iter().position(|s| s == name).unwrap_or(0))
        }
    };
    (0..face.muscles.len()).map(of).collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn gathered_forces_sum_to_those_of_the_fibre() {
        let points: Vec<Vec3> =
            (0..40).map(|k| f64::from(k) / 10.).map(|t| Vec3::new(10. * t, 3. * t.sin(), 0.)).collect();
        let fibre = Fibre { points: points.clone(), closed: false };
        let muscle = Muscle {
            name: "arc".into(),
            max_force_n: 2.,
            radius_mm: 1.,
            area_mm2: None,
            insertion_mm: 8.,
            fibres: vec![fibre.clone()],
        };
        let arrows = gathered(&muscle, 0.5, &[points]);
        assert!(arrows.len() < 20);
        let sum: Vec3 = arrows.iter().map(|(_, f)| f).sum();
        assert!(sum.norm() < 1e-12, "a fibre is in balance: {sum:?}");
        assert_eq!(arrows[0].1, fibre_forces(&fibre, 1., 8.)[0]);
    }
}
