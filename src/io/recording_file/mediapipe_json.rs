//! Face landmarks of MediaPipe in JSON: what its results are when they are written as they stand.

use std::fmt;
use std::path::Path;

use serde::Deserialize;
use serde::de::{self, Deserializer, IgnoredAny, MapAccess, SeqAccess, Visitor};

use super::draft::Draft;
use super::error::{RecordingFileError, RecordingFileErrorKind};
use super::format::RecordingFormat;
use super::mediapipe::{self, POINTS};
use super::options::ReadOptions;
use super::table::Times;
use crate::io::Location;
use crate::io::text::shown;
use crate::units::{LengthUnit, Vec3};

type Result<T> = std::result::Result<T, RecordingFileError>;

/// Most frames that are read: ten hours of video.
const MAX_FRAMES: usize = 1 << 20;
/// One frame in so many must have a face.
const SPARSEST: usize = 64;

/// A face: its points, shares of the image.
type Face = Vec<[f64; 3]>;

/// One frame of a video.
#[derive(Default)]
struct Frame {
    /// No face, one, or several.
    faces: Vec<Face>,
    time: Option<Time>,
    number: Option<f64>,
    width: Option<f64>,
    height: Option<f64>,
    rate_hz: Option<f64>,
    /// The frames of a recording that says something of them all.
    frames: Option<Vec<Self>>,
}

#[derive(Clone, Copy)]
struct Time {
    value: f64,
    /// Seconds in one.
    unit: f64,
    stated: bool,
}

/// Any part of such a file. Numbers, points, faces and frames are told apart by how deep they are.
enum Part {
    Nothing,
    Number(f64),
    Point([f64; 3]),
    Face(Face),
    Faces(Vec<Face>),
    Frame(Box<Frame>),
    Frames(Vec<Frame>),
}

impl Part {
    /// As the faces of one frame.
    fn into_faces(self) -> Option<Vec<Face>> {
        match self {
            Self::Nothing => Some(Vec::new()),
            Self::Face(face) => Some(vec![face]),
            Self::Faces(faces) => Some(faces),
            Self::Frame(frame) if frame.frames.is_none() => Some(frame.faces),
            // Faces as objects.
            Self::Frames(frames) => Some(frames.into_iter().flat_map(|frame| frame.faces).collect()),
            _ => None,
        }
    }

    /// As the frames of a recording.
    fn into_frames(self) -> Option<Vec<Frame>> {
        let of = |faces: Vec<Face>| Frame { faces, ..Frame::default() };
        match self {
            Self::Nothing => Some(Vec::new()),
            Self::Face(face) => Some(vec![of(vec![face])]),
            Self::Faces(faces) => Some(faces.into_iter().map(|face| of(vec![face])).collect()),
            Self::Frame(frame) => Some(vec![*frame]),
            Self::Frames(frames) => Some(frames),
            _ => None,
        }
    }
}

impl<'de> Deserialize<'de> for Part {
    fn deserialize<D: Deserializer<'de>>(deserializer: D) -> std::result::Result<Self, D::Error> {
        deserializer.deserialize_any(PartVisitor)
    }
}

struct PartVisitor;

impl<'de> Visitor<'de> for PartVisitor {
    type Value = Part;

    fn expecting(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str("points {x, y, z} of faces in frames")
    }

    fn visit_unit<E>(self) -> std::result::Result<Part, E> {
        Ok(Part::Nothing)
    }

    fn visit_bool<E>(self, _: bool) -> std::result::Result<Part, E> {
        Ok(Part::Nothing)
    }

    fn visit_i64<E>(self, value: i64) -> std::result::Result<Part, E> {
        Ok(Part::Number(value as f64))
    }

    fn visit_u64<E>(self, value: u64) -> std::result::Result<Part, E> {
        Ok(Part::Number(value as f64))
    }

    fn visit_f64<E>(self, value: f64) -> std::result::Result<Part, E> {
        Ok(Part::Number(value))
    }

    fn visit_str<E>(self, _: &str) -> std::result::Result<Part, E> {
        Ok(Part::Nothing)
    }

