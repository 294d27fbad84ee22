//! From a recording to activations over time.

use std::ops::Range;

use rayon::prelude::*;
use thiserror::Error;

use super::tracked_face::{contact_pairs, displacement};
use crate::face::Face;
use crate::forward::{ContactError, ForwardError, Model};
use crate::inverse::{Goal, Marker, Place};
use crate::mesh::Site;
use crate::recording::{
    BoundMarker, FrameChoice, MarkerMap, Mechanism, Movement, Recording, Subject, SubjectError,
    SubjectWarning, TrackSummary, TrackedFrame, Tracker,
};
use crate::units::Vec3;

/// Activation at which the stiffness is held to find the mean,
const FIRST: f64 = 0.2;
/// and frames from which it is found.
const SAMPLED: usize = 480;

/// Where the stiffness of a recording is held.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub enum HeldStiffness {
    /// Each muscle at its mean activation over the recording, found at a uniform stiffness first.
    #[default]
    Mean,
    /// All muscles at one activation, 0 to 1.
    At(f64),
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

/// A recording on a face, ready to be fitted block by block.
#[derive(Debug)]
pub struct Track {
    /// The subject on the face.
    pub subject: Subject,
    /// How the markers move on it.
    pub movement: Movement,
    /// What muscles and jaw do to them.
    pub mechanism: Mechanism,
    /// The activations (m) at which the stiffness is held.
    pub held: Vec<f64>,
    model: Model,
    times_s: Vec<f64>,
    depth_weight: f64,
    map: MarkerMap,
    follows: bool,
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
            HeldStiffness::Mean => FIRST,
            HeldStiffness::At(a) => a,
        };
        let uniform = vec![uniform; m];
        let mut track = Self {
            mechanism: at(&model, &uniform)?,
            model,
            subject,
            movement,
            held: uniform,
            times_s: recording.times_s().to_vec(),
            depth_weight: recording.depth_weight(),
            follows: recording.frame_names().is_none(),
            map,
        };
        if held == HeldStiffness::Mean {
            track.held = track.mean();
            track.mechanism = at(&track.model, &track.held)?;
        }
        Ok(track)
    }

    /// Times of the frames (f), s.
    pub fn times_s(&self) -> &[f64] {
        &self.times_s
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

    /// Displacements (3n each), mm, of the whole face at the unknowns of some frames (n each).
    ///
    /// # Errors
    /// [`TrackError`] when the face cannot be solved.
    pub fn displacements(&self, unknowns: &[&[f64]]) -> Result<Vec<Vec<f64>>, TrackError> {
        let fixed = self.model.at(&self.held)?;
        unknowns.iter().map(|x| displacement(&fixed, &self.mechanism, x)).collect()
    }

    /// What `frames` come to.
    pub fn summary(&self, face: &Face, frames: &[TrackedFrame]) -> TrackSummary {
        TrackSummary::of(face, &self.subject, &self.movement, frames)
    }

    fn tracker<'a>(&'a self, movement: &'a Movement, times_s: &'a [f64]) -> Tracker<'a> {
        let dynamics = self.follows.then_some(self.map.dynamics);
        let (mechanism, subject) = (&self.mechanism, &self.subject);
        Tracker::new(mechanism, subject, movement, times_s, self.depth_weight, self.map.effort, dynamics)
    }

    /// The mean activation of each muscle (m) over frames spread over the recording.
    fn mean(&self) -> Vec<f64> {
        let step = self.times_s.len().div_ceil(SAMPLED);
        let times_s: Vec<f64> = self.times_s.iter().step_by(step).copied().collect();
        let movement = self.movement.every(step);
        let tracker = self.tracker(&movement, &times_s);
        let blocks: Vec<Vec<TrackedFrame>> =
            tracker.blocks().into_par_iter().map(|block| tracker.fit(block)).collect();
        let frames: Vec<&TrackedFrame> = blocks.iter().flatten().collect();
        let mean = |k: usize| frames.iter().map(|f| f.unknowns[k]).sum::<f64>() / frames.len().max(1) as f64;
        (0..self.held.len()).map(|k| mean(k).clamp(0., 1.)).collect()
    }
}
