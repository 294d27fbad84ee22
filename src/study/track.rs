//! From a recording to activations over time.

use std::ops::Range;

use nalgebra::DVector;
use rayon::prelude::*;
use thiserror::Error;

use super::tracked_face::contact_pairs;
use super::{Mechanics, Mover, Stiffness, Strain, StudyError};
use crate::certainty::{Discrepancy, Intervals};
use crate::face::Face;
use crate::forward::{ContactError, ForwardError, Model};
use crate::inverse::{Goal, Marker, Place};
use crate::mesh::Site;
use crate::recording::{
    BoundMarker, FrameChoice, MarkerMap, Mechanism, Mechanisms, Movement, Recording, Subject, SubjectError,
    SubjectWarning, TrackSummary, TrackedFrame, Tracker,
};
use crate::units::Vec3;

/// Activation at which the stiffness is held to find the mean,
const FIRST: f64 = 0.2;
/// and frames from which it is found.
const SAMPLED: usize = 480;

/// States about which the face is described where the stiffness follows,
const KEYS: usize = 12;
/// and times that they are moved to the mean of their frames.
const MOVES: usize = 10;

/// Where the stiffness of a recording is held.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub enum HeldStiffness {
    /// At none: it follows the activations to first order about twelve states of the recording, each frame having the nearest.
    Follow,
    /// Each muscle at its mean activation over the recording, found at a uniform stiffness first.
    #[default]
    Mean,
    /// All muscles at one activation, 0 to 1.
    At(f64),
}

impl HeldStiffness {
    /// As the command line writes it: `mean`, `follow` or `fixed=A`.
    pub fn text(self) -> String {
        match self {
            Self::Mean => "mean".to_owned(),
            Self::Follow => "follow".to_owned(),
            Self::At(a) => format!("fixed={a}"),
        }
    }
}

