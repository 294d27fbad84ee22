//! The inside of the mouth, behind the teeth.

use super::colour::{Rgb, mix, srgb};
use super::solid::Solid;
use crate::face::Teeth;
use crate::units::Vec3;

/// How far within the outer faces of the teeth its walls stand, mm.
const INSET_MM: f64 = 2.;
/// Panels round the arch, and from front to back.
const AROUND: usize = 24;
const DEEP: usize = 8;

/// Colours at the front and at the back: light hardly gets there.
fn colours() -> (Rgb, Rgb) {
    (srgb(112, 44, 44), srgb(22, 7, 8))
}

/// The outline of an arch: half an ellipse in the horizontal plane, at the height where its roots end.
#[derive(Clone, Copy)]
struct Arch {
    middle_mm: f64,
    half_mm: f64,
    front_mm: f64,
    back_mm: f64,
    height_mm: f64,
}

impl Arch {
    /// That of some `teeth`; `None` where they are too small to go round anything.
    fn of(teeth: &[&Teeth], upper: bool) -> Option<Self> {
        let points = || teeth.iter().flat_map(|teeth| &teeth.surface.points);
        let (lo, hi) = points()
            .fold((Vec3::repeat(f64::MAX), Vec3::repeat(f64::MIN)), |(lo, hi), p| (lo.inf(p), hi.sup(p)));
        let arch = Self {
            middle_mm: 0.5 * (lo.x + hi.x),
            half_mm: 0.5 * (hi.x - lo.x) - INSET_MM,
            front_mm: hi.z - INSET_MM,
            back_mm: lo.z,
            height_mm: if upper { hi.y } else { lo.y },
        };
        (arch.half_mm > 0. && arch.front_mm > arch.back_mm).then_some(arch)
    }

    fn at(&self, angle: f64) -> Vec3 {
        let (sin, cos) = angle.sin_cos();
        let z = self.back_mm + cos * (self.front_mm - self.back_mm);
        Vec3::new(self.middle_mm + sin * self.half_mm, self.height_mm, z)
    }
}

/// Adds the walls, the roof, the floor and the back of the mouth between the arches of `teeth`, of which those that the viewer
/// sees from outside, where `is_seen` holds of what points outward, are left out: the mouth is open to who looks into it.
/// Nothing where one of the arches is not there.
pub(super) fn cavity(teeth: &[Teeth], is_seen: impl Fn(Vec3) -> bool, solid: &mut Solid) {
    let of = |upper: bool| {
        let own: Vec<&Teeth> = teeth.iter().filter(|t| t.upper == upper).collect();
        Arch::of(&own, upper)
    };
    let (Some(upper), Some(lower)) = (of(true), of(false)) else { return };
    let (front, back) = colours();
    let ends = [upper.front_mm.max(lower.front_mm), upper.back_mm.min(lower.back_mm)];
    let centre = Vec3::new(
        0.5 * (upper.middle_mm + lower.middle_mm),
        0.5 * (upper.height_mm + lower.height_mm),
        0.5 * (ends[0] + ends[1]),
    );
    let mut panel = |[a, b, c, d]: [Vec3; 4]| {
        let middle = 0.25 * (a + b + c + d);
        let normal = (c - a).cross(&(d - b));
        if is_seen(if normal.dot(&(middle - centre)) < 0. { -normal } else { normal }) {
            return;
        }
        let depth = (ends[0] - middle.z) / (ends[0] - ends[1]);
        let colour = mix(front, back, depth.clamp(0., 1.).sqrt() as f32);
        solid.quad([a, b, c, d], colour);
    };
    let quarter = std::f64::consts::FRAC_PI_2;
    let angle = |k: usize| quarter * (2. * k as f64 / AROUND as f64 - 1.);
    for k in 0..AROUND {
        let (from, to) = (angle(k), angle(k + 1));
        let [a, b] = [from, to].map(|angle| [upper.at(angle), lower.at(angle)]);
        panel([a[0], a[1], b[1], b[0]]);
        // Roof and floor in strips from the front to the back.
        for (arch, rim) in [(&upper, [a[0], b[0]]), (&lower, [a[1], b[1]])] {
            let towards = |p: Vec3, share: f64| Vec3::new(p.x, p.y, p.z + share * (arch.back_mm - p.z));
            for step in 0..DEEP {
                let [near, far] = [step, step + 1].map(|s| s as f64 / DEEP as f64);
                panel([
                    towards(rim[0], near),
                    towards(rim[1], near),
                    towards(rim[1], far),
                    towards(rim[0], far),
                ]);
            }
        }
        let rear = |arch: &Arch, p: Vec3| Vec3::new(p.x, p.y, arch.back_mm);
        panel([rear(&upper, a[0]), rear(&upper, b[0]), rear(&lower, b[1]), rear(&lower, a[1])]);
    }
}
