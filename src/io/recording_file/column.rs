//! The columns of tables of markers.

use super::unit;
use crate::units::LengthUnit;

/// What a column holds.
#[derive(Clone, Debug, PartialEq)]
pub(super) enum Column {
    /// One coordinate of a marker, or of the row's marker.
    Coordinate(Coordinate),
    /// Time, of which so many seconds are one.
    Time {
        seconds: f64,
        /// Whether the column says so.
        stated: bool,
    },
    /// The number of the frame.
    Frame,
    /// The name of an expression or a pose.
    Pose,
    /// The name of a marker.
    Marker,
    /// `label`, which is a pose beside a marker, else a marker.
    Label,
    Other,
}

/// One coordinate of a marker.
#[derive(Clone, Debug, PartialEq)]
pub(super) struct Coordinate {
    /// The marker; empty where a row has its own.
    pub(super) marker: String,
    /// 0, 1 or 2.
    pub(super) axis: usize,
    /// Whether it counts from a neutral position.
    pub(super) displacement: bool,
    /// Its unit, where the column says it.
    pub(super) unit: Option<LengthUnit>,
}

impl Column {
    /// What the column called `head` holds.
    pub(super) fn parse(head: &str) -> Self {
        let lower = head.trim().to_lowercase();
        match lower.as_str() {
            "frame" | "frame#" | "frame_number" | "frame_index" | "frame number" | "field" => {
                return Self::Frame;
            }
            "expression" | "pose" => return Self::Pose,
            "marker" | "landmark" | "point" | "name" | "landmark_index" | "landmark_id" | "point_index" => {
                return Self::Marker;
            }
            "label" => return Self::Label,
            _ => {}
        }
        if let Some(time) = time(&lower) {
            return time;
        }
        Coordinate::parse(head.trim()).map_or(Self::Other, Self::Coordinate)
    }
}

fn time(lower: &str) -> Option<Column> {
    let stem = ["timestamp", "time", "t"].into_iter().find_map(|stem| lower.strip_prefix(stem))?;
    let of = |seconds, stated| Some(Column::Time { seconds, stated });
    match stem.trim_matches(['_', ' ', '(', ')', '[', ']', '.']) {
        "" if stem.is_empty() => of(1., false),
        "s" | "sec" | "seconds" if stem.len() > 1 => of(1., true),
        "ms" | "msec" | "milliseconds" if stem.len() > 2 => of(1e-3, true),
        "us" | "microseconds" if stem.len() > 2 => of(1e-6, true),
        _ => None,
    }
}

impl Coordinate {
    /// `LAB_x_mm`, `LAB.x`, `LAB x (mm)`, `x_LAB`, `x12`, `x`, `dx_mm`, ...
    pub(super) fn parse(head: &str) -> Option<Self> {
        let lower = head.to_lowercase();
        if lower.len() != head.len() {
            return None;
        }
        for (suffix, unit) in [
            ("mm", Some(LengthUnit::Millimetre)),
            ("cm", Some(LengthUnit::Centimetre)),
            ("m", Some(LengthUnit::Metre)),
            ("", None),
        ] {
            let bare = if unit.is_none() { Some(lower.as_str()) } else { without_unit(&lower, suffix) };
            let Some(rest) = bare.and_then(|bare| head.get(..bare.len())) else { continue };
            if let Some((marker, axis, displacement)) = axis(rest) {
                return Some(Self { marker: marker.to_owned(), axis, displacement, unit });
            }
        }
        // Units in brackets may be spelt out.
        let (rest, word) = head.strip_suffix([')', ']'])?.rsplit_once(['(', '['])?;
        let (unit, (marker, axis, displacement)) = (unit::parse(word)?, axis(rest.trim_end())?);
        Some(Self { marker: marker.to_owned(), axis, displacement, unit: Some(unit) })
    }
}

