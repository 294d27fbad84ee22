//! How the markers move on the face, the head held still.

use super::error::SubjectError;
use super::head::HeadMotion;
use super::recording::Recording;
use super::subject::Subject;
use crate::units::Vec3;

/// Two markers are swapped only if each jumps by more than this, mm,
const JUMP_MM: f64 = 3.;
/// and both together come closer than this share of that when exchanged.
const SWAPPED_SHARE: f64 = 0.4;
/// Time, s, after which a marker's last place says nothing.
const MEMORY_S: f64 = 0.5;

/// Frames in which neither of two may be seen while their labels go on being exchanged.
const UNSEEN: usize = 3;

/// Two labels that were exchanged in some frames.
#[derive(Clone, Debug, PartialEq)]
pub struct LabelSwap {
    /// The labels.
    pub labels: [String; 2],
    /// First and last frame, from 0.
    pub frames: [usize; 2],
}

/// Displacements of the bound markers in the frame of the face.
#[derive(Clone, Debug, PartialEq)]
pub struct Movement {
    /// Of each frame (f) and bound marker (b), frame by frame: the displacement from neutral, mm on the face; `None` where it
    /// or the head was not seen.
    pub displacement_mm: Vec<Option<Vec3>>,
    /// Labels that were found exchanged, and exchanged back.
    pub swaps: Vec<LabelSwap>,
    /// How the head moves.
    pub head: HeadMotion,
}

impl Movement {
    /// That of the markers of `subject` in `recording`.
    ///
    /// # Errors
    /// [`SubjectError::TooFewStable`].
    pub fn of(recording: &Recording, subject: &Subject) -> Result<Self, SubjectError> {
        let head = HeadMotion::of(recording, subject)?;
        let frames = recording.times_s().len();
        let m = recording.names().len();
        let at: Vec<Option<Vec3>> = (0..frames)
            .flat_map(|frame| {
                let to_neutral = head.to_neutral[frame];
                recording.frame(frame).iter().map(move |p| Some(to_neutral?.apply((*p)?)))
            })
            .collect();
        let (at, swaps) = unswapped(recording, subject, at);
        let displacement = |frame: usize| {
            let row = &at[frame * m..][..m];
            subject.bound.iter().map(move |b| row[b.marker].map(|p| subject.alignment.turn(p - b.neutral_mm)))
        };
        let displacement_mm = (0..frames).flat_map(displacement).collect();
        Ok(Self { displacement_mm, swaps, head })
    }

    /// Every `step`th frame of it.
    #[must_use]
    pub fn every(&self, step: usize) -> Self {
        let frames = (0..self.head.to_neutral.len()).step_by(step.max(1));
        let displacement_mm = frames.clone().flat_map(|f| self.frame(f).iter().copied()).collect();
        let to_neutral = frames.map(|f| self.head.to_neutral[f]).collect();
        let head = HeadMotion { to_neutral, interpolated: Vec::new(), ..self.head.clone() };
        Self { displacement_mm, swaps: Vec::new(), head }
    }

    /// Displacements of the bound markers (b) in a frame, mm.
    ///
    /// # Panics
    /// If there is no such frame.
    pub fn frame(&self, frame: usize) -> &[Option<Vec3>] {
        let b = self.displacement_mm.len() / self.head.to_neutral.len();
        &self.displacement_mm[frame * b..][..b]
    }
}

/// The positions `at` (f x m) with labels exchanged back where two markers jump into each other's places.
///
/// A marker is expected where it was last seen, or at its neutral place. Where two are each far from there and near where
/// the other was, their labels were exchanged.
fn unswapped(
    recording: &Recording,
    subject: &Subject,
    mut at: Vec<Option<Vec3>>,
) -> (Vec<Option<Vec3>>, Vec<LabelSwap>) {
    let m = recording.names().len();
    let times_s = recording.times_s();
    let mut last: Vec<Option<(f64, Vec3)>> = vec![None; m];
    let mut strayed: Vec<Option<Vec3>> = vec![None; m];
    let mut swaps: Vec<LabelSwap> = Vec::new();
    for (frame, &time_s) in times_s.iter().enumerate() {
        let row = &mut at[frame * m..][..m];
        let expected: Vec<Option<Vec3>> = (0..m)
            .map(|k| {
                last[k].filter(|(t, _)| time_s - t <= MEMORY_S).map(|(_, p)| p).or(subject.neutral_mm[k])
            })
            .collect();
        let jump = |row: &[Option<Vec3>], k: usize| Some((row[k]? - expected[k]?).norm());
        let jumps = |row: &[Option<Vec3>], k: usize| jump(row, k).is_some_and(|d| d > JUMP_MM);
        let jumped: Vec<usize> = (0..m).filter(|&k| jumps(row, k)).collect();
        let mut done: Vec<usize> = Vec::new();
        for &i in &jumped {
            // Of two that are known to be exchanged one may be out of sight.
            let is_known = |j: usize| {
                let pair = [&subject.labels[i], &subject.labels[j]];
                let recent = |s: &&LabelSwap| time_s - times_s[s.frames[1]] <= MEMORY_S;
                swaps.iter().filter(recent).any(|s| s.labels.iter().all(|l| pair.contains(&l)))
            };
            let partner = (0..m).filter(|&j| j != i && !done.contains(&i) && !done.contains(&j)).find(|&j| {
                let (Some(a), Some(p), Some(q)) = (row[i], expected[i], expected[j]) else { return false };
                let (stated, exchanged) = match row[j] {
                    Some(b) if jumped.contains(&j) => {
                        ((a - p).norm() + (b - q).norm(), (a - q).norm() + (b - p).norm())
                    }
                    None if is_known(j) => ((a - p).norm(), (a - q).norm()),
                    _ => return false,
                };
                exchanged < SWAPPED_SHARE * stated
            });
            let Some(j) = partner else { continue };
            row.swap(i, j);
            done.extend([i, j]);
            let (a, b) = (i.min(j), i.max(j));
            let labels = [subject.labels[a].clone(), subject.labels[b].clone()];
            match swaps.iter_mut().rev().find(|s| s.labels == labels) {
                Some(swap) if frame - swap.frames[1] <= UNSEEN => swap.frames[1] = frame,
                _ => swaps.push(LabelSwap { labels, frames: [frame; 2] }),
            }
        }
        for k in 0..m {
            // Where one that jumps alone goes to says nothing about where it will be, unless it stays there.
            let Some(p) = row[k] else { continue };
            if !jumps(row, k) || strayed[k].is_some_and(|q| (p - q).norm() <= JUMP_MM) {
                (last[k], strayed[k]) = (Some((time_s, p)), None);
            } else {
                strayed[k] = Some(p);
            }
        }
    }
    (at, swaps)
}
