//! What a camera saw: marker positions over time.

use std::collections::{HashMap, HashSet};

use crate::units::Vec3;

/// Marker positions over time in mm, in the frame of the device that took them.
#[derive(Clone, Debug, PartialEq)]
pub struct Recording {
    names: Vec<String>,
    times_s: Vec<f64>,
    positions_mm: Vec<Option<Vec3>>,
    depth_weight: f64,
    frame_names: Vec<String>,
}

/// One frame of a recording.
#[derive(Clone, Debug, PartialEq)]
pub enum FrameChoice {
    /// By its place, from 0.
    Index(usize),
    /// The one nearest to a time, s.
    Time(f64),
    /// By its name.
    Named(String),
}

/// Why marker positions are no recording.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
pub enum RecordingError {
    /// There are no markers.
    #[error("the recording has no markers")]
    NoMarkers,
    /// There are no frames.
    #[error("the recording has no frames")]
    NoFrames,
    /// A marker's name is empty.
    #[error("marker {} has no name", .0 + 1)]
    Unnamed(usize),
    /// Two markers are called the same.
    #[error("two markers are called `{0}`; give each its own name")]
    DuplicateName(String),
    /// Time does not increase.
    #[error("frame {} is at {time_s} s, not after the frame before it, at {before_s} s", .frame + 1)]
    TimeNotIncreasing {
        /// Which, from 0.
        frame: usize,
        /// Its time, s.
        time_s: f64,
        /// The time of the one before it, s.
        before_s: f64,
    },
    /// A number is not finite.
    #[error("frame {}, marker `{marker}`: a coordinate is not a finite number; a missing marker is left empty", .frame + 1)]
    NotFinite {
        /// Which, from 0.
        frame: usize,
        /// The marker's name.
        marker: String,
    },
    /// Two frames are called the same.
    #[error("two frames are called `{0}`; give each its own name")]
    DuplicateFrame(String),
    /// The names of frames are not as many as the frames.
    #[error("{frames} frames cannot have {names} names")]
    FrameNames {
        /// Times.
        frames: usize,
        /// Names of frames.
        names: usize,
    },
    /// The numbers of names, times and positions do not agree.
    #[error("{frames} frames of {markers} markers need {} positions, not {positions}", .frames * .markers)]
    Shape {
        /// Times.
        frames: usize,
        /// Names.
        markers: usize,
        /// Positions.
        positions: usize,
    },
}

impl Recording {
    /// `names` of m markers, `times_s` of f frames, increasing, and `positions_mm` (f x m, frame by frame), `None` where a
    /// marker was not seen.
    ///
    /// # Errors
    /// No markers or frames, names empty or twice, times not increasing, coordinates not finite, numbers that do not agree.
    pub fn new(
        names: Vec<String>,
        times_s: Vec<f64>,
        positions_mm: Vec<Option<Vec3>>,
    ) -> Result<Self, RecordingError> {
        if names.is_empty() {
            return Err(RecordingError::NoMarkers);
        }
        if times_s.is_empty() {
            return Err(RecordingError::NoFrames);
        }
        if names.len().checked_mul(times_s.len()) != Some(positions_mm.len()) {
            return Err(RecordingError::Shape {
                frames: times_s.len(),
                markers: names.len(),
                positions: positions_mm.len(),
            });
        }
        let mut seen = HashMap::new();
        for (m, name) in names.iter().enumerate() {
            if name.trim().is_empty() {
                return Err(RecordingError::Unnamed(m));
            }
            if seen.insert(name.as_str(), m).is_some() {
                return Err(RecordingError::DuplicateName(name.clone()));
            }
        }
        for (frame, &time_s) in times_s.iter().enumerate() {
            let before_s = if frame == 0 { f64::NEG_INFINITY } else { times_s[frame - 1] };
            if !time_s.is_finite() || time_s <= before_s {
                return Err(RecordingError::TimeNotIncreasing { frame, time_s, before_s });
            }
        }
        let finite = |p: &Option<Vec3>| p.is_none_or(|p| p.iter().all(|x| x.is_finite()));
        if let Some(at) = positions_mm.iter().position(|p| !finite(p)) {
            let marker = names[at % names.len()].clone();
            return Err(RecordingError::NotFinite { frame: at / names.len(), marker });
        }
        Ok(Self { names, times_s, positions_mm, depth_weight: 1., frame_names: Vec::new() })
    }

    /// The same, where what the camera says of depth (z) counts `weight` times as much as across, in (0, 1]: a single camera
    /// guesses depth.
    #[must_use]
    pub fn with_depth_weight(self, weight: f64) -> Self {
        Self { depth_weight: weight, ..self }
    }

