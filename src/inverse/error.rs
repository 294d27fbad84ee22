//! What can be wrong with a target.

use thiserror::Error;

use crate::units::Vec3;

/// Why a target cannot be posed; `field` is the path of the field, `markers[2].sigma_mm`.
#[derive(Clone, Debug, PartialEq, Error)]
#[non_exhaustive]
pub enum TargetError {
    /// No landmark has this name.
    #[error("{field}: no landmark is called `{name}`; {}", offer(.nearest))]
    UnknownLandmark {
        /// Path of the field.
        field: String,
        /// The name.
        name: String,
        /// The nearest names, best first.
        nearest: Vec<String>,
    },
    /// No muscle has this name.
    #[error("{field}: no muscle is called `{name}`; {}", offer(.nearest))]
    UnknownMuscle {
        /// Path of the field.
        field: String,
        /// The name.
        name: String,
        /// The nearest names, best first.
        nearest: Vec<String>,
    },
    /// Two markers or two features share a label, or a muscle has two bounds.
    #[error("{field}: `{name}` is there already, at {first}; give each its own name")]
    Duplicate {
        /// Path of the second.
        field: String,
        /// The name.
        name: String,
        /// Path of the first.
        first: String,
    },
    /// A number is NaN or infinite.
    #[error("{field}: {value} is no finite number; leave a missing component out")]
    NotFinite {
        /// Path of the field.
        field: String,
        /// The value.
        value: f64,
    },
    /// A standard deviation that gives no weight.
    #[error("{field}: a standard deviation must be positive and finite, not {value} mm")]
    Sigma {
        /// Path of the field.
        field: String,
        /// The value, mm.
        value: f64,
    },
    /// A negative effort rewards activation.
    #[error("{field}: a weight of the effort must be finite and not negative, not {value}")]
    Effort {
        /// Path of the field.
        field: String,
        /// The value.
        value: f64,
    },
    /// A loss that turns nowhere.
    #[error("{field}: Huber's loss turns at 0.1 to 100 standard deviations, not {value}; 3 is usual")]
    Huber {
        /// Path of the field.
        field: String,
        /// The value.
        value: f64,
    },
    /// A standard deviation of an activation that is none.
    #[error(
        "{field}: the standard deviation of an activation must be from 0.0001 to 10000, not {value}; 0.1 is ten per cent of full activation"
    )]
    PriorSigma {
        /// Path of the field.
        field: String,
        /// The value.
        value: f64,
    },
    /// An activation outside [0, 1].
    #[error("{field}: {value} is no activation; activations lie within 0 and 1")]
    BoundOutside {
        /// Path of the field.
        field: String,
        /// The value.
        value: f64,
    },
    /// `min > max`.
    #[error("{field}: min {min} exceeds max {max} for `{muscle}`; exchange them")]
    BoundsCross {
        /// Path of the field.
        field: String,
        /// The muscle.
        muscle: String,
        /// Least activation.
        min: f64,
        /// Greatest activation.
        max: f64,
    },
    /// A jaw that opens less than not at all, or farther than jaws do.
    #[error(
        "{field}: a jaw opens by 0 to {most} mm, not by {value}; the opening is the arc of the lower incisal point"
    )]
    JawOpening {
        /// Path of the field.
        field: String,
        /// The value, mm.
        value: f64,
        /// Widest opening accepted, mm.
        most: f64,
    },
    /// Bounds of the jaw's opening that leave nothing unknown.
    #[error("{field}: min {min} must be less than max {max} mm; for one opening give the number itself")]
    JawRange {
        /// Path of the field.
        field: String,
        /// Least opening, mm.
        min: f64,
        /// Greatest opening, mm.
        max: f64,
    },
    /// A jaw that is to open on a face that has none.
    #[error("{field}: the face has no jaw joint; give its face file a [jaw] table, or leave the opening out")]
    NoJaw {
        /// Path of the field.
        field: String,
    },
    /// A distance asked to be negative.
    #[error("{field}: a distance of {value} mm does not exist; give an axis for a signed component")]
    NegativeDistance {
        /// Path of the field.
        field: String,
        /// The value, mm.
        value: f64,
    },
    /// A feature or pair whose ends are one point.
    #[error("{field}: both ends are the same point; name two points")]
    SamePoint {
        /// Path of the field.
        field: String,
    },
    /// A muscle tied to itself.
    #[error("{field}: `{muscle}` is tied to itself; name two muscles")]
    TiedToItself {
        /// Path of the field.
        field: String,
        /// The muscle.
        muscle: String,
    },
    /// Tied muscles with different bounds.
    #[error(
        "{field}: `{left}` is tied to `{right}`, but they are bounded by {left_bounds:?} and {right_bounds:?}; bound both alike"
    )]
    TiedUnequal {
        /// Path of the field.
        field: String,
        /// One muscle.
        left: String,
        /// The other.
        right: String,
        /// Bounds of the one.
        left_bounds: [f64; 2],
        /// Bounds of the other.
        right_bounds: [f64; 2],
    },
    /// A point that no tissue is near.
    #[error("{field}: the point ({}, {}, {}) mm is {distance_mm:.1} mm from the face; is the unit or the frame another?", .point.x, .point.y, .point.z)]
    OutsideFace {
        /// Path of the field.
        field: String,
        /// The point, mm.
        point: Vec3,
        /// Its distance from the mesh, mm.
        distance_mm: f64,
    },
    /// A target without any term.
    #[error("{field}: nothing is asked for; give a marker, a feature, a mirrored pair or an effort")]
    NothingAsked {
        /// Path of the field.
        field: String,
    },
    /// A response that does not belong to the observations.
    #[error("{field}: the response has {found} rows, but the observations need {expected}")]
    ResponseShape {
        /// Which part of the response.
        field: String,
        /// Its rows or columns.
        found: usize,
        /// What they must be.
        expected: usize,
    },
}

impl TargetError {
    /// Path of the field, `markers[2].sigma_mm`, for a file reader that knows its line.
    pub fn field(&self) -> &str {
        match self {
            Self::UnknownLandmark { field, .. }
            | Self::UnknownMuscle { field, .. }
            | Self::Duplicate { field, .. }
            | Self::NotFinite { field, .. }
            | Self::Sigma { field, .. }
            | Self::Effort { field, .. }
            | Self::Huber { field, .. }
            | Self::PriorSigma { field, .. }
            | Self::BoundOutside { field, .. }
            | Self::BoundsCross { field, .. }
            | Self::JawOpening { field, .. }
            | Self::JawRange { field, .. }
            | Self::NoJaw { field, .. }
            | Self::NegativeDistance { field, .. }
            | Self::SamePoint { field, .. }
            | Self::TiedToItself { field, .. }
            | Self::TiedUnequal { field, .. }
            | Self::OutsideFace { field, .. }
            | Self::NothingAsked { field, .. }
            | Self::ResponseShape { field, .. } => field,
        }
    }
}

fn offer(nearest: &[String]) -> String {
    if nearest.is_empty() {
        return "the face has none".to_string();
    }
    let quoted: Vec<String> = nearest.iter().map(|name| format!("`{name}`")).collect();
    format!("the nearest are {}", quoted.join(", "))
}
