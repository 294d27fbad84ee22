//! Marker maps, `map.toml`: how the markers of a recording are to be read.

use std::collections::BTreeMap;
use std::path::{Path, PathBuf};

use schemars::JsonSchema;
use serde::Deserialize;
use thiserror::Error;
use toml::de::DeTable;

use super::input_file::read_text;
use super::schema::{pretty, toml_schema_of};
use super::target_toml::{check_table, line_of};
use super::{FieldLines, Location, TargetFileError, sha256};
use crate::recording::{Dynamics, JawFreedom, MappedMarker, MarkerMap, MarkerPlace, Neutral, OffSkin};
use crate::units::Vec3;

/// A marker map: which markers of a recording are which points of the face, and how they are to be read. Lengths mm, times
/// s; face frame +x the subject's left, +y up, +z anterior.
#[derive(Debug, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
#[schemars(title = "Modiolus marker map")]
struct MapTable {
    /// Unit of every length in this file: "mm".
    #[schemars(extend("enum" = ["mm"]))]
    #[expect(dead_code, reason = "the schema holds it to mm")]
    unit: String,
    /// First and last time of the neutral frames, s; the first frame when absent.
    neutral_s: Option<[f64; 2]>,
    /// A file of neutral positions, such as a CSV of `marker,x_mm,y_mm,z_mm`, beside this file; in place of `neutral_s`.
    neutral_file: Option<String>,
    /// "moving", or "still" when the head's own movement was taken away already; "moving" when absent.
    #[schemars(extend("enum" = ["moving", "still"]))]
    head: Option<String>,
    /// Labels of markers that move with the skull; found by their rigidity when absent.
    #[serde(default)]
    stable: Vec<String>,
    /// Labels of markers that are not read.
    #[serde(default)]
    ignore: Vec<String>,
    /// Scale from the subject to the face; found when absent.
    #[schemars(range(min = 0.0))]
    scale: Option<f64>,
    /// What becomes of markers more than 5 mm off the skin: `"leave_out"` or `"refuse"`; `"leave_out"` when absent.
    #[schemars(extend("enum" = ["leave_out", "refuse"]))]
    off_skin: Option<String>,
    /// Standard deviation of a marker's position, mm, of measurement and model together; 0.5 when absent.
    #[schemars(range(min = 0.0))]
    sigma_mm: Option<f64>,
    /// Weight of the squared activations; 0.1 when absent.
    #[schemars(range(min = 0.0))]
    effort: Option<f64>,
    /// "l2", the only one that recordings are fitted with.
    #[expect(dead_code, reason = "there is one, which the schema holds")]
    #[schemars(extend("enum" = ["l2"]))]
    effort_norm: Option<String>,
    /// How far the jaw may move.
    jaw: Option<JawTable>,
    /// How activation may change in time.
    dynamics: Option<DynamicsTable>,
    /// Markers by label; one that is not here is the landmark of its label, or else the skin nearest to it.
    #[serde(default)]
    marker: Vec<MarkerTable>,
}

/// How far the jaw may move.
#[derive(Debug, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
struct JawTable {
    /// Widest opening, mm at the lower incisal point; 0 for a jaw that rests; 25 when absent.
    #[schemars(range(min = 0.0, max = 60.0))]
    opening_mm: Option<f64>,
    /// Farthest protrusion and retrusion, mm; 3 when absent.
    #[schemars(range(min = 0.0, max = 20.0))]
    protrusion_mm: Option<f64>,
    /// Farthest shift to either side, mm; 3 when absent.
    #[schemars(range(min = 0.0, max = 20.0))]
    lateral_mm: Option<f64>,
    /// Standard deviation of each movement as a share of its farthest; 1 when absent.
    #[schemars(range(min = 0.0))]
    sigma: Option<f64>,
}

/// How activation may change in time.
#[derive(Debug, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
struct DynamicsTable {
    /// Standard deviation of the change of an activation within a second, as of a random walk; 2 when absent.
    #[schemars(range(min = 0.0))]
    change_per_root_s: Option<f64>,
    /// Time constant of rising activation, s; 0.015 when absent, 0 for none.
    #[schemars(range(min = 0.0))]
    rise_s: Option<f64>,
    /// Time constant of falling activation, s; 0.05 when absent, 0 for none.
    #[schemars(range(min = 0.0))]
    fall_s: Option<f64>,
}