/// Why a recording was not fitted.
#[derive(Debug, Error)]
#[non_exhaustive]
pub enum TrackError {
    /// The subject cannot be brought to the face.
    #[error(transparent)]
    Subject(#[from] SubjectError),
    /// The face cannot be solved.
    #[error(transparent)]
    Forward(#[from] ForwardError),
    /// No contact forces hold it.
    #[error("contact: {0}; --contact off leaves it out")]
    Contact(#[from] ContactError),
}

/// The markers of one frame of `recording` as displacements on `face`, read as `map` says, and what is odd about them.
///
/// # Errors
/// [`SubjectError`]: there is no such frame, or the subject cannot be brought to the face.
pub fn recorded_markers(
    face: &Face,
    recording: &Recording,
    map: &MarkerMap,
    choice: &FrameChoice,
) -> Result<(Vec<Marker>, Vec<SubjectWarning>), SubjectError> {
    let Some(frame) = recording.find(choice) else {
        let wanted = match choice {
            FrameChoice::Index(frame) => frame.to_string(),
            FrameChoice::Time(time_s) => format!("at {time_s} s"),
            FrameChoice::Named(name) => format!("`{name}`"),
        };
        let names = recording.frame_names().map_or_else(Vec::new, <[String]>::to_vec);
        return Err(SubjectError::NoFrame { wanted, count: recording.n_frames(), names });
    };
    let subject = Subject::new(recording, map, face)?;
    let movement = Movement::of(recording, &subject)?;
    let marker = |(bound, seen): (&BoundMarker, &Option<Vec3>)| {
        let at = match &bound.landmark {
            Some(name) => Place::Landmark(name.clone()),
            None => Place::Point(bound.site.position),
        };
        let goal = Goal::Displacement(seen.map_or([None; 3], |u| [Some(u.x), Some(u.y), Some(u.z)]));
        Marker { name: bound.label.clone(), at, goal, sigma_mm: bound.sigma_mm }
    };
    Ok((subject.bound.iter().zip(movement.frame(frame)).map(marker).collect(), subject.warnings))
}

/// What the markers of a frame determine.
#[derive(Clone, Debug, PartialEq)]
pub struct FrameIntervals {
    /// The frame, from 0.
    pub frame: usize,
    /// Intervals of its unknowns.
    pub intervals: Intervals,
}

/// A frame in which the face was settled anew.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct CheckedFrame {
    /// The frame, from 0.
    pub frame: usize,
    /// How far its markers are from where the recording's model has them, mm: root mean square,
    pub rms_mm: f64,
    /// and the farthest.
    pub most_mm: f64,
    /// Root mean square residual of its markers, mm.
    pub residual_mm: f64,
}

/// The face settled anew in some frames.
#[derive(Debug)]
pub struct Checked {
    /// How strain was measured.
    pub strain: Strain,
    /// What was found.
    pub frames: Vec<CheckedFrame>,
    /// Frames in which the face does not come to rest, and why.
    pub failed: Vec<(usize, StudyError)>,
}

/// A recording on a face, ready to be fitted block by block.
#[derive(Debug)]
pub struct Track {
    /// The subject on the face.
    pub subject: Subject,
    /// How the markers move on it.
    pub movement: Movement,
    /// What muscles and jaw do to them.
    pub mechanisms: Mechanisms,
    /// The activations (m) at which the stiffness is held, or their mean where it follows.
    pub held: Vec<f64>,
    model: Model,
    times_s: Vec<f64>,
    depth_weight: f64,
    map: MarkerMap,
    stiffness: HeldStiffness,
    /// Whether frames follow each other in time.
    is_movement: bool,
}

impl Track {
    /// `recording` on `face`, read as `map` says, at the stiffness `held`, with contact where `has_contact` says.
    ///
    /// # Errors
    /// [`TrackError`] for a subject that cannot be brought to the face and a face that cannot be solved.
    pub fn new(
        face: &Face,
        recording: &Recording,
        map: MarkerMap,
        held: HeldStiffness,
        has_contact: bool,
    ) -> Result<Self, TrackError> {
        let subject = Subject::new(recording, &map, face)?;
        let movement = Movement::of(recording, &subject)?;
        let model = Model::new(face, contact_pairs(face, has_contact))?;
        let sites: Vec<Site> = subject.bound.iter().map(|b| b.site.clone()).collect();
        let freedom = map.jaw;
        let at = |model: &Model, a: &[f64]| -> Result<Mechanism, TrackError> {
            Ok(Mechanism::new(&model.at(a)?, &sites, freedom))
        };
        let m = model.muscles().len();
        let uniform = match held {
            HeldStiffness::Mean | HeldStiffness::Follow => FIRST,
            HeldStiffness::At(a) => a,
        };
        let uniform = vec![uniform; m];
        let mut track = Self {
            mechanisms: Mechanisms::one(at(&model, &uniform)?),
            model,
            subject,
            movement,
            held: uniform,
            times_s: recording.times_s().to_vec(),
            depth_weight: recording.depth_weight(),
            is_movement: recording.frame_names().is_none(),
            stiffness: held,
            map,
        };
        if matches!(held, HeldStiffness::Mean | HeldStiffness::Follow) {
            track.held = track.mean(&track.sampled());
            track.mechanisms = Mechanisms::one(at(&track.model, &track.held)?);
        }
        if held == HeldStiffness::Follow {
            let sampled = track.sampled();
            let (keys, nearest) = keys(&sampled);
            let about = |x: &DVector<f64>| -> Result<Mechanism, TrackError> {
                let x = x.as_slice();
                Ok(Mechanism::about(&track.model.at(&x[..m])?, &sites, freedom, x)?)
            };
            let all = keys.iter().map(about).collect::<Result<Vec<Mechanism>, TrackError>>()?;
            let step = track.step();
            let of_frame = (0..track.times_s.len()).map(|frame| nearest[frame / step]).collect();
            track.held = track.mean(&sampled);
            if let Some(mechanisms) = Mechanisms::new(all, of_frame) {
                track.mechanisms = mechanisms;
            }
        }
        Ok(track)
    }

    /// Times of the frames (f), s.
    pub fn times_s(&self) -> &[f64] {
        &self.times_s
    }

    /// The mechanism whose muscles, bounds and jaw are those of all.
    pub fn mechanism(&self) -> &Mechanism {
        self.mechanisms.first()
    }

    /// How the markers were read.
    pub fn map(&self) -> &MarkerMap {
        &self.map
    }

    /// The frames of each block, in order. Blocks may be fitted in any order.
    pub fn blocks(&self) -> Vec<Range<usize>> {
        self.tracker(&self.movement, &self.times_s).blocks()
    }

    /// The frames of a block fitted.
    pub fn fit(&self, block: Range<usize>) -> Vec<TrackedFrame> {
        self.tracker(&self.movement, &self.times_s).fit(block)
    }

    /// All frames, block by block on all cores, each block as `fit` gives it: by [`fit`](Self::fit), or from where it was
    /// kept. The same bytes for any number of threads.
    pub fn fit_all(
        &self,
        fit: impl Fn(Range<usize>) -> Vec<TrackedFrame> + Sync + Send,
    ) -> Vec<TrackedFrame> {
        let blocks: Vec<Vec<TrackedFrame>> = self.blocks().into_par_iter().map(fit).collect();
        blocks.into_iter().flatten().collect()
    }

    /// Intervals of the unknowns of every `every`th of `frames` with a model as far from the face as `discrepancy`, by the
    /// frame's own markers; frames of which no marker counts have none.
    pub fn intervals(
        &self,
        frames: &[TrackedFrame],
        every: usize,
        discrepancy: &Discrepancy,
    ) -> Vec<FrameIntervals> {
        let tracker = self.tracker(&self.movement, &self.times_s);
        let of = |frame: usize| {
            let intervals = tracker.seen(frame, &frames[frame]).intervals(discrepancy)?;
            Some(FrameIntervals { frame, intervals })
        };
        let asked: Vec<usize> = (0..frames.len()).step_by(every.max(1)).collect();
        asked.into_par_iter().filter_map(of).collect()
    }

    /// Displacements (3n each), mm, of the whole face in the frames of these places in `frames`; where the stiffness follows, at
    /// that of the frame's own activations.
    ///
    /// # Errors
    /// [`TrackError`] when the face cannot be solved.
    pub fn displacements(
        &self,
        frames: &[TrackedFrame],
        places: &[usize],
    ) -> Result<Vec<Vec<f64>>, TrackError> {
        let mut fixed = self.model.at(&self.held)?;
        let mut displacements = Vec::with_capacity(places.len());
        for &place in places {
            let x = &frames[place].unknowns;
            if self.stiffness == HeldStiffness::Follow {
                fixed = self.model.at(&x[..self.held.len()])?;
            }
            displacements.push(self.mechanisms.of(place).displacement(&fixed, x)?);
        }
        Ok(displacements)
    }

    /// The face settled anew, its muscles as stiff as they are active, in the frame of each block in which the muscles do
    /// most: what the model of the recording leaves out there. `done` hears of each frame that was.
    ///
    /// # Errors
    /// [`StudyError`] when the face cannot be modelled so.
    pub fn check(
        &self,
        frames: &[TrackedFrame],
        strain: Strain,
        done: impl Fn(usize),
    ) -> Result<Checked, StudyError> {
        let face = self.model.face();
        let contact = !self.model.pairs().is_empty();
        let mover = Mover::new(face, Mechanics { strain, stiffness: Stiffness::Activated, contact })?;
        let m = self.held.len();
        let effort = |f: &usize| frames[*f].unknowns[..m].iter().map(|a| a * a).sum::<f64>();
        let strongest = |block: Range<usize>| block.max_by(|a, b| effort(a).total_cmp(&effort(b)));
        let one = |frame: usize| {
            let fitted = &frames[frame];
            let pose = self.mechanism().pose(face, &fitted.unknowns);
            let moved = mover.settle(&fitted.unknowns[..m], &pose)?;
            let (mut off, mut residual, mut most_mm, mut count) = (0., 0., 0_f64, 0_usize);
            for (b, bound) in self.subject.bound.iter().enumerate() {
                let (Some(seen), Some(left)) = (self.movement.frame(frame)[b], fitted.residual_mm[b]) else {
                    continue;
                };
                if fitted.outliers.contains(&b) {
                    continue;
                }
                let anew = bound.site.displacement(&moved.displacement);
                let apart = anew - (seen - left);
                off += apart.norm_squared();
                most_mm = most_mm.max(apart.norm());
                residual += (seen - anew).norm_squared();
                count += 1;
            }
            let mean = |squares: f64| (squares / count.max(1) as f64).sqrt();
            Ok::<_, StudyError>(CheckedFrame {
                frame,
                rms_mm: mean(off),
                most_mm,
                residual_mm: mean(residual),
            })
        };
        let mut checked = Checked { strain, frames: Vec::new(), failed: Vec::new() };
        for frame in self.blocks().into_iter().filter_map(strongest) {
            match one(frame) {
                Ok(found) => checked.frames.push(found),
                Err(error) => checked.failed.push((frame, error)),
            }
            done(1);
        }
        Ok(checked)
    }

    /// What `frames` come to.
    pub fn summary(&self, face: &Face, frames: &[TrackedFrame]) -> TrackSummary {
        TrackSummary::of(face, &self.subject, &self.movement, frames)
    }

    fn tracker<'a>(&'a self, movement: &'a Movement, times_s: &'a [f64]) -> Tracker<'a> {
        let dynamics = self.is_movement.then_some(self.map.dynamics);
        let (mechanisms, subject) = (&self.mechanisms, &self.subject);
        Tracker::new(mechanisms, subject, movement, times_s, self.depth_weight, self.map.effort, dynamics)
    }

