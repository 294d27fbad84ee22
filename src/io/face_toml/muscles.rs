//! Muscles from the fibres file.

use std::collections::BTreeMap;
use std::f64::consts::PI;

use super::Reader;
use super::error::{FaceFileError, FaceFileErrorKind};
use super::file::{End, FaceTable, MuscleTable, Origins};
use super::frame::Frame;
use super::limits::FibreLimits;
use super::rows::Rows;
use super::scale;
use crate::face::{
    FaceError, FaceWarning, Fibre, Muscle, Projected, SkinNormal, embed, join_ring, polyline_length,
    smooth_curve, spread,
};
use crate::io::Location;
use crate::mesh::{Locator, Mesh};
use crate::units::Vec3;

/// The widest gap that a ring may bridge between two of its pieces, mm.
const RING_GAP_MM: f64 = 10.;

/// How the fibres of a file are taken.
#[derive(Clone, Copy, PartialEq, Eq)]
enum Course {
    /// Smooth curves through the points, brought inside the mesh.
    Smooth,
    /// The points as they are.
    Polyline,
}

/// A fibre as its file has it.
#[derive(Clone, Default)]
struct Path {
    /// Where each point stands, so that later errors can name its line.
    at: Vec<Location>,
    points: Vec<Vec3>,
}

/// Fibres by muscle, then side, then name.
type Paths = BTreeMap<String, BTreeMap<String, BTreeMap<String, Path>>>;

/// What the fibres of all muscles are made with.
struct Tissue {
    course: Course,
    locator: Locator,
    skin: SkinNormal,
    step_mm: f64,
    limit_mm: f64,
}

