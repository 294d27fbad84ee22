//! The tables of a target file, as they are written.

use std::fmt;

use schemars::{JsonSchema, Schema};
use serde::{Deserialize, Deserializer, de};

/// A target file: what a face shall do, and the limits of its muscles. Lengths mm; frame +x the
/// subject's left, +y up, +z anterior, origin at the stomion.
#[derive(Debug, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
#[schemars(title = "Modiolus target", transform = accept_singular_names)]
pub(super) struct TargetTable {
    /// Name of the target, one word of letters, digits, `_` and `-`.
    pub(super) name: String,
    /// What it is, one sentence.
    #[serde(default)]
    pub(super) description: String,
    /// Where the figures come from.
    #[serde(default)]
    pub(super) provenance: String,
    /// Unit of every length in the file: "mm".
    #[expect(dead_code, reason = "the reader checks it before the other fields, whose names end in it")]
    #[schemars(extend("enum" = ["mm"]))]
    pub(super) unit: String,
    /// Points of the face and where they shall go.
    #[serde(default, alias = "marker")]
    pub(super) markers: Vec<MarkerTable>,
    /// Markers of one frame of a recording, beside those above.
    pub(super) recording: Option<RecordingTable>,
    /// Lengths between two points.
    #[serde(default, alias = "feature")]
    pub(super) features: Vec<FeatureTable>,
    /// Pairs of points that shall move as mirror images.
    #[serde(default)]
    pub(super) symmetry: Vec<SymmetryTable>,
    /// Weight w of the effort; 0 when absent.
    #[serde(default)]
    #[schemars(range(min = 0.0))]
    pub(super) effort: f64,
    /// How the activations a of muscles that cost c make one effort: "l2", w/2 times the sum of c a², in which all that help
    /// act, or "l1", w times the sum of c a, in which few do; "l2" when absent.
    pub(super) effort_norm: Option<NormName>,
    /// What the effort of a muscle is: "activation", its force by "force", or its active "volume"; "activation" when absent.
    pub(super) effort_by: Option<EffortName>,
    /// Muscles whose effort counts more or less than that.
    #[serde(default, alias = "cost")]
    pub(super) costs: Vec<CostTable>,
    /// How residuals of markers count: "squares", or "huber", which an outlier cannot turn; "squares" when absent.
    pub(super) loss: Option<LossName>,
    /// Standard deviations at which Huber's loss turns from squares to a line, 0.1 to 100; 3 when absent.
    #[schemars(range(min = 0.1, max = 100.0))]
    pub(super) loss_sigmas: Option<f64>,
    /// Activations that were observed, as by electromyography, or are thought likely.
    #[serde(default, alias = "prior")]
    pub(super) priors: Vec<PriorTable>,
    /// Limits of activations other than 0 to 1.
    #[serde(default, alias = "bound")]
    pub(super) bounds: Vec<BoundTable>,
    /// How far the jaw is open, mm of arc at the lower incisors, 0 to 60: a number, or the bounds of an unknown
    /// opening, `{ min = 0.0, max = 12.0 }`; at rest when absent.
    pub(super) jaw_opening_mm: Option<OpeningValue>,
    /// Pairs of muscles with equal activations, such as `["risorius_l", "risorius_r"]`.
    #[serde(default)]
    pub(super) tied: Vec<[String; 2]>,
    /// Results stated for known faces.
    #[serde(default)]
    pub(super) expected: Vec<ExpectedTable>,
}

/// A marker: a landmark or a rest point, and its displacement or its position.
#[derive(Debug, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub(super) struct MarkerTable {
    /// Label, unique in the file; the landmark's name when absent.
    pub(super) name: Option<String>,
    /// Landmark by name, such as `cheilion_l`.
    pub(super) landmark: Option<String>,
    /// Rest position [x, y, z], mm, when the point is not a landmark.
    pub(super) point_mm: Option<[f64; 3]>,
    /// Displacement from rest [x, y, z], mm; nan (or "") is a component that was not observed.
    pub(super) displacement_mm: Option<[Component; 3]>,
    /// Position in the face frame [x, y, z], mm; nan (or "") is a component that was not observed.
    pub(super) position_mm: Option<[Component; 3]>,
    /// Standard deviation, mm, more than 0.
    #[schemars(extend("exclusiveMinimum" = 0.0))]
    pub(super) sigma_mm: f64,
}

