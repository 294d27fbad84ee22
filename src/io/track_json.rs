//! What a recording comes to, `summary.json`.

use std::collections::BTreeMap;

use schemars::JsonSchema;
use schemars::generate::SchemaSettings;
use serde::{Deserialize, Serialize};

use super::DiscrepancyJson;
use super::schema::{pretty, schema_of};
use super::solution_json::to_text;
use crate::certainty::Discrepancy;
use crate::recording::{BoundMarker, LabelSwap, Met, OffSkinMarker, SubjectWarning, TrackSummary};
use crate::study::{Checked, CheckedFrame, FrameIntervals, RestRound, Track};

/// A recording fitted, as `summary.json` states it. Lengths mm, forces N, times s, frames from 0; byte-identical from run to
/// run apart from `timings_s`.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[schemars(title = "Modiolus track", deny_unknown_fields)]
pub struct TrackJson {
    /// The recording as given.
    pub recording: String,
    /// The face: the name of a built-in face, or the path of its face.toml as given.
    pub face: String,
    /// How strong the muscles were, as a multiple of the face's `max_force_n`.
    pub strength: f64,
    /// How lips, cheeks and teeth touch: "reactions" or "off".
    pub contact_mode: String,
    /// Frames and the times of the first and the last, s.
    pub frames: usize,
    /// Time of the first frame, s.
    pub from_s: f64,
    /// Time of the last frame, s.
    pub to_s: f64,
    /// How many frames ended how: `"ok"`, `"no_data"`, `"underdetermined"`, `"not_solved"`.
    pub statuses: BTreeMap<String, usize>,
    /// All markers over all frames.
    pub all: MetJson,
    /// By region of the face.
    pub regions: BTreeMap<String, MetJson>,
    /// By marker.
    pub markers: BTreeMap<String, BoundJson>,
    /// How the subject was brought to the face.
    pub alignment: AlignmentJson,
    /// How the head was followed.
    pub head: HeadJson,
    /// Labels found exchanged, and exchanged back.
    pub swaps: Vec<SwapJson>,
    /// Markers far from what the others say, which did not count.
    pub outliers: Vec<OutlierJson>,
    /// How strain was measured: "linear" or "finite".
    pub strain: String,
    /// At finite strain, the rounds in which the face was settled; empty at linear strain.
    pub settled: Vec<SettledJson>,
    /// Where the stiffness was held: "mean", "fixed=A", or "follow" where it follows the activations.
    pub stiffness: String,
    /// Activation of each muscle at which the stiffness was held, 0 to 1; the mean where it follows.
    pub held_stiffness: BTreeMap<String, f64>,
    /// Least, mean and greatest activation of each muscle.
    pub activations: BTreeMap<String, [f64; 3]>,
    /// Least, mean and greatest opening of the jaw, mm; null where it rests.
    pub jaw_opening_mm: Option<[f64; 3]>,
    /// What `intervals.csv` comes to; null where no intervals were asked for.
    pub intervals: Option<IntervalsJson>,
    /// The face settled anew in a frame of each block: that in which the muscles do most, or at finite strain the farthest from all
    /// faces that were settled; null where that was not asked for.
    pub checked: Option<CheckedJson>,
    /// Largest violation of the optimality conditions, recomputed from the programs.
    pub certificate: f64,
    /// What is odd.
    pub warnings: Vec<String>,
    /// What is odd about the face.
    pub face_warnings: Vec<String>,
    /// Wall time of each step, s.
    pub timings_s: BTreeMap<String, f64>,
    /// SHA-256 of each input file, by its name on the command line.
    pub inputs: BTreeMap<String, String>,
    /// SHA-256 of each other file of this result.
    pub files: BTreeMap<String, String>,
    /// Version of the program.
    pub version: String,
}

