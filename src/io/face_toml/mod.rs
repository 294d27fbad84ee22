//! Face files, `face.toml`.

mod error;
mod file;
mod frame;
mod landmarks;
mod limits;
mod muscles;
mod rows;
mod scale;
mod sets;

use std::cell::RefCell;
use std::collections::BTreeMap;
use std::path::{Path, PathBuf};

use serde::Deserialize;
use toml::de::DeTable;

pub use error::{FaceFileError, FaceFileErrorKind, FaceFileWarning, FaceFileWarningKind};
pub use landmarks::read_landmarks;

use self::file::{FaceTable, MuscleTissueTable, TissueTable};
use self::frame::Frame;
use super::input_file::read_text;
use super::nearest::nearest;
use super::schema::{pretty, toml_schema_of};
use super::target_toml::line_of;
use super::text::read_bytes;
use super::{
    FieldLines, InputFile, Location, MeshFileError, NoSet, UnreadableText, parse_surface, read_mesh_document,
    settle_folder,
};
use crate::contact::{TeethWarning, closed_surface, oriented};
use crate::face::{Face, FaceError, FaceWarning, Jaw, MuscleLaw, MuscleTissue, Support, Teeth, Tissue};
use crate::mesh::{Mesh, MeshError, validate_shape};
use crate::units::{LengthUnit, Vec3};

/// A face as its files state it.
#[derive(Clone, Debug)]
pub struct FaceDocument {
    /// The face.
    pub face: Face,
    /// What is odd about the files and about the face.
    pub warnings: Vec<FaceFileWarning>,
    /// The files that were read, the face file first.
    pub files: Vec<InputFile>,
}

/// Reads the face file `path` and the files that it names, which lie in `base`, or without one in the folder
/// that the file's own field `base` states relative to it, or else beside it.
///
/// # Errors
/// [`FaceFileError`] when it is no face that can be computed with: it names file, line, field, value and
/// remedy.
pub fn read_face(path: &Path, base: Option<&Path>) -> Result<FaceDocument, FaceFileError> {
    // What was being written there when its process ended is whole before it is read.
    settle_folder(path.parent().unwrap_or(Path::new(""))).map_err(|e| {
        let reason = UnreadableText::Io { reason: e.to_string() };
        FaceFileError::new(Location::file(path), FaceFileErrorKind::Unreadable(reason))
    })?;
    let bytes = unread(path, read_text(path))?;
    let text = bytes.strip_prefix('\u{feff}').unwrap_or(&bytes);
    let root = DeTable::parse(text).map_err(|e| not_toml(path, text, &e))?;
    let lines = FieldLines::of(path, text, root.get_ref());
    let table =
        FaceTable::deserialize(toml::Deserializer::from(root)).map_err(|e| not_toml(path, text, &e))?;
    let beside = path.parent().unwrap_or(Path::new(""));
    let own = table.base.as_ref().map_or_else(|| beside.to_owned(), |folder| beside.join(folder));
    let base = base.map_or(own, Path::to_owned);
    let mut reader = Reader {
        lines: &lines,
        base,
        warnings: Vec::new(),
        muscle_fields: BTreeMap::new(),
        no_sets: Vec::new(),
        files: RefCell::new(vec![InputFile::new(path, bytes.as_bytes())]),
    };
    let face = reader.face(&table)?;
    reader.check(&table, &face)?;
    let warnings = FaceWarning::join_sides(reader.warnings, FaceFileWarning::with_other_side);
    Ok(FaceDocument { face, warnings, files: reader.files.into_inner() })
}

/// The JSON schema of face files, as in `schemas/face.schema.json`.
pub fn face_schema() -> String {
    pretty(&toml_schema_of::<FaceTable>())
}

/// One reading of one face file.
struct Reader<'a> {
    lines: &'a FieldLines,
    base: PathBuf,
    warnings: Vec<FaceFileWarning>,
    /// The table of each muscle, by the muscle's full name.
    muscle_fields: BTreeMap<String, String>,
    /// What the mesh file has that is no set.
    no_sets: Vec<NoSet>,
    /// What was read so far.
    files: RefCell<Vec<InputFile>>,
}

/// What a face file or table that cannot be read gets.
fn unread<T>(path: &Path, read: Result<T, UnreadableText>) -> Result<T, FaceFileError> {
    read.map_err(|reason| FaceFileError::new(Location::file(path), FaceFileErrorKind::Unreadable(reason)))
}

