//! What stands out of the featureless head: nose, lips, philtrum, chin and folds.

use super::curve::{Curve, bell, smooth_max, step};
use super::parameters::Parameters;
use crate::units::Vec3;

/// The skin's displacement from the featureless head; all functions take half widths `x >= 0`.
#[derive(Clone, Debug)]
pub(super) struct Relief {
    parameters: Parameters,
    nose_y: Curve,
    nose_z: Curve,
    ridge_width: Curve,
    ridge_power: Curve,
    upper_roll: Curve,
    lower_roll: Curve,
}

impl Relief {
    /// The relief of a face with these parameters.
    pub(super) fn new(parameters: &Parameters) -> Self {
        // Featureless height; height and rise of the nose's profile there. Heights are drawn
        // together on the underside, so that equal rows sample its length.
        const NOSE: [(f64, f64, f64); 17] = [
            (17.0, 0.0, 0.0),
            (20.0, 0.0, 0.1),
            (21.9, -0.2, 0.6),
            (24.0, -0.9, 2.8),
            (26.0, -1.7, 6.6),
            (28.0, -2.4, 11.6),
            (30.0, -2.7, 16.6),
            (32.2, -2.2, 20.7),
            (34.8, -1.2, 23.3),
            (37.8, -0.4, 24.4),
            (41.0, 0.0, 24.3),
            (45.0, 0.0, 23.4),
            (49.0, 0.0, 22.2),
            (54.0, 0.0, 20.6),
            (60.0, 0.0, 19.2),
            (66.0, 0.0, 18.3),
            (75.0, 0.0, 19.6),
        ];
        Self {
            parameters: parameters.clone(),
            nose_y: Curve::natural(&NOSE.map(|k| (k.0, k.1))),
            nose_z: Curve::natural(&NOSE.map(|k| (k.0, k.2))),
            ridge_width: Curve::monotone(&[
                (17.0, 9.0),
                (22.0, 6.6),
                (25.0, 6.4),
                (28.0, 7.6),
                (31.0, 9.4),
                (35.0, 11.2),
                (40.0, 11.8),
                (47.0, 11.4),
                (54.0, 11.0),
                (60.0, 10.2),
                (72.0, 9.6),
            ]),
            ridge_power: Curve::monotone(&[(20.0, 2.0), (28.0, 2.2), (34.0, 2.5), (42.0, 2.2), (60.0, 2.0)]),
            upper_roll: Curve::natural(&[
                (0.0, 0.0),
                (0.1, 0.38),
                (0.25, 0.70),
                (0.45, 0.93),
                (0.7, 1.0),
                (1.0, 0.91),
                (1.3, 0.70),
                (1.7, 0.46),
                (2.2, 0.24),
                (3.0, 0.0),
            ]),
            lower_roll: Curve::natural(&[
                (0.0, 0.0),
                (0.1, 0.33),
                (0.25, 0.64),
                (0.45, 0.92),
                (0.65, 1.0),
                (0.85, 0.90),
                (1.0, 0.73),
                (1.3, 0.38),
                (1.6, 0.15),
                (2.0, 0.0),
            ]),
        }
    }

    /// Half width of the mouth, mm.
    pub(super) fn mouth_half(&self) -> f64 {
        0.5 * self.parameters.mouth_width_mm
    }

    /// Height of the closed slit: it bows up beside the middle and falls towards the corners.
    pub(super) fn slit(&self, x: f64) -> f64 {
        let t = (x / self.mouth_half()).min(1.12);
        0.8 * bell(t - 0.36, 0.24) - 0.8 * bell(0.36, 0.24) * (1.0 - t) - 1.6 * t * t * t
    }

    /// 1 at the middle of the mouth, 0 at its corner and beyond.
    fn taper(&self, x: f64, power: f64) -> f64 {
        (1.0 - (x / self.mouth_half()).powi(2)).max(0.0).powf(power)
    }