/// A frame of a recording; give one of `frame`, `time_s` and `name`.
#[derive(Debug, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub(super) struct RecordingTable {
    /// The recording, its path beside this file.
    pub(super) file: String,
    /// The frame, counted from 0.
    #[schemars(range(min = 0.0))]
    pub(super) frame: Option<f64>,
    /// The time of the frame, s; the nearest is taken.
    pub(super) time_s: Option<f64>,
    /// The name of the frame, such as that of an expression.
    pub(super) name: Option<String>,
    /// The marker map, its path beside this file; labels are names of landmarks when absent.
    pub(super) map: Option<String>,
}

/// A distance, or with an axis the signed component `to - from` along it.
#[derive(Debug, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub(super) struct FeatureTable {
    /// Label, unique in the file; "FROM to TO" when absent.
    pub(super) name: Option<String>,
    /// One end: a landmark by name, or a rest position [x, y, z], mm.
    pub(super) from: PlaceValue,
    /// The other end: a landmark by name, or a rest position [x, y, z], mm.
    pub(super) to: PlaceValue,
    /// Axis of the signed component, "x", "y" or "z"; the distance when absent.
    pub(super) axis: Option<AxisName>,
    /// The length itself, mm.
    pub(super) value_mm: Option<f64>,
    /// Its change from rest, mm.
    pub(super) change_mm: Option<f64>,
    /// Standard deviation, mm, more than 0.
    #[schemars(extend("exclusiveMinimum" = 0.0))]
    pub(super) sigma_mm: f64,
}

/// Two points that shall move as mirror images in the plane x = 0.
#[derive(Debug, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub(super) struct SymmetryTable {
    /// The subject's left point: a landmark by name, or a rest position [x, y, z], mm.
    pub(super) left: PlaceValue,
    /// The subject's right point: a landmark by name, or a rest position [x, y, z], mm.
    pub(super) right: PlaceValue,
    /// Standard deviation of the difference, mm, more than 0.
    #[schemars(extend("exclusiveMinimum" = 0.0))]
    pub(super) sigma_mm: f64,
}

/// An activation that was observed, of one muscle or of all that a pattern names.
#[derive(Debug, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub(super) struct PriorTable {
    /// Muscle by name, or a pattern with one star such as "zygomaticus_*_l".
    pub(super) muscle: String,
    /// Its activation, 0 to 1.
    #[schemars(range(min = 0.0, max = 1.0))]
    pub(super) activation: f64,
    /// Standard deviation in units of activation, more than 0.
    #[schemars(extend("exclusiveMinimum" = 0.0))]
    pub(super) sigma: f64,
}

/// What one muscle, or all that a pattern names, cost beside what their measure says.
#[derive(Debug, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub(super) struct CostTable {
    /// Muscle by name, or a pattern with one star such as "platysma_*".
    pub(super) muscle: String,
    /// Factor on its effort, 0 or more.
    #[schemars(range(min = 0.0))]
    pub(super) factor: f64,
}

/// Limits of one activation, or of all that a pattern names.
#[derive(Debug, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub(super) struct BoundTable {
    /// Muscle by name, or a pattern with one star such as "*_r".
    pub(super) muscle: String,
    /// Least activation, 0 to 1; 0 when absent.
    #[schemars(range(min = 0.0, max = 1.0))]
    pub(super) min: Option<f64>,
    /// Greatest activation, 0 to 1; 1 when absent.
    #[schemars(range(min = 0.0, max = 1.0))]
    pub(super) max: Option<f64>,
}

