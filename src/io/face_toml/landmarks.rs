//! Landmarks, put on the skin.

use std::collections::HashSet;
use std::path::Path;

use super::Reader;
use super::error::{FaceFileError, FaceFileErrorKind, FaceFileWarning, FaceFileWarningKind};
use super::file::FaceTable;
use super::frame::Frame;
use super::rows::Rows;
use super::{scale, unread};
use crate::contact::{Facets, Patch};
use crate::face::Landmark;
use crate::io::input_file::read_text;
use crate::io::{InputFile, Location};
use crate::mesh::{Mesh, Site};
use crate::units::{LengthUnit, Vec3};

/// Movements below this go without a word, mm: about the error of landmarking by hand.
const UNNOTICED_MM: f64 = 0.5;

/// Column of the nodes that carry a landmark, and their weights.
const CARRIERS: &str = "carriers";

/// How far from its place the carriers of a landmark may lead, mm: rounding of a file in another unit.
const SAME_PLACE_MM: f64 = 1e-3;

/// A landmark as its file has it.
struct Named {
    /// Where the point is stated,
    at: Location,
    /// and where its name is.
    called: Location,
    name: String,
    point: Vec3,
    /// The carriers, where they are stated.
    site: Option<Site>,
}

/// The landmarks in the table `path`, whose columns are `landmark` and `x_mm`, `y_mm`, `z_mm`, or `x`, `y`, `z` in `unit`;
/// positions in mm, and the file as it was read.
///
/// # Errors
/// [`FaceFileError`] with the line, when the table is not one.
pub fn read_landmarks(
    path: &Path,
    unit: LengthUnit,
) -> Result<(Vec<(String, Vec3)>, InputFile), FaceFileError> {
    let text = unread(path, read_text(path))?;
    let frame = Frame::new(None, unit)
        .map_err(|(field, kind)| FaceFileError::new(Location::file(path).in_field(field), kind))?;
    let rows = Rows::parse(path, text.strip_prefix('\u{feff}').unwrap_or(&text))?;
    let landmarks = rows
        .rows()
        .map(|row| Ok((row.text("landmark")?.to_owned(), row.point(&frame)?)))
        .collect::<Result<_, FaceFileError>>()?;
    Ok((landmarks, InputFile::new(path, text.as_bytes())))
}

/// Holds landmarks against the mesh: two may be the lips' middle, and as near to each other as they like.
fn check_scale(what: &'static str, named: &[Named], mesh: &Mesh) -> Result<(), FaceFileErrorKind> {
    if named.len() < 3 {
        return Ok(());
    }
    scale::check(what, named.iter().map(|landmark| &landmark.point), mesh)
}

/// The site at `point` that `text` (`12:0.25 13:0.75`) states, if it is one.
fn carried(text: &str, point: Vec3, mesh: &Mesh) -> Option<Site> {
    let carrier = |word: &str| {
        let (node, weight) = word.split_once(':')?;
        let node: usize = node.parse().ok()?;
        Some((node, weight.parse::<f64>().ok()?)).filter(|_| node < mesh.n_nodes())
    };
    let weights: Vec<(usize, f64)> = text.split_whitespace().map(carrier).collect::<Option<_>>()?;
    let place: Vec3 = weights.iter().map(|&(node, w)| w * mesh.points[node]).sum();
    let sum: f64 = weights.iter().map(|(_, w)| w).sum();
    // A sum that is not a number is not near one.
    let leads_there = (sum - 1.).abs() <= 1e-9 && (place - point).norm() <= SAME_PLACE_MM;
    leads_there.then_some(Site { position: point, weights })
}

impl Reader<'_> {
    pub(super) fn landmarks(
        &mut self,
        table: &FaceTable,
        frame: &Frame,
        mesh: &Mesh,
        skin: &[usize],
    ) -> Result<Vec<Landmark>, FaceFileError> {
        let mut named: Vec<Named> = Vec::new();
        if let Some(file) = &table.landmarks {
            let file = self.path_of(file);
            let rows = Rows::parse(&file, &self.text(&file)?)?;
            for row in rows.rows() {
                let (name, point) = (row.text("landmark")?.to_owned(), row.point(frame)?);
                let carriers = if rows.has(CARRIERS) { row.text(CARRIERS)? } else { "" };
                let site = match carriers {
                    "" => None,
                    text => Some(carried(text, point, mesh).ok_or_else(|| {
                        let accepted = "nodes of the mesh (from 0) with weights that sum to one and lead to the place, such \
                                        as `12:0.25 13:0.75`, or nothing";
                        let (value, accepted) = (text.to_owned(), accepted.to_owned());
                        FaceFileError::new(row.at(CARRIERS), FaceFileErrorKind::Value { value, accepted })
                    })?),
                };
                let at = row.at("landmark");
                named.push(Named { called: at.clone(), at, name, point, site });
            }
            check_scale("the cloud of all landmarks", &named, mesh)
                .map_err(|kind| FaceFileError::new(rows.location(), kind))?;
        }
        let in_file = named.len();
        for (k, point) in table.points.iter().enumerate() {
            let [at, called] = ["at_mm", "name"].map(|field| self.location(&format!("points[{k}].{field}")));
            let (name, point) = (point.name.clone(), Vec3::from(point.at_mm));
            named.push(Named { at, called, name, point, site: None });
        }
        check_scale("the cloud of all points", &named[in_file..], mesh)
            .map_err(|kind| self.error("points", kind))?;
        let patch = Patch::new(&Facets::of(mesh).within(skin), mesh);
        let limit_mm = table.max_projection_mm;
        let mut landmarks: Vec<Landmark> = Vec::with_capacity(named.len());
        let mut names = HashSet::with_capacity(named.len());
        for Named { at, called, name, point: p, site } in named {
            if name.trim().is_empty() {
                let (value, accepted) = (name, "a name, by which targets call the point".to_owned());
                return Err(FaceFileError::new(called, FaceFileErrorKind::Value { value, accepted }));
            }
            if !names.insert(name.clone()) {
                return Err(FaceFileError::new(
                    called,
                    FaceFileErrorKind::Duplicate { what: "landmark", name },
                ));
            }
            if let Some(site) = site {
                landmarks.push(Landmark { name, site });
                continue;
            }
            let Some((site, distance_mm)) = patch.project(p) else {
                let value = format!("({}, {}, {})", p.x, p.y, p.z);
                let accepted = "finite coordinates, and a skin that has facets".to_owned();
                return Err(FaceFileError::new(at, FaceFileErrorKind::Value { value, accepted }));
            };
            if distance_mm > limit_mm {
                let kind = FaceFileErrorKind::FarLandmark { name, distance_mm, limit_mm };
                return Err(FaceFileError::new(at, kind));
            }
            if distance_mm > UNNOTICED_MM {
                let kind = FaceFileWarningKind::MovedLandmark { name: name.clone(), distance_mm };
                self.warnings.push(FaceFileWarning { location: at, kind });
            }
            landmarks.push(Landmark { name, site });
        }
        Ok(landmarks)
    }

    pub(super) fn path_of(&self, file: &str) -> std::path::PathBuf {
        self.base.join(Path::new(file))
    }
}