/// Faces settled at finite strain for frames to be described about, in one round.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[schemars(deny_unknown_fields)]
pub struct SettledJson {
    /// Faces settled.
    pub states: usize,
    /// Faces that do not come to rest.
    pub without_rest: usize,
    /// Distance of their markers from where the round before had them, at first the linear model, mm, root mean square.
    pub rms_mm: f64,
    /// The farthest of them, mm.
    pub most_mm: f64,
}

impl From<&RestRound> for SettledJson {
    fn from(round: &RestRound) -> Self {
        let RestRound { states, without_rest, rms_mm, most_mm } = *round;
        Self { states, without_rest, rms_mm, most_mm }
    }
}

/// The face settled anew in a frame of each block.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[schemars(deny_unknown_fields)]
pub struct CheckedJson {
    /// How strain was measured: "linear" or "finite".
    pub strain: String,
    /// What was found in each.
    pub frames: Vec<CheckedFrameJson>,
}

/// A frame in which the face was settled anew.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[schemars(deny_unknown_fields)]
pub struct CheckedFrameJson {
    /// The frame, from 0.
    pub frame: usize,
    /// How far its markers are from where the recording's model has them, mm, root mean square.
    pub rms_mm: f64,
    /// The farthest of them, mm.
    pub most_mm: f64,
    /// Root mean square residual of its markers, mm.
    pub residual_mm: f64,
}

impl CheckedJson {
    /// What was found.
    pub fn of(checked: &Checked) -> Self {
        let one = |c: &CheckedFrame| {
            let CheckedFrame { frame, rms_mm, most_mm, residual_mm } = *c;
            CheckedFrameJson { frame, rms_mm, most_mm, residual_mm }
        };
        Self { strain: checked.strain.name().to_owned(), frames: checked.frames.iter().map(one).collect() }
    }
}

/// Intervals of the unknowns in some frames.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[schemars(deny_unknown_fields)]
pub struct IntervalsJson {
    /// From how many frames one was taken.
    pub every: usize,
    /// How many frames have intervals.
    pub frames: usize,
    /// How far the model was taken to be from the face.
    pub discrepancy: DiscrepancyJson,
    /// By how much the standard deviations had to be multiplied for the residuals to be likely; mean of the frames.
    pub noise_factor: f64,
    /// Mean width of the interval of each muscle's activation; 1 where nothing is determined.
    pub mean_width: BTreeMap<String, f64>,
}

impl IntervalsJson {
    /// Those of every `every`th frame of `track` with a model as far from the face as `discrepancy`.
    pub fn of(track: &Track, intervals: &[FrameIntervals], every: usize, discrepancy: &Discrepancy) -> Self {
        let mean = |of: &dyn Fn(&FrameIntervals) -> f64| {
            intervals.iter().map(of).sum::<f64>() / intervals.len().max(1) as f64
        };
        let width = |k: usize| mean(&|f| f.intervals.max[k] - f.intervals.min[k]);
        let muscles = track.mechanism().muscles.iter().enumerate();
        Self {
            every,
            frames: intervals.len(),
            discrepancy: DiscrepancyJson::from(discrepancy),
            noise_factor: mean(&|f| f.intervals.noise_factor),
            mean_width: muscles.map(|(k, name)| (name.clone(), width(k))).collect(),
        }
    }
}

/// How well markers are met.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[schemars(deny_unknown_fields)]
pub struct MetJson {
    /// Observations: markers by frames.
    pub observations: usize,
    /// Root mean square of the residuals, mm.
    pub rms_mm: f64,
    /// Root mean square of the measured displacements, mm on the face.
    pub movement_mm: f64,
    /// Share of the measured movement that is explained; null where nothing moved.
    pub explained: Option<f64>,
}

/// A marker on the face.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[schemars(deny_unknown_fields)]
pub struct BoundJson {
    /// The landmark that it is; null where it sits between landmarks.
    pub landmark: Option<String>,
    /// Its point of the face at rest, mm.
    pub at_mm: [f64; 3],
    /// How far its aligned neutral position is from there, mm.
    pub distance_mm: f64,
    /// How well it is met; null where it was never seen.
    pub met: Option<MetJson>,
}

