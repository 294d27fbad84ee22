//! From a recording to activations over time.

use std::ops::Range;

use nalgebra::DVector;
use rayon::prelude::*;
use thiserror::Error;

use super::key_states::{key_states, nearest};
use super::rest_states::{GOOD_MM, ROUNDS, RestRound, RestStates};
use super::tracked_face::{contact_pairs, finite_model};
use super::{HeldStiffness, Mechanics, Mover, Stiffness, Strain, StudyError, TrackedFace, TrackedMoment};
use crate::certainty::{Discrepancy, Intervals};
use crate::face::Face;
use crate::forward::finite::FiniteError;
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

/// States about which the face is described where the stiffness follows.
const KEYS: usize = 12;

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
    /// It cannot be modelled at finite strain, or finds no rest there.
    #[error(transparent)]
    Finite(#[from] FiniteError),
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
    has_contact: bool,
    times_s: Vec<f64>,
    depth_weight: f64,
    map: MarkerMap,
    stiffness: HeldStiffness,
    /// At finite strain.
    rest: Option<RestStates>,
    /// Whether frames follow each other in time.
    is_movement: bool,
}

impl Track {
    /// Faces that [`at_finite_strain`](Self::at_finite_strain) settles at most.
    pub const MOST_STATES: usize = RestStates::MOST;

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
            has_contact,
            subject,
            movement,
            held: uniform,
            times_s: recording.times_s().to_vec(),
            depth_weight: recording.depth_weight(),
            is_movement: recording.frame_names().is_none(),
            stiffness: held,
            rest: None,
            map,
        };
        if matches!(held, HeldStiffness::Mean | HeldStiffness::Follow) {
            track.held = track.mean(&track.sampled());
            track.mechanisms = Mechanisms::one(at(&track.model, &track.held)?);
        }
        if held == HeldStiffness::Follow {
            let sampled = track.sampled();
            let keys = key_states(&sampled, &[], KEYS, 0.);
            let about = |x: &DVector<f64>| -> Result<Mechanism, TrackError> {
                let x = x.as_slice();
                Ok(Mechanism::about(&track.model.at(&x[..m])?, &sites, freedom, x)?)
            };
            let all = keys.iter().map(about).collect::<Result<Vec<Mechanism>, TrackError>>()?;
            let of_sampled: Vec<usize> = sampled.iter().map(|x| nearest(x, &keys).0).collect();
            let of_frame = track.of_frame(&of_sampled);
            track.held = track.mean(&sampled);
            if let Some(mechanisms) = Mechanisms::new(all, of_frame) {
                track.mechanisms = mechanisms;
            }
        }
        Ok(track)
    }

    /// The same recording at finite strain. The face is settled where frames stand for many, at first by what the linear model has
    /// found, and each frame has what unknowns do about the nearest, to first order; it is settled in more places while its
    /// points are not where that had them. `done` hears of each face that was settled, of [`MOST_STATES`](Self::MOST_STATES) at most.
    ///
    /// # Errors
    /// [`TrackError::Finite`] when the face cannot be modelled at finite strain, or finds no rest.
    pub fn at_finite_strain(mut self, done: impl Fn(usize) + Sync) -> Result<Self, TrackError> {
        let model = finite_model(self.model.face(), self.has_contact)?;
        let mut rest = RestStates::new(model, self.mechanisms.first().clone());
        let sites: Vec<Site> = self.subject.bound.iter().map(|b| b.site.clone()).collect();
        let mut sampled = self.sampled();
        let mut own = vec![0; sampled.len()];
        for round in 0..ROUNDS {
            let places = rest.places(round, &own, &sampled);
            let worst_mm = rest.refine(&places, &own, &sites, &done)?;
            let before = std::mem::replace(&mut own, places.iter().map(|x| rest.nearest(x)).collect());
            let of_frame = self.of_frame(&own);
            if let Some(mechanisms) = Mechanisms::new(rest.mechanisms.clone(), of_frame) {
                self.mechanisms = mechanisms;
            }
            sampled = self.sampled();
            // What the mean is says nothing of those frames that are far from it.
            let is_good = round > 0 && worst_mm.is_some_and(|worst_mm| worst_mm <= GOOD_MM);
            if is_good || (worst_mm.is_none() && own == before) {
                break;
            }
        }
        self.held = self.mean(&sampled);
        self.stiffness = HeldStiffness::Follow;
        self.rest = Some(rest);
        Ok(self)
    }

    /// Where the stiffness is held; it follows at finite strain.
    pub fn stiffness(&self) -> HeldStiffness {
        self.stiffness
    }

    /// How strain is measured.
    pub fn strain(&self) -> Strain {
        if self.rest.is_some() { Strain::Finite } else { Strain::Linear }
    }

    /// The rounds in which faces were settled at finite strain; none at linear strain.
    pub fn rounds(&self) -> &[RestRound] {
        self.rest.as_ref().map_or(&[], |rest| &rest.rounds)
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
        self.tracker(&self.mechanisms, &self.movement, &self.times_s).blocks()
    }

    /// The frames of a block fitted.
    pub fn fit(&self, block: Range<usize>) -> Vec<TrackedFrame> {
        self.tracker(&self.mechanisms, &self.movement, &self.times_s).fit(block)
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
        let tracker = self.tracker(&self.mechanisms, &self.movement, &self.times_s);
        let of = |frame: usize| {
            let intervals = tracker.seen(frame, &frames[frame]).intervals(discrepancy)?;
            Some(FrameIntervals { frame, intervals })
        };
        let asked: Vec<usize> = (0..frames.len()).step_by(every.max(1)).collect();
        asked.into_par_iter().filter_map(of).collect()
    }

    /// Displacements (3n each), mm, of the whole face in the frames of these places in `frames`; where the stiffness follows, at
    /// that of the frame's own activations, and at finite strain of the face at rest under them. `done` hears of each.
    ///
    /// # Errors
    /// [`TrackError`] when the face cannot be solved.
    pub fn displacements(
        &self,
        frames: &[TrackedFrame],
        places: &[usize],
        done: impl Fn(usize) + Sync,
    ) -> Result<Vec<Vec<f64>>, TrackError> {
        let held = (self.stiffness != HeldStiffness::Follow).then_some(&self.held[..]);
        let face = TrackedFace::new(self.model.face(), self.strain(), held, self.has_contact)?;
        let moment = |place: &usize| {
            let x = &frames[*place].unknowns;
            let jaw_mm = self.mechanism().jaw_mm(x).unwrap_or_default();
            TrackedMoment { activation: &x[..self.held.len()], jaw_mm }
        };
        let moments: Vec<TrackedMoment<'_>> = places.iter().map(moment).collect();
        Ok(face.at(&moments, done)?.into_iter().map(|(displacement, _)| displacement).collect())
    }

    /// The frames that [`check`](Self::check) settles.
    pub fn to_check(&self, frames: &[TrackedFrame]) -> Vec<usize> {
        let m = self.held.len();
        let size = |frame: usize| {
            let x = &frames[frame].unknowns;
            match &self.rest {
                Some(rest) => rest.apart(self.mechanisms.index(frame), &DVector::from_column_slice(x)),
                None => x[..m].iter().map(|a| a * a).sum::<f64>(),
            }
        };
        let counts = |frame: &usize| {
            let TrackedFrame { residual_mm, outliers, .. } = &frames[*frame];
            (0..residual_mm.len()).any(|b| residual_mm[b].is_some() && !outliers.contains(&b))
        };
        // A frame without a marker has nothing that could be off.
        let strongest =
            |block: Range<usize>| block.filter(counts).max_by(|a, b| size(*a).total_cmp(&size(*b)));
        // Of frames that do not follow each other none says anything of another.
        match self.rest.is_some() && !self.is_movement {
            true => (0..frames.len()).filter(counts).collect(),
            false => self.blocks().into_iter().filter_map(strongest).collect(),
        }
    }

    /// The face settled anew, its muscles as stiff as they are active, in the frame of each block in which the muscles do
    /// most, or at finite strain in that which is farthest from the face about which it is described, and in every frame of those that
    /// do not follow each other: what the model of the recording leaves out there. `done` hears of each frame that was.
    ///
    /// # Errors
    /// [`StudyError`] when the face cannot be modelled so.
    pub fn check(
        &self,
        frames: &[TrackedFrame],
        strain: Strain,
        done: impl Fn(usize) + Sync,
    ) -> Result<Checked, StudyError> {
        let face = self.model.face();
        let contact = self.has_contact;
        let mover = Mover::new(face, Mechanics { strain, stiffness: Stiffness::Activated, contact })?;
        let m = self.held.len();
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
        let one = |frame: usize| {
            let found = one(frame);
            done(1);
            (frame, found)
        };
        let settled: Vec<_> = self.to_check(frames).into_par_iter().map(one).collect();
        let mut checked = Checked { strain, frames: Vec::new(), failed: Vec::new() };
        for (frame, found) in settled {
            match found {
                Ok(found) => checked.frames.push(found),
                Err(error) => checked.failed.push((frame, error)),
            }
        }
        Ok(checked)
    }

    /// What `frames` come to.
    pub fn summary(&self, face: &Face, frames: &[TrackedFrame]) -> TrackSummary {
        TrackSummary::of(face, &self.subject, &self.movement, frames)
    }

    fn tracker<'a>(
        &'a self,
        mechanisms: &'a Mechanisms,
        movement: &'a Movement,
        times_s: &'a [f64],
    ) -> Tracker<'a> {
        let dynamics = self.is_movement.then_some(self.map.dynamics);
        let subject = &self.subject;
        Tracker::new(mechanisms, subject, movement, times_s, self.depth_weight, self.map.effort, dynamics)
    }

    /// Frames from one of those that are sampled to the next.
    fn step(&self) -> usize {
        self.times_s.len().div_ceil(SAMPLED)
    }

    /// Which mechanism each frame (f) has: that of the frame before it that is among the sampled, `of_sampled`.
    fn of_frame(&self, of_sampled: &[usize]) -> Vec<usize> {
        let step = self.step();
        (0..self.times_s.len()).map(|frame| of_sampled[frame / step]).collect()
    }

    /// Unknowns (n each) of frames spread over the recording.
    fn sampled(&self) -> Vec<DVector<f64>> {
        let step = self.step();
        let times_s: Vec<f64> = self.times_s.iter().step_by(step).copied().collect();
        let (movement, mechanisms) = (self.movement.every(step), self.mechanisms.every(step));
        let tracker = self.tracker(&mechanisms, &movement, &times_s);
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
