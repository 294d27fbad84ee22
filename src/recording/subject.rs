//! A subject's markers on a face.

use std::collections::{BTreeMap, HashSet};
use std::fmt;

use super::error::{OffSkinMarker, SubjectError, listed};
use super::marker_map::{MarkerMap, MarkerPlace, Neutral, OffSkin};
use super::recording::Recording;
use crate::face::{Face, Similarity};
use crate::inverse::spelling;
use crate::mesh::{Locator, Site};
use crate::units::{Vec3, counted};

/// How far off the skin a marker's neutral place may lie to be projected to it, mm.
pub const OFF_SKIN_MM: f64 = 5.;
/// Scales of people to a face; others are a mistaken unit.
const PEOPLE: [f64; 2] = [0.5, 2.];
/// Distance, mm, beyond which a landmark of the subject and of the face do not help to align them.
const ALIKE_MM: f64 = 4.;
/// Distance, mm, from which a subject's landmark so far from the face's is told.
const UNLIKE_MM: f64 = 10.;
/// How much closer two landmarks must come when their labels are exchanged.
const SWAPPED_SHARE: f64 = 0.4;

/// A marker and the point of the face that it is.
#[derive(Clone, Debug, PartialEq)]
pub struct BoundMarker {
    /// Its place in the recording, from 0.
    pub marker: usize,
    /// Its label.
    pub label: String,
    /// Its neutral position, mm, in the subject's frame.
    pub neutral_mm: Vec3,
    /// The point of the face.
    pub site: Site,
    /// The landmark that it is, if it is one.
    pub landmark: Option<String>,
    /// How far the aligned neutral position is from that point, mm: of a landmark how the faces differ, else how far it was
    /// projected.
    pub distance_mm: f64,
    /// Standard deviation of its position, mm, on the face.
    pub sigma_mm: f64,
}

/// Doubts about how a subject was brought to a face.
#[derive(Clone, Debug, PartialEq)]
pub enum SubjectWarning {
    /// Markers whose neutral place is too far from the skin.
    LeftOut(Vec<OffSkinMarker>),
    /// Markers without a neutral position.
    NoNeutral(Vec<String>),
    /// Landmarks of the subject far from those of the face.
    Unlike(Vec<OffSkinMarker>),
    /// The face has no jaw joint: its jaw rests.
    NoJaw,
    /// Two labels fit better exchanged in all frames; they were exchanged.
    Swapped {
        /// The labels.
        labels: [String; 2],
        /// Root mean square distance of the two from the face's landmarks as they stand, mm.
        as_stated_mm: f64,
        /// The same when exchanged.
        exchanged_mm: f64,
    },
}

impl fmt::Display for SubjectWarning {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::LeftOut(markers) => write!(
                f,
                "{} farther than {OFF_SKIN_MM} mm off the skin, left out: {}; map them to landmarks, or to points of the face",
                counted(markers.len(), "marker"),
                listed(markers)
            ),
            Self::NoNeutral(labels) => write!(
                f,
                "{} without a neutral position, left out: {}; state neutral frames that see them",
                counted(labels.len(), "marker"),
                labels.join(", ")
            ),
            Self::Unlike(markers) => write!(
                f,
                "{} more than {UNLIKE_MM} mm from where the face has the landmark: {}; check the labels, or register a face \
                 of the subject",
                counted(markers.len(), "marker"),
                listed(markers)
            ),
            Self::NoJaw => f.write_str(
                "the face has no jaw joint, so that its jaw rests; add `[jaw]` to the face where the subject's moves",
            ),
            Self::Swapped { labels: [a, b], as_stated_mm, exchanged_mm } => write!(
                f,
                "`{a}` and `{b}` are {as_stated_mm:.1} mm from the face's landmarks as they are labelled and {exchanged_mm:.1} mm \
                 when exchanged: they were exchanged in all frames; check the labels"
            ),
        }
    }
}