/// How the subject was brought to the face.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[schemars(deny_unknown_fields)]
pub struct AlignmentJson {
    /// Size of the face over that of the subject.
    pub scale: f64,
    /// Root mean square distance of the subject's landmarks, aligned, from the face's, mm.
    pub rms_mm: f64,
    /// Markers off the skin, left out, and how far off they are, mm.
    pub left_out_mm: BTreeMap<String, Option<f64>>,
}

/// How the head was followed.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[schemars(deny_unknown_fields)]
pub struct HeadJson {
    /// The markers that move with the skull.
    pub stable: Vec<String>,
    /// Root mean square distance of these from their neutral places once the head's movement is taken away, mm.
    pub rms_mm: f64,
    /// Frames in which its place was interpolated.
    pub interpolated: usize,
    /// Frames in which it is not known.
    pub unknown: usize,
}

/// Labels that were exchanged.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[schemars(deny_unknown_fields)]
pub struct SwapJson {
    /// The labels.
    pub labels: [String; 2],
    /// First and last frame, from 0.
    pub frames: [usize; 2],
}

/// A marker far from what the others say.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[schemars(deny_unknown_fields)]
pub struct OutlierJson {
    /// The frame, from 0.
    pub frame: usize,
    /// The marker.
    pub marker: String,
    /// How far it is from where the others put it, mm.
    pub residual_mm: f64,
}

impl From<&Met> for MetJson {
    fn from(met: &Met) -> Self {
        let Met { observations, rms_mm, movement_mm, explained } = *met;
        Self { observations, rms_mm, movement_mm, explained }
    }
}

impl From<&LabelSwap> for SwapJson {
    fn from(swap: &LabelSwap) -> Self {
        Self { labels: swap.labels.clone(), frames: swap.frames }
    }
}

impl BoundJson {
    /// By label each marker of `track` that is on the face, and how well it is met.
    pub fn of(track: &Track, summary: &TrackSummary) -> BTreeMap<String, Self> {
        let one = |b: &BoundMarker| {
            let p = b.site.position;
            let met = summary.markers.get(&b.label).map(MetJson::from);
            let (landmark, distance_mm) = (b.landmark.clone(), b.distance_mm);
            (b.label.clone(), Self { landmark, at_mm: [p.x, p.y, p.z], distance_mm, met })
        };
        track.subject.bound.iter().map(one).collect()
    }
}

impl AlignmentJson {
    /// That of `track`.
    pub fn of(track: &Track) -> Self {
        let subject = &track.subject;
        let left_out = subject.warnings.iter().find_map(|w| match w {
            SubjectWarning::LeftOut(markers) => Some(markers),
            _ => None,
        });
        let distance =
            |m: &OffSkinMarker| (m.label.clone(), m.distance_mm.is_finite().then_some(m.distance_mm));
        Self {
            scale: subject.alignment.scale,
            rms_mm: subject.alignment_rms_mm,
            left_out_mm: left_out.into_iter().flatten().map(distance).collect(),
        }
    }
}

impl HeadJson {
    /// That of `track`.
    pub fn of(track: &Track) -> Self {
        let head = &track.movement.head;
        Self {
            stable: head.stable.iter().map(|&k| track.subject.labels[k].clone()).collect(),
            rms_mm: head.rms_mm,
            interpolated: head.interpolated.len(),
            unknown: head.to_neutral.iter().filter(|h| h.is_none()).count(),
        }
    }
}

impl TrackJson {
    /// The text of the file.
    ///
    /// # Errors
    /// When it cannot be put together.
    pub fn to_text(&self) -> serde_json::Result<String> {
        to_text(self)
    }
}

/// The JSON schema of `summary.json`, as in `schemas/track.schema.json`.
pub fn track_schema() -> String {
    let settings = SchemaSettings::draft2020_12().for_serialize();
    pretty(&schema_of::<TrackJson>(settings))
}
