//! Surgical plans, `plan.toml`.

use std::path::Path;

use nalgebra::Rotation3;
use schemars::JsonSchema;
use serde::Deserialize;
use thiserror::Error;
use toml::de::DeTable;

use super::input_file::read_text;
use super::schema::{pretty, toml_schema_of};
use super::target_toml::{check_table, line_of, word};
use super::{FieldLines, Location, TargetFileError, sha256};
use crate::face::{About, Cut, CutBy, Motion, Move, SurgicalPlan};
use crate::units::Vec3;

/// A surgical plan: cuts split pieces off bones, moves bring bones and pieces to new places. Lengths mm, angles
/// degrees; frame +x the subject's left, +y up, +z anterior.
#[derive(Debug, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
#[schemars(title = "Modiolus surgical plan")]
struct PlanTable {
    /// Name of the plan, one word of letters, digits, `_` and `-`.
    name: String,
    /// What it is, one sentence.
    #[serde(default)]
    #[expect(dead_code, reason = "for the reader of the file")]
    description: String,
    /// Unit of every length in the file: "mm".
    #[schemars(extend("enum" = ["mm"]))]
    #[expect(dead_code, reason = "the schema holds it to mm")]
    unit: String,
    /// Cuts, in order.
    #[serde(default)]
    cut: Vec<CutTable>,
    /// Motions of bones and pieces.
    #[serde(default, rename = "move")]
    moves: Vec<MoveTable>,
}

/// A cut: by a plane, or by a node set of the mesh.
#[derive(Debug, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
struct CutTable {
    /// The bone, such as "mandible".
    bone: String,
    /// Name of the piece that is split off.
    piece: String,
    /// Plane of the cut: the piece is on the side to which the normal points.
    plane: Option<PlaneTable>,
    /// Node set of the mesh that holds the piece.
    set: Option<String>,
    /// Arches that go with the piece: "upper", "lower".
    #[serde(default)]
    teeth: Vec<ArchName>,
}

/// A plane.
#[derive(Debug, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
struct PlaneTable {
    /// A point of the plane [x, y, z], mm.
    point_mm: [f64; 3],
    /// Its normal [x, y, z], of any length.
    normal: [f64; 3],
    /// Distance from the plane up to which the tissue is stripped off the bone before it moves, mm; 0 when absent.
    #[serde(default)]
    #[schemars(range(min = 0.0))]
    stripped_mm: f64,
}

#[derive(Clone, Copy, Debug, Deserialize, JsonSchema, PartialEq, Eq)]
#[serde(rename_all = "lowercase")]
enum ArchName {
    Upper,
    Lower,
}

/// A motion: first the rotation, then the translation.
#[derive(Debug, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
struct MoveTable {
    /// The bone or piece; pieces without a move of their own go with their bone.
    bone: String,
    /// Translation [x, y, z], mm; none when absent.
    #[serde(default)]
    translation_mm: [f64; 3],
    /// Rotation about the axis, degrees, right-handed; none when absent.
    #[serde(default)]
    rotation_deg: f64,
    /// Axis of the rotation: "condylar" (from right to left; positive lowers the chin), "pitch", "yaw" or "roll" about the
    /// incisal point of the teeth that the bone carries, or a point and a direction.
    axis: Option<AxisValue>,
    /// The motion as a cephalometric table gives it, in place of the other three.
    incisor: Option<IncisorTable>,
}

/// How the incisal point of the teeth that a bone carries moves, and how the bone turns about it: pitch first, then roll,
/// then yaw, each about an axis of the face.
#[derive(Clone, Copy, Debug, Default, Deserialize, JsonSchema)]
#[serde(default, deny_unknown_fields)]
struct IncisorTable {
    /// Forward, mm: an advancement; negative a setback.
    anterior_mm: f64,
    /// Upward, mm: an impaction of the upper jaw; negative an extrusion.
    superior_mm: f64,
    /// To the subject's left, mm.
    left_mm: f64,
    /// Degrees, positive lowers what lies in front of the incisal point and raises what lies behind.
    pitch_deg: f64,
    /// Degrees, positive raises the subject's left.
    roll_deg: f64,
    /// Degrees, positive turns the front to the subject's left.
    yaw_deg: f64,
}

impl IncisorTable {
    fn motion(&self) -> Motion {
        let turn = |axis: Vec3, degrees: f64| Rotation3::from_scaled_axis(degrees.to_radians() * axis);
        let [pitch, roll, yaw] =
            [(Vec3::x(), self.pitch_deg), (Vec3::z(), self.roll_deg), (Vec3::y(), self.yaw_deg)]
                .map(|(axis, degrees)| turn(axis, degrees));
        let axis = (yaw * roll * pitch).scaled_axis();
        Motion {
            translation: Vec3::new(self.left_mm, self.superior_mm, self.anterior_mm),
            rotation_deg: axis.norm().to_degrees(),
            about: About::Incisor { direction: axis },
        }
    }
}

#[derive(Debug, Deserialize, JsonSchema)]
#[serde(untagged)]
enum AxisValue {
    /// The line through the condyles.
    Named(AxisName),
    /// Another line.
    Line(LineTable),
}

#[derive(Debug, Deserialize, JsonSchema)]
#[serde(rename_all = "lowercase")]
enum AxisName {
    Condylar,
    Pitch,
    Yaw,
    Roll,
}

/// A line.
#[derive(Debug, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
struct LineTable {
    /// A point of it [x, y, z], mm.
    point_mm: [f64; 3],
    /// Its direction [x, y, z], of any length.
    direction: [f64; 3],
}

