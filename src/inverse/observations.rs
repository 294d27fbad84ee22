//! The points of the face that a target observes.

use super::error::TargetError;
use super::spelling::nearest;
use super::target::{EffortMeasure, EffortNorm, JawOpening, Place, Target};
use crate::face::{Face, Muscle, polyline_length};
use crate::mesh::Site;
use crate::units::Vec3;

/// The observed points of one face, each once, and where the target's parts find theirs.
///
/// The sites are in the order of the point rows of [`Response::map`](crate::forward::Response): site
/// `k` owns rows `3k`, `3k + 1` and `3k + 2`.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Observations {
    /// The `p` observed points.
    pub sites: Vec<Site>,
    /// Point of each marker.
    pub markers: Vec<usize>,
    /// Points `[from, to]` of each feature.
    pub features: Vec<[usize; 2]>,
    /// Points `[left, right]` of each mirrored pair.
    pub symmetry: Vec<[usize; 2]>,
    /// What each muscle (m) costs by the target's measure of effort; empty where all cost the same.
    pub cost: Vec<f64>,
}

impl Observations {
    /// Number `d = 3p` of rows of the response's map.
    pub fn n_rows(&self) -> usize {
        3 * self.sites.len()
    }

    /// Finds the points of `target` on `face`.
    ///
    /// `locate` carries a rest position (mm) to the tissue, or says how far (mm) the nearest is.
    ///
    /// # Errors
    /// [`TargetError`]: unknown landmark, point off the face, or anything [`Target::check`] finds.
    pub fn resolve(
        target: &Target,
        face: &Face,
        locate: impl Fn(Vec3) -> Result<Site, f64>,
    ) -> Result<Self, TargetError> {
        let muscles: Vec<String> = face.muscles.iter().map(|m| m.name.clone()).collect();
        target.check(&muscles)?;
        if target.jaw_opening.is_some() && face.jaw.is_none() {
            return Err(TargetError::NoJaw { field: JawOpening::FIELD.to_owned() });
        }
        let mut observations = Self::default();
        let mut find = |place: &Place, field: String| -> Result<usize, TargetError> {
            let site = match place {
                Place::Landmark(name) => match face.landmark(name) {
                    Some(landmark) => landmark.site.clone(),
                    None => {
                        let choices = face.landmarks.iter().map(|l| l.name.as_str());
                        let (name, nearest) = (name.clone(), nearest(name, choices));
                        return Err(TargetError::UnknownLandmark {
                            field: format!("{field}landmark"),
                            name,
                            nearest,
                        });
                    }
                },
                Place::Point(point) => {
                    let field = format!("{field}point_mm");
                    if let Some(&value) = point.iter().find(|v| !v.is_finite()) {
                        return Err(TargetError::NotFinite { field, value });
                    }
                    locate(*point).map_err(|distance_mm| TargetError::OutsideFace {
                        field,
                        point: *point,
                        distance_mm,
                    })?
                }
            };
            let sites = &mut observations.sites;
            Ok(sites.iter().position(|s| *s == site).unwrap_or_else(|| {
                sites.push(site);
                sites.len() - 1
            }))
        };
        let mut markers = Vec::new();
        for (k, marker) in target.markers.iter().enumerate() {
            markers.push(find(&marker.at, format!("markers[{k}]."))?);
        }
        let mut features = Vec::new();
        for (k, feature) in target.features.iter().enumerate() {
            let from = find(&feature.from, format!("features[{k}].from."))?;
            features.push([from, find(&feature.to, format!("features[{k}].to."))?]);
        }
        let mut symmetry = Vec::new();
        for (k, pair) in target.symmetry.iter().enumerate() {
            let left = find(&pair.left, format!("symmetry[{k}].left."))?;
            symmetry.push([left, find(&pair.right, format!("symmetry[{k}].right."))?]);
        }
        // Two names of one point, or two points carried by the same tissue, measure nothing.
        let lists = [("features", &features), ("symmetry", &symmetry)];
        for (list, pairs) in lists {
            if let Some(k) = pairs.iter().position(|[a, b]| a == b) {
                return Err(TargetError::SamePoint { field: format!("{list}[{k}]") });
            }
        }
        (observations.markers, observations.features, observations.symmetry) = (markers, features, symmetry);
        observations.cost = costs(target.effort_by, target.effort_norm, face);
        Ok(observations)
    }
}

/// What each muscle of `face` costs, relative to their mean; empty where all cost the same.
fn costs(measure: EffortMeasure, norm: EffortNorm, face: &Face) -> Vec<f64> {
    let of = |muscle: &Muscle| {
        let lengths: f64 =
            muscle.fibres.iter().map(|fibre| polyline_length(&fibre.points, fibre.closed)).sum();
        match (measure, norm) {
            (EffortMeasure::Activation, _) => 1.,
            (EffortMeasure::Force, EffortNorm::L1) => muscle.max_force_n,
            (EffortMeasure::Force, EffortNorm::L2) => muscle.max_force_n.powi(2),
            (EffortMeasure::Volume, _) => muscle.max_force_n * lengths / muscle.fibres.len().max(1) as f64,
        }
    };
    if measure == EffortMeasure::Activation {
        return Vec::new();
    }
    let costs: Vec<f64> = face.muscles.iter().map(of).collect();
    let mean = costs.iter().sum::<f64>() / costs.len().max(1) as f64;
    costs.into_iter().map(|cost| cost / mean).collect()
}
