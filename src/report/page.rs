//! Results as one page that needs nothing else.

use std::collections::BTreeMap;

use serde::Serialize;
use thiserror::Error;

use super::arrays::{ArrayRef, Arrays};
use super::drawn_face::{DrawnFace, FaceJson, PlaceJson};
use super::markup::{escaped, filled, script_json, source_of};
use super::motion::{Motion, MotionKind, MotionState};
use super::{plot, tables, track_tables};
use crate::face::{Face, Pose};
use crate::io::{AnswerFiles, BoundJson, MarkerJson, TrackFiles};
use crate::mesh::Locator;
use crate::render::{ColourMap, to_srgb};
use crate::units::Vec3;

const TEMPLATE: &str = include_str!("../../web/src/page.html");
const PAGE_STYLE: &str = include_str!("../../web/src/page.css");
const SCRIPT: &str = include_str!("../../web/dist/report.js");

/// Most results that a page shows beside each other.
pub const MOST_RESULTS: usize = 2;
/// Colours by which the page draws its map.
const COLOURS: usize = 65;
/// Farthest that a marker may be from the surface to move with it on the page, mm.
const MARKER_MM: f64 = 2.;

/// A result as it is shown.
#[derive(Clone, Debug)]
pub struct ShownResult<'a> {
    /// Its heading.
    pub title: String,
    /// What its files say.
    pub told: Told<'a>,
    /// Which of the page's faces it moves.
    pub face: usize,
    /// How it moves it.
    pub motion: Motion,
}

/// What the files of a result say.
#[derive(Clone, Copy, Debug)]
pub enum Told<'a> {
    /// An answer.
    Answer(&'a AnswerFiles),
    /// A recording fitted, of whose frames the motion shows every so many.
    Track(&'a TrackFiles),
}

impl Told<'_> {
    /// Least and greatest activation that the data allow.
    fn intervals(self) -> BTreeMap<String, [f64; 2]> {
        match self {
            Self::Answer(answer) => {
                let unknowns = answer.certainty.iter().flat_map(|c| &c.unknowns);
                unknowns.map(|u| (u.name.clone(), [u.min, u.max])).collect()
            }
            Self::Track(_) => BTreeMap::new(),
        }
    }

    /// Everything that is not seen on the face, as HTML.
    fn article(self, muscles: &[String]) -> String {
        match self {
            Self::Answer(answer) => tables::article(answer, muscles),
            Self::Track(track) => track_tables::article(track, muscles),
        }
    }
}