/// A marker.
#[derive(Debug, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
struct MarkerTable {
    /// Its label in the recording.
    label: String,
    /// The landmark of the face that it is.
    landmark: Option<String>,
    /// The point of the face [x, y, z] nearest to which it sits, mm; in place of `landmark`.
    point_mm: Option<[f64; 3]>,
    /// Standard deviation of its position, mm; that of the file when absent.
    #[schemars(range(min = 0.0))]
    sigma_mm: Option<f64>,
}

/// A marker map as its file states it.
#[derive(Clone, Debug)]
pub struct MarkerMapDocument {
    /// The map; its neutral positions are still to be read where [`neutral_file`](Self::neutral_file) names them.
    pub map: MarkerMap,
    /// The file of neutral positions, beside the map's.
    pub neutral_file: Option<PathBuf>,
    /// Where each field stands, so that later errors can name its line.
    pub lines: FieldLines,
    /// SHA-256 of the text that was parsed.
    pub sha256: String,
}

/// Why a marker map was refused.
#[derive(Debug, Error)]
#[non_exhaustive]
pub enum MarkerMapError {
    /// A fault of its form.
    #[error(transparent)]
    Form(#[from] TargetFileError),
    /// The text is not TOML.
    #[error("{at}: not TOML: {reason}; schemas/map.schema.json shows the form")]
    Syntax {
        /// The line.
        at: Box<Location>,
        /// What the parser says.
        reason: String,
    },
    /// A number out of its range.
    #[error("{at}: {value} is not accepted; {remedy}")]
    Range {
        /// The field.
        at: Box<Location>,
        /// The value.
        value: f64,
        /// What to write.
        remedy: &'static str,
    },
    /// Two things that exclude each other.
    #[error("{at}: give `{one}` or `{other}`, not both")]
    Both {
        /// The field.
        at: Box<Location>,
        /// One of the two.
        one: &'static str,
        /// The other.
        other: &'static str,
    },
    /// A label twice.
    #[error("{at}: `{label}` is mapped twice; keep one")]
    Twice {
        /// The second.
        at: Box<Location>,
        /// The label.
        label: String,
    },
}

/// Reads the marker map `path`.
///
/// # Errors
/// [`MarkerMapError`]: it names the line, the field, the value and the remedy.
pub fn read_marker_map(path: &Path) -> Result<MarkerMapDocument, MarkerMapError> {
    let text = read_text(path)
        .map_err(|reason| TargetFileError::Unreadable { at: Box::new(Location::file(path)), reason })?;
    parse_marker_map(&text, path)
}

/// Reads a marker map from `text`; `path` is named in messages, and its folder is where `neutral_file` is sought.
///
/// # Errors
/// As [`read_marker_map`].
pub fn parse_marker_map(text: &str, path: &Path) -> Result<MarkerMapDocument, MarkerMapError> {
    let sha256 = sha256(text.as_bytes());
    let text = text.strip_prefix('\u{feff}').unwrap_or(text);
    let not_toml = |e: toml::de::Error| MarkerMapError::Syntax {
        at: Box::new(Location::file(path).at_line(line_of(text, e.span().map_or(0, |s| s.start)))),
        reason: e.message().to_owned(),
    };
    let root = DeTable::parse(text).map_err(not_toml)?;
    let lines = FieldLines::of(path, text, root.get_ref());
    check_table(root.get_ref(), toml_schema_of::<MapTable>().as_value(), "", &lines)?;
    let table = MapTable::deserialize(toml::Deserializer::from(root)).map_err(not_toml)?;
    let neutral_file = table.neutral_file.as_ref().map(|name| path.with_file_name(name));
    let map = of_table(table, &lines)?;
    Ok(MarkerMapDocument { map, neutral_file, lines, sha256 })
}

fn of_table(table: MapTable, lines: &FieldLines) -> Result<MarkerMap, MarkerMapError> {
    let at = |field: &str| Box::new(lines.location(field));
    let within = |field: &str, value: Option<f64>, range: [f64; 2], remedy| match value {
        Some(value) if !(range[0]..=range[1]).contains(&value) => {
            Err(MarkerMapError::Range { at: at(field), value, remedy })
        }
        value => Ok(value),
    };
    let positive = [f64::MIN_POSITIVE, 1e6];
    let sigma = "write millimetres above 0, such as 0.5";
    if table.neutral_s.is_some() && table.neutral_file.is_some() {
        let (at, one, other) = (at("neutral_file"), "neutral_s", "neutral_file");
        return Err(MarkerMapError::Both { at, one, other });
    }
    let default = MarkerMap::default();
    let neutral = match table.neutral_s {
        Some([from, to]) if !(from <= to && from.is_finite() && to.is_finite()) => {
            let remedy = "write the first and the last time in s, such as [0.0, 0.2]";
            return Err(MarkerMapError::Range { at: at("neutral_s"), value: to, remedy });
        }
        Some(span) => Neutral::Span(span),
        None => default.neutral.clone(),
    };
    let mut markers = BTreeMap::new();
    for (k, marker) in table.marker.into_iter().enumerate() {
        let field = |name: &str| format!("markers[{k}].{name}");
        let place = match (marker.landmark, marker.point_mm) {
            (Some(_), Some(_)) => {
                let (at, one, other) = (at(&field("point_mm")), "landmark", "point_mm");
                return Err(MarkerMapError::Both { at, one, other });
            }
            (Some(name), None) => MarkerPlace::Landmark(name),
            (None, Some(point)) => {
                if let Some(&value) = point.iter().find(|v| !v.is_finite()) {
                    let remedy = "write three numbers in mm";
                    return Err(MarkerMapError::Range { at: at(&field("point_mm")), value, remedy });
                }
                MarkerPlace::Point(Vec3::from(point))
            }
            (None, None) => MarkerPlace::Skin,
        };
        let sigma_mm = within(&field("sigma_mm"), marker.sigma_mm, positive, sigma)?;
        if markers.insert(marker.label.clone(), MappedMarker { place, sigma_mm }).is_some() {
            return Err(MarkerMapError::Twice { at: at(&field("label")), label: marker.label });
        }
    }
    let jaw = JawFreedom::default();
    let jaw = match table.jaw {
        None => Some(jaw),
        Some(JawTable { opening_mm: Some(0.), .. }) => None,
        Some(own) => {
            let far = |name: &str, value, most| {
                within(
                    &format!("jaw.{name}"),
                    value,
                    [0., most],
                    "write millimetres from 0 to what a jaw can do",
                )
            };
            // A movement that is fixed keeps a unit of its own.
            let least = |value: f64| value.max(1e-6);
            Some(JawFreedom {
                opening_mm: far("opening_mm", own.opening_mm, 60.)?.unwrap_or(jaw.opening_mm),
                protrusion_mm: least(
                    far("protrusion_mm", own.protrusion_mm, 20.)?.unwrap_or(jaw.protrusion_mm),
                ),
                lateral_mm: least(far("lateral_mm", own.lateral_mm, 20.)?.unwrap_or(jaw.lateral_mm)),
                sigma: within("jaw.sigma", own.sigma, positive, "write a number above 0, such as 1")?
                    .unwrap_or(jaw.sigma),
            })
        }
    };
    let dynamics = Dynamics::default();
    let dynamics = match table.dynamics {
        None => dynamics,
        Some(own) => {
            let time = |name: &str, value| {
                within(
                    &format!("dynamics.{name}"),
                    value,
                    [0., 10.],
                    "write seconds from 0 to 10, such as 0.05",
                )
            };
            let walk = "write a number above 0, such as 2";
            Dynamics {
                change_per_root_s: within(
                    "dynamics.change_per_root_s",
                    own.change_per_root_s,
                    positive,
                    walk,
                )?
                .unwrap_or(dynamics.change_per_root_s),
                rise_s: time("rise_s", own.rise_s)?.unwrap_or(dynamics.rise_s),
                fall_s: time("fall_s", own.fall_s)?.unwrap_or(dynamics.fall_s),
            }
        }
    };
    let effort = within("effort", table.effort, [1e-9, 1e6], "write a number above 0, such as 0.1")?;
    Ok(MarkerMap {
        markers,
        ignore: table.ignore,
        neutral,
        stable: table.stable,
        head_is_still: table.head.as_deref() == Some("still"),
        scale: within("scale", table.scale, positive, "write the face's size over the subject's, such as 1")?,
        off_skin: if table.off_skin.as_deref() == Some("refuse") {
            OffSkin::Refuse
        } else {
            OffSkin::LeaveOut
        },
        sigma_mm: within("sigma_mm", table.sigma_mm, positive, sigma)?.unwrap_or(default.sigma_mm),
        jaw,
        effort: effort.unwrap_or(default.effort),
        dynamics,
    })
}

/// The JSON schema of marker maps, as in `schemas/map.schema.json`.
pub fn marker_map_schema() -> String {
    pretty(&toml_schema_of::<MapTable>())
}

#[cfg(test)]
mod tests {
    use super::*;

