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
}
