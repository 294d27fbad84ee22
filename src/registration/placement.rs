//! Landmarks found on the face, and the similarity that they tell.

use super::{RegistrationError, RegistrationWarning, Similarity};
use crate::face::Face;
use crate::units::Vec3;

/// Landmarks needed.
const NEEDED: usize = 8;
/// Smallest and largest size of a head against the standard face: children to large adults.
const SIZES: [f64; 2] = [0.6, 1.6];
/// Units in which scans come, in mm.
const UNITS: [(&str, f64); 3] = [("m", 1000.), ("cm", 10.), ("in", 25.4)];
/// A fit that leaves more than this, rms, may have landmarks exchanged, mm.
const DOUBTFUL_MM: f64 = 4.;
/// Share of what the fit leaves, below which a fit with some exchanged is the better one.
const BETTER: f64 = 0.75;
/// What a fit of a face leaves at most, rms, mm.
const MOST_MM: f64 = 14.;
/// Distances at which a landmark loses weight, and from which it is left out, mm.
const TOLERANCE_MM: f64 = 8.;
const MISPLACED_MM: f64 = 14.;

/// A landmark as it was measured.
#[derive(Clone, Debug, PartialEq)]
pub struct GivenLandmark {
    /// Its name on the face: `cheilion_l`.
    pub name: String,
    /// Where it was measured, mm.
    pub position: Vec3,
}

/// Landmarks that the face has, and where they put it.
#[derive(Clone, Debug)]
pub(super) struct Placement {
    /// From the face to the scan.
    pub(super) similarity: Similarity,
    /// Number of the landmark on the face and place on the scan, mm, in the order given.
    pub(super) known: Vec<(usize, Vec3)>,
    /// Of each known one, whether it is where the others have it.
    pub(super) is_sound: Vec<bool>,
    /// What the similarity leaves of the sound ones, rms, mm.
    pub(super) rms_mm: f64,
}

impl Placement {
    /// Where `given` puts `face`.
    ///
    /// # Errors
    /// [`RegistrationError`] for too few landmarks, other units, and names that are exchanged.
    pub(super) fn new(
        face: &Face,
        given: &[GivenLandmark],
        warnings: &mut Vec<RegistrationWarning>,
    ) -> Result<Self, RegistrationError> {
        let names: Vec<String> = face.landmarks.iter().map(|l| l.name.clone()).collect();
        let mut known: Vec<(usize, Vec3)> = Vec::new();
        for landmark in given {
            let name = landmark.name.clone();
            if !landmark.position.iter().all(|x| x.is_finite()) {
                return Err(RegistrationError::NotFinite { what: format!("the landmark {name}") });
            }
            match names.iter().position(|own| *own == name) {
                Some(k) if known.iter().any(|(other, _)| *other == k) => {
                    return Err(RegistrationError::Twice { name });
                }
                Some(k) => known.push((k, landmark.position)),
                None => {
                    warnings.push(RegistrationWarning::UnknownLandmark { name, known: names.clone() });
                }
            }
        }
        if known.len() < NEEDED {
            return Err(RegistrationError::FewLandmarks { known: known.len(), needed: NEEDED, names });
        }
        let pairs: Vec<[Vec3; 2]> =
            known.iter().map(|&(k, y)| [face.landmarks[k].site.position, y]).collect();
        check_size(&pairs)?;
        let name = |k: usize| names[known[k].0].clone();
        check_names(&pairs, name)?;
        let (mut similarity, _) =
            Similarity::robust(&pairs, TOLERANCE_MM).ok_or(RegistrationError::Collinear)?;
        let distance = |pair: &[Vec3; 2]| (similarity.apply(pair[0]) - pair[1]).norm();
        let is_sound: Vec<bool> = pairs.iter().map(|pair| distance(pair) <= MISPLACED_MM).collect();
        for (k, pair) in pairs.iter().enumerate().filter(|(k, _)| !is_sound[*k]) {
            let distance_mm = distance(pair);
            warnings.push(RegistrationWarning::MisplacedLandmark { name: name(k), distance_mm });
        }
        let sound: Vec<[Vec3; 2]> =
            pairs.iter().zip(&is_sound).filter(|(_, s)| **s).map(|(p, _)| *p).collect();
        if sound.len() < NEEDED.min(pairs.len()) {
            let (worst, worst_mm) = pairs
                .iter()
                .map(distance)
                .enumerate()
                .fold((0, 0.), |most, next| if next.1 > most.1 { next } else { most });
            let rms_mm = similarity.rms(&pairs);
            return Err(RegistrationError::NoFace { rms_mm, name: name(worst), worst_mm });
        }
        if let Some((again, _)) = Similarity::robust(&sound, TOLERANCE_MM) {
            similarity = again;
        }
        Ok(Self { similarity, rms_mm: similarity.rms(&sound), known, is_sound })
    }
}