/// A subject brought to a face: where each marker sits on it, and the map from the subject's millimetres to the face's.
#[derive(Clone, Debug, PartialEq)]
pub struct Subject {
    /// From the subject's neutral frame to the face's.
    pub alignment: Similarity,
    /// Root mean square distance of the aligned landmarks from the face's, mm.
    pub alignment_rms_mm: f64,
    /// The markers on the face.
    pub bound: Vec<BoundMarker>,
    /// Neutral positions of all markers (of the recording), mm, in the subject's frame.
    pub neutral_mm: Vec<Option<Vec3>>,
    /// Labels in the order of the recording, those that were exchanged being exchanged.
    pub labels: Vec<String>,
    /// Markers that move with the skull, by their place in the recording; empty: to be found.
    pub stable: Vec<usize>,
    /// Whether the head's own movement was taken away already.
    pub head_is_still: bool,
    /// Markers that may be found to be stable: all above the base of the nose.
    pub above: Vec<usize>,
    /// What is odd.
    pub warnings: Vec<SubjectWarning>,
}

impl Subject {
    /// The subject of `recording` on `face`, read as `map` says.
    ///
    /// # Errors
    /// [`SubjectError`]: names that are not there, fewer than three landmarks, a scale that is no person's, and markers off
    /// the skin where the map refuses them.
    pub fn new(recording: &Recording, map: &MarkerMap, face: &Face) -> Result<Self, SubjectError> {
        check_names(recording, map, face)?;
        let mut labels = recording.names().to_vec();
        let neutral_mm = neutral(recording, map)?;
        let landmark_of = |label: &str| match map.markers.get(label).map(|m| &m.place) {
            Some(MarkerPlace::Landmark(name)) => face.landmark(name),
            Some(_) => None,
            None => face.landmark(label),
        };
        let ignored: HashSet<&str> = map.ignore.iter().map(String::as_str).collect();
        let is_read = |label: &str| !ignored.contains(label);
        let pairs = |labels: &[String]| -> Vec<(usize, [Vec3; 2])> {
            let all = labels.iter().zip(&neutral_mm).enumerate().filter(|(_, (label, _))| is_read(label));
            all.filter_map(|(k, (label, at))| Some((k, [(*at)?, landmark_of(label)?.site.position])))
                .collect()
        };
        let mut warnings = Vec::new();
        let too_few = |found: usize| SubjectError::TooFewLandmarks { found };
        let align = |pairs: &[(usize, [Vec3; 2])]| {
            let ends: Vec<[Vec3; 2]> = pairs.iter().map(|(_, p)| *p).collect();
            Similarity::robust(&ends, map.scale, ALIKE_MM).ok_or(too_few(ends.len()))
        };
        let mut found = pairs(&labels);
        let mut alignment = align(&found)?;
        while let Some((a, b, warning)) = exchanged(&found, &alignment, &labels) {
            labels.swap(a, b);
            warnings.push(warning);
            found = pairs(&labels);
            alignment = align(&found)?;
        }
        if !(PEOPLE[0]..=PEOPLE[1]).contains(&alignment.scale) && map.scale.is_none() {
            return Err(SubjectError::Scale { scale: alignment.scale });
        }
        let off = |(_, p): &(usize, [Vec3; 2])| (alignment.apply(p[0]) - p[1]).norm_squared();
        let alignment_rms_mm = (found.iter().map(off).sum::<f64>() / found.len() as f64).sqrt();

        let skin: HashSet<usize> = face.skin.iter().copied().collect();
        let locator = Locator::new(&face.mesh);
        let (mut bound, mut off_skin, mut unlike, mut without) =
            (Vec::new(), Vec::new(), Vec::new(), Vec::new());
        let base = face.landmark("subnasale").map_or(0., |l| l.site.position.y);
        let mut above = Vec::new();
        for (marker, label) in labels.iter().enumerate().filter(|(_, label)| is_read(label)) {
            let Some(neutral) = neutral_mm[marker] else {
                without.push(label.clone());
                continue;
            };
            let at = alignment.apply(neutral);
            if at.y > base {
                above.push(marker);
            }
            let mapped = map.markers.get(label);
            let sigma_mm = mapped.and_then(|m| m.sigma_mm).unwrap_or(map.sigma_mm) * alignment.scale;
            let landmark = landmark_of(label);
            let told = |distance_mm| OffSkinMarker { label: label.clone(), distance_mm };
            let (site, distance_mm) = match (landmark, mapped.map(|m| &m.place)) {
                (Some(landmark), _) => {
                    let distance_mm = (landmark.site.position - at).norm();
                    if distance_mm > UNLIKE_MM {
                        unlike.push(told(distance_mm));
                    }
                    (landmark.site.clone(), distance_mm)
                }
                (None, place) => {
                    let query = if let Some(MarkerPlace::Point(point)) = place { *point } else { at };
                    let on_skin =
                        locator.closest_among(query, |f| f.nodes().iter().all(|n| skin.contains(n)));
                    match on_skin {
                        Some(found) if found.distance_mm <= OFF_SKIN_MM => (found.site, found.distance_mm),
                        found => {
                            off_skin.push(told(found.map_or(f64::INFINITY, |f| f.distance_mm)));
                            continue;
                        }
                    }
                }
            };
            let landmark = landmark.map(|l| l.name.clone());
            let label = label.clone();
            bound.push(BoundMarker {
                marker,
                label,
                neutral_mm: neutral,
                site,
                landmark,
                distance_mm,
                sigma_mm,
            });
        }
        if map.off_skin == OffSkin::Refuse && !off_skin.is_empty() {
            return Err(SubjectError::OffSkin { markers: off_skin, limit_mm: OFF_SKIN_MM });
        }
        if bound.is_empty() {
            return Err(SubjectError::NothingOnSkin(off_skin));
        }
        let place = |label: &String| labels.iter().position(|l| l == label);
        let stable = map.stable.iter().filter_map(place).filter(|k| neutral_mm[*k].is_some()).collect();
        if !off_skin.is_empty() {
            warnings.push(SubjectWarning::LeftOut(off_skin));
        }
        if !without.is_empty() {
            warnings.push(SubjectWarning::NoNeutral(without));
        }
        if map.jaw.is_some() && face.jaw.is_none() {
            warnings.push(SubjectWarning::NoJaw);
        }
        if !unlike.is_empty() {
            warnings.push(SubjectWarning::Unlike(unlike));
        }
        let head_is_still = map.head_is_still;
        Ok(Self {
            alignment,
            alignment_rms_mm,
            bound,
            neutral_mm,
            labels,
            stable,
            head_is_still,
            above,
            warnings,
        })
    }
}