impl Reader<'_> {
    fn face(&mut self, table: &FaceTable) -> Result<Face, FaceFileError> {
        let Some(unit) = LengthUnit::parse(&table.unit) else {
            return Err(self.unknown("unit", "unit", &table.unit, LengthUnit::NAMES));
        };
        let frame =
            Frame::new(table.frame.as_ref(), unit).map_err(|(field, kind)| self.error(field, kind))?;
        limits::check_tables(table).map_err(|(field, kind)| self.error(field, kind))?;
        let (tissue, muscle_tissue) = self.tissues(table)?;
        self.positive(table.max_projection_mm, "max_projection_mm")?;
        let mesh = self.mesh(table, &frame, unit)?;
        let optional = |name: &Option<String>, field| match name {
            Some(name) => self.set(&mesh, name, field),
            None => Ok(Vec::new()),
        };
        let skin = self.set(&mesh, &table.skin, "skin")?;
        let mucosa = optional(&table.mucosa, "mucosa")?;
        let upper_lip = optional(&table.upper_lip, "upper_lip")?;
        let lower_lip = optional(&table.lower_lip, "lower_lip")?;
        let supports = self.supports(table, &mesh)?;
        let jaw = table.jaw.as_ref().map(|jaw| Jaw {
            bone: jaw.bone.clone(),
            condyles: jaw.condyles_mm.map(Vec3::from),
            incisor: Vec3::from(jaw.incisor_mm),
        });
        let teeth = self.teeth(table, &supports, &mesh, &frame, unit)?;
        let landmarks = self.landmarks(table, &frame, &mesh, &skin)?;
        let muscles = self.muscles(table, &frame, &mesh, &skin)?;
        let name = table.name.clone();
        Ok(Face {
            name,
            mesh,
            tissue,
            muscle_tissue,
            supports,
            jaw,
            muscles,
            teeth,
            mucosa,
            upper_lip,
            lower_lip,
            skin,
            landmarks,
        })
    }

    /// The material constants, checked before anything costly is read.
    fn tissues(&self, table: &FaceTable) -> Result<(Tissue, MuscleTissue), FaceFileError> {
        let tissue = match &table.tissue {
            Some(TissueTable { young_kpa, poisson, strain_stiffening }) => Tissue {
                young_kpa: *young_kpa,
                poisson: *poisson,
                strain_stiffening: strain_stiffening.unwrap_or(Tissue::NAZARI),
            },
            None => Tissue::default(),
        };
        let muscle = match &table.muscle_tissue {
            Some(MuscleTissueTable { rest_kpa, active_kpa, poisson, law }) => {
                let law = match law {
                    None => MuscleLaw::default(),
                    Some(name) => MuscleLaw::parse(name).ok_or_else(|| {
                        self.unknown("muscle_tissue.law", "muscle law", name, MuscleLaw::NAMES)
                    })?,
                };
                MuscleTissue { rest_kpa: *rest_kpa, active_kpa: *active_kpa, poisson: *poisson, law }
            }
            None => MuscleTissue::default(),
        };
        let errors = tissue.check().0.into_iter().chain(muscle.check().0);
        errors.into_iter().next().map_or(Ok((tissue, muscle)), |error| Err(self.face_error(table, error)))
    }

    fn mesh(&mut self, table: &FaceTable, frame: &Frame, unit: LengthUnit) -> Result<Mesh, FaceFileError> {
        let path = self.path_of(&table.mesh);
        let document =
            read_mesh_document(&path, unit).map_err(|e| self.error("mesh", FaceFileErrorKind::Mesh(e)))?;
        document.files.into_iter().for_each(|file| self.note(file));
        let mut mesh = document.mesh;
        self.no_sets = document.no_sets;
        for warning in document.warnings {
            let (location, kind) = (Location::file(&path), FaceFileWarningKind::MeshFile(warning));
            self.warnings.push(FaceFileWarning { location, kind });
        }
        for p in &mut mesh.points {
            *p = frame.point_in_mm(*p);
        }
        // Before anything is measured against it: a wrong unit would look like a far landmark.
        validate_shape(&mesh).map_err(|e| self.mesh_error(table, e))?;
        if let Some(file) = &table.node_sets {
            self.add_json_sets(&self.path_of(file), &mut mesh)?;
        }
        self.add_selections(&table.select, &mut mesh)?;
        Ok(mesh)
    }

    fn supports(&self, table: &FaceTable, mesh: &Mesh) -> Result<Vec<Support>, FaceFileError> {
        let bones = ["skull", "maxilla", "mandible"];
        let support = |(k, support): (usize, &file::SupportTable)| {
            let (field, name) = match &support.part_of {
                Some(whole) => ("part_of", whole),
                None => ("bone", &support.bone),
            };
            if !bones.contains(&name.as_str()) {
                return Err(self.unknown(&format!("supports[{k}].{field}"), "bone", name, bones));
            }
            if support.part_of.is_some()
                && (bones.contains(&support.bone.as_str()) || support.bone.is_empty())
            {
                let accepted = "a name of its own for a piece, such as `mandible_body`".to_owned();
                let kind = FaceFileErrorKind::Value { value: support.bone.clone(), accepted };
                return Err(self.error(&format!("supports[{k}].bone"), kind));
            }
            let nodes = self.set(mesh, &support.set, &format!("supports[{k}].set"))?;
            Ok(Support { bone: support.bone.clone(), part_of: support.part_of.clone(), nodes })
        };
        table.supports.iter().enumerate().map(support).collect()
    }

    fn teeth(
        &mut self,
        table: &FaceTable,
        supports: &[Support],
        mesh: &Mesh,
        frame: &Frame,
        unit: LengthUnit,
    ) -> Result<Vec<Teeth>, FaceFileError> {
        let mut teeth = Vec::with_capacity(table.teeth.len());
        for (k, arch) in table.teeth.iter().enumerate() {
            let field = format!("teeth[{k}].file");
            let upper = match arch.arch.as_str() {
                "upper" => true,
                "lower" => false,
                other => {
                    let field = format!("teeth[{k}].arch");
                    return Err(self.unknown(&field, "arch", other, ["upper", "lower"]));
                }
            };
            let has =
                |bone: &str| supports.iter().any(|s| s.bone == bone || s.part_of.as_deref() == Some(bone));
            let bone = match &arch.bone {
                Some(bone) if !has(bone) => {
                    let known = supports.iter().map(|s| s.bone.as_str());
                    return Err(self.unknown(&format!("teeth[{k}].bone"), "bone", bone, known));
                }
                Some(bone) => bone.as_str(),
                None if !upper => "mandible",
                None if has("maxilla") => "maxilla",
                None => "skull",
            };
            let file = self.path_of(&arch.file);
            let read = read_bytes(&file).and_then(|bytes| {
                self.note(InputFile::new(&file, &bytes));
                parse_surface(&bytes, &file, unit)
            });
            let mut surface = read.map_err(|e| self.error(&field, FaceFileErrorKind::Mesh(e)))?;
            for p in &mut surface.points {
                *p = frame.point_in_mm(*p);
            }
            // Before anything is computed with it: squares of far coordinates overflow.
            scale::check("the tooth surface", &surface.points, mesh)
                .map_err(|kind| self.error(&field, kind))?;
            let mut turned = 0;
            if arch.orient {
                (surface, turned) = oriented(&surface);
            }
            let (surface, mut warnings) = closed_surface(&surface, arch.cap_holes)
                .map_err(|e| self.error(&field, FaceFileErrorKind::Teeth(e)))?;
            if turned > 0 {
                warnings.push(TeethWarning::Turned { triangles: turned });
            }
            for warning in warnings {
                let (location, kind) = (self.location(&field), FaceFileWarningKind::Teeth(warning));
                self.warnings.push(FaceFileWarning { location, kind });
            }
            teeth.push(Teeth { upper, bone: bone.to_owned(), surface });
        }
        Ok(teeth)
    }

    fn check(&mut self, table: &FaceTable, face: &Face) -> Result<(), FaceFileError> {
        let (errors, warnings) = face.check();
        if let Some(error) = errors.into_iter().next() {
            return Err(self.face_error(table, error));
        }
        for warning in warnings {
            match warning {
                FaceWarning::Mesh(odd) => {
                    let location = Location::file(self.path_of(&table.mesh));
                    self.warnings.push(FaceFileWarning { location, kind: FaceFileWarningKind::Mesh(odd) });
                }
                warning => {
                    let field = self.field_of(&warning);
                    self.warn(&field, warning);
                }
            }
        }
        Ok(())
    }

    fn mesh_error(&self, table: &FaceTable, error: MeshError) -> FaceFileError {
        let error = MeshFileError::invalid(self.path_of(&table.mesh), error);
        self.error("mesh", FaceFileErrorKind::Mesh(error))
    }

    fn face_error(&self, table: &FaceTable, error: FaceError) -> FaceFileError {
        let of = |muscle: &String| self.muscle_fields.get(muscle).cloned().unwrap_or_default();
        let field = match &error {
            FaceError::Mesh(error) => return self.mesh_error(table, error.clone()),
            FaceError::Modulus { field, .. } | FaceError::Poisson { field, .. } => (*field).to_owned(),
            FaceError::StrainStiffening { .. } => "tissue.strain_stiffening".to_owned(),
            FaceError::UnstableMuscle { .. } => "muscle_tissue.active_kpa".to_owned(),
            FaceError::MuscleNumber { muscle, field, .. } => format!("{}.{field}", of(muscle)),
            FaceError::NoTissue { muscle, .. } => format!("{}.radius_mm", of(muscle)),
            FaceError::DuplicateName { muscle }
            | FaceError::NoFibre { muscle }
            | FaceError::ZeroLength { muscle, .. }
            | FaceError::OutsideMesh { muscle, .. } => format!("{}.name", of(muscle)),
            FaceError::MissingNode { set, .. } | FaceError::OrphanNode { set, .. } => {
                self.field_of_set(table, set)
            }
            FaceError::Jaw { field, .. } => (*field).to_owned(),
            FaceError::UnknownBone { field, .. } => field.clone(),
        };
        self.error(&field, FaceFileErrorKind::Face(error))
    }

    /// The field that names the nodes of `set`: its own, or that of the support of this name.
    fn field_of_set(&self, table: &FaceTable, set: &str) -> String {
        let support = table.supports.iter().position(|s| s.bone == set);
        support.map_or_else(|| set.to_owned(), |k| format!("supports[{k}].set"))
    }

    fn field_of(&self, warning: &FaceWarning) -> String {
        let of = |muscle: &String| self.muscle_fields.get(muscle).cloned().unwrap_or_default();
        match warning {
            FaceWarning::ImplausibleModulus { field, .. } => (*field).to_owned(),
            FaceWarning::SofterWhenActive { .. } => "muscle_tissue".to_owned(),
            FaceWarning::FlippedFibres { muscle, .. } => format!("{}.origin", of(muscle)),
            FaceWarning::AllInsertion { muscle, .. } => format!("{}.insertion_mm", of(muscle)),
            FaceWarning::TwoBones { support, .. } => format!("supports[{support}].set"),
            FaceWarning::SameFibres { second, .. } => format!("{}.name", of(second)),
            FaceWarning::Projected { muscle, .. } => format!("{}.name", of(muscle)),
            FaceWarning::RestOverlap(_) | FaceWarning::NoContact { .. } => "teeth".to_owned(),
            FaceWarning::Mesh(_) => "mesh".to_owned(),
        }
    }

    /// The text of a named table, whose fingerprint is kept.
    fn text(&self, file: &Path) -> Result<String, FaceFileError> {
        let text = unread(file, read_text(file))?;
        self.note(InputFile::new(file, text.as_bytes()));
        Ok(text.strip_prefix('\u{feff}').map(str::to_owned).unwrap_or(text))
    }

    fn note(&self, file: InputFile) {
        let mut files = self.files.borrow_mut();
        if files.iter().all(|known| known.path != file.path) {
            files.push(file);
        }
    }

    fn location(&self, field: &str) -> Location {
        self.lines.location(field)
    }

    fn error(&self, field: &str, kind: FaceFileErrorKind) -> FaceFileError {
        FaceFileError::new(self.location(field), kind)
    }

    fn warn(&mut self, field: &str, warning: FaceWarning) {
        let (location, kind) = (self.location(field), FaceFileWarningKind::Face(warning));
        self.warnings.push(FaceFileWarning { location, kind });
    }

    fn unknown<'k>(
        &self,
        field: &str,
        what: &'static str,
        name: &str,
        known: impl IntoIterator<Item = &'k str>,
    ) -> FaceFileError {
        let known: Vec<&str> = known.into_iter().collect();
        let nearest = nearest(name, known.iter().copied()).map(str::to_owned);
        let known = known.into_iter().map(str::to_owned).collect();
        self.error(field, FaceFileErrorKind::UnknownName { what, name: name.to_owned(), nearest, known })
    }

    fn positive(&self, value: f64, field: &str) -> Result<f64, FaceFileError> {
        if value > 0. && value.is_finite() {
            return Ok(value);
        }
        let accepted = "a positive number".to_owned();
        Err(self.error(field, FaceFileErrorKind::Value { value: value.to_string(), accepted }))
    }
}

