//! How the head moves.

use super::error::SubjectError;
use super::recording::Recording;
use super::subject::Subject;
use crate::face::Similarity;
use crate::units::Vec3;

/// Frames that are looked at to tell which markers keep their distances.
const LOOKED_AT: usize = 400;
/// Standard deviation, mm, of the distance between two markers that are fixed to one bone under the skin: 0.3 to 0.5 mm of
/// measurement and of skin that slides.
const RIGID_MM: f64 = 1.;
/// Distance, mm, beyond which a stable marker of a frame is thought to be mislabelled or to slip.
const SLIP_MM: f64 = 1.5;
/// Longest gap, s, over which the head's place is interpolated.
const LONGEST_GAP_S: f64 = 0.25;

/// Where the head is in each frame: what brings it back to the neutral one.
#[derive(Clone, Debug, PartialEq)]
pub struct HeadMotion {
    /// The markers that it was found from, by their place in the recording.
    pub stable: Vec<usize>,
    /// Of each frame (f) what brings the recorded positions to the subject's neutral frame; `None` where too few stable markers
    /// are seen for too long.
    pub to_neutral: Vec<Option<Similarity>>,
    /// Frames between others that see the head, from which its place was interpolated.
    pub interpolated: Vec<usize>,
    /// Root mean square distance of the stable markers from their neutral places once brought back, mm.
    pub rms_mm: f64,
}

impl HeadMotion {
    /// How the head of `subject` moves in `recording`.
    ///
    /// # Errors
    /// [`SubjectError::TooFewStable`].
    pub fn of(recording: &Recording, subject: &Subject) -> Result<Self, SubjectError> {
        if subject.head_is_still {
            let to_neutral = vec![Some(Similarity::identity()); recording.times_s().len()];
            return Ok(Self { stable: Vec::new(), to_neutral, interpolated: Vec::new(), rms_mm: 0. });
        }
        let stable = match subject.stable.is_empty() {
            true => rigid(recording, subject),
            false => subject.stable.clone(),
        };
        let places: Vec<[Vec3; 2]> =
            stable.iter().filter_map(|&k| subject.neutral_mm[k].map(|p| [p; 2])).collect();
        let too_few = SubjectError::TooFewStable { found: places.len() };
        if Similarity::fit(&places, &vec![1.; places.len()], Some(1.)).is_none() {
            return Err(too_few);
        }
        let (mut squares, mut count) = (0., 0_usize);
        let frames = 0..recording.times_s().len();
        let mut to_neutral: Vec<Option<Similarity>> = frames
            .map(|frame| {
                let row = recording.frame(frame);
                let pairs = stable.iter().filter_map(|&k| Some([row[k]?, subject.neutral_mm[k]?]));
                let pairs: Vec<[Vec3; 2]> = pairs.collect();
                let head = Similarity::robust(&pairs, Some(1.), SLIP_MM)?;
                squares += pairs.iter().map(|p| (head.apply(p[0]) - p[1]).norm_squared()).sum::<f64>();
                count += pairs.len();
                Some(head)
            })
            .collect();
        if count == 0 {
            return Err(too_few);
        }
        let interpolated = interpolate(recording.times_s(), &mut to_neutral);
        Ok(Self { stable, to_neutral, interpolated, rms_mm: (squares / count as f64).sqrt() })
    }
}

/// Fills gaps that are short enough; returns the frames.
fn interpolate(times_s: &[f64], heads: &mut [Option<Similarity>]) -> Vec<usize> {
    let seen: Vec<usize> = (0..heads.len()).filter(|f| heads[*f].is_some()).collect();
    let mut filled = Vec::new();
    for pair in seen.windows(2).filter(|p| p[1] > p[0] + 1) {
        let (from, to) = (pair[0], pair[1]);
        let (Some(before), Some(after)) = (heads[from], heads[to]) else { continue };
        if times_s[to] - times_s[from] > LONGEST_GAP_S {
            continue;
        }
        for frame in from + 1..to {
            let share = (times_s[frame] - times_s[from]) / (times_s[to] - times_s[from]);
            heads[frame] = Some(Similarity {
                scale: 1.,
                rotation: before.rotation.slerp(&after.rotation, share),
                translation: before.translation.lerp(&after.translation, share),
            });
            filled.push(frame);
        }
    }
    filled
}

/// The markers above the base of the nose that keep their distances from each other: the largest set that grows from the
/// most rigid three.
fn rigid(recording: &Recording, subject: &Subject) -> Vec<usize> {
    let all = &subject.above;
    let frames = recording.times_s().len();
    let step = frames.div_ceil(LOOKED_AT);
    let deviation = |i: usize, j: usize| {
        let (mut n, mut mean, mut squares) = (0., 0., 0.);
        for frame in (0..frames).step_by(step) {
            let row = recording.frame(frame);
            if let (Some(a), Some(b)) = (row[i], row[j]) {
                let d = (a - b).norm();
                n += 1.;
                let off = d - mean;
                mean += off / n;
                squares += off * (d - mean);
            }
        }
        if n < 2. { if frames < 2 { 0. } else { f64::INFINITY } } else { (squares / n).sqrt() }
    };
    let table: Vec<Vec<f64>> = all.iter().map(|&i| all.iter().map(|&j| deviation(i, j)).collect()).collect();
    let mut best: Vec<usize> = Vec::new();
    for start in 0..all.len() {
        let mut set = vec![start];
        loop {
            let worst = |k: usize| set.iter().map(|&s| table[k][s]).fold(0., f64::max);
            let next =
                (0..all.len()).filter(|k| !set.contains(k)).min_by(|a, b| worst(*a).total_cmp(&worst(*b)));
            match next {
                Some(k) if worst(k) <= RIGID_MM => set.push(k),
                _ => break,
            }
        }
        let spread = |set: &[usize]| -> f64 {
            set.iter().map(|&a| set.iter().map(|&b| table[a][b]).fold(0., f64::max)).fold(0., f64::max)
        };
        let is_better = set.len() > best.len() || (set.len() == best.len() && spread(&set) < spread(&best));
        if is_better {
            best = set;
        }
    }
    best.sort_unstable();
    best.into_iter().map(|k| all[k]).collect()
}