/// Two landmarks that are both far off and come close when their labels are exchanged.
fn exchanged(
    pairs: &[(usize, [Vec3; 2])],
    alignment: &Similarity,
    labels: &[String],
) -> Option<(usize, usize, SubjectWarning)> {
    let rms = |a: Vec3, b: Vec3| (0.5 * (a.norm_squared() + b.norm_squared())).sqrt();
    let at: Vec<Vec3> = pairs.iter().map(|(_, p)| alignment.apply(p[0])).collect();
    let mut best: Option<(f64, usize, usize, f64)> = None;
    for (i, (_, p)) in pairs.iter().enumerate() {
        for (j, (_, q)) in pairs.iter().enumerate().skip(i + 1) {
            let as_stated_mm = rms(at[i] - p[1], at[j] - q[1]);
            let exchanged_mm = rms(at[i] - q[1], at[j] - p[1]);
            let is_better = as_stated_mm > UNLIKE_MM && exchanged_mm < SWAPPED_SHARE * as_stated_mm;
            if is_better && best.is_none_or(|b| as_stated_mm - exchanged_mm > b.3 - b.0) {
                best = Some((exchanged_mm, i, j, as_stated_mm));
            }
        }
    }
    best.map(|(exchanged_mm, i, j, as_stated_mm)| {
        let (a, b) = (pairs[i].0, pairs[j].0);
        let labels = [labels[a].clone(), labels[b].clone()];
        (a, b, SubjectWarning::Swapped { labels, as_stated_mm, exchanged_mm })
    })
}