    /// Frames from one of those that are sampled to the next.
    fn step(&self) -> usize {
        self.times_s.len().div_ceil(SAMPLED)
    }

    /// Unknowns (n each) of frames spread over the recording, all with the first mechanism.
    fn sampled(&self) -> Vec<DVector<f64>> {
        let step = self.step();
        let times_s: Vec<f64> = self.times_s.iter().step_by(step).copied().collect();
        let movement = self.movement.every(step);
        let tracker = self.tracker(&movement, &times_s);
        let blocks: Vec<Vec<TrackedFrame>> =
            tracker.blocks().into_par_iter().map(|block| tracker.fit(block)).collect();
        blocks.iter().flatten().map(|frame| DVector::from_column_slice(&frame.unknowns)).collect()
    }

    /// The mean activation of each muscle (m) over frames with the unknowns `sampled`.
    fn mean(&self, sampled: &[DVector<f64>]) -> Vec<f64> {
        let mean = |k: usize| sampled.iter().map(|x| x[k]).sum::<f64>() / sampled.len().max(1) as f64;
        (0..self.held.len()).map(|k| mean(k).clamp(0., 1.)).collect()
    }
}

/// A few of the unknowns `sampled` that stand for all, and which of them is nearest to each: means of clusters that begin far from
/// each other (Gonzalez 1985, Theor Comput Sci 38:293) and move to the mean of what is nearest to them (Lloyd 1982, IEEE Trans
/// Inf Theory 28:129).
fn keys(sampled: &[DVector<f64>]) -> (Vec<DVector<f64>>, Vec<usize>) {
    let Some(n) = sampled.first().map(DVector::len) else { return (Vec::new(), Vec::new()) };
    let mean = |members: &mut dyn Iterator<Item = &DVector<f64>>| {
        let (mut sum, mut count) = (DVector::zeros(n), 0.);
        members.for_each(|x| (sum, count) = (&sum + x, count + 1.));
        (count > 0.).then(|| sum / count)
    };
    let apart = |x: &DVector<f64>, keys: &[DVector<f64>]| {
        let squares = keys.iter().map(|key| (x - key).norm_squared()).enumerate();
        squares.min_by(|a, b| a.1.total_cmp(&b.1)).unwrap_or((0, f64::INFINITY))
    };
    let mut keys: Vec<DVector<f64>> = mean(&mut sampled.iter()).into_iter().collect();
    while keys.len() < KEYS {
        let farthest = sampled.iter().max_by(|a, b| apart(a, &keys).1.total_cmp(&apart(b, &keys).1));
        match farthest.filter(|x| apart(x, &keys).1 > 0.) {
            Some(x) => keys.push(x.clone()),
            None => break,
        }
    }
    let nearest =
        |keys: &[DVector<f64>]| -> Vec<usize> { sampled.iter().map(|x| apart(x, keys).0).collect() };
    for _ in 0..MOVES {
        let of = nearest(&keys);
        for (k, key) in keys.iter_mut().enumerate() {
            let mut members = sampled.iter().zip(&of).filter(|(_, own)| **own == k).map(|(x, _)| x);
            if let Some(centre) = mean(&mut members) {
                *key = centre;
            }
        }
    }
    let of = nearest(&keys);
    (keys, of)
}