/// What the parser refuses; it states unknown and missing fields in words, `` unknown field `a`, expected
/// one of `b`, `c` ``.
fn not_toml(path: &Path, text: &str, error: &toml::de::Error) -> FaceFileError {
    let line = line_of(text, error.span().map_or(0, |s| s.start));
    let at = Location::file(path).at_line(line);
    let message = error.message();
    let mut quoted = message.split('`').skip(1).step_by(2).map(str::to_owned);
    let (at, kind) = match quoted.next() {
        Some(field) if message.starts_with("unknown field") => {
            let known: Vec<String> = quoted.collect();
            let nearest = nearest(&field, known.iter().map(String::as_str)).map(str::to_owned);
            (at.in_field(field.clone()), FaceFileErrorKind::UnknownField { field, nearest, known })
        }
        Some(field) if message.starts_with("missing field") => {
            let hint = match field.as_str() {
                "unit" => "state the unit of the named files: `unit = \"mm\"`, \"cm\" or \"m\"",
                _ => "schemas/face.schema.json says what it means",
            };
            let hint = hint.to_owned();
            (at.in_field(field.clone()), FaceFileErrorKind::MissingField { field, hint })
        }
        _ => (at, FaceFileErrorKind::Syntax { reason: message.to_owned() }),
    };
    FaceFileError::new(at, kind)
}