    /// The same, with its frames called `names` (f): expressions or poses rather than moments of one movement.
    ///
    /// # Errors
    /// [`RecordingError::FrameNames`] and [`RecordingError::DuplicateFrame`].
    pub fn with_frame_names(self, names: Vec<String>) -> Result<Self, RecordingError> {
        if names.len() != self.times_s.len() {
            return Err(RecordingError::FrameNames { frames: self.times_s.len(), names: names.len() });
        }
        let mut seen = HashSet::new();
        if let Some(twice) = names.iter().find(|name| !seen.insert(name.as_str())) {
            return Err(RecordingError::DuplicateFrame(twice.clone()));
        }
        Ok(Self { frame_names: names, ..self })
    }

    /// Names of the markers (m), unique.
    pub fn names(&self) -> &[String] {
        &self.names
    }

    /// Times of the frames (f), s, increasing.
    pub fn times_s(&self) -> &[f64] {
        &self.times_s
    }

    /// Positions of the markers (m) in a frame, mm; `None` where one was not seen.
    ///
    /// # Panics
    /// If there is no such frame.
    pub fn frame(&self, frame: usize) -> &[Option<Vec3>] {
        &self.positions_mm[frame * self.names.len()..][..self.names.len()]
    }

    /// Frames (f).
    pub fn n_frames(&self) -> usize {
        self.times_s.len()
    }

    /// Names of the frames (f), unique, where they have any.
    pub fn frame_names(&self) -> Option<&[String]> {
        (!self.frame_names.is_empty()).then_some(&self.frame_names[..])
    }

    /// The frame called `name`.
    pub fn frame_named(&self, name: &str) -> Option<usize> {
        self.frame_names.iter().position(|n| n == name)
    }

    /// Frames a second, on average; `None` of one frame, or of named ones.
    pub fn rate_hz(&self) -> Option<f64> {
        let (first, last) = (self.times_s.first()?, self.times_s.last()?);
        let moves = self.times_s.len() > 1 && self.frame_names.is_empty();
        moves.then(|| (self.times_s.len() - 1) as f64 / (last - first))
    }

    /// The place of a frame, from 0; `None` where there is no such frame.
    pub fn find(&self, choice: &FrameChoice) -> Option<usize> {
        match choice {
            FrameChoice::Index(frame) => (*frame < self.times_s.len()).then_some(*frame),
            FrameChoice::Time(time_s) => {
                let off = |frame: &usize| (self.times_s[*frame] - time_s).abs();
                (0..self.times_s.len()).min_by(|a, b| off(a).total_cmp(&off(b)))
            }
            FrameChoice::Named(name) => self.frame_named(name),
        }
    }

    /// What depth (z) counts beside the other directions, in (0, 1].
    pub fn depth_weight(&self) -> f64 {
        self.depth_weight
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn recording(times_s: &[f64], names: &[&str]) -> Result<Recording, RecordingError> {
        let names: Vec<String> = names.iter().map(|n| (*n).to_string()).collect();
        let positions = vec![Some(Vec3::zeros()); times_s.len() * names.len()];
        Recording::new(names, times_s.to_vec(), positions)
    }

    #[test]
    fn a_recording_is_whole() {
        assert!(recording(&[0., 0.1], &["a", "b"]).is_ok_and(|r| r.frame(1).len() == 2));
        assert_eq!(recording(&[0.], &[]), Err(RecordingError::NoMarkers));
        assert_eq!(recording(&[], &["a"]), Err(RecordingError::NoFrames));
        assert_eq!(recording(&[0.], &["a", " "]), Err(RecordingError::Unnamed(1)));
        assert_eq!(recording(&[0.], &["a", "a"]), Err(RecordingError::DuplicateName("a".into())));
        let stands = RecordingError::TimeNotIncreasing { frame: 1, time_s: 0., before_s: 0. };
        assert_eq!(recording(&[0., 0.], &["a"]), Err(stands));
        let bad = Recording::new(vec!["a".into()], vec![0.], vec![Some(Vec3::new(f64::NAN, 0., 0.))]);
        assert_eq!(bad, Err(RecordingError::NotFinite { frame: 0, marker: "a".into() }));
        let short = Recording::new(vec!["a".into()], vec![0.], Vec::new());
        assert!(matches!(short, Err(RecordingError::Shape { positions: 0, .. })));
    }

    #[test]
    fn frames_may_have_names() -> Result<(), RecordingError> {
        let names = |all: &[&str]| all.iter().map(|n| (*n).to_string()).collect::<Vec<_>>();
        let bare = recording(&[0., 1., 3.], &["a"])?;
        assert_eq!((bare.frame_names(), bare.rate_hz()), (None, Some(2. / 3.)));
        let named = bare.clone().with_frame_names(names(&["rest", "smile", "snarl"]))?;
        assert_eq!((named.frame_named("snarl"), named.frame_named("rests")), (Some(2), None));
        assert_eq!(named.rate_hz(), None);
        let twice = bare.clone().with_frame_names(names(&["rest", "smile", "rest"]));
        assert_eq!(twice, Err(RecordingError::DuplicateFrame("rest".into())));
        let few = bare.with_frame_names(names(&["rest"]));
        assert_eq!(few, Err(RecordingError::FrameNames { frames: 3, names: 1 }));
        Ok(())
    }
}