    fn parse(text: &str) -> Result<MarkerMapDocument, MarkerMapError> {
        parse_marker_map(text, Path::new("data/map.toml"))
    }

    #[test]
    fn a_map_is_read() {
        let text = "unit = \"mm\"\nneutral_file = \"rest.csv\"\nstable = [\"N\"]\n[jaw]\nopening_mm = 0\n\
                    [[marker]]\nlabel = \"RCH\"\nlandmark = \"cheilion_r\"\nsigma_mm = 0.3\n[[marker]]\nlabel = \"X\"\n";
        let document = parse(text).expect("well formed");
        assert_eq!(document.neutral_file, Some(PathBuf::from("data/rest.csv")));
        let map = document.map;
        let corner = MappedMarker { place: MarkerPlace::Landmark("cheilion_r".into()), sigma_mm: Some(0.3) };
        assert_eq!((map.markers.get("RCH"), map.jaw), (Some(&corner), None));
        assert_eq!(map.markers["X"].place, MarkerPlace::Skin);
        assert_eq!(parse("unit = \"mm\"\n").expect("well formed").map, MarkerMap::default());
    }

    #[test]
    fn what_is_wrong_is_named_with_its_line() {
        for (text, told) in [
            ("neutral_s = [0, 1]\n", "unit: missing"),
            (
                "unit = \"mm\"\nsigma_mm = 0\n",
                "map.toml:2: sigma_mm: 0 is not accepted; write millimetres above 0",
            ),
            ("unit = \"mm\"\nneutral_s = [1, 0]\n", "map.toml:2: neutral_s"),
            (
                "unit = \"mm\"\nneutral_s = [0, 1]\nneutral_file = \"a\"\n",
                "map.toml:3: neutral_file: give `neutral_s` or",
            ),
            ("unit = \"mm\"\nsigma = 1\n", "map.toml:2: sigma: unknown field; did you mean sigma_mm?"),
            (
                "unit = \"mm\"\n[[marker]]\nlabel = \"a\"\n[[marker]]\nlabel = \"a\"\n",
                "map.toml:5: markers[1].label: `a` is mapped twice",
            ),
            (
                "unit = \"mm\"\n[[marker]]\nlabel = \"a\"\nlandmark = \"b\"\npoint_mm = [0, 0, 0]\n",
                "give `landmark` or `point_mm`",
            ),
            ("unit = \"mm\"\n[jaw]\nopening_mm = 90\n", "map.toml:3: jaw.opening_mm: 90 is not accepted"),
            ("unit = \"mm\"\noff_skin = \"no\"\n", "map.toml:2: off_skin: \"no\" is not accepted"),
            ("unit = \"mm\"\neffort_norm = \"l1\"\n", "map.toml:2: effort_norm: \"l1\" is not accepted"),
            ("unit = \n", "not TOML"),
        ] {
            let error = parse(text).err().map(|e| e.to_string()).unwrap_or_default();
            assert!(error.contains(told), "{text}: {error}");
        }
    }
}
