//! How much a face file may ask for: one wrong digit must not fill the memory or take a day.

use super::error::FaceFileErrorKind;
use super::file::FaceTable;
use crate::face::polyline_length;
use crate::mesh::{Extent, Mesh};
use crate::units::Vec3;

/// Least distance of neighbouring fibre points, mm: a tenth of that at which they are taken for one.
const LEAST_STEP_MM: f64 = 0.01;
/// Most points of a fibre, and of all fibres together. The built-in face has some ten thousand.
const FIBRE_POINTS: usize = 10_000;
const ALL_POINTS: usize = 500_000;
/// Most pieces of a ring, each of which is held against all others.
const RING_PIECES: usize = 1000;

/// How many tables of each kind a face file may have.
pub(super) fn check_tables(table: &FaceTable) -> Result<(), (&'static str, FaceFileErrorKind)> {
    let counts = [
        ("muscles", table.muscles.len(), 1000),
        ("supports", table.supports.len(), 200),
        ("select", table.select.len(), 1000),
        ("teeth", table.teeth.len(), 100),
    ];
    match counts.into_iter().find(|(_, n, most)| n > most) {
        Some((field, n, most)) => Err((field, value(&n, format!("at most {most} tables `[[{field}]]`")))),
        None => Ok(()),
    }
}

/// What fibres may still ask for.
pub(super) struct FibreLimits {
    step_mm: f64,
    extent_mm: f64,
    left: usize,
}

impl FibreLimits {
    /// Of fibres in steps of `step_mm` through `mesh`.
    pub(super) fn new(step_mm: f64, mesh: &Mesh) -> Result<Self, FaceFileErrorKind> {
        if step_mm < LEAST_STEP_MM {
            return Err(value(&step_mm, format!("{LEAST_STEP_MM} mm or more")));
        }
        let Extent { lo, hi } = mesh.extent();
        Ok(Self { step_mm, extent_mm: (hi - lo).norm(), left: ALL_POINTS })
    }

    /// Refuses a bundle wider than the mesh.
    pub(super) fn check_width(&self, width_mm: f64) -> Result<(), FaceFileErrorKind> {
        if width_mm <= self.extent_mm {
            return Ok(());
        }
        Err(value(&width_mm, format!("a width in mm that the mesh, of {:.0} mm, can hold", self.extent_mm)))
    }

    /// Refuses a ring of too many pieces.
    pub(super) fn check_pieces(&self, pieces: usize) -> Result<(), FaceFileErrorKind> {
        match pieces > RING_PIECES {
            true => {
                Err(value(&format!("{pieces} pieces"), format!("a ring of at most {RING_PIECES} pieces")))
            }
            false => Ok(()),
        }
    }

    /// Counts the points of fibre `fibre` (from 1) of `muscle` before they are made from its polyline `points`.
    pub(super) fn spend(
        &mut self,
        muscle: &str,
        fibre: usize,
        points: &[Vec3],
        closed: bool,
    ) -> Result<(), FaceFileErrorKind> {
        let length_mm = polyline_length(points, closed);
        // The cast saturates; a length that is no number asks for none, and is refused where it is located.
        let wanted = points.len().saturating_add((length_mm / self.step_mm) as usize);
        if wanted <= FIBRE_POINTS && wanted <= self.left {
            self.left -= wanted;
            return Ok(());
        }
        let most = if wanted > FIBRE_POINTS { FIBRE_POINTS } else { ALL_POINTS };
        let muscle = muscle.to_owned();
        Err(FaceFileErrorKind::FibrePoints { muscle, fibre, length_mm, step_mm: self.step_mm, most })
    }
}

fn value(value: &impl ToString, accepted: String) -> FaceFileErrorKind {
    FaceFileErrorKind::Value { value: value.to_string(), accepted }
}
