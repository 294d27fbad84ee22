//! Light on skin, teeth and muscles.

use super::colour::Rgb;
use crate::units::Vec3;

/// Lights in the picture's axes (right, up, towards the viewer) with their strengths.
const LIGHTS: [([f64; 3], f32); 3] =
    [([-0.45, 0.62, 0.65], 0.72), ([0.75, 0.15, 0.55], 0.24), ([0., -0.6, 0.5], 0.06)];
/// Light from everywhere: from below and from above.
const AMBIENT: (f32, f32) = (0.20, 0.34);
/// Its tint: a warm room.
const TINT: Rgb = [1.06, 0.97, 0.93];

/// How a material takes light.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct Finish {
    /// How far light bleeds round into the shade, for red, green and blue: it does in skin.
    pub(super) bleed: Rgb,
    /// Strength of the gloss.
    pub(super) gloss: f32,
    /// Sharpness of the gloss.
    pub(super) polish: f32,
}

/// Skin.
pub(super) const SKIN: Finish = Finish { bleed: [0.38, 0.27, 0.22], gloss: 0.045, polish: 14. };
/// The red of the lips.
pub(super) const LIP: Finish = Finish { bleed: [0.35, 0.2, 0.18], gloss: 0.12, polish: 32. };
/// Teeth.
pub(super) const ENAMEL: Finish = Finish { bleed: [0.3; 3], gloss: 0.25, polish: 50. };
/// What is drawn to be read rather than looked at.
pub(super) const MATT: Finish = Finish { bleed: [0.5; 3], gloss: 0., polish: 1. };

/// The light that leaves a surface of `albedo` with unit normal `n` (picture's axes) towards the viewer;
/// `open` is the share of the surroundings that it sees.
pub(super) fn shade(albedo: Rgb, finish: Finish, n: Vec3, open: f32) -> Rgb {
    let n = if n.z < 0. { -n } else { n };
    let up = (0.5 + 0.5 * n.y) as f32;
    let ambient = AMBIENT.0 + up * (AMBIENT.1 - AMBIENT.0);
    let mut light = TINT.map(|t| t * ambient * open);
    let mut gloss = 0.;
    for (direction, strength) in LIGHTS {
        let l = Vec3::from(direction).normalize();
        let facing = n.dot(&l) as f32;
        for (light, bleed) in light.iter_mut().zip(finish.bleed) {
            *light += strength * (0.35 + 0.65 * open) * ((facing + bleed) / (1. + bleed)).max(0.);
        }
        let half = (l + Vec3::z()).normalize();
        gloss += strength * open * (n.dot(&half).max(0.) as f32).powf(finish.polish);
    }
    [0, 1, 2].map(|k| albedo[k] * light[k] + finish.gloss * gloss)
}
