//! Face landmarks as MediaPipe finds them in a video: shares of the image become mm.

use super::draft::Draft;
use super::error::{RecordingFileError, RecordingFileErrorKind};
use super::format::RecordingFormat;
use super::landmarks;
use super::options::{ImageScale, ReadOptions};
use super::warning::RecordingFileWarning;
use crate::io::Location;
use crate::units::{LengthUnit, Vec3};

type Result<T> = std::result::Result<T, RecordingFileError>;

/// Points of the mesh, without irises and with them.
pub(super) const POINTS: [usize; 2] = [468, 478];
/// Width of an iris: 11.77 mm, within the 11.7 +- 0.5 mm that MediaPipe Iris goes by (Ablavatski and others, "Real-time Pupil
/// Tracking from Monocular Video for Digital Puppetry", 2020).
const IRIS_MM: f64 = 11.77;
/// Either side of the right iris and of the left one.
const IRISES: [[usize; 2]; 2] = [[469, 471], [474, 476]];
/// What depth counts beside the other directions: a single camera does not see it, a network guesses it from how faces usually
/// are. A tenth is a convention, no measurement: residuals of depth decide only where nothing else does.
const DEPTH_WEIGHT: f64 = 0.1;
/// Shares of an image that a point of a face may be from its middle: beyond, they are pixels.
const LARGEST_SHARE: f64 = 8.;

/// Whether `names` are the indices of all points of the mesh, each once, after a word or alone.
pub(super) fn are_landmarks(names: &[String]) -> bool {
    POINTS.contains(&names.len()) && indices(names).is_some()
}

fn indices(names: &[String]) -> Option<Vec<usize>> {
    let stem = |name: &str| name.trim_end_matches(|c: char| c.is_ascii_digit()).len();
    let first = names.first()?;
    let word = &first[..stem(first)];
    let mut seen = vec![false; names.len()];
    names
        .iter()
        .map(|name| {
            let index = name.strip_prefix(word)?.parse::<usize>().ok()?;
            let once = !std::mem::replace(seen.get_mut(index)?, true);
            once.then_some(index)
        })
        .collect()
}

/// The recording of a table whose markers are the points of the mesh.
pub(super) fn from_table(draft: Draft, options: &ReadOptions) -> Result<Draft> {
    let order = indices(&draft.names).unwrap_or_default();
    let n = order.len();
    let mut shares = vec![None; draft.positions.len()];
    for (k, p) in draft.positions.iter().enumerate() {
        shares[k / n * n + order[k % n]] = *p;
    }
    in_mm(Draft { positions: shares, ..draft }, None, options)
}

/// `draft`, whose positions are shares of an image in the order of the mesh, in mm: +y is up and +z towards the camera. `size`
/// is that of the image in pixels, as the file states it.
pub(super) fn in_mm(draft: Draft, size: Option<[f64; 2]>, options: &ReadOptions) -> Result<Draft> {
    let refused =
        |kind| Err(RecordingFileError::new(Location { field: None, ..draft.names_at.clone() }, kind));
    let usable = |size: &[f64; 2]| size.iter().all(|s| s.is_finite() && *s >= 1.);
    let Some([width, height]) = options.image.or(size).filter(usable) else {
        return refused(RecordingFileErrorKind::AbsentImage);
    };
    let n = draft.names.len();
    let mut positions = draft.positions;
    for (k, p) in positions.iter_mut().enumerate() {
        let Some(share) = p else { continue };
        if share.x.abs().max(share.y.abs()) > LARGEST_SHARE {
            let line = draft.lines.get(k / n).copied();
            let at = Location { line, field: None, ..draft.names_at };
            let kind = RecordingFileErrorKind::Pixels { value: share.x.abs().max(share.y.abs()) };
            return Err(RecordingFileError::new(at, kind));
        }
        // z has the scale of x, and is negative towards the camera.
        *p = Some(Vec3::new(share.x * width, -share.y * height, -share.z * width));
    }
    let frames = || positions.chunks_exact(n);
    let (pixels, length_mm, by) = match options.scale {
        ImageScale::Iris if n == POINTS[1] => {
            let across = |frame: &[Option<Vec3>]| {
                let [right, left] =
                    IRISES.map(|[a, b]| frame[a].zip(frame[b]).map(|(a, b)| (a - b).xy().norm()));
                right.zip(left).map(|(r, l)| 0.5 * (r + l))
            };
            (median(frames().filter_map(across)), IRIS_MM, format!("irises of {IRIS_MM} mm"))
        }
        ImageScale::Iris => return refused(RecordingFileErrorKind::NoIris),
        ImageScale::Length { from, to, length_mm } => {
            let mut ends = [0, 0];
            for (end, name) in ends.iter_mut().zip([from, to]) {
                match landmarks::index(name).filter(|k| *k < n) {
                    Some(k) => *end = k,
                    None => {
                        let (name, last) = (name.to_owned(), n - 1);
                        return refused(RecordingFileErrorKind::NoPoint { name, last });
                    }
                }
            }
            let [a, b] = ends;
            let between = |frame: &[Option<Vec3>]| frame[a].zip(frame[b]).map(|(a, b)| (a - b).norm());
            (median(frames().filter_map(between)), length_mm, format!("{from} to {to} of {length_mm} mm"))
        }
    };
    let scale = pixels.map_or(f64::NAN, |pixels| length_mm / pixels);
    if !(scale > 0. && scale.is_finite()) {
        return refused(RecordingFileErrorKind::NoScale { by });
    }
    positions.iter_mut().flatten().for_each(|p| *p *= scale);
    let mut warnings = draft.warnings;
    warnings.insert(0, RecordingFileWarning::VideoTracker { by, mm_a_pixel: scale });
    Ok(Draft {
        format: RecordingFormat::MediaPipe,
        unit: LengthUnit::Millimetre,
        names: (0..n).map(landmarks::name).collect(),
        positions,
        depth_weight: DEPTH_WEIGHT,
        warnings,
        ..draft
    })
}

fn median(lengths: impl Iterator<Item = f64>) -> Option<f64> {
    let mut all: Vec<f64> = lengths.collect();
    all.sort_by(f64::total_cmp);
    all.get(all.len() / 2).copied()
}
