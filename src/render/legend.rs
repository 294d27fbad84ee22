//! Scale bar, colour bar, arrow of force and names of muscles.

use super::bundles::activation_colour;
use super::colour::{ColourMap, distinct, to_srgb};
use super::{Image, LETTER, LINE};

/// Width that the colour bar takes at the right, pixels.
pub(super) const BAR_SPACE: f64 = 72.;

const INK: [u8; 3] = [30; 3];

/// `x` rounded up to a number whose quarters are short: 1, 1.2, 1.6, 2, 2.4, 3.2, 4, 6 or 8 times a power of ten;
/// 1 for nothing.
pub(super) fn round_up(x: f64) -> f64 {
    if !(x > 0. && x.is_finite()) {
        return 1.;
    }
    let power = 10f64.powf(x.log10().floor());
    let fit = [1., 1.2, 1.6, 2., 2.4, 3.2, 4., 6., 8., 10.].map(|k| k * power);
    fit.into_iter().find(|v| *v >= x * (1. - 1e-9)).unwrap_or(10. * power)
}

/// The largest of 1, 2 or 5 times a power of ten that is not above `x`.
fn round_down(x: f64) -> f64 {
    let power = 10f64.powf(x.max(1e-12).log10().floor());
    [5., 2.].map(|k| k * power).into_iter().find(|v| *v <= x * (1. + 1e-9)).unwrap_or(power)
}

/// A bar of round length at the lower left.
pub(super) fn scale_bar(image: &mut Image, pixels_per_mm: f64) {
    let mm = round_down(0.25 * image.width as f64 / pixels_per_mm);
    let (length, y) = ((mm * pixels_per_mm).round() as i64, image.height as i64 - 12);
    bar(image, 8, y, length);
    image.write(8 + length + 8, y - 8, &format!("{mm} mm"), false, INK);
}

/// The length of a round force at the lower right, as long as the arrows show it.
pub(super) fn force_bar(image: &mut Image, pixels_per_n: f64) {
    let n = round_down(0.12 * image.width as f64 / pixels_per_n);
    let (length, y) = ((n * pixels_per_n).round() as i64, image.height as i64 - 12);
    let text = format!("{n} N");
    let x = image.width as i64 - 8 - (text.len() * LETTER) as i64;
    image.write(x, y - 8, &text, false, [24, 58, 140]);
    let (from, to) = (x - 8 - length, x - 8);
    image.fill(from, y - 1, length as usize, 3, [24, 58, 140]);
    for k in 0..6 {
        image.fill(to - k, y - k / 2 - 1, 1, (k + 3) as usize, [24, 58, 140]);
    }
}

fn bar(image: &mut Image, x: i64, y: i64, length: i64) {
    image.fill(x, y, length.max(1) as usize, 2, INK);
    image.fill(x, y - 4, 2, 10, INK);
    image.fill(x + length - 1, y - 4, 2, 10, INK);
}

/// The colours from 0 to `largest` mm at the right.
pub(super) fn colour_bar(image: &mut Image, largest_mm: f64) {
    let map = ColourMap::new();
    let height = (image.height / 2).max(40);
    let (x, top) = (image.width as i64 - 60, (image.height as i64 - height as i64) / 2);
    for row in 0..height {
        let share = 1. - row as f64 / (height - 1) as f64;
        image.fill(x, top + row as i64, 14, 1, to_srgb(map.at(share)));
    }
    for k in 0..=4 {
        let share = f64::from(k) / 4.;
        let y = top + ((1. - share) * (height - 1) as f64).round() as i64;
        image.fill(x + 14, y, 4, 1, INK);
        let digits = if largest_mm >= 20. {
            0
        } else if largest_mm >= 2. {
            1
        } else {
            2
        };
        image.write(x + 20, y - 8, &format!("{:.digits$}", share * largest_mm), false, INK);
    }
    image.write(x, top - 26, "mm", true, INK);
}

/// Whose side is where, seen from the front, above the scale bar; `right` pixels are taken at the right.
pub(super) fn sides(image: &mut Image, right: f64) {
    let y = image.height as i64 - 46;
    image.write(8, y, "R", true, INK);
    image.write(image.width as i64 - right as i64 - LETTER as i64, y, "L", true, INK);
}

/// The colours of activations at the upper left, below `lines` of title.
pub(super) fn activation_bar(image: &mut Image, lines: usize) {
    let top = 10 + (lines * LINE) as i64;
    image.write(8, top, "activation", false, INK);
    let (length, y) = (100, top + LINE as i64);
    for k in 0..length {
        let a = (k + 1) as f64 / length as f64;
        image.fill(8 + k, y + 3, 1, 10, to_srgb(activation_colour(a)));
    }
    image.write(8 + length + 6, y, "0 to 100 %", false, INK);
    image.fill(8, y + LINE as i64 + 3, 10, 10, to_srgb(activation_colour(0.)));
    image.write(22, y + LINE as i64, "at rest", false, INK);
}

/// Width that the names take at the left, pixels.
pub(super) fn names_space(stems: &[String]) -> f64 {
    (30 + LETTER * stems.iter().map(|s| s.chars().count()).max().unwrap_or(0)) as f64
}

/// Names of muscles in their colours, down the left side below `lines` of title.
pub(super) fn names(image: &mut Image, stems: &[String], lines: usize) {
    let top = 12 + (lines * LINE) as i64;
    for (k, name) in stems.iter().enumerate() {
        let y = top + (k * LINE) as i64;
        if y as usize + 2 * LINE > image.height {
            break;
        }
        image.fill(8, y + 3, 10, 10, to_srgb(distinct(k)));
        image.write(22, y, &name.replace('_', " "), false, INK);
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn ends_are_round() {
        for (x, up, down) in [(7.3, 8., 5.), (1., 1., 1.), (0.021, 0.024, 0.02), (99., 100., 50.)] {
            assert!((round_up(x) - up).abs() < 1e-9 && (round_down(x) - down).abs() < 1e-9, "{x}");
        }
        assert_eq!([0., -1., f64::NAN, f64::INFINITY].map(round_up), [1.; 4]);
    }
}
