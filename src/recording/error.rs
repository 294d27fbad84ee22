//! Why a recording cannot be brought to a face.

use thiserror::Error;

use crate::units::counted;

/// A marker off the skin.
#[derive(Clone, Debug, PartialEq)]
pub struct OffSkinMarker {
    /// Its label.
    pub label: String,
    /// Its distance from the skin, mm.
    pub distance_mm: f64,
}

/// Why a recording cannot be brought to a face.
#[derive(Clone, Debug, Error)]
#[non_exhaustive]
pub enum SubjectError {
    /// A label of the map is in no frame.
    #[error("`{label}` is no marker of the recording{}", did_you_mean(.nearest))]
    UnknownLabel {
        /// The label.
        label: String,
        /// Labels that are spelt alike.
        nearest: Vec<String>,
    },
    /// A landmark of the map is not on the face.
    #[error("marker `{label}`: the face has no landmark `{landmark}`{}", did_you_mean(.nearest))]
    UnknownLandmark {
        /// The marker.
        label: String,
        /// The landmark.
        landmark: String,
        /// Landmarks that are spelt alike.
        nearest: Vec<String>,
    },
    /// Too little to align the head by.
    #[error(
        "the neutral frames have {found} that are landmarks of the face, not on one line; at least 3 are needed to align \
         the head; name them in the map: [markers] LABEL = \"landmark\"",
        found = counted(*.found, "marker")
    )]
    TooFewLandmarks {
        /// How many there are.
        found: usize,
    },
    /// No marker is seen in the neutral frames.
    #[error("no frame from {} to {} s sees a marker; state other neutral frames, or a file of neutral positions", .span[0], .span[1])]
    NoNeutral {
        /// The span, s.
        span: [f64; 2],
    },
    /// The scale is that of another unit.
    #[error(
        "the face is {scale:.4} times as large as the subject, which is no person: the recording's unit is probably not \
         the one stated; state the unit, or the scale where it is meant"
    )]
    Scale {
        /// What was found.
        scale: f64,
    },
    /// Markers off the skin, where the map refuses them.
    #[error("{} farther than {limit_mm} mm off the skin: {}; leave them out with `off_skin = \"leave_out\"`", counted(.markers.len(), "marker"), listed(.markers))]
    OffSkin {
        /// Which.
        markers: Vec<OffSkinMarker>,
        /// How far they may be, mm.
        limit_mm: f64,
    },
    /// No marker is left to fit to.
    #[error("no marker lies on the skin of the face: {}", listed(.0))]
    NothingOnSkin(Vec<OffSkinMarker>),
    /// A frame that the recording has not.
    #[error("the recording has no frame {wanted}; it has {}", frames(*.count, .names))]
    NoFrame {
        /// How it was asked for.
        wanted: String,
        /// How many there are.
        count: usize,
        /// Their names, if they have any.
        names: Vec<String>,
    },
    /// Too little to follow the head by.
    #[error(
        "{found} that move with the skull; at least 3, not on one line, are needed to tell the head's movement from the \
         face's; name them: stable = [\"nasion\", ...]",
        found = counted(*.found, "marker")
    )]
    TooFewStable {
        /// How many there are.
        found: usize,
    },
}

fn did_you_mean(nearest: &[String]) -> String {
    match nearest {
        [] => String::new(),
        names => format!("; did you mean {}?", names.join(" or ")),
    }
}

fn frames(count: usize, names: &[String]) -> String {
    match names {
        [] => format!("the frames 0 to {}", count.saturating_sub(1)),
        names => names.join(", "),
    }
}

/// `a (6.1 mm), b (12.0 mm)`.
pub(super) fn listed(markers: &[OffSkinMarker]) -> String {
    let one = |m: &OffSkinMarker| format!("{} ({:.1} mm)", m.label, m.distance_mm);
    markers.iter().map(one).collect::<Vec<_>>().join(", ")
}
