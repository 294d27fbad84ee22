//! C3D: points over time, with parameters that say what they are.
//!
//! After the C3D User Guide (Motion Lab Systems) and its format specification at c3d.org. Analog samples are skipped.

mod frames;
mod labels;
mod parameters;
mod processor;

use std::path::Path;

use self::frames::Frames;
use self::parameters::Parameters;
use self::processor::Processor;
use super::draft::Draft;
use super::error::{RecordingFileError, RecordingFileErrorKind};
use super::format::RecordingFormat;
use super::options::ReadOptions;
use super::unit;
use crate::io::Location;
use crate::units::Vec3;

type Result<T> = std::result::Result<T, RecordingFileError>;

/// Bytes of a block, in which places are given.
const BLOCK: usize = 512;

/// The header's words, or what parameters say in their place.
struct Header<'a> {
    file: &'a Path,
    bytes: &'a [u8],
    processor: Processor,
}

impl Header<'_> {
    /// Word `k` of the header, from 1.
    fn word(&self, k: usize) -> u16 {
        self.processor.u16([self.bytes[2 * k - 2], self.bytes[2 * k - 1]])
    }

    /// The number in words `k` and `k + 1`.
    fn float(&self, k: usize) -> f64 {
        let at = 2 * k - 2;
        self.processor.float([0, 1, 2, 3].map(|i| self.bytes[at + i]))
    }

    /// The bytes from block `block` on, asked for by `field` at byte `byte`.
    fn block(&self, block: u64, field: &str, byte: usize) -> Result<usize> {
        let blocks = self.bytes.len().div_ceil(BLOCK) as u64;
        if (2..=blocks).contains(&block) {
            return Ok((block as usize - 1) * BLOCK);
        }
        let at = Location::file(self.file).at_byte(byte).in_field(field);
        Err(RecordingFileError::new(at, RecordingFileErrorKind::PastEnd { block, blocks }))
    }

    fn value<T>(&self, at: Location, value: f64, accepted: &'static str) -> Result<T> {
        let kind = RecordingFileErrorKind::Value { value: value.to_string(), accepted };
        Err(RecordingFileError::new(at, kind))
    }
}

/// The recording in the C3D file `file` whose content is `bytes`.
pub(super) fn parse(file: &Path, bytes: &[u8], options: &ReadOptions) -> Result<Draft> {
    if bytes.len() < BLOCK {
        let kind = RecordingFileErrorKind::Truncated { expected: "the end of its header".to_owned() };
        return Err(RecordingFileError::new(Location::file(file).at_byte(bytes.len()), kind));
    }
    // Only the parameters say how the numbers of the header are stored; where they are is one byte.
    let mut header = Header { file, bytes, processor: Processor::Intel };
    let start = header.block(u64::from(bytes[0]), "the header's parameter block", 0)?;
    let Some(&[_, _, _, kind]) = bytes[start..].first_chunk() else {
        let parameter = "the parameter section".to_owned();
        let kind = RecordingFileErrorKind::ParameterPastEnd { parameter };
        return Err(RecordingFileError::new(Location::file(file).at_byte(start), kind));
    };
    header.processor = match Processor::of(kind) {
        Some(processor) => processor,
        None => {
            let at = Location::file(file).at_byte(start + 3).in_field("processor type");
            return header.value(
                at,
                f64::from(kind),
                "write 84 (Intel), 85 (DEC) or 86 (MIPS): export the file again",
            );
        }
    };
    let parameters = Parameters::read(file, bytes, start + 4, header.processor)?;
    let at = |name: &str, word: usize| match parameters.get(name) {
        Some(_) => parameters.location(file, name),
        None => Location::file(file).at_byte(2 * word - 2).in_field("header"),
    };

    let n = parameters.number("POINT:USED").unwrap_or(f64::from(header.word(2)));
    if !(1. ..=f64::from(u16::MAX)).contains(&n) {
        let accepted = "it counts points, of which there must be any: export the trajectories";
        return header.value(at("POINT:USED", 2), n, accepted);
    }
    let n = n as usize;
    let scale = parameters.number("POINT:SCALE").unwrap_or(header.float(7));
    if scale == 0. || !scale.is_finite() {
        let accepted = "it must be negative for floating points, positive and the unit of whole ones: export the file again";
        return header.value(at("POINT:SCALE", 7), scale, accepted);
    }
    let rate =
        options.rate_hz.or_else(|| parameters.number("POINT:RATE")).unwrap_or_else(|| header.float(11));
    if !(rate > 0. && rate.is_finite()) {
        let accepted =
            "it is the number of frames a second: correct it, or state it beside the file: --rate-hz 60";
        return header.value(at("POINT:RATE", 11), rate, accepted);
    }
    let mut warnings = Vec::new();
    let frames = Frames::of(&header, &parameters, &mut warnings)?;
    let stated = parameters.get("POINT:UNITS").and_then(|p| p.texts().into_iter().next());
    let units_at = parameters.location(file, "POINT:UNITS");
    let unit = unit::resolve(options, stated.as_deref(), units_at, "write POINT:UNITS", &mut warnings)?;
    let names = labels::labels(&parameters, n, &mut warnings);

    let size = if scale < 0. { 4 } else { 2 };
    let stride = size * (4 * n + usize::from(header.word(3)));
    let block = match header.word(9) {
        0 => parameters.number("POINT:DATA_START").unwrap_or(0.) as u64,
        block => u64::from(block),
    };
    let data = &bytes[header.block(block, "the header's data block", 16)?..];
    let held = (data.len() / stride) as u64;
    if held < frames.count {
        let (parameter, declared) = (frames.parameter, frames.count);
        let kind = RecordingFileErrorKind::FramesPastEnd { parameter, declared, held };
        return Err(RecordingFileError::new(Location::file(file).at_byte(bytes.len()), kind));
    }
    let count = frames.count as usize;
    let mut positions = Vec::with_capacity(count * n);
    for frame in data.chunks_exact(stride).take(count) {
        positions.extend(frame[..4 * size * n].chunks_exact(4 * size).map(|point| {
            let [x, y, z, residual] = [0, 1, 2, 3].map(|k| match point[size * k..][..size] {
                [a, b] => f64::from(header.processor.i16([a, b])),
                [a, b, c, d] => header.processor.float([a, b, c, d]),
                _ => f64::NAN,
            });
            let p = Vec3::new(x, y, z) * if scale < 0. { 1. } else { scale };
            // A negative residual says that the point was not reconstructed, whatever stands beside it.
            (residual.is_nan() || residual >= 0.).then_some(p).filter(|p| !p.iter().any(|x| x.is_nan()))
        }));
    }
    let before = frames.first.saturating_sub(1);
    Ok(Draft {
        format: RecordingFormat::C3d,
        unit,
        names,
        times_s: (0..frames.count).map(|k| (before + k) as f64 / rate).collect(),
        positions,
        frame_names: Vec::new(),
        depth_weight: 1.,
        warnings,
        names_at: parameters.location(file, "POINT:LABELS"),
        lines: Vec::new(),
        marker_lines: Vec::new(),
    })
}