/// A surgical plan as its file states it, with the line of each field.
#[derive(Clone, Debug)]
pub struct PlanDocument {
    /// The plan.
    pub plan: SurgicalPlan,
    /// Where each field stands, so that later errors can name its line.
    pub lines: FieldLines,
    /// SHA-256 of the text that was parsed.
    pub sha256: String,
}

/// Why a plan file was refused.
#[derive(Debug, Error)]
#[non_exhaustive]
pub enum PlanFileError {
    /// A fault of its form.
    #[error(transparent)]
    Form(#[from] TargetFileError),
    /// The text is not TOML.
    #[error("{at}: not TOML: {reason}; schemas/plan.schema.json shows the form")]
    Syntax {
        /// The line.
        at: Box<Location>,
        /// What the parser says.
        reason: String,
    },
    /// A cut by nothing, or by two things.
    #[error("{at}: give `plane` or `set`, one of the two")]
    CutBy {
        /// The cut.
        at: Box<Location>,
    },
    /// A motion given in both ways.
    #[error("{at}: stands for the whole motion; leave out translation_mm, rotation_deg and axis")]
    TwoMotions {
        /// The field.
        at: Box<Location>,
    },
    /// A rotation about nothing.
    #[error(
        "{at}: missing; a rotation needs an axis: \"condylar\", \"pitch\", \"yaw\", \"roll\", or {{ point_mm = [x, y, z], direction = [x, y, z] }}"
    )]
    NoAxis {
        /// The field.
        at: Box<Location>,
    },
}

/// Reads the plan file `path`.
///
/// # Errors
/// [`PlanFileError`]: it names the line, the field, the value and the remedy.
pub fn read_plan(path: &Path) -> Result<PlanDocument, PlanFileError> {
    let text = read_text(path)
        .map_err(|reason| TargetFileError::Unreadable { at: Box::new(Location::file(path)), reason })?;
    parse_plan(&text, path)
}

/// Reads a plan from `text`; `path` is only named in messages.
///
/// # Errors
/// As [`read_plan`].
pub fn parse_plan(text: &str, path: &Path) -> Result<PlanDocument, PlanFileError> {
    let sha256 = sha256(text.as_bytes());
    let text = text.strip_prefix('\u{feff}').unwrap_or(text);
    let not_toml = |e: toml::de::Error| PlanFileError::Syntax {
        at: Box::new(Location::file(path).at_line(line_of(text, e.span().map_or(0, |s| s.start)))),
        reason: e.message().to_owned(),
    };
    let root = DeTable::parse(text).map_err(not_toml)?;
    let lines = FieldLines::of(path, text, root.get_ref());
    check_table(root.get_ref(), toml_schema_of::<PlanTable>().as_value(), "", &lines)?;
    let table = PlanTable::deserialize(toml::Deserializer::from(root)).map_err(not_toml)?;
    word(&lines, "name", &table.name)?;
    let at = |field: String| Box::new(lines.location(&field));
    let cut = |(k, cut): (usize, CutTable)| {
        let by = match (cut.plane, cut.set) {
            (Some(plane), None) => {
                let (point, normal) = (Vec3::from(plane.point_mm), Vec3::from(plane.normal));
                CutBy::Plane { point, normal, stripped_mm: plane.stripped_mm }
            }
            (None, Some(set)) => CutBy::Set(set),
            _ => return Err(PlanFileError::CutBy { at: at(format!("cut[{k}]")) }),
        };
        let teeth = cut.teeth.iter().map(|arch| *arch == ArchName::Upper).collect();
        Ok(Cut { bone: cut.bone, piece: cut.piece, by, teeth })
    };
    let step = |(k, step): (usize, MoveTable)| {
        if let Some(incisor) = step.incisor {
            if step.translation_mm != [0.; 3] || step.rotation_deg != 0. || step.axis.is_some() {
                return Err(PlanFileError::TwoMotions { at: at(format!("move[{k}].incisor")) });
            }
            return Ok(Move { bone: step.bone, motion: incisor.motion() });
        }
        let about = match step.axis {
            Some(AxisValue::Line(line)) => {
                About::Line { point: Vec3::from(line.point_mm), direction: Vec3::from(line.direction) }
            }
            None if step.rotation_deg != 0. => {
                return Err(PlanFileError::NoAxis { at: at(format!("move[{k}].axis")) });
            }
            Some(AxisValue::Named(AxisName::Condylar)) | None => About::Condyles,
            Some(AxisValue::Named(AxisName::Pitch)) => About::Incisor { direction: Vec3::x() },
            Some(AxisValue::Named(AxisName::Yaw)) => About::Incisor { direction: Vec3::y() },
            Some(AxisValue::Named(AxisName::Roll)) => About::Incisor { direction: Vec3::z() },
        };
        let (translation, rotation_deg) = (Vec3::from(step.translation_mm), step.rotation_deg);
        Ok(Move { bone: step.bone, motion: Motion { translation, rotation_deg, about } })
    };
    let cuts = table.cut.into_iter().enumerate().map(cut).collect::<Result<_, _>>()?;
    let moves = table.moves.into_iter().enumerate().map(step).collect::<Result<_, _>>()?;
    Ok(PlanDocument { plan: SurgicalPlan { name: table.name, cuts, moves }, lines, sha256 })
}

/// The JSON schema of plan files, as in `schemas/plan.schema.json`.
pub fn plan_schema() -> String {
    pretty(&toml_schema_of::<PlanTable>())
}
