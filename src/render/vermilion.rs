//! Where the red of the lips is.

use crate::face::Face;
use crate::units::Vec3;

/// The border from the subject's right corner over the upper lip to the left one and back.
const BORDER: [(&str, bool); 10] = [
    ("cheilion_r", true),
    ("upper_lip_lateral_r", false),
    ("crista_philtri_r", false),
    ("labiale_superius", true),
    ("crista_philtri_l", false),
    ("upper_lip_lateral_l", false),
    ("cheilion_l", true),
    ("lower_lip_lateral_l", false),
    ("labiale_inferius", true),
    ("lower_lip_lateral_r", false),
];
/// Points of the curve from one landmark to the next.
const PIECES: usize = 8;
/// Width over which red fades into skin, mm.
const SOFT_MM: f64 = 0.9;

/// The outline of the vermilion, seen from the front of the face at rest.
#[derive(Clone, Debug, Default)]
pub(super) struct Vermilion {
    outline: Vec<[f64; 2]>,
    box_mm: [f64; 4],
}

impl Vermilion {
    /// The outline through the face's lip landmarks; empty when corners or mid-points are missing.
    pub(super) fn new(face: &Face) -> Self {
        let mut stops: Vec<([f64; 2], bool)> = Vec::new();
        for (name, needed) in BORDER {
            match face.landmark(name) {
                Some(l) => stops.push(([l.site.position.x, l.site.position.y], name.starts_with("cheilion"))),
                None if needed => return Self::default(),
                None => {}
            }
        }
        let n = stops.len();
        let mut outline = Vec::with_capacity(n * PIECES);
        for k in 0..n {
            let [before, a, b, after] = [k + n - 1, k, k + 1, k + 2].map(|j| stops[j % n]);
            for piece in 0..PIECES {
                let t = piece as f64 / PIECES as f64;
                outline.push([0, 1].map(|c| {
                    let (a0, b0) = (a.0[c], b.0[c]);
                    // The corner of the mouth is sharp: each lip's curve ends there.
                    let from = if a.1 { b0 - a0 } else { (b0 - before.0[c]) / 2. };
                    let to = if b.1 { b0 - a0 } else { (after.0[c] - a0) / 2. };
                    let (t2, t3) = (t * t, t * t * t);
                    (2. * t3 - 3. * t2 + 1.) * a0
                        + (t3 - 2. * t2 + t) * from
                        + (3. * t2 - 2. * t3) * b0
                        + (t3 - t2) * to
                }));
            }
        }
        let bounds =
            |c: usize| outline.iter().fold((f64::MAX, f64::MIN), |(lo, hi), p| (p[c].min(lo), p[c].max(hi)));
        let ((x0, x1), (y0, y1)) = (bounds(0), bounds(1));
        let box_mm = [x0 - SOFT_MM, x1 + SOFT_MM, y0 - SOFT_MM, y1 + SOFT_MM];
        Self { outline, box_mm }
    }

    /// Share of red, 0 to 1, at the point that rests at `p` (mm).
    pub(super) fn share(&self, p: Vec3) -> f32 {
        let [x0, x1, y0, y1] = self.box_mm;
        if self.outline.is_empty() || p.x < x0 || p.x > x1 || p.y < y0 || p.y > y1 {
            return 0.;
        }
        let n = self.outline.len();
        let (mut inside, mut nearest) = (false, f64::MAX);
        for k in 0..n {
            let (a, b) = (self.outline[k], self.outline[(k + 1) % n]);
            if (a[1] > p.y) != (b[1] > p.y) && p.x < a[0] + (p.y - a[1]) / (b[1] - a[1]) * (b[0] - a[0]) {
                inside = !inside;
            }
            let (dx, dy) = (b[0] - a[0], b[1] - a[1]);
            let length = dx * dx + dy * dy;
            let t = if length > 0. {
                (((p.x - a[0]) * dx + (p.y - a[1]) * dy) / length).clamp(0., 1.)
            } else {
                0.
            };
            nearest = nearest.min((p.x - a[0] - t * dx).hypot(p.y - a[1] - t * dy));
        }
        let signed = if inside { nearest } else { -nearest };
        let t = (0.5 + 0.5 * signed / SOFT_MM).clamp(0., 1.);
        (t * t * (3. - 2. * t)) as f32
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::face::{standard, standard::Resolution};

    #[test]
    fn lips_are_red_between_their_borders_only() {
        let face = standard(&Resolution::COARSE);
        let red = Vermilion::new(&face);
        assert!(red.share(Vec3::new(0., 3., 0.)) > 0.99 && red.share(Vec3::new(-8., -4., 0.)) > 0.99);
        for p in [[0., 15., 0.], [0., -15., 0.], [30., 0., 0.], [-30., 0., 0.]] {
            assert_eq!(red.share(Vec3::from(p)), 0., "{p:?}");
        }
        let at = face.landmark("labiale_superius").expect("a landmark").site.position;
        assert!((red.share(at) - 0.5).abs() < 0.05);
    }
}