    fn visit_seq<A: SeqAccess<'de>>(self, mut seq: A) -> std::result::Result<Part, A::Error> {
        let mixed = || de::Error::custom("points, faces and frames stand side by side");
        let (mut numbers, mut count) = ([0.; 3], 0);
        let (mut face, mut faces, mut frames) = (Face::new(), Vec::new(), Vec::new());
        while let Some(part) = seq.next_element::<Part>()? {
            match part {
                Part::Number(x) => {
                    if let Some(number) = numbers.get_mut(count) {
                        *number = x;
                    }
                    count += 1;
                }
                Part::Point(p) => face.push(p),
                Part::Face(f) => faces.push(f),
                // A frame in which no face was found.
                Part::Nothing => faces.push(Face::new()),
                Part::Faces(_) | Part::Frame(_) => {
                    if faces.iter().all(Vec::is_empty) {
                        frames.extend(faces.drain(..).map(|_| Frame::default()));
                    }
                    frames.push(match part {
                        Part::Frame(frame) => *frame,
                        other => Frame { faces: other.into_faces().unwrap_or_default(), ..Frame::default() },
                    });
                }
                Part::Frames(_) => return Err(mixed()),
            }
            if faces.len().max(frames.len()) > MAX_FRAMES {
                return Err(de::Error::custom(format!("there are more than {MAX_FRAMES} frames")));
            }
        }
        if !frames.is_empty() && faces.iter().all(Vec::is_empty) {
            frames.extend(faces.drain(..).map(|_| Frame::default()));
        }
        let kinds = [count > 0, !face.is_empty(), !faces.is_empty(), !frames.is_empty()];
        if kinds.iter().filter(|k| **k).count() > 1 {
            return Err(mixed());
        }
        Ok(match kinds {
            // Four and more are a point with its visibility.
            [true, ..] if count >= 2 => Part::Point(numbers),
            [true, ..] => Part::Number(numbers[0]),
            [_, true, ..] => Part::Face(face),
            [_, _, true, _] => Part::Faces(faces),
            [.., true] => Part::Frames(frames),
            _ => Part::Nothing,
        })
    }

    fn visit_map<A: MapAccess<'de>>(self, mut map: A) -> std::result::Result<Part, A::Error> {
        let mut p = [None; 3];
        let mut frame = Frame::default();
        let wrong = |key: &str| de::Error::custom(format!("`{}` holds something else", shown(key)));
        while let Some(key) = map.next_key::<String>()? {
            let flat: String = key.chars().filter(|c| *c != '_').flat_map(char::to_lowercase).collect();
            let number = |map: &mut A| -> std::result::Result<Option<f64>, A::Error> {
                match map.next_value::<Part>()? {
                    Part::Number(x) => Ok(Some(x)),
                    Part::Nothing => Ok(None),
                    _ => Err(wrong(&key)),
                }
            };
            let time = |map: &mut A, unit, stated| -> std::result::Result<Option<Time>, A::Error> {
                Ok(number(map)?.map(|value| Time { value, unit, stated }))
            };
            match flat.as_str() {
                "x" => p[0] = number(&mut map)?,
                "y" => p[1] = number(&mut map)?,
                "z" => p[2] = number(&mut map)?,
                "times" | "timestamps" => frame.time = time(&mut map, 1., true)?,
                "timems" | "timestampms" => frame.time = time(&mut map, 1e-3, true)?,
                "timestampus" | "timeus" => frame.time = time(&mut map, 1e-6, true)?,
                "time" | "timestamp" | "t" => frame.time = time(&mut map, 1., false)?,
                "frame" | "frameindex" | "framenumber" => frame.number = number(&mut map)?,
                "width" | "imagewidth" => frame.width = number(&mut map)?,
                "height" | "imageheight" => frame.height = number(&mut map)?,
                "fps" | "rate" | "ratehz" | "framerate" => frame.rate_hz = number(&mut map)?,
                "imagesize" | "size" | "resolution" => match map.next_value::<Part>()? {
                    Part::Point([w, h, _]) => (frame.width, frame.height) = (Some(w), Some(h)),
                    _ => return Err(wrong(&key)),
                },
                "frames" | "results" => {
                    frame.frames = Some(map.next_value::<Part>()?.into_frames().ok_or_else(|| wrong(&key))?);
                }
                "facelandmarks" | "multifacelandmarks" | "landmarks" | "landmark" | "keypoints"
                | "points" | "faces" => {
                    frame.faces = map.next_value::<Part>()?.into_faces().ok_or_else(|| wrong(&key))?;
                }
                _ => drop(map.next_value::<IgnoredAny>()?),
            }
        }
        match p {
            [Some(x), Some(y), z] => Ok(Part::Point([x, y, z.unwrap_or(0.)])),
            [None, None, None] => Ok(Part::Frame(Box::new(frame))),
            _ => Err(de::Error::custom("a point lacks x or y")),
        }
    }
}

