//! Units of length as files of markers name them.

use super::error::{RecordingFileError, RecordingFileErrorKind};
use super::options::ReadOptions;
use super::warning::RecordingFileWarning;
use crate::io::Location;
use crate::io::text::shown;
use crate::units::LengthUnit;

/// The unit called `name` by the programs that record markers.
pub(super) fn parse(name: &str) -> Option<LengthUnit> {
    match name.trim().to_lowercase().as_str() {
        "mm" | "millimeter" | "millimeters" | "millimetre" | "millimetres" => Some(LengthUnit::Millimetre),
        "cm" | "centimeter" | "centimeters" | "centimetre" | "centimetres" => Some(LengthUnit::Centimetre),
        "m" | "meter" | "meters" | "metre" | "metres" => Some(LengthUnit::Metre),
        _ => None,
    }
}

/// `unit` in a word.
pub(super) fn name(unit: LengthUnit) -> &'static str {
    match unit {
        LengthUnit::Millimetre => "mm",
        LengthUnit::Centimetre => "cm",
        LengthUnit::Metre => "m",
    }
}

/// The unit that `options` or else the file states, in the words `stated` at `at`; `fix` says where it would stand.
pub(super) fn resolve(
    options: &ReadOptions,
    stated: Option<&str>,
    at: Location,
    fix: &'static str,
    warnings: &mut Vec<RecordingFileWarning>,
) -> Result<LengthUnit, RecordingFileError> {
    let stated = stated.filter(|s| !s.trim().is_empty());
    match (options.unit, stated) {
        (Some(unit), None) => Ok(unit),
        (Some(unit), Some(stated)) => {
            if parse(stated) != Some(unit) {
                let (stated, taken) = (shown(stated), name(unit));
                warnings.push(RecordingFileWarning::OtherUnit { stated, taken });
            }
            Ok(unit)
        }
        (None, Some(stated)) => parse(stated).ok_or_else(|| {
            RecordingFileError::new(at, RecordingFileErrorKind::UnknownUnit { value: shown(stated) })
        }),
        (None, None) => Err(RecordingFileError::new(at, RecordingFileErrorKind::AbsentUnit { fix })),
    }
}