    /// Height of the vermilion above the slit; Cupid's bow peaks at the philtral crests.
    pub(super) fn upper_vermilion(&self, x: f64) -> f64 {
        let crest = 0.5 * self.parameters.philtrum_width_mm;
        let bow = 0.9 * bell(x - 0.9 * crest, 3.4) - 0.9 * bell(0.9 * crest, 3.4) * bell(x, 3.0);
        (self.parameters.upper_vermilion_mm + bow) * self.taper(x, 0.62)
    }

    /// Height of the vermilion below the slit.
    pub(super) fn lower_vermilion(&self, x: f64) -> f64 {
        self.parameters.lower_vermilion_mm * self.taper(x, 0.52)
    }

    /// Displacement of the nose at featureless position `(x, y)`; the cartilage follows it in part.
    pub(super) fn nose(&self, x: f64, y: f64) -> Vec3 {
        let y = y - self.parameters.nose_shift();
        if y < 17.0 {
            return Vec3::zeros();
        }
        // Above the wings the sides run out into the cheeks.
        let foot = 0.28 * step(y, 28.0, 44.0);
        let steep = (-(x / self.ridge_width.at(y)).powf(self.ridge_power.at(y))).exp();
        let ridge = self.nose_z.at(y) * ((1.0 - foot) * steep + foot * bell(x, 16.0));
        // The wing reaches further towards the tip than towards the cheek.
        let reach = 6.8 + 2.7 * (1.0 - step(x, 9.0, 15.4));
        let off = ((x - 12.2) / reach).hypot((y - 30.4) / 7.8);
        let wing = (11.2 - 0.75 * (x - 12.2)) * (-off.powf(2.2)).exp();
        let radius = 5.5 * step(x, 1.0, 7.0) * step(y, 20.0, 25.0) * (1.0 - step(y, 42.0, 54.0));
        let rise = smooth_max(ridge, wing, radius)
            - smooth_max(0.0, 0.0, radius) * (1.0 - step(ridge.max(wing), 0.0, 6.0));
        let droop = self.nose_y.at(y) * (-(x / 15.0).powi(4)).exp();
        Vec3::new(0.0, droop + Self::base_of_nose(x, y), rise)
    }

    /// Rise of the nose's underside: a hollow for each nostril between the columella and the rim of the wing.
    fn base_of_nose(x: f64, y: f64) -> f64 {
        let hollow = 1.9 * bell(x - 6.9, 2.9) * bell(y - 26.4, 3.1);
        let columella = 0.9 * bell(x, 2.8) * bell(y - 26.5, 3.0);
        let rim = 0.7 * bell(x - 12.6, 2.6) * bell(y - 26.0, 3.0);
        hollow - columella - rim
    }

    /// How much higher than the skin's grid the cartilage under the nose's base lies, mm.
    pub(super) fn underside(&self, x: f64, y: f64) -> f64 {
        let y = y - self.parameters.nose_shift();
        let lean = step(y, 16.5, 25.0) * (1.0 - step(y, 27.0, 50.0));
        5.5 * lean * (-(x / 17.0).powi(4)).exp()
    }

    /// Rise of everything but the nose at featureless position `(x, y)`, `above` the slit, mm.
    pub(super) fn rise(&self, x: f64, y: f64, above: f64) -> f64 {
        self.lips(x, above) + self.philtrum(x, y) + self.chin(x, y) + self.cheek(x, y)
    }

    fn lips(&self, x: f64, above: f64) -> f64 {
        let roll = if above >= 0.0 {
            let border = self.upper_vermilion(x).max(0.35);
            let e = if above < border { above / border } else { 1.0 + (above - border) / 8.0 };
            (5.3 * self.taper(x, 0.55) + 0.5 * bell(x, 3.5) * bell(above - 3.0, 2.5)) * self.upper_roll.at(e)
        } else {
            let border = self.lower_vermilion(x).max(0.35);
            let e = if -above < border { -above / border } else { 1.0 + (-above - border) / 8.5 };
            4.6 * self.taper(x, 0.5) * self.lower_roll.at(e)
        };
        // The slit lies a little below the rolls even at the corner, which is a dimple.
        roll - 1.6 * bell(x - self.mouth_half() - 0.6, 3.6) * bell(above, 4.2)
    }

