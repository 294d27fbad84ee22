//! Which tissue is muscle, and along which direction its fibres run.

use std::collections::HashMap;

use crate::face::{Fibre, Muscle};
use crate::units::Vec3;

/// Distances, as shares of a radius, that rounding makes differ: of fibres so equally near the first one counts, on
/// either side of a symmetric face.
const TIE: f64 = 1e-9;

/// The muscle at a material point.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct InMuscle {
    /// Its number.
    pub(crate) muscle: usize,
    /// Unit direction of its nearest fibre at the nearest point.
    pub(crate) direction: Vec3,
    /// Share of the muscle's tension that this fibre carries there: less than 1 along the insertion.
    pub(crate) share: f64,
}

/// What each point belongs to; `None` is passive tissue.
pub(crate) type MuscleAt = Option<InMuscle>;

/// For each point the muscle that it belongs to: the one whose nearest fibre is closest in units of
/// the muscle's radius, if that is at most 1.
pub(crate) fn muscle_at(points: &[Vec3], muscles: &[Muscle]) -> Vec<MuscleAt> {
    let cell = muscles.iter().map(|m| m.radius_mm).fold(1e-3, f64::max);
    let key = |p: &Vec3| (p / cell).map(|x| x.floor() as i64);
    let mut grid: HashMap<[i64; 3], Vec<usize>> = HashMap::new();
    for (i, p) in points.iter().enumerate() {
        grid.entry(key(p).into()).or_default().push(i);
    }
    let mut nearest = vec![f64::INFINITY; points.len()];
    let mut found: Vec<MuscleAt> = vec![None; points.len()];
    for (index, muscle) in muscles.iter().enumerate() {
        for fibre in &muscle.fibres {
            let n = fibre.points.len();
            let tangents = tangents(fibre);
            let shares = fibre.tension_shares(muscle.insertion_mm);
            for i in 0..if fibre.closed { n } else { n.saturating_sub(1) } {
                let (a, b) = (fibre.points[i], fibre.points[(i + 1) % n]);
                if a == b {
                    continue;
                }
                let ends = [tangents[i], tangents[(i + 1) % n]];
                let reach = Vec3::repeat(muscle.radius_mm);
                let (lo, hi) = (key(&(a.inf(&b) - reach)), key(&(a.sup(&b) + reach)));
                for x in lo.x..=hi.x {
                    for y in lo.y..=hi.y {
                        for z in lo.z..=hi.z {
                            for &p in grid.get(&[x, y, z]).into_iter().flatten() {
                                let (t, distance) = nearest_on_segment(points[p], a, b);
                                let distance = distance / muscle.radius_mm;
                                let direction = (1. - t) * ends[0] + t * ends[1];
                                if distance <= 1.
                                    && distance < nearest[p] - TIE
                                    && let Some(direction) = direction.try_normalize(0.)
                                {
                                    nearest[p] = distance;
                                    let share = shares[i];
                                    found[p] = Some(InMuscle { muscle: index, direction, share });
                                }
                            }
                        }
                    }
                }
            }
        }
    }
    found
}

/// Direction of the fibre at each of its points, between those of the segments that meet there: a point
/// outside a bend is as near to one segment as to the next, and must not take the one that comes first.
fn tangents(fibre: &Fibre) -> Vec<Vec3> {
    let points = &fibre.points;
    let n = points.len();
    let segment = |i: usize| {
        let along = points[(i + 1) % n] - points[i % n];
        along.try_normalize(0.).unwrap_or_else(Vec3::zeros)
    };
    let at = |i: usize| {
        let before = if i > 0 || fibre.closed { segment(i + n - 1) } else { Vec3::zeros() };
        let after = if i + 1 < n || fibre.closed { segment(i) } else { Vec3::zeros() };
        (before + after).try_normalize(1e-9).unwrap_or(after)
    };
    (0..n).map(at).collect()
}

/// Place, from 0 at `a` to 1 at `b`, of the segment's point nearest to `p`, and its distance.
fn nearest_on_segment(p: Vec3, a: Vec3, b: Vec3) -> (f64, f64) {
    let d = b - a;
    let t = ((p - a).dot(&d) / d.norm_squared()).clamp(0., 1.);
    (t, (p - a - t * d).norm())
}
