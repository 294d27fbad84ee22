//! The standard face's proportions fitted to landmarks and skin.

use nalgebra::{DMatrix, DVector};

use super::correspondence::{FaceSkin, Tie, correspond};
use super::scan::Scan;
use super::similarity::Similarity;
use crate::face::Face;
use crate::face::standard::{ParameterError, Parameters, Resolution, parametric};
use crate::units::Vec3;

/// Rounds of Gauss and Newton, each with new correspondences.
const ROUNDS: usize = 4;
/// Step of the differences, as a share of a proportion's standard deviation.
const DIFFERENCE: f64 = 0.05;
/// Standard deviation of a landmark, mm: of measuring it, and of what proportions do not make.
const LANDMARK_MM: f64 = 2.;
/// All the skin counts as so many landmarks.
const SKIN: f64 = 10.;
/// Distance at which a point of the skin loses weight, and beyond which it has no counterpart, mm.
const TOLERANCE_MM: f64 = 3.;
const REACH_MM: f64 = 12.;

/// A standard face with fitted proportions, brought to where the landmarks are.
pub(super) struct Fitted {
    pub(super) parameters: Parameters,
    pub(super) face: Face,
    /// From the face to the landmarks.
    pub(super) similarity: Similarity,
}

impl Fitted {
    fn new(
        parameters: Parameters,
        resolution: &Resolution,
        landmarks: &[(usize, Vec3)],
    ) -> Result<Option<Self>, ParameterError> {
        let face = parametric(&parameters, resolution)?;
        Ok(bring(&face, landmarks).map(|similarity| Self { parameters, face, similarity }))
    }

    fn nodes(&self) -> Vec<Vec3> {
        self.face.mesh.points.iter().map(|&x| self.similarity.apply(x)).collect()
    }

    /// Residuals of landmarks, skin and proportions, each over its standard deviation.
    fn residuals(&self, landmarks: &[(usize, Vec3)], ties: &[Tie]) -> DVector<f64> {
        let mut residuals = Vec::with_capacity(3 * landmarks.len() + ties.len() + 5);
        for &(k, y) in landmarks {
            let r = (self.similarity.apply(self.face.landmarks[k].site.position) - y) / LANDMARK_MM;
            residuals.extend(r.iter());
        }
        let area: f64 = ties.iter().map(|tie| tie.area).sum();
        for tie in ties {
            let x: Vec3 = tie.carriers.iter().map(|&(n, w)| w * self.face.mesh.points[n]).sum();
            let r = tie.normal.dot(&(self.similarity.apply(x) - tie.target));
            let robust = TOLERANCE_MM.powi(2) / (TOLERANCE_MM.powi(2) + tie.distance_mm.powi(2));
            residuals.push((SKIN * tie.area / area).sqrt() * robust * r / LANDMARK_MM);
        }
        let drawn = Parameters::default();
        for proportion in &Parameters::PROPORTIONS {
            residuals.push((proportion.of(&self.parameters) - proportion.of(&drawn)) / proportion.sd_mm);
        }
        DVector::from_vec(residuals)
    }
}

/// The similarity from a face to the `landmarks`, each its number on the face and its place, mm.
pub(super) fn bring(face: &Face, landmarks: &[(usize, Vec3)]) -> Option<Similarity> {
    let pairs: Vec<[Vec3; 2]> =
        landmarks.iter().map(|&(k, y)| [face.landmarks[k].site.position, y]).collect();
    Similarity::fit(&pairs, &vec![1.; pairs.len()], false)
}

/// The proportions that minimise the squared residuals of `landmarks` (number on the face, place in mm), of the skin to
/// the `scan` and of the proportions to the standard's, by Gauss and Newton with differences; the similarity that goes
/// with each is eliminated. `None` where the landmarks fix no similarity.
///
/// # Errors
/// [`ParameterError`] when no such face can be built.
pub(super) fn fit_proportions(
    resolution: &Resolution,
    landmarks: &[(usize, Vec3)],
    scan: &Scan,
) -> Result<Option<Fitted>, ParameterError> {
    let Some(mut now) = Fitted::new(Parameters::default(), resolution, landmarks)? else { return Ok(None) };
    let skin = FaceSkin::of(&now.face);
    for _ in 0..ROUNDS {
        let ties = correspond(&skin.at(&now.face, &now.nodes()), &scan.sheet, &[], REACH_MM);
        let residuals = now.residuals(landmarks, &ties);
        let mut jacobian = DMatrix::zeros(residuals.len(), Parameters::PROPORTIONS.len());
        for (k, proportion) in Parameters::PROPORTIONS.iter().enumerate() {
            let mut nudged = now.parameters.clone();
            let value = proportion.of(&nudged);
            // Away from the nearer end of what can be built.
            let step = DIFFERENCE * proportion.sd_mm;
            proportion.set(&mut nudged, value + step);
            if proportion.of(&nudged) < value + step {
                proportion.set(&mut nudged, value - step);
            }
            let step = proportion.of(&nudged) - value;
            let Some(nudged) = Fitted::new(nudged, resolution, landmarks)? else { return Ok(None) };
            jacobian.set_column(k, &((nudged.residuals(landmarks, &ties) - &residuals) / step));
        }
        let normal = jacobian.tr_mul(&jacobian);
        let Some(step) = normal.cholesky().map(|factor| factor.solve(&jacobian.tr_mul(&residuals))) else {
            break;
        };
        let mut share = 1.;
        let moved = loop {
            let mut next = now.parameters.clone();
            for (k, proportion) in Parameters::PROPORTIONS.iter().enumerate() {
                proportion.set(&mut next, proportion.of(&now.parameters) - share * step[k]);
            }
            let Some(next) = Fitted::new(next, resolution, landmarks)? else { return Ok(None) };
            if next.residuals(landmarks, &ties).norm_squared() <= residuals.norm_squared() {
                break Some(next);
            }
            share *= 0.5;
            if share < 0.1 {
                break None;
            }
        };
        match moved {
            Some(next) => now = next,
            None => break,
        }
    }
    Ok(Some(now))
}