impl Reader<'_> {
    pub(super) fn muscles(
        &mut self,
        table: &FaceTable,
        frame: &Frame,
        mesh: &Mesh,
        skin: &[usize],
    ) -> Result<Vec<Muscle>, FaceFileError> {
        let course = match table.fibre_course.as_deref() {
            None | Some("smooth") => Course::Smooth,
            Some("polyline") => Course::Polyline,
            Some(other) => {
                return Err(self.unknown("fibre_course", "course", other, ["smooth", "polyline"]));
            }
        };
        let tissue = Tissue {
            course,
            locator: Locator::new(mesh),
            skin: SkinNormal::new(mesh, skin),
            step_mm: self.positive(table.fibre_step_mm, "fibre_step_mm")?,
            limit_mm: table.max_projection_mm,
        };
        let mut limits =
            FibreLimits::new(tissue.step_mm, mesh).map_err(|kind| self.error("fibre_step_mm", kind))?;
        let mut files: BTreeMap<String, Paths> = BTreeMap::new();
        let mut muscles = Vec::new();
        for (k, muscle) in table.muscles.iter().enumerate() {
            let field = format!("muscles[{k}]");
            let Some(file) = muscle.file.as_ref().or(table.fibres.as_ref()) else {
                let hint = "name the fibres file here, or once for all muscles".to_owned();
                let kind = FaceFileErrorKind::MissingField { field: "fibres".to_owned(), hint };
                return Err(self.error(&field, kind));
            };
            if !files.contains_key(file) {
                let at = self.path_of(file);
                let rows = Rows::parse(&at, &self.text(&at)?)?;
                files.insert(file.clone(), read_paths(&rows, frame, mesh)?);
            }
            let paths = &files[file];
            let Some(sides) = paths.get(&muscle.name) else {
                let known = paths.keys().map(String::as_str);
                return Err(self.unknown(&format!("{field}.name"), "muscle", &muscle.name, known));
            };
            for (name, polylines) in self.polylines(muscle, &field, sides, &limits)? {
                self.muscle_fields.insert(name.clone(), field.clone());
                muscles.push(self.muscle(muscle, &field, name, &polylines, &tissue, &mut limits)?);
            }
        }
        Ok(muscles)
    }

    /// The polylines of each muscle that `muscle` stands for, by the muscle's full name.
    fn polylines(
        &self,
        muscle: &MuscleTable,
        field: &str,
        sides: &BTreeMap<String, BTreeMap<String, Path>>,
        limits: &FibreLimits,
    ) -> Result<Vec<(String, Vec<Path>)>, FaceFileError> {
        if muscle.ring {
            let all: Vec<&Path> = sides.values().flat_map(BTreeMap::values).collect();
            limits.check_pieces(all.len()).map_err(|kind| self.error(&format!("{field}.ring"), kind))?;
            let pieces: Vec<Vec<Vec3>> = all.iter().map(|path| path.points.clone()).collect();
            let (ring, gap_mm) = join_ring(&pieces);
            if gap_mm > RING_GAP_MM {
                let kind = FaceFileErrorKind::OpenRing { muscle: muscle.name.clone(), gap_mm };
                return Err(self.error(&format!("{field}.ring"), kind));
            }
            let at = all.iter().flat_map(|path| path.at.iter().cloned()).collect();
            return Ok(vec![(muscle.name.clone(), vec![Path { at, points: ring }])]);
        }
        let of_side = |side: &str| match sides.get(side) {
            Some(fibres) => Ok(fibres.values().cloned().collect()),
            None => {
                let named: Vec<String> =
                    sides.keys().filter(|s| !s.is_empty()).map(|s| format!("\"{s}\"")).collect();
                let accepted = format!("[{}], as the fibres of `{}` have it", named.join(", "), muscle.name);
                let kind = FaceFileErrorKind::Value { value: format!("{:?}", muscle.sides), accepted };
                Err(self.error(&format!("{field}.sides"), kind))
            }
        };
        if muscle.sides.is_empty() {
            return Ok(vec![(muscle.name.clone(), of_side("")?)]);
        }
        let named = |side: &String| Ok((format!("{}_{side}", muscle.name), of_side(side)?));
        muscle.sides.iter().map(named).collect()
    }

    fn muscle(
        &mut self,
        table: &MuscleTable,
        field: &str,
        name: String,
        paths: &[Path],
        tissue: &Tissue,
        limits: &mut FibreLimits,
    ) -> Result<Muscle, FaceFileError> {
        if table.fibres == 0 || table.fibres > 1000 {
            let accepted = "1 to 1000 fibres".to_owned();
            let kind = FaceFileErrorKind::Value { value: table.fibres.to_string(), accepted };
            return Err(self.error(&format!("{field}.fibres"), kind));
        }
        if !(table.width_mm >= 0. && table.width_mm.is_finite()) {
            let accepted = "0 or a width in mm".to_owned();
            let kind = FaceFileErrorKind::Value { value: table.width_mm.to_string(), accepted };
            return Err(self.error(&format!("{field}.width_mm"), kind));
        }
        limits.check_width(table.width_mm).map_err(|kind| self.error(&format!("{field}.width_mm"), kind))?;
        let origins = match &table.origin {
            Origins::All(end) => vec![*end; paths.len()],
            Origins::Each(ends) if ends.len() == paths.len() => ends.clone(),
            Origins::Each(ends) => {
                let (value, accepted) = (format!("{ends:?}"), format!("{} ends", paths.len()));
                let kind = FaceFileErrorKind::Value { value, accepted };
                return Err(self.error(&format!("{field}.origin"), kind));
            }
        };
        // Without a width the fibres would all lie in one place.
        let count = if table.width_mm > 0. { table.fibres } else { 1 };
        let closed = table.ring || table.closed;
        let mut projected = Projected::default();
        let mut fibres: Vec<Fibre> = Vec::new();
        for (k, path) in paths.iter().enumerate() {
            let mut points = path.points.clone();
            if origins[k] == End::Last {
                points.reverse();
            }
            // The place of the given point nearest to where the fault is.
            let fibre_error = |near: Vec3, error: FaceError| {
                let far = |k: &usize| (path.points[*k] - near).norm();
                let nearest = (0..path.points.len()).min_by(|a, b| far(a).total_cmp(&far(b)));
                let at = nearest.and_then(|k| path.at.get(k).cloned());
                let at = at.unwrap_or_else(|| self.location(field));
                FaceFileError::new(at, FaceFileErrorKind::Face(error))
            };
            let fibre = k + 1;
            if polyline_length(&points, closed) <= 1e-9 {
                let at = points.first().copied().unwrap_or_default();
                return Err(fibre_error(at, FaceError::ZeroLength { muscle: name, fibre }));
            }
            let outside = |point: Vec3, distance_mm: f64| FaceError::OutsideMesh {
                muscle: name.clone(),
                fibre,
                at: point.into(),
                distance_mm,
                limit_mm: tissue.limit_mm,
            };
            if tissue.course == Course::Polyline {
                for &p in &points {
                    let distance_mm = tissue.locator.locate(p).map_or(f64::NAN, |found| found.distance_mm);
                    if distance_mm.is_nan() || distance_mm > tissue.limit_mm {
                        return Err(fibre_error(p, outside(p, distance_mm)));
                    }
                }
                fibres.push(Fibre { points, closed });
                continue;
            }
            limits.spend(&name, k + 1, &points, closed).map_err(|kind| self.error(field, kind))?;
            let curve = smooth_curve(&points, closed, tissue.step_mm);
            for strand in spread(&curve, closed, count, table.width_mm, |p| tissue.skin.at(p)) {
                limits.spend(&name, k + 1, &strand, closed).map_err(|kind| self.error(field, kind))?;
                let strand = smooth_curve(&strand, closed, tissue.step_mm);
                let (locator, limit_mm, step_mm) = (&tissue.locator, tissue.limit_mm, tissue.step_mm);
                let fibre = embed(&strand, closed, locator, limit_mm, step_mm, &mut projected);
                fibres
                    .push(fibre.map_err(|far| fibre_error(far.point, outside(far.point, far.distance_mm)))?);
            }
        }
        if projected.outside > 0 {
            let Projected { outside, points, largest_mm } = projected;
            let muscle = name.clone();
            self.warn(field, FaceWarning::Projected { muscle, outside, points, largest_mm });
        }
        let radius_mm = self.radius(table, field, fibres.len())?;
        let (max_force_n, insertion_mm, area_mm2) = (table.max_force_n, table.insertion_mm, table.area_mm2);
        Ok(Muscle { name, max_force_n, radius_mm, area_mm2, insertion_mm, fibres })
    }

    fn radius(&self, table: &MuscleTable, field: &str, strands: usize) -> Result<f64, FaceFileError> {
        match (table.radius_mm, table.area_mm2) {
            (Some(radius_mm), _) => Ok(radius_mm),
            (None, Some(area_mm2)) => {
                let area_mm2 = self.positive(area_mm2, &format!("{field}.area_mm2"))?;
                Ok((area_mm2 / (PI * strands.max(1) as f64)).sqrt())
            }
            (None, None) => {
                let hint = "add it, or `area_mm2`".to_owned();
                let kind = FaceFileErrorKind::MissingField { field: "radius_mm".to_owned(), hint };
                Err(self.error(field, kind))
            }
        }
    }
}

