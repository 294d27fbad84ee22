//! A recording fitted.

use std::collections::BTreeMap;

use super::movement::Movement;
use super::region::region;
use super::subject::Subject;
use super::tracker::{FrameStatus, TrackedFrame};
use crate::face::Face;

/// How well some markers are met, over all frames in which they count.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Met {
    /// Observations: markers by frames.
    pub observations: usize,
    /// Root mean square of the residuals, mm.
    pub rms_mm: f64,
    /// Root mean square of the measured displacements, mm.
    pub movement_mm: f64,
    /// Share of the measured movement that is explained, `1 - rms^2 / movement^2`; `None` where nothing moved.
    pub explained: Option<f64>,
}

/// A marker far from what the others say.
#[derive(Clone, Debug, PartialEq, PartialOrd)]
pub struct Outlier {
    /// The frame, from 0.
    pub frame: usize,
    /// The marker's label.
    pub marker: String,
    /// How far it is from where the others put it, mm.
    pub residual_mm: f64,
}

/// What a recording comes to.
#[derive(Clone, Debug, PartialEq)]
pub struct TrackSummary {
    /// How many frames ended how.
    pub frames: BTreeMap<FrameStatus, usize>,
    /// All markers.
    pub all: Met,
    /// By region of the face.
    pub regions: BTreeMap<String, Met>,
    /// By label.
    pub markers: BTreeMap<String, Met>,
    /// Markers far from what the others say, by frame.
    pub outliers: Vec<Outlier>,
    /// Largest violation of the optimality conditions.
    pub certificate: f64,
}

#[derive(Clone, Copy, Default)]
struct Sums {
    observations: usize,
    residual: f64,
    movement: f64,
}

impl Sums {
    fn met(self) -> Met {
        let mean = |squares: f64| (squares / self.observations.max(1) as f64).sqrt();
        Met {
            observations: self.observations,
            rms_mm: mean(self.residual),
            movement_mm: mean(self.movement),
            explained: (self.movement > 0.).then(|| 1. - self.residual / self.movement),
        }
    }
}

impl TrackSummary {
    /// That of `frames` of the `movement` of a `subject` on `face`.
    pub fn of(face: &Face, subject: &Subject, movement: &Movement, frames: &[TrackedFrame]) -> Self {
        let regions: Vec<String> = subject.bound.iter().map(|b| region(face, b.site.position)).collect();
        let mut statuses: BTreeMap<FrameStatus, usize> = FrameStatus::ALL.map(|s| (s, 0)).into();
        let (mut all, mut by_region, mut by_marker) = (Sums::default(), BTreeMap::new(), BTreeMap::new());
        let mut outliers = Vec::new();
        let mut certificate = 0_f64;
        for (f, frame) in frames.iter().enumerate() {
            *statuses.entry(frame.status).or_default() += 1;
            certificate = certificate.max(frame.certificate);
            for (b, bound) in subject.bound.iter().enumerate() {
                let (Some(residual), Some(u)) = (frame.residual_mm[b], movement.frame(f)[b]) else {
                    continue;
                };
                if frame.outliers.contains(&b) {
                    let (marker, residual_mm) = (bound.label.clone(), residual.norm());
                    outliers.push(Outlier { frame: f, marker, residual_mm });
                    continue;
                }
                let own: [&mut Sums; 3] = [
                    &mut all,
                    by_region.entry(regions[b].clone()).or_default(),
                    by_marker.entry(bound.label.clone()).or_default(),
                ];
                for sums in own {
                    sums.observations += 1;
                    sums.residual += residual.norm_squared();
                    sums.movement += u.norm_squared();
                }
            }
        }
        let met = |sums: BTreeMap<String, Sums>| sums.into_iter().map(|(name, s)| (name, s.met())).collect();
        Self {
            frames: statuses,
            all: all.met(),
            regions: met(by_region),
            markers: met(by_marker),
            outliers,
            certificate,
        }
    }
}