/// The recording in the JSON `bytes` of `file`: one value, or one a line.
pub(super) fn parse(file: &Path, bytes: &[u8], options: &ReadOptions) -> Result<Draft> {
    let mut parts = Vec::new();
    for part in serde_json::Deserializer::from_slice(bytes).into_iter::<Part>() {
        parts.push(part.map_err(|e| {
            let at = Location::file(file).at_line(e.line().max(1));
            RecordingFileError::new(at, RecordingFileErrorKind::Json { reason: e.to_string() })
        })?);
    }
    let refused = |kind| Err(RecordingFileError::new(Location::file(file), kind));
    let mut whole = Frame::default();
    let mut frames = Vec::new();
    for part in parts {
        let Some(some) = part.into_frames() else {
            return refused(RecordingFileErrorKind::Unrecognised {
                formats: RecordingFormat::READ,
                why: "its JSON holds no frames with landmarks",
            });
        };
        frames.extend(some);
    }
    if frames.len() == 1
        && let Some(own) = frames[0].frames.take()
    {
        whole = std::mem::replace(&mut frames, own).swap_remove(0);
    }
    let Some(n) = frames.iter().flat_map(|frame| &frame.faces).map(Vec::len).find(|n| *n > 0) else {
        return refused(RecordingFileErrorKind::Unrecognised {
            formats: RecordingFormat::READ,
            why: "its JSON holds no face",
        });
    };
    if !POINTS.contains(&n) {
        return refused(RecordingFileErrorKind::Points { found: n });
    }
    // A frame without a face is short in the file and as long as another in memory.
    let with_face = frames.iter().filter(|frame| frame.faces.iter().any(|face| !face.is_empty())).count();
    if frames.len() > SPARSEST.saturating_mul(with_face) {
        return refused(RecordingFileErrorKind::NoFaces);
    }
    let mut positions = Vec::new();
    let mut size = whole.width.zip(whole.height);
    for (k, frame) in frames.iter().enumerate() {
        let at = || Location::file(file).in_field(format!("frame {}", k + 1));
        let mut faces = frame.faces.iter().filter(|face| !face.is_empty());
        let face = faces.next();
        if faces.next().is_some() {
            return Err(RecordingFileError::new(at(), RecordingFileErrorKind::Faces));
        }
        match face {
            Some(face) if face.len() != n => {
                let kind = RecordingFileErrorKind::RowLength { found: face.len(), expected: n };
                return Err(RecordingFileError::new(at(), kind));
            }
            Some(face) => positions.extend(face.iter().map(|&[x, y, z]| Some(Vec3::new(x, y, z)))),
            None => positions.resize(positions.len() + n, None),
        }
        let own = frame.width.zip(frame.height);
        if own.is_some() && size.is_some() && own != size {
            return Err(RecordingFileError::new(at(), RecordingFileErrorKind::TwoImages));
        }
        size = size.or(own);
    }
    let mut warnings = Vec::new();
    let times: Option<Vec<Time>> = frames.iter().map(|frame| frame.time).collect();
    let numbers: Option<Vec<f64>> = frames.iter().map(|frame| frame.number).collect();
    let times = match (times, numbers) {
        (Some(times), _) => {
            let column = times.iter().any(|t| !t.stated).then(|| "time".to_owned());
            let values = times.iter().map(|t| t.value * t.unit).collect();
            Times::Time { values, seconds: 1., column }
        }
        (_, Some(values)) => Times::Frames { values, rate_hz: None },
        _ => Times::Unsaid(frames.len()),
    };
    let with_rate = ReadOptions { rate_hz: options.rate_hz.or(whole.rate_hz), ..*options };
    let times_s = times.in_seconds(file, &with_rate, &mut warnings)?;
    let draft = Draft {
        format: RecordingFormat::MediaPipe,
        unit: LengthUnit::Millimetre,
        names: vec![String::new(); n],
        times_s,
        positions,
        frame_names: Vec::new(),
        depth_weight: 1.,
        warnings,
        names_at: Location::file(file),
        lines: Vec::new(),
        marker_lines: Vec::new(),
    };
    mediapipe::in_mm(draft, size.map(|(w, h)| [w, h]), options)
}
