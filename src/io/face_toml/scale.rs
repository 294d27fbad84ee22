//! Whether what a face file names is as large as its like on the mesh, and lies where the mesh does.

use super::error::FaceFileErrorKind;
use crate::mesh::{Extent, Mesh};
use crate::units::Vec3;

/// Least and greatest size of teeth, fibres or landmarks over that of the mesh. A single tooth (8 mm) on a whole
/// head (300 mm) is a fortieth; a skull around the mesh of the lips is not five times its size.
const LIKELY: [f64; 2] = [1. / 50., 5.];

/// Units in which coordinates come that should be mm, and how many mm they are.
const MISTAKEN: [(&str, f64); 3] = [("metres", 1e3), ("centimetres", 10.), ("micrometres", 1e-3)];

/// Holds the `points` (mm) of `what` against the box around `mesh`.
///
/// # Errors
/// [`FaceFileErrorKind::Size`] or [`FaceFileErrorKind::Elsewhere`].
pub(super) fn check<'a>(
    what: &'static str,
    points: impl IntoIterator<Item = &'a Vec3>,
    mesh: &Mesh,
) -> Result<(), FaceFileErrorKind> {
    let (own, face) = (Extent::of(points), mesh.extent());
    check_size(what, &own, &face, LIKELY)?;
    let (gap_mm, mesh_mm) = (own.gap_mm(&face), face.longest_mm());
    if gap_mm > mesh_mm && gap_mm.is_finite() {
        return Err(FaceFileErrorKind::Elsewhere { what, gap_mm, mesh_mm });
    }
    Ok(())
}

/// The same for something that may be as large and as far away as it likes.
///
/// # Errors
/// [`FaceFileErrorKind::Size`].
pub(super) fn check_least<'a>(
    what: &'static str,
    points: impl IntoIterator<Item = &'a Vec3>,
    mesh: &Mesh,
) -> Result<(), FaceFileErrorKind> {
    check_size(what, &Extent::of(points), &mesh.extent(), [LIKELY[0], f64::INFINITY])
}

fn check_size(
    what: &'static str,
    own: &Extent,
    face: &Extent,
    [least, most]: [f64; 2],
) -> Result<(), FaceFileErrorKind> {
    let (size_mm, mesh_mm) = (own.longest_mm(), face.longest_mm());
    let ratio = size_mm / mesh_mm;
    // One place, or none, has no size.
    if size_mm <= 0. || (least..=most).contains(&ratio) {
        return Ok(());
    }
    let off = |in_mm: f64| (ratio * in_mm).ln().abs();
    let fitting =
        MISTAKEN.into_iter().filter(|(_, in_mm)| (LIKELY[0]..=LIKELY[1]).contains(&(ratio * in_mm)));
    let unit = fitting.min_by(|a, b| off(a.1).total_cmp(&off(b.1)));
    Err(FaceFileErrorKind::Size { what, size_mm, mesh_mm, unit: unit.map(|(name, _)| name) })
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::mesh::{Cell, CellKind};

    fn told(scale: f64, shift: f64) -> String {
        let points: Vec<Vec3> =
            [[0., 0., 0.], [20., 0., 0.], [0., 20., 0.], [0., 0., 20.]].map(Vec3::from).into();
        let moved: Vec<Vec3> = points.iter().map(|p| scale * p + Vec3::repeat(shift)).collect();
        let mesh = Mesh::new(points, vec![Cell::new(CellKind::Tet4, &[0, 1, 2, 3])]);
        check("it", &moved, &mesh).map_or_else(|kind| kind.to_string(), |()| String::new())
    }

    #[test]
    fn units_and_places_that_cannot_be_are_told_with_the_unit_that_could() {
        for (scale, shift, words) in [
            (1., 0., ""),
            (0.1, 15., ""),
            (1e-3, 0., "0.020 mm across where the mesh measures 20 mm: metres?"),
            (1e-2, 0., "centimetres?"),
            (1e3, 0., "micrometres?"),
            (1e160, 0., "measures"),
            (1., 400., "lies 380 mm away from the mesh"),
        ] {
            let told = told(scale, shift);
            assert!(told.contains(words) && told.is_empty() == words.is_empty(), "{scale} {shift}: {told}");
        }
    }
}
