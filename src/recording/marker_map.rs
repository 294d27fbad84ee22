//! How the markers of a recording are to be read.

use std::collections::BTreeMap;

use crate::units::Vec3;

/// Which point of the face a marker is.
#[derive(Clone, Debug, PartialEq)]
pub enum MarkerPlace {
    /// A landmark of the face by name.
    Landmark(String),
    /// A rest position on the face, mm; the skin nearest to it is taken.
    Point(Vec3),
    /// The skin nearest to where the marker is in the neutral frames, once the head is aligned.
    Skin,
}

/// What is said about one marker.
#[derive(Clone, Debug, PartialEq)]
pub struct MappedMarker {
    /// Which point it is.
    pub place: MarkerPlace,
    /// Standard deviation of its position, mm, where it differs from [`MarkerMap::sigma_mm`].
    pub sigma_mm: Option<f64>,
}

/// Where the subject rests.
#[derive(Clone, Debug, PartialEq)]
pub enum Neutral {
    /// In the frames from one time to another, s, of which the medians are taken.
    Span([f64; 2]),
    /// At positions known from elsewhere, mm, by label, in any frame of reference.
    Positions(BTreeMap<String, Vec3>),
}

/// What becomes of markers whose neutral place is farther than 5 mm from the skin.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum OffSkin {
    /// They do not count for the face, and are listed.
    #[default]
    LeaveOut,
    /// The recording is refused.
    Refuse,
}

/// How far the jaw may move; it is unknown beside the activations.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct JawFreedom {
    /// Widest opening, mm at the lower incisal point.
    pub opening_mm: f64,
    /// Farthest protrusion or retrusion, mm.
    pub protrusion_mm: f64,
    /// Farthest shift to either side, mm.
    pub lateral_mm: f64,
    /// Standard deviation of each movement, as a share of its farthest: a weak belief that the jaw rests.
    pub sigma: f64,
}

impl Default for JawFreedom {
    /// 25 mm open, half of what adults can do (ANATOMY: 40 to 60 mm); 3 mm forward, back and to the sides, about the
    /// envelope of speech and far from that of chewing.
    fn default() -> Self {
        Self { opening_mm: 25., protrusion_mm: 3., lateral_mm: 3., sigma: 1. }
    }
}

/// How activation may change in time.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Dynamics {
    /// Standard deviation of the change of an activation within a second, were it a random walk: `r sqrt(dt)` from frame to
    /// frame. Infinite for none.
    pub change_per_root_s: f64,
    /// Time constant of rising activation, s: an activation rises by at most `dt / rise_s`, as first-order dynamics at full
    /// excitation do at first. 0 for no limit.
    pub rise_s: f64,
    /// Time constant of falling activation, s: an activation falls by at most `dt / fall_s`. 0 for no limit.
    pub fall_s: f64,
}

impl Default for Dynamics {
    /// Time constants of 15 and 50 ms (Thelen 2003, J Biomech Eng 125:70, young adults); a walk of 2 a
    /// second to the half, which leaves 0.26 from frame to frame at 60 Hz.
    fn default() -> Self {
        Self { change_per_root_s: 2., rise_s: 0.015, fall_s: 0.05 }
    }
}

/// How the markers of a recording are to be read.
#[derive(Clone, Debug, PartialEq)]
pub struct MarkerMap {
    /// Markers by label. One that is not here is the landmark of its label where the face has it, else [`MarkerPlace::Skin`].
    pub markers: BTreeMap<String, MappedMarker>,
    /// Labels that are not read at all.
    pub ignore: Vec<String>,
    /// Where the subject rests.
    pub neutral: Neutral,
    /// Labels that move with the skull; empty: they are found by their rigidity, above the base of the nose.
    pub stable: Vec<String>,
    /// The head's own movement was taken away already: it is still.
    pub head_is_still: bool,
    /// Scale from the subject to the face; `None`: it is found.
    pub scale: Option<f64>,
    /// What becomes of markers off the skin.
    pub off_skin: OffSkin,
    /// Standard deviation of a marker's position, mm, model and measurement together.
    pub sigma_mm: f64,
    /// How far the jaw may move; `None`: it rests.
    pub jaw: Option<JawFreedom>,
    /// Weight of the squared activations.
    pub effort: f64,
    /// How activations may change in time.
    pub dynamics: Dynamics,
}

impl Default for MarkerMap {
    fn default() -> Self {
        Self {
            markers: BTreeMap::new(),
            ignore: Vec::new(),
            neutral: Neutral::Span([0., 0.]),
            stable: Vec::new(),
            head_is_still: false,
            scale: None,
            off_skin: OffSkin::default(),
            sigma_mm: 0.5,
            jaw: Some(JawFreedom::default()),
            effort: 0.1,
            dynamics: Dynamics::default(),
        }
    }
}