/// `name` without `_mm`, ` mm`, `(mm)` or `[mm]`.
fn without_unit<'a>(name: &'a str, unit: &str) -> Option<&'a str> {
    if let Some(rest) = name.strip_suffix(unit) {
        return rest.strip_suffix(['_', ' ', '.', '-']).map(str::trim_end);
    }
    let rest = name.strip_suffix([')', ']'])?.strip_suffix(unit)?;
    rest.strip_suffix(['(', '[']).map(|rest| rest.trim_end_matches([' ', '_']))
}

/// The marker, the axis, and whether it is a displacement's.
fn axis(name: &str) -> Option<(&str, usize, bool)> {
    const PARTS: [char; 6] = ['_', '.', ':', ' ', '-', '/'];
    let of = |word: &str| match word.to_ascii_lowercase().as_str() {
        "x" => Some((0, false)),
        "y" => Some((1, false)),
        "z" => Some((2, false)),
        "dx" => Some((0, true)),
        "dy" => Some((1, true)),
        "dz" => Some((2, true)),
        _ => None,
    };
    if let Some((axis, displacement)) = of(name) {
        return Some(("", axis, displacement));
    }
    if let Some((marker, word)) = name.rsplit_once(PARTS)
        && let Some((axis, displacement)) = of(word)
        && !marker.trim().is_empty()
    {
        return Some((marker.trim(), axis, displacement));
    }
    if let Some((word, marker)) = name.split_once(PARTS)
        && let Some((axis, displacement)) = of(word)
        && !marker.trim().is_empty()
    {
        return Some((marker.trim(), axis, displacement));
    }
    let digits = name.get(1..)?;
    let (axis, displacement) = of(name.get(..1)?)?;
    (!digits.is_empty() && digits.bytes().all(|b| b.is_ascii_digit())).then_some((digits, axis, displacement))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn coordinates_are_named_in_many_ways() {
        use LengthUnit::{Centimetre, Metre, Millimetre};
        for (head, marker, axis, displacement, unit) in [
            ("cheilion_l_x_mm", "cheilion_l", 0, false, Some(Millimetre)),
            ("LAB.y", "LAB", 1, false, None),
            ("LAB_Z", "LAB", 2, false, None),
            ("LAB x (mm)", "LAB", 0, false, Some(Millimetre)),
            ("LAB x [Meters]", "LAB", 0, false, Some(Metre)),
            ("LAB_x_m", "LAB", 0, false, Some(Metre)),
            ("x_cm", "", 0, false, Some(Centimetre)),
            ("X", "", 0, false, None),
            ("dx_mm", "", 0, true, Some(Millimetre)),
            ("LAB_dy_mm", "LAB", 1, true, Some(Millimetre)),
            ("x0", "0", 0, false, None),
            ("z_467", "467", 2, false, None),
            ("y_nose tip", "nose tip", 1, false, None),
        ] {
            let expected = Coordinate { marker: marker.to_owned(), axis, displacement, unit };
            assert_eq!(Coordinate::parse(head), Some(expected), "{head}");
        }
        for head in ["", "mm", "_mm", "LAB", "extra", "Xylophone", "confidence", "é_x\u{130}"] {
            assert_eq!(Coordinate::parse(head), None, "{head}");
        }
    }

    #[test]
    fn times_have_units() {
        let time = |seconds, stated| Column::Time { seconds, stated };
        for (head, expected) in [
            ("time_s", time(1., true)),
            ("Time (Seconds)", time(1., true)),
            ("time [ms]", time(1e-3, true)),
            ("timestamp_ms", time(1e-3, true)),
            ("Time", time(1., false)),
            ("t", time(1., false)),
            ("Frame#", Column::Frame),
            ("expression", Column::Pose),
            ("ts", Column::Other),
            ("tongue", Column::Other),
            ("quality", Column::Other),
        ] {
            assert_eq!(Column::parse(head), expected, "{head}");
        }
    }
}
