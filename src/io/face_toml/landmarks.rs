//! Landmarks, put on the skin.

use std::collections::HashSet;
use std::path::Path;

use super::Reader;
use super::error::{FaceFileError, FaceFileErrorKind, FaceFileWarning, FaceFileWarningKind};
use super::file::FaceTable;
use super::frame::Frame;
use super::rows::Rows;
use crate::contact::{Facets, Patch};
use crate::face::Landmark;
use crate::io::Location;
use crate::mesh::Mesh;
use crate::units::Vec3;

/// Movements below this go without a word, mm: about the error of landmarking by hand.
const UNNOTICED_MM: f64 = 0.5;

impl Reader<'_> {
    pub(super) fn landmarks(
        &mut self,
        table: &FaceTable,
        frame: &Frame,
        mesh: &Mesh,
        skin: &[usize],
    ) -> Result<Vec<Landmark>, FaceFileError> {
        let mut named: Vec<(Location, String, Vec3)> = Vec::new();
        if let Some(file) = &table.landmarks {
            let rows = Rows::read(&self.path_of(file))?;
            for row in rows.rows() {
                named.push((row.at("landmark"), row.text("landmark")?.to_owned(), row.point(frame)?));
            }
        }
        for (k, point) in table.points.iter().enumerate() {
            let at = self.location(&format!("points[{k}].at_mm"));
            named.push((at, point.name.clone(), Vec3::from(point.at_mm)));
        }
        let patch = Patch::new(&Facets::of(mesh).within(skin), mesh);
        let limit_mm = table.max_projection_mm;
        let mut landmarks: Vec<Landmark> = Vec::with_capacity(named.len());
        let mut names = HashSet::with_capacity(named.len());
        for (at, name, p) in named {
            if !names.insert(name.clone()) {
                return Err(FaceFileError::new(at, FaceFileErrorKind::Duplicate { what: "landmark", name }));
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
