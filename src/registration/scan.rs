//! The scan made ready: the parts that are the face, facing outward, no finer than the match needs.

use std::collections::BTreeMap;

use super::sheet::{Groups, Sheet};
use super::{RegistrationError, RegistrationWarning};
use crate::mesh::{Extent, Surface};
use crate::units::Vec3;

/// How far beyond the face the scan is kept, mm.
const MARGIN_MM: f64 = 25.;
/// Triangles above which it is thinned, and the side of the cells in which vertices are then joined, mm.
const MANY: usize = 300_000;
const SPACING_MM: f64 = 0.8;
/// Most vertices that are drawn from the scan to the skin.
const MOST_DRAWN: usize = 15_000;
/// Distance beyond which a landmark is no point of the scan, mm.
pub(super) const OFF_MM: f64 = 3.;

/// The scan in the axes of the face.
pub(super) struct Scan {
    pub(super) sheet: Sheet,
    /// The vertices that correspond to something on the skin.
    pub(super) drawn: Vec<usize>,
}

impl Scan {
    /// `surface` (mm, in the face's axes) with the `landmarks` on it, about a face of `extent`.
    ///
    /// # Errors
    /// [`RegistrationError`] for a scan without triangles, and landmarks that are not on it.
    pub(super) fn new(
        surface: Surface,
        landmarks: &[Vec3],
        extent: Extent,
        warnings: &mut Vec<RegistrationWarning>,
    ) -> Result<Self, RegistrationError> {
        if !surface.points.iter().flatten().all(|x| x.is_finite()) {
            return Err(RegistrationError::NotFinite { what: "the scan".into() });
        }
        if surface.triangles.is_empty() {
            return Err(RegistrationError::EmptyScan);
        }
        let sheet = Sheet::new(surface);
        let feet: Vec<_> = landmarks.iter().map(|&p| sheet.nearest(p, None, f64::INFINITY)).collect();
        let mut distances: Vec<f64> = feet.iter().flatten().map(|foot| foot.distance_mm).collect();
        distances.sort_by(f64::total_cmp);
        let off = distances.iter().filter(|d| **d > OFF_MM).count();
        if 3 * off > landmarks.len() {
            let median_mm = distances[distances.len() / 2];
            return Err(RegistrationError::OffScan {
                off,
                landmarks: landmarks.len(),
                limit_mm: OFF_MM,
                median_mm,
            });
        }
        let marked = feet.iter().flatten().filter(|foot| foot.distance_mm <= OFF_MM);
        let marked: Vec<usize> = marked.map(|foot| foot.carriers[0].0).collect();
        let surface = about(&marked_pieces(sheet, &marked, warnings), extent);
        let triangles = surface.triangles.len();
        let surface = if triangles > MANY { thinned(&surface) } else { surface };
        if surface.triangles.len() < triangles {
            let kept = surface.triangles.len();
            warnings.push(RegistrationWarning::Thinned { triangles, kept, spacing_mm: SPACING_MM });
        }
        let sheet = Sheet::new(surface);
        let n = sheet.surface.points.len();
        let drawn = (0..n).step_by(n.div_ceil(MOST_DRAWN).max(1)).collect();
        Ok(Self { sheet, drawn })
    }

    /// The same with triangles the other way round.
    pub(super) fn turned(self) -> Self {
        let mut surface = self.sheet.surface;
        surface.triangles.iter_mut().for_each(|t| t.swap(1, 2));
        Self { sheet: Sheet::new(surface), drawn: self.drawn }
    }
}

/// The pieces that hold a vertex of `marked`.
fn marked_pieces(sheet: Sheet, marked: &[usize], warnings: &mut Vec<RegistrationWarning>) -> Surface {
    let mut groups = Groups::new(sheet.surface.points.len());
    for &[a, b, c] in &sheet.surface.triangles {
        groups.join(a, b);
        groups.join(a, c);
    }
    let mut areas: BTreeMap<usize, f64> = BTreeMap::new();
    for t in &sheet.surface.triangles {
        for &v in t {
            *areas.entry(groups.of(v)).or_default() += sheet.areas[v];
        }
    }
    let marked: Vec<usize> = marked.iter().map(|&v| groups.of(v)).collect();
    let total: f64 = areas.values().sum();
    let left: f64 = areas.iter().filter(|(piece, _)| !marked.contains(piece)).map(|(_, area)| area).sum();
    let Surface { points, mut triangles } = sheet.surface;
    triangles.retain(|t| marked.contains(&groups.of(t[0])));
    if left > 1e-3 * total {
        warnings.push(RegistrationWarning::Pieces { pieces: areas.len(), share: left / total });
    }
    compact(&points, triangles)
}

/// What lies about `extent`.
fn about(surface: &Surface, extent: Extent) -> Surface {
    let (lo, hi) = (extent.lo.add_scalar(-MARGIN_MM), extent.hi.add_scalar(MARGIN_MM));
    let is_near = |v: usize| {
        let p = surface.points[v];
        (0..3).all(|k| (lo[k]..=hi[k]).contains(&p[k]))
    };
    let near = surface.triangles.iter().filter(|t| t.iter().all(|&v| is_near(v))).copied();
    compact(&surface.points, near.collect())
}

/// `surface` with the vertices in each cell of a grid joined at their mean (Rossignac and Borrel 1993).
fn thinned(surface: &Surface) -> Surface {
    let cell = |p: &Vec3| [0, 1, 2].map(|k| (p[k] / SPACING_MM).floor() as i64);
    let mut cells: BTreeMap<[i64; 3], usize> = BTreeMap::new();
    let (mut sums, mut of): (Vec<(Vec3, f64)>, Vec<usize>) = (Vec::new(), Vec::new());
    for p in &surface.points {
        let next = sums.len();
        let joined = *cells.entry(cell(p)).or_insert(next);
        if joined == next {
            sums.push((Vec3::zeros(), 0.));
        }
        sums[joined].0 += p;
        sums[joined].1 += 1.;
        of.push(joined);
    }
    let mut triangles: Vec<[usize; 3]> = surface
        .triangles
        .iter()
        .map(|t| t.map(|v| of[v]))
        .filter(|[a, b, c]| a != b && b != c && a != c)
        .map(|[a, b, c]| {
            if a < b && a < c {
                [a, b, c]
            } else if b < c {
                [b, c, a]
            } else {
                [c, a, b]
            }
        })
        .collect();
    triangles.sort_unstable();
    triangles.dedup();
    Surface { points: sums.into_iter().map(|(sum, n)| sum / n).collect(), triangles }
}

/// Without the points that no triangle has.
fn compact(points: &[Vec3], triangles: Vec<[usize; 3]>) -> Surface {
    let mut number = vec![usize::MAX; points.len()];
    let mut kept = Vec::new();
    let mut renumbered = |v: usize| {
        if number[v] == usize::MAX {
            number[v] = kept.len();
            kept.push(points[v]);
        }
        number[v]
    };
    let triangles = triangles.into_iter().map(|t| t.map(&mut renumbered)).collect();
    Surface { points: kept, triangles }
}
