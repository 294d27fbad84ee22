//! Muscles from the fibres file.

use std::collections::BTreeMap;
use std::f64::consts::PI;

use super::Reader;
use super::error::{FaceFileError, FaceFileErrorKind};
use super::file::{End, FaceTable, MuscleTable, Origins};
use super::frame::Frame;
use super::limits::FibreLimits;
use super::rows::Rows;
use crate::face::{
    FaceError, FaceWarning, Fibre, Muscle, Projected, SkinNormal, embed, join_ring, polyline_length,
    smooth_curve, spread,
};
use crate::mesh::{Locator, Mesh};
use crate::units::Vec3;

/// The widest gap that a ring may bridge between two of its pieces, mm.
const RING_GAP_MM: f64 = 10.;

/// The polylines of one muscle.
type Polylines = Vec<Vec<Vec3>>;

/// Polylines by muscle, then side, then fibre.
type Paths = BTreeMap<String, BTreeMap<String, BTreeMap<String, Vec<Vec3>>>>;

/// What the fibres of all muscles are made with.
struct Tissue {
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
        let tissue = Tissue {
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
                files.insert(file.clone(), read_paths(&Rows::read(&self.path_of(file))?, frame)?);
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
        sides: &BTreeMap<String, BTreeMap<String, Vec<Vec3>>>,
        limits: &FibreLimits,
    ) -> Result<Vec<(String, Polylines)>, FaceFileError> {
        let known = || sides.keys().map(String::as_str);
        if muscle.ring {
            let pieces = sides.values().map(BTreeMap::len).sum();
            limits.check_pieces(pieces).map_err(|kind| self.error(&format!("{field}.ring"), kind))?;
            let pieces: Vec<Vec<Vec3>> = sides.values().flat_map(|f| f.values().cloned()).collect();
            let (ring, gap_mm) = join_ring(&pieces);
            if gap_mm > RING_GAP_MM {
                let kind = FaceFileErrorKind::OpenRing { muscle: muscle.name.clone(), gap_mm };
                return Err(self.error(&format!("{field}.ring"), kind));
            }
            return Ok(vec![(muscle.name.clone(), vec![ring])]);
        }
        if muscle.sides.is_empty() {
            let Some(fibres) = sides.get("") else {
                return Err(self.unknown(&format!("{field}.sides"), "side", "", known()));
            };
            return Ok(vec![(muscle.name.clone(), fibres.values().cloned().collect())]);
        }
        muscle
            .sides
            .iter()
            .map(|side| match sides.get(side) {
                Some(fibres) => Ok((format!("{}_{side}", muscle.name), fibres.values().cloned().collect())),
                None => Err(self.unknown(&format!("{field}.sides"), "side", side, known())),
            })
            .collect()
    }

    fn muscle(
        &mut self,
        table: &MuscleTable,
        field: &str,
        name: String,
        polylines: &[Vec<Vec3>],
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
            Origins::All(end) => vec![*end; polylines.len()],
            Origins::Each(ends) if ends.len() == polylines.len() => ends.clone(),
            Origins::Each(ends) => {
                let (value, accepted) = (format!("{ends:?}"), format!("{} ends", polylines.len()));
                let kind = FaceFileErrorKind::Value { value, accepted };
                return Err(self.error(&format!("{field}.origin"), kind));
            }
        };
        // Without a width the fibres would all lie in one place.
        let count = if table.width_mm > 0. { table.fibres } else { 1 };
        let closed = table.ring || table.closed;
        let mut projected = Projected::default();
        let mut fibres: Vec<Fibre> = Vec::new();
        for (k, polyline) in polylines.iter().enumerate() {
            let mut points = polyline.clone();
            if origins[k] == End::Last {
                points.reverse();
            }
            let fibre_error = |error: FaceError| self.error(field, FaceFileErrorKind::Face(error));
            if polyline_length(&points, closed) <= 1e-9 {
                return Err(fibre_error(FaceError::ZeroLength { muscle: name, fibre: k + 1 }));
            }
            limits.spend(&name, k + 1, &points, closed).map_err(|kind| self.error(field, kind))?;
            let curve = smooth_curve(&points, closed, tissue.step_mm);
            for strand in spread(&curve, closed, count, table.width_mm, |p| tissue.skin.at(p)) {
                limits.spend(&name, k + 1, &strand, closed).map_err(|kind| self.error(field, kind))?;
                let strand = smooth_curve(&strand, closed, tissue.step_mm);
                let (locator, limit_mm, step_mm) = (&tissue.locator, tissue.limit_mm, tissue.step_mm);
                let fibre = embed(&strand, closed, locator, limit_mm, step_mm, &mut projected);
                fibres.push(fibre.map_err(|far| {
                    fibre_error(FaceError::OutsideMesh {
                        muscle: name.clone(),
                        fibre: k + 1,
                        at: far.point.into(),
                        distance_mm: far.distance_mm,
                        limit_mm: tissue.limit_mm,
                    })
                })?);
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

fn read_paths(rows: &Rows, frame: &Frame) -> Result<Paths, FaceFileError> {
    let mut paths = Paths::new();
    for row in rows.rows() {
        let sides = paths.entry(row.text("muscle")?.to_owned()).or_default();
        let fibres = sides.entry(row.text("side")?.to_owned()).or_default();
        let points = fibres.entry(row.text("fibre")?.to_owned()).or_default();
        if row.text("point")?.parse() != Ok(points.len()) {
            let value = row.text("point")?.to_owned();
            let accepted = format!("point {}: the points of a fibre in their order, from 0", points.len());
            return Err(FaceFileError::new(row.at("point"), FaceFileErrorKind::Value { value, accepted }));
        }
        points.push(row.point(frame)?);
    }
    Ok(paths)
}
