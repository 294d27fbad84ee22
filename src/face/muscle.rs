//! Muscles as bundles of fibre polylines.

use super::polyline_length;
use crate::units::Vec3;

/// A fibre: a polyline from origin (bone) to insertion (skin), or closed for a sphincter.
#[derive(Clone, Debug, PartialEq)]
pub struct Fibre {
    /// Points, mm; for a closed fibre the first is not repeated at the end.
    pub points: Vec<Vec3>,
    /// Whether the last point joins the first.
    pub closed: bool,
}

impl Fibre {
    /// The share of the fibre's tension that each of its segments carries: 1, and along the last `insertion_mm` before
    /// the insertion (or the whole fibre, where it is shorter) falling to 0. A closed fibre has no insertion.
    pub fn tension_shares(&self, insertion_mm: f64) -> Vec<f64> {
        let n = self.points.len();
        let n_segments = if self.closed { n } else { n.saturating_sub(1) };
        let length = |i: usize| (self.points[(i + 1) % n] - self.points[i]).norm();
        let mut remaining: f64 = (0..n_segments).map(length).sum();
        let ramp = if self.closed { 0. } else { insertion_mm.min(remaining) };
        let share = |i: usize| {
            let share = if ramp > 0. { ((remaining - 0.5 * length(i)) / ramp).min(1.) } else { 1. };
            remaining -= length(i);
            share
        };
        (0..n_segments).map(share).collect()
    }
}

/// A muscle: one activation that drives a bundle of fibres.
#[derive(Clone, Debug, PartialEq)]
pub struct Muscle {
    /// Name with the subject's side, `zygomaticus_major_l`; unpaired muscles have none.
    pub name: String,
    /// Force at full activation, N, shared equally by the fibres.
    pub max_force_n: f64,
    /// Tissue within this distance of a fibre is muscle tissue, mm.
    pub radius_mm: f64,
    /// Cross-section of the bundle, mm². The tissue within the radius is muscle in the volume fraction
    /// `min(1, area x mean fibre length / its volume)` and passive for the rest, so that a thin muscle on
    /// a coarse mesh is not stiffer than it is; `None` takes that tissue for muscle in full.
    pub area_mm2: Option<f64>,
    /// Length at the insertion over which the tension ramps to zero, mm; 0 is a point load.
    pub insertion_mm: f64,
    /// The bundle.
    pub fibres: Vec<Fibre>,
}

impl Muscle {
    /// Volume of the muscle, area x mean fibre length, mm³, if its cross-section is known.
    pub fn volume_mm3(&self) -> Option<f64> {
        let length: f64 = self.fibres.iter().map(|f| polyline_length(&f.points, f.closed)).sum();
        Some(self.area_mm2? * length / self.fibres.len().max(1) as f64)
    }

    /// Integral of the tension of full activation along the fibres, N mm: what the muscle's force can do per unit of
    /// shortening.
    pub fn tension_moment(&self) -> f64 {
        let along = |fibre: &Fibre| -> f64 {
            let n = fibre.points.len();
            let length = |i: usize| (fibre.points[(i + 1) % n] - fibre.points[i]).norm();
            fibre
                .tension_shares(self.insertion_mm)
                .iter()
                .enumerate()
                .map(|(i, share)| share * length(i))
                .sum()
        };
        self.max_force_n * self.fibres.iter().map(along).sum::<f64>() / self.fibres.len().max(1) as f64
    }
}