/// The fibres of a file, in their frame and held against the `mesh`.
fn read_paths(rows: &Rows, frame: &Frame, mesh: &Mesh) -> Result<Paths, FaceFileError> {
    let mut paths = Paths::new();
    let mut all = Vec::new();
    for row in rows.rows() {
        let sides = paths.entry(row.text("muscle")?.to_owned()).or_default();
        let fibres = sides.entry(row.text("side")?.to_owned()).or_default();
        let path = fibres.entry(row.text("fibre")?.to_owned()).or_default();
        if row.text("point")?.parse() != Ok(path.points.len()) {
            let value = row.text("point")?.to_owned();
            let next = path.points.len();
            let accepted = format!("point {next}: the points of a fibre in their order, from 0");
            return Err(FaceFileError::new(row.at("point"), FaceFileErrorKind::Value { value, accepted }));
        }
        let point = row.point(frame)?;
        let at = row.at("point");
        // Before curves are drawn through it: a far point would take as many steps as it is far.
        scale::check("the fibre point", [&point], mesh).map_err(|k| FaceFileError::new(at.clone(), k))?;
        path.at.push(at);
        path.points.push(point);
        all.push(point);
    }
    scale::check("the bundle of all fibres", &all, mesh)
        .map_err(|kind| FaceFileError::new(rows.location(), kind))?;
    Ok(paths)
}