/// An opening of the jaw, or the bounds of an unknown one.
#[derive(Clone, Copy, Debug, Deserialize, JsonSchema)]
#[serde(untagged)]
pub(super) enum OpeningValue {
    /// That far, mm.
    Held(f64),
    /// Unknown within bounds.
    Within(OpeningTable),
}

/// Bounds of an unknown opening of the jaw.
#[derive(Clone, Copy, Debug, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub(super) struct OpeningTable {
    /// Least opening, mm; 0 when absent.
    #[serde(default)]
    pub(super) min: f64,
    /// Greatest opening, mm.
    pub(super) max: f64,
}

/// A result stated for one face.
#[derive(Debug, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub(super) struct ExpectedTable {
    /// Name of the face.
    pub(super) face: String,
    /// Root mean square of the marker residuals, mm.
    pub(super) residual_rms_mm: f64,
    /// How far the computed value may be from it, mm.
    pub(super) tolerance_mm: f64,
}

/// One component of an observation; `None` when it was not observed.
#[derive(Clone, Copy, Debug, JsonSchema)]
#[schemars(with = "ComponentValue")]
pub(super) struct Component(pub(super) Option<f64>);

impl<'de> Deserialize<'de> for Component {
    fn deserialize<D: Deserializer<'de>>(deserializer: D) -> Result<Self, D::Error> {
        match ComponentValue::deserialize(deserializer)? {
            ComponentValue::Number(x) => Ok(Self((!x.is_nan()).then_some(x))),
            ComponentValue::Blank(text) if text.is_empty() => Ok(Self(None)),
            ComponentValue::Blank(_) => {
                Err(de::Error::custom("expected a number, or nan when it is missing"))
            }
        }
    }
}

#[derive(Debug, Deserialize, JsonSchema)]
#[serde(untagged)]
enum ComponentValue {
    /// A number, or nan.
    Number(f64),
    /// Blank: not observed.
    Blank(#[schemars(extend("enum" = [""]))] String),
}

/// A point: a landmark by name, or a rest position, mm.
#[derive(Clone, Debug, PartialEq, Deserialize, JsonSchema)]
#[serde(untagged)]
pub(super) enum PlaceValue {
    /// A landmark by name.
    Landmark(String),
    /// A rest position [x, y, z], mm.
    Point([f64; 3]),
}

impl fmt::Display for PlaceValue {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::Landmark(name) => f.write_str(name),
            Self::Point(p) => write!(f, "[{}, {}, {}]", p[0], p[1], p[2]),
        }
    }
}

#[derive(Clone, Copy, Debug, PartialEq, Eq, Deserialize, JsonSchema)]
#[serde(rename_all = "lowercase")]
pub(super) enum EffortName {
    Activation,
    Force,
    Volume,
}

#[derive(Clone, Copy, Debug, PartialEq, Eq, Deserialize, JsonSchema)]
#[serde(rename_all = "lowercase")]
pub(super) enum NormName {
    L1,
    L2,
}

#[derive(Clone, Copy, Debug, PartialEq, Eq, Deserialize, JsonSchema)]
#[serde(rename_all = "lowercase")]
pub(super) enum LossName {
    Squares,
    Huber,
}

#[derive(Clone, Copy, Debug, Deserialize, JsonSchema)]
#[serde(rename_all = "lowercase")]
pub(super) enum AxisName {
    X,
    Y,
    Z,
}

/// The lists that may also be written in the singular, `[[marker]]`.
pub(super) const SINGULAR: [(&str, &str); 5] = [
    ("marker", "markers"),
    ("feature", "features"),
    ("cost", "costs"),
    ("prior", "priors"),
    ("bound", "bounds"),
];

fn accept_singular_names(schema: &mut Schema) {
    let Some(properties) = schema.get_mut("properties").and_then(|p| p.as_object_mut()) else {
        return;
    };
    for (singular, plural) in SINGULAR {
        if let Some(list) = properties.get(plural).cloned() {
            properties.insert(singular.to_owned(), list);
        }
    }
}