fn check_names(recording: &Recording, map: &MarkerMap, face: &Face) -> Result<(), SubjectError> {
    let known: HashSet<&str> = recording.names().iter().map(String::as_str).collect();
    let unknown = |label: &&String| !known.contains(label.as_str());
    let all = map.markers.keys().chain(&map.ignore).chain(&map.stable);
    if let Some(label) = all.clone().find(unknown) {
        let nearest = spelling::nearest(label, recording.names().iter().map(String::as_str));
        return Err(SubjectError::UnknownLabel { label: label.clone(), nearest });
    }
    for (label, marker) in &map.markers {
        if let MarkerPlace::Landmark(landmark) = &marker.place
            && face.landmark(landmark).is_none()
        {
            let nearest = spelling::nearest(landmark, face.landmarks.iter().map(|l| l.name.as_str()));
            let (label, landmark) = (label.clone(), landmark.clone());
            return Err(SubjectError::UnknownLandmark { label, landmark, nearest });
        }
    }
    Ok(())
}

/// Neutral positions of the markers, mm.
fn neutral(recording: &Recording, map: &MarkerMap) -> Result<Vec<Option<Vec3>>, SubjectError> {
    let found: Vec<Option<Vec3>> = match &map.neutral {
        Neutral::Positions(positions) => {
            recording.names().iter().map(|label| positions.get(label).copied()).collect()
        }
        Neutral::Span([from, to]) => {
            let is_in = |t: f64| {
                (*from..=*to).contains(&t) || (*from <= 0. && *to <= 0. && t == recording.times_s()[0])
            };
            let frames: Vec<usize> =
                (0..recording.times_s().len()).filter(|f| is_in(recording.times_s()[*f])).collect();
            stacked(recording, &frames)
        }
    };
    if found.iter().all(Option::is_none) {
        let span = match map.neutral {
            Neutral::Span(span) => span,
            Neutral::Positions(_) => [0.; 2],
        };
        return Err(SubjectError::NoNeutral { span });
    }
    Ok(found)
}

/// The median position of each marker over `frames`, each brought to the first by the similarity of scale 1 that fits all
/// markers best, so that the head may move meanwhile.
fn stacked(recording: &Recording, frames: &[usize]) -> Vec<Option<Vec3>> {
    let m = recording.names().len();
    let Some(&first) = frames.first() else { return vec![None; m] };
    let mut seen: BTreeMap<usize, Vec<Vec3>> = BTreeMap::new();
    for &frame in frames {
        let both = recording.frame(frame).iter().zip(recording.frame(first));
        let pairs: Vec<[Vec3; 2]> = both.filter_map(|(a, b)| Some([(*a)?, (*b)?])).collect();
        let moved = match frame == first {
            true => Some(Similarity::identity()),
            false => Similarity::robust(&pairs, Some(1.), 1.),
        };
        let Some(moved) = moved else { continue };
        for (marker, at) in recording.frame(frame).iter().enumerate() {
            seen.entry(marker).or_default().extend(at.map(|p| moved.apply(p)));
        }
    }
    let median = |positions: &mut Vec<Vec3>| {
        let mut axis = |k: usize| {
            positions.sort_by(|a, b| a[k].total_cmp(&b[k]));
            let half = positions.len() / 2;
            if positions.len() % 2 == 1 {
                positions[half][k]
            } else {
                0.5 * (positions[half - 1][k] + positions[half][k])
            }
        };
        Vec3::new(axis(0), axis(1), axis(2))
    };
    (0..m).map(|k| seen.get_mut(&k).filter(|p| !p.is_empty()).map(median)).collect()
}
