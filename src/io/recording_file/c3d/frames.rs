//! How many frames a C3D file has, of which a word counts 65535 at most.

use super::super::error::{RecordingFileError, RecordingFileErrorKind};
use super::super::warning::RecordingFileWarning;
use super::parameters::Parameters;
use super::{Header, Result};
use crate::io::Location;
use crate::recording::RecordingError;

/// Which frames the file has.
pub(super) struct Frames {
    /// The number of the first.
    pub(super) first: u64,
    /// How many.
    pub(super) count: u64,
    /// What says so.
    pub(super) parameter: &'static str,
}

impl Frames {
    /// The frames that the header counts, or, where they may be more than it can, the parameters.
    pub(super) fn of(
        header: &Header,
        parameters: &Parameters,
        warnings: &mut Vec<RecordingFileWarning>,
    ) -> Result<Self> {
        let (first, last) = (u64::from(header.word(4)), u64::from(header.word(5)));
        let plain = Self { first, count: (last + 1).saturating_sub(first), parameter: "the header" };
        let by_parameters = actual_fields(parameters).or_else(|| long_frames(parameters, first));
        // A count that does not fit is cut off at 65535 or by 65536; one that fits is as the header says.
        let does_not_fit = |long: &Self| {
            let end = long.first + long.count;
            end > u64::from(u16::MAX) || last == u64::from(u16::MAX)
        };
        let frames = match by_parameters {
            Some(long) if plain.count == 0 || does_not_fit(&long) => long,
            Some(long) => {
                if long.count != plain.count {
                    let (parameter, other, taken) = (long.parameter, long.count, plain.count);
                    warnings.push(RecordingFileWarning::Frames { parameter, other, taken });
                }
                plain
            }
            None => plain,
        };
        if frames.count == 0 {
            let at = Location::file(header.file).at_byte(6).in_field("the header's frames");
            return Err(RecordingFileError::new(
                at,
                RecordingFileErrorKind::Recording(RecordingError::NoFrames),
            ));
        }
        Ok(frames)
    }
}

/// `TRIAL:ACTUAL_START_FIELD` and `ACTUAL_END_FIELD`: the low word of a number, then the high one.
fn actual_fields(parameters: &Parameters) -> Option<Frames> {
    let field = |name: &str| {
        let parameter = parameters.get(name)?;
        let numbers = parameter.numbers();
        let number = match (parameter.is_float(), &numbers[..]) {
            (false, &[low, high, ..]) => low + 65536. * high,
            (_, &[number, ..]) => number,
            _ => return None,
        };
        (number >= 0. && number < 2f64.powi(32)).then_some(number as u64)
    };
    let (first, last) = (field("TRIAL:ACTUAL_START_FIELD")?, field("TRIAL:ACTUAL_END_FIELD")?);
    let count = (last + 1).checked_sub(first).filter(|n| *n > 0)?;
    Some(Frames { first, count, parameter: "TRIAL:ACTUAL_END_FIELD" })
}

/// `POINT:LONG_FRAMES`, or `POINT:FRAMES` where it is a floating number.
fn long_frames(parameters: &Parameters, first: u64) -> Option<Frames> {
    let long = |name: &'static str| {
        let parameter = parameters.get(name)?;
        let number = parameter.number().filter(|n| *n >= 1. && *n < 2f64.powi(32))?;
        let counts = name != "POINT:FRAMES" || parameter.is_float();
        counts.then_some(Frames { first, count: number as u64, parameter: name })
    };
    long("POINT:LONG_FRAMES").or_else(|| long("POINT:FRAMES"))
}
