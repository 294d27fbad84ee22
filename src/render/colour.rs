//! Colours, and the map from lengths to colours.

/// A colour in linear light: red, green, blue from 0 to 1.
pub type Rgb = [f32; 3];

/// The colour of eight-bit sRGB values.
pub fn srgb(red: u8, green: u8, blue: u8) -> Rgb {
    [red, green, blue].map(|c| {
        let c = f32::from(c) / 255.;
        if c <= 0.04045 { c / 12.92 } else { ((c + 0.055) / 1.055).powf(2.4) }
    })
}

/// The eight-bit sRGB values of a colour; what is out of range is cut.
pub fn to_srgb(colour: Rgb) -> [u8; 3] {
    colour.map(|c| {
        let c = c.clamp(0., 1.);
        let c = if c <= 0.003_130_8 { 12.92 * c } else { 1.055 * c.powf(1. / 2.4) - 0.055 };
        (255. * c).round() as u8
    })
}

/// `a` towards `b` by `share` (0 to 1).
pub fn mix(a: Rgb, b: Rgb, share: f32) -> Rgb {
    [0, 1, 2].map(|k| a[k] + share * (b[k] - a[k]))
}

/// Where the map starts and ends: lightness, chroma at the middle, and hue in degrees.
const LIGHTNESS: (f64, f64) = (0.94, 0.30);
const CHROMA: f64 = 0.15;
const HUE: (f64, f64) = (95., -75.);
/// Pieces in which the length of the map's path is measured.
const PIECES: usize = 256;

/// A perceptually uniform map from pale yellow through red to dark violet: equal steps of the value are equal
/// steps in `OKLab`, and lightness falls all along, so that it also reads in grey.
#[derive(Clone, Debug)]
pub struct ColourMap {
    path: Vec<[f64; 3]>,
}

impl ColourMap {
    /// The map.
    pub fn new() -> Self {
        let at = |t: f64| {
            let chroma = 0.05 + CHROMA * (std::f64::consts::PI * t).sin().powf(0.8);
            let (sin, cos) = (HUE.0 + t * (HUE.1 - HUE.0)).to_radians().sin_cos();
            [LIGHTNESS.0 + t * (LIGHTNESS.1 - LIGHTNESS.0), chroma * cos, chroma * sin]
        };
        let raw: Vec<[f64; 3]> = (0..=PIECES).map(|k| at(k as f64 / PIECES as f64)).collect();
        let mut length = vec![0.; raw.len()];
        for k in 1..raw.len() {
            length[k] = length[k - 1] + distance(raw[k - 1], raw[k]);
        }
        let whole = length[PIECES];
        let path = (0..=PIECES)
            .map(|k| {
                let wanted = whole * k as f64 / PIECES as f64;
                let j = length.partition_point(|l| *l < wanted).clamp(1, PIECES);
                let t = (wanted - length[j - 1]) / (length[j] - length[j - 1]);
                [0, 1, 2].map(|c| raw[j - 1][c] + t * (raw[j][c] - raw[j - 1][c]))
            })
            .collect();
        Self { path }
    }

    /// The colour at `share` of the range, cut to 0 and 1; NaN is 0.
    pub fn at(&self, share: f64) -> Rgb {
        from_oklab(self.oklab(share))
    }

    fn oklab(&self, share: f64) -> [f64; 3] {
        let t = if share.is_nan() { 0. } else { share.clamp(0., 1.) } * PIECES as f64;
        let k = (t as usize).min(PIECES - 1);
        let f = t - k as f64;
        [0, 1, 2].map(|c| self.path[k][c] + f * (self.path[k + 1][c] - self.path[k][c]))
    }
}

impl Default for ColourMap {
    fn default() -> Self {
        Self::new()
    }
}

fn distance(a: [f64; 3], b: [f64; 3]) -> f64 {
    (0..3).map(|k| (a[k] - b[k]).powi(2)).sum::<f64>().sqrt()
}

/// Linear light of an `OKLab` colour. Source: B. Ottosson, "A perceptual color space for image processing", 2020.
fn from_oklab([l, a, b]: [f64; 3]) -> Rgb {
    let cone = |ka: f64, kb: f64| (l + ka * a + kb * b).powi(3);
    let long = cone(0.396_337_777_4, 0.215_803_757_3);
    let medium = cone(-0.105_561_345_8, -0.063_854_172_8);
    let short = cone(-0.089_484_177_5, -1.291_485_548);
    [
        4.076_741_662_1 * long - 3.307_711_591_3 * medium + 0.230_969_929_2 * short,
        -1.268_438_004_6 * long + 2.609_757_401_1 * medium - 0.341_319_396_5 * short,
        -0.004_196_086_3 * long - 0.703_418_614_7 * medium + 1.707_614_701 * short,
    ]
    .map(|c| c.clamp(0., 1.) as f32)
}

/// A colour that tells the `index`-th of several things from its neighbours: hues a golden angle apart at
/// two lightnesses.
pub fn distinct(index: usize) -> Rgb {
    let hue = (20. + 137.508 * index as f64).to_radians();
    let lightness = if index.is_multiple_of(2) { 0.62 } else { 0.50 };
    from_oklab([lightness, 0.15 * hue.cos(), 0.15 * hue.sin()])
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_map_starts_pale_ends_dark_and_holds_its_ends() {
        let map = ColourMap::new();
        let luminance = |c: Rgb| 0.2126 * c[0] + 0.7152 * c[1] + 0.0722 * c[2];
        assert!(luminance(map.at(0.)) > 0.7 && luminance(map.at(1.)) < 0.06);
        assert_eq!(map.at(-3.), map.at(0.));
        assert_eq!(map.at(7.), map.at(1.));
        assert_eq!(map.at(f64::NAN), map.at(0.));
        let falls = (0..100)
            .all(|k| luminance(map.at(f64::from(k) / 100.)) > luminance(map.at(f64::from(k + 1) / 100.)));
        assert!(falls, "lightness falls all along");
    }

    #[test]
    fn equal_steps_look_equal() {
        let map = ColourMap::new();
        let steps: Vec<f64> = (0..50)
            .map(|k| distance(map.oklab(f64::from(k) / 50.), map.oklab(f64::from(k + 1) / 50.)))
            .collect();
        let mean = steps.iter().sum::<f64>() / 50.;
        assert!(steps.iter().all(|s| (s / mean - 1.).abs() < 0.02), "{steps:?}");
    }

    #[test]
    fn eight_bits_come_back() {
        for v in 0..=255 {
            assert_eq!(to_srgb(srgb(v, 255 - v, 7)), [v, 255 - v, 7]);
        }
    }

    #[test]
    fn oklab_white_is_white() {
        assert!(from_oklab([1., 0., 0.]).iter().all(|c| (c - 1.).abs() < 1e-3));
    }
}
