//! Fibres brought inside the tissue.

use super::Fibre;
use super::curve::resample;
use crate::mesh::Locator;
use crate::units::Vec3;

/// Points nearer than this to the one before are dropped after projection, mm: several points of a
/// fibre may land on one point of the boundary, and a step without length has no direction.
const LEAST_STEP_MM: f64 = 0.1;

/// Rounds of smoothing and projection of a fibre that was outside, and means a round: enough to join the
/// two sides of a gap that the fibre jumped, too few to straighten a muscle.
const REPAIRS: usize = 3;
const SMOOTHINGS: usize = 4;

/// How much of some fibres lay outside the mesh.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Projected {
    /// Points outside.
    pub outside: usize,
    /// Points in all.
    pub points: usize,
    /// Greatest distance from the mesh, mm.
    pub largest_mm: f64,
}

/// A fibre point too far from the mesh to be projected.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct TooFar {
    /// The point, mm.
    pub point: Vec3,
    /// Its distance from the mesh, mm; NaN when the point is not finite.
    pub distance_mm: f64,
}

/// `points` as a fibre inside the mesh, of steps of about `step_mm`: points outside are moved to the
/// closest point of the boundary, and counted in `projected`; a fibre of which some were outside is then
/// smoothed, since neighbours may land far apart, and brought inside again.
///
/// # Errors
/// [`TooFar`], the farthest point when any is farther than `limit_mm` outside.
pub fn embed(
    points: &[Vec3],
    closed: bool,
    locator: &Locator,
    limit_mm: f64,
    step_mm: f64,
    projected: &mut Projected,
) -> Result<Fibre, TooFar> {
    let mut worst: Option<TooFar> = None;
    let mut outside = 0;
    for &point in points {
        let distance_mm = locator.locate(point).map_or(f64::NAN, |found| found.distance_mm);
        if distance_mm.is_nan() {
            return Err(TooFar { point, distance_mm });
        }
        outside += usize::from(distance_mm > 0.);
        projected.largest_mm = projected.largest_mm.max(distance_mm);
        if distance_mm > limit_mm && worst.is_none_or(|w| distance_mm > w.distance_mm) {
            worst = Some(TooFar { point, distance_mm });
        }
    }
    if let Some(worst) = worst {
        return Err(worst);
    }
    projected.points += points.len();
    projected.outside += outside;
    let mut inside = brought_inside(points, closed, locator);
    if outside > 0 && step_mm > 0. {
        for _ in 0..REPAIRS {
            let smooth = smoothed(&inside, closed);
            let curve = if closed { [smooth.as_slice(), &smooth[..1]].concat() } else { smooth };
            if curve.len() < 2 {
                break;
            }
            inside = brought_inside(&resample(&curve, closed, step_mm), closed, locator);
        }
    }
    Ok(Fibre { points: inside, closed })
}

fn brought_inside(points: &[Vec3], closed: bool, locator: &Locator) -> Vec<Vec3> {
    let mut inside: Vec<Vec3> = Vec::with_capacity(points.len());
    for p in points.iter().filter_map(|p| locator.locate(*p)).map(|found| found.site.position) {
        if inside.last().is_none_or(|last| (p - last).norm() >= LEAST_STEP_MM) {
            inside.push(p);
        }
    }
    while closed && inside.len() > 1 && (inside[inside.len() - 1] - inside[0]).norm() < LEAST_STEP_MM {
        inside.pop();
    }
    inside
}

/// Repeated means of each point with its neighbours; open ends stay.
fn smoothed(points: &[Vec3], closed: bool) -> Vec<Vec3> {
    let n = points.len();
    let mut now = points.to_vec();
    for _ in 0..SMOOTHINGS {
        let last = now.clone();
        for (k, p) in now.iter_mut().enumerate() {
            let at_end = k == 0 || k + 1 == n;
            if closed || !at_end {
                *p = 0.25 * last[(k + n - 1) % n] + 0.5 * last[k] + 0.25 * last[(k + 1) % n];
            }
        }
    }
    now
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::mesh::{Cell, CellKind, Mesh};

    fn locator() -> Locator {
        let points = [[0., 0., 0.], [9., 0., 0.], [9., 9., 0.], [0., 9., 0.]];
        let points = points.iter().chain(&[[0., 0., 9.], [9., 0., 9.], [9., 9., 9.], [0., 9., 9.]]);
        let nodes: Vec<usize> = (0..8).collect();
        Locator::new(&Mesh::new(
            points.map(|p| Vec3::from(*p)).collect(),
            vec![Cell::new(CellKind::Hex8, &nodes)],
        ))
    }

    #[test]
    fn points_inside_stay_and_points_outside_are_moved_counted_and_limited() {
        let line: Vec<Vec3> = (0..=9).map(|k| Vec3::new(4., 4., f64::from(k) + 1.5)).collect();
        let mut projected = Projected::default();
        let fibre = embed(&line, false, &locator(), 2., 1., &mut projected).expect("near enough");
        assert_eq!((projected.outside, projected.points, projected.largest_mm), (2, 10, 1.5));
        assert!(fibre.points.iter().all(|p| p.z <= 9.));
        assert!((fibre.points[0] - line[0]).norm() < 1e-9);
        let far = embed(&line, false, &locator(), 1., 1., &mut projected).expect_err("too far");
        assert_eq!((far.distance_mm, far.point), (1.5, line[9]));
        let nan = [Vec3::repeat(f64::NAN), line[0]];
        assert!(embed(&nan, false, &locator(), 2., 1., &mut projected).is_err());
        let inside = &line[..6];
        assert_eq!(
            embed(inside, false, &locator(), 2., 1., &mut projected).expect("near enough").points,
            inside
        );
    }
}