/// Why there is no page.
#[derive(Debug, Error)]
#[non_exhaustive]
pub enum ReportError {
    /// No result, or more than fit beside each other.
    #[error(
        "a report shows one or {} results, not {found}; more of one face are shown as a sequence",
        MOST_RESULTS
    )]
    Results {
        /// How many there are.
        found: usize,
    },
    /// A field that is not of its face.
    #[error("{title}: {what} has {found} values, but its face needs {expected}")]
    Length {
        /// The result.
        title: String,
        /// What does not fit.
        what: &'static str,
        /// Its length.
        found: usize,
        /// That of the face.
        expected: usize,
    },
    /// The numbers cannot be packed.
    #[error("the page cannot be put together: {0}")]
    Packing(#[from] std::io::Error),
    /// The data cannot be written.
    #[error("the page cannot be put together: {0}")]
    Json(#[from] serde_json::Error),
}

#[derive(Serialize)]
struct PageJson {
    version: &'static str,
    /// sRGB of the colour map, from its least to its greatest value.
    colours: Vec<[u8; 3]>,
    faces: Vec<FaceJson>,
    results: Vec<ResultJson>,
}

#[derive(Serialize)]
struct ResultJson {
    title: String,
    face: usize,
    kind: &'static str,
    answer: StateJson,
    /// On the way to the answer those before it, of a sequence all.
    states: Vec<StateJson>,
    /// Displacement of the carriers per unit activation, mm, of each muscle.
    tangent: Vec<ArrayRef>,
    notes: Vec<String>,
    /// Least and greatest activation that the data allow.
    intervals: BTreeMap<String, [f64; 2]>,
    markers: Vec<ShownMarkerJson>,
}

#[derive(Serialize)]
struct StateJson {
    label: String,
    time: f64,
    activation: Vec<f64>,
    displacement: Option<ArrayRef>,
    /// kPa, of the first carriers.
    pressure: Option<ArrayRef>,
    /// Of each tooth surface the images of the origin and of the three unit vectors, mm; none where no bone moves.
    teeth: Vec<[[f64; 3]; 4]>,
    /// Of each marker whether it was seen, and its measured less its modelled displacement, mm; null where markers do not
    /// change from state to state.
    residuals: Option<[ArrayRef; 2]>,
}

#[derive(Serialize)]
struct ShownMarkerJson {
    name: String,
    rest: [f64; 3],
    measured: [Option<f64>; 3],
    model: [f64; 3],
    residual: Option<f64>,
    place: Option<PlaceJson>,
}

/// The page that shows `results`, of which each moves one of `faces`: HTML that opens from disk, asks no network and lets
/// no other script run. The same input gives the same bytes.
///
/// # Errors
/// [`ReportError`] for no results or too many, and for fields of other faces.
pub fn page(faces: &[&Face], results: &[ShownResult<'_>]) -> Result<String, ReportError> {
    if !(1..=MOST_RESULTS).contains(&results.len()) {
        return Err(ReportError::Results { found: results.len() });
    }
    for result in results {
        check(faces[result.face], result)?;
    }
    let mut arrays = Arrays::default();
    let drawn: Vec<DrawnFace> = faces.iter().map(|face| DrawnFace::new(face, &mut arrays)).collect();
    let shown =
        results.iter().map(|result| shown(faces[result.face], &drawn[result.face], result, &mut arrays));
    let map = ColourMap::new();
    let data = PageJson {
        version: env!("CARGO_PKG_VERSION"),
        colours: (0..COLOURS).map(|k| to_srgb(map.at(k as f64 / (COLOURS - 1) as f64))).collect(),
        results: shown.collect(),
        faces: drawn.into_iter().map(|face| face.json).collect(),
    };
    let titles: Vec<String> = results.iter().map(|result| result.title.clone()).collect();
    let articles = results.iter().enumerate().map(|(k, result)| {
        let muscles: Vec<String> = faces[result.face].muscles.iter().map(|m| m.name.clone()).collect();
        let letter = if results.len() > 1 { format!("{}: ", letter(k)) } else { String::new() };
        let body = result.told.article(&muscles);
        format!("<article><h2>{letter}{}</h2>{body}</article>", escaped(&result.title))
    });
    let style = format!("{PAGE_STYLE}{}", plot::STYLE);
    let policy = format!(
        "default-src 'none'; script-src {}; style-src {}; base-uri 'none'; form-action 'none'",
        source_of(SCRIPT),
        source_of(&style)
    );
    Ok(filled(
        TEMPLATE,
        &[
            ("policy", &escaped_policy(&policy)),
            ("title", &escaped(&titles.join(" and "))),
            ("style", &style),
            ("script", SCRIPT),
            ("articles", &articles.collect::<String>()),
            ("data", &script_json(&data)?),
            ("arrays", &arrays.to_base64()?),
            ("version", env!("CARGO_PKG_VERSION")),
        ],
    ))
}

/// A policy for a double-quoted attribute: it needs its single quotes.
fn escaped_policy(policy: &str) -> String {
    policy.replace('&', "&amp;").replace('"', "&quot;")
}

/// How the `k`-th of two results is called.
fn letter(k: usize) -> char {
    if k == 0 { 'A' } else { 'B' }
}

fn check(face: &Face, result: &ShownResult<'_>) -> Result<(), ReportError> {
    let (n, m) = (face.mesh.n_nodes(), face.muscles.len());
    let mut lengths: Vec<(&'static str, usize, usize)> = Vec::new();
    for state in result.motion.states.iter().chain([&result.motion.answer]) {
        lengths.push(("an activation list", state.activation.len(), m));
        lengths.extend(state.displacement.iter().map(|u| ("a displacement", u.len(), 3 * n)));
        lengths.extend(state.pressure_kpa.iter().map(|p| ("a contact pressure", p.len(), n)));
    }
    if let Told::Track(track) = result.told {
        let of_state = |s: &MotionState| ("a list of residuals", s.residual_mm.len(), track.markers.len());
        lengths.extend(result.motion.states.iter().map(of_state));
    }
    lengths.extend(result.motion.tangent.iter().map(|u| ("a field of the tangent", u.len(), 3 * n)));
    match lengths.into_iter().find(|(_, found, expected)| found != expected) {
        Some((what, found, expected)) => {
            Err(ReportError::Length { title: result.title.clone(), what, found, expected })
        }
        None => Ok(()),
    }
}

fn shown(face: &Face, drawn: &DrawnFace, result: &ShownResult<'_>, arrays: &mut Arrays) -> ResultJson {
    let motion = &result.motion;
    let has_load = |p: &&Vec<f64>| p.iter().any(|p| *p > 0.);
    let mut all = motion.states.iter().chain([&motion.answer]);
    let loaded = all.any(|s| s.pressure_kpa.as_ref().is_some_and(|p| has_load(&p)));
    let state = |state: &MotionState, arrays: &mut Arrays| StateJson {
        label: state.label.clone(),
        time: state.time,
        activation: state.activation.clone(),
        displacement: state.displacement.as_ref().map(|u| arrays.reals(&drawn.displacement(u))),
        pressure: state.pressure_kpa.as_ref().filter(|_| loaded).map(|p| {
            let on_surface: Vec<f64> = drawn.surface_nodes.iter().map(|n| p[*n]).collect();
            arrays.reals(&on_surface)
        }),
        teeth: teeth(face, &state.pose),
        residuals: (!state.residual_mm.is_empty()).then(|| {
            let seen: Vec<u8> = state.residual_mm.iter().map(|r| u8::from(r.is_some())).collect();
            let all = state.residual_mm.iter().flat_map(|r| <[f64; 3]>::from(r.unwrap_or_default()));
            [arrays.bytes(&seen), arrays.reals(&all.collect::<Vec<_>>())]
        }),
    };
    let answer = state(&motion.answer, arrays);
    let states = motion.states.iter().map(|s| state(s, arrays)).collect();
    let tangent = motion.tangent.iter().map(|field| arrays.reals(&drawn.displacement(field))).collect();
    let locator = Locator::new(&face.mesh);
    let markers = match result.told {
        Told::Answer(answer) => {
            answer.markers.iter().filter_map(|m| marker(face, drawn, &locator, m)).collect()
        }
        Told::Track(track) => tracked_markers(drawn, &locator, track),
    };
    ResultJson {
        title: result.title.clone(),
        face: result.face,
        kind: match motion.kind {
            MotionKind::Loading => "loading",
            MotionKind::Sequence => "sequence",
            MotionKind::Track => "track",
        },
        answer,
        states,
        tangent,
        notes: motion.notes.clone(),
        intervals: result.told.intervals(),
        markers,
    }
}

/// A marker that was measured; `None` for points that were only reported, and where its place is not known.
fn marker(face: &Face, drawn: &DrawnFace, locator: &Locator, marker: &MarkerJson) -> Option<ShownMarkerJson> {
    if marker.target_mm.iter().all(Option::is_none) {
        return None;
    }
    let landmark = face.landmark(&marker.name);
    let rest = marker.rest_mm.map(Vec3::from).or_else(|| landmark.map(|l| l.site.position))?;
    let own = landmark.map(|l| &l.site).filter(|site| (site.position - rest).norm() < 1e-6);
    let nearest = locator.closest(rest).filter(|found| found.distance_mm < MARKER_MM);
    let place = own.and_then(|site| drawn.place(site)).or_else(|| drawn.place(&nearest?.site));
    Some(ShownMarkerJson {
        name: marker.name.clone(),
        rest: rest.into(),
        measured: marker.target_mm,
        model: marker.model_mm,
        residual: marker.residual_mm,
        place,
    })
}

/// The markers of a track, each where it is on the face.
fn tracked_markers(drawn: &DrawnFace, locator: &Locator, track: &TrackFiles) -> Vec<ShownMarkerJson> {
    let one = |(name, bound): (&String, &BoundJson)| ShownMarkerJson {
        name: name.clone(),
        rest: bound.at_mm,
        measured: [None; 3],
        model: [0.; 3],
        residual: bound.met.as_ref().map(|met| met.rms_mm),
        place: locator.closest(Vec3::from(bound.at_mm)).and_then(|found| drawn.place(&found.site)),
    };
    track.summary.markers.iter().map(one).collect()
}

fn teeth(face: &Face, pose: &Pose) -> Vec<[[f64; 3]; 4]> {
    if pose.is_rest() {
        return Vec::new();
    }
    let images = |bone: &str| {
        let motion = pose.motion(face, bone);
        [Vec3::zeros(), Vec3::x(), Vec3::y(), Vec3::z()].map(|p| motion.apply(p).into())
    };
    face.teeth.iter().map(|teeth| images(&teeth.bone)).collect()
}