    fn philtrum(&self, x: f64, y: f64) -> f64 {
        let (top, bottom) = (self.parameters.upper_lip_mm, self.parameters.upper_vermilion_mm);
        let up = ((y - bottom) / (top - bottom)).clamp(0.0, 1.0);
        let column = 0.5 * self.parameters.philtrum_width_mm * (0.9 - 0.35 * up);
        let present = step(y, bottom - 3.0, bottom + 1.0) * (1.0 - step(y, top - 4.5, top + 0.5));
        3.6 * bell(x, 13.0) * bell(y - 18.5, 8.0)
            + present * (0.85 * bell(x - column, 2.2) - 0.9 * bell(x, 2.9))
    }

    fn chin(&self, x: f64, y: f64) -> f64 {
        -2.0 * bell(y + 17.8 - 0.006 * x * x, 5.2) * bell(x, 17.0) + 4.6 * bell(y + 35.5, 9.0) * bell(x, 14.5)
            - 0.35 * bell(x, 2.6) * bell(y + 36.0, 5.0)
            - 0.8 * bell(x - 20.5, 6.0) * bell(y + 10.5, 5.0)
    }

    fn cheek(&self, x: f64, y: f64) -> f64 {
        // The nasolabial fold runs from the wing of the nose past the corner of the mouth.
        let (dx, dy) = (13.5, -30.0);
        let length: f64 = 32.9;
        let along = ((x - 20.5) * dx + (y - 27.0) * dy) / (length * length);
        let outward = ((y - 27.0) * dx - (x - 20.5) * dy) / length;
        let present = step(along, -0.12, 0.15) * (1.0 - step(along, 0.72, 1.15));
        let fold = present * (0.6 * bell(outward - 7.0, 6.0) - 0.9 * bell(outward, 3.2));
        fold + 2.2 * bell(x - 41.0, 17.0) * bell(y - 37.0, 15.0)
            - 1.2 * bell(x - 28.0, 11.0) * bell(y - 18.0, 10.0)
            + 1.0 * bell(x - self.mouth_half() - 6.5, 4.2) * bell(y + 2.0, 9.0)
            - 1.6 * bell(x - 19.8, 3.4) * bell(y - 26.0, 6.0)
            - 2.2 * bell(x - 30.0, 15.0) * bell(y - 66.0, 9.0)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_mouth_closes_at_its_corners() {
        let relief = Relief::new(&Parameters::default());
        let half = relief.mouth_half();
        assert!(relief.slit(0.0).abs() < 1e-12);
        assert_eq!((relief.upper_vermilion(half), relief.lower_vermilion(half)), (0.0, 0.0));
        assert!(relief.upper_vermilion(6.6) > relief.upper_vermilion(0.0), "Cupid's bow has two peaks");
    }

    #[test]
    fn the_relief_is_continuous() {
        let relief = Relief::new(&Parameters::default());
        let at = |x: f64, y: f64| relief.nose(x, y).z + relief.rise(x, y, y - relief.slit(x));
        let h = 0.02;
        for i in 0..80 {
            for j in 0..120 {
                let (x, y) = (f64::from(i) * 0.7, f64::from(j) * 0.9 - 50.0);
                let jump = (at(x + h, y) - at(x, y)).abs().max((at(x, y + h) - at(x, y)).abs());
                // The lips are the steepest: they rise from the slit over the first millimetre.
                assert!(jump < 6.0 * h + 0.02, "{jump} at {x} {y}");
            }
        }
    }

    #[test]
    fn the_nose_ends_at_the_cheek() {
        let relief = Relief::new(&Parameters::default());
        for y in [20.0, 30.0, 40.0] {
            assert!(relief.nose(34.0, y).norm() < 0.2, "{:?}", relief.nose(34.0, y));
        }
    }
}