/// Root mean square distance of points from their mean, mm.
fn spread(points: impl Iterator<Item = Vec3> + Clone) -> f64 {
    let n = points.clone().count().max(1) as f64;
    let mean = points.clone().sum::<Vec3>() / n;
    (points.map(|p| (p - mean).norm_squared()).sum::<f64>() / n).sqrt()
}

fn check_size(pairs: &[[Vec3; 2]]) -> Result<(), RegistrationError> {
    let [own, given] = [0, 1].map(|k| spread(pairs.iter().map(move |pair| pair[k])));
    let ratio = given / own;
    let is_size = |ratio: f64| (SIZES[0]..=SIZES[1]).contains(&ratio);
    if is_size(ratio) {
        return Ok(());
    }
    let unit = UNITS.into_iter().find(|(_, mm)| is_size(ratio * mm)).map(|(name, _)| name);
    Err(RegistrationError::Unit { ratio, unit })
}

/// Whether all fit better mirrored, or with two exchanged.
fn check_names(pairs: &[[Vec3; 2]], name: impl Fn(usize) -> String) -> Result<(), RegistrationError> {
    let ones = vec![1.; pairs.len()];
    let fit = |pairs: &[[Vec3; 2]], reflects| {
        Similarity::fit(pairs, &ones, reflects).map_or(f64::INFINITY, |found| found.rms(pairs))
    };
    let rms_mm = fit(pairs, false);
    if rms_mm.is_infinite() {
        return Err(RegistrationError::Collinear);
    }
    if rms_mm <= DOUBTFUL_MM {
        return Ok(());
    }
    let mirrored_mm = fit(pairs, true);
    let mut best = (f64::INFINITY, 0, 0);
    for i in 0..pairs.len() {
        for j in 0..i {
            let mut exchanged = pairs.to_vec();
            (exchanged[i][1], exchanged[j][1]) = (pairs[j][1], pairs[i][1]);
            let rms = fit(&exchanged, false);
            if rms < best.0 {
                best = (rms, j, i);
            }
        }
    }
    let (exchanged_mm, first, second) = best;
    if mirrored_mm.min(exchanged_mm) > BETTER * rms_mm {
        return if rms_mm <= MOST_MM { Ok(()) } else { no_face(pairs, name) };
    }
    Err(if mirrored_mm < exchanged_mm {
        RegistrationError::Mirrored { rms_mm, mirrored_mm }
    } else {
        let (first, second) = (name(first), name(second));
        RegistrationError::Exchanged { first, second, rms_mm, exchanged_mm }
    })
}

/// An error, unless leaving a few out makes a face of the rest.
fn no_face(pairs: &[[Vec3; 2]], name: impl Fn(usize) -> String) -> Result<(), RegistrationError> {
    let Some((robust, weights)) = Similarity::robust(pairs, TOLERANCE_MM) else {
        return Err(RegistrationError::Collinear);
    };
    let kept = weights.iter().filter(|w| **w > 0.1).count();
    if kept >= NEEDED && 4 * kept >= 3 * pairs.len() {
        return Ok(());
    }
    let off = pairs.iter().map(|&[x, y]| (robust.apply(x) - y).norm()).enumerate();
    let (worst, worst_mm) = off.fold((0, 0.), |most, next| if next.1 > most.1 { next } else { most });
    Err(RegistrationError::NoFace { rms_mm: robust.rms(pairs), name: name(worst), worst_mm })
}
