//! A frame with two scales.

use super::svg::{Anchor, Svg};

/// One scale: from a value to pixels.
#[derive(Clone, Copy, Debug)]
pub(super) struct Scale {
    from: f64,
    to: f64,
    log: bool,
    pixels: (f64, f64),
}

impl Scale {
    /// From `from` to `to` over `pixels`; a scale of one value is widened.
    pub(super) fn linear(from: f64, to: f64, pixels: (f64, f64)) -> Self {
        let to = if to > from { to } else { from + 1. };
        Self { from, to, log: false, pixels }
    }

    /// The decades about positive values.
    pub(super) fn decades(values: impl Iterator<Item = f64>, pixels: (f64, f64)) -> Self {
        let (lo, hi) = values
            .filter(|v| *v > 0.)
            .fold((f64::MAX, f64::MIN_POSITIVE), |(lo, hi), v| (lo.min(v), hi.max(v)));
        let lo = if lo > hi { hi } else { lo };
        let (from, to) = (lo.log10().floor(), hi.log10().ceil());
        Self { from, to: if to > from { to } else { from + 1. }, log: true, pixels }
    }

    pub(super) fn at(&self, value: f64) -> f64 {
        let value = if self.log { value.max(f64::MIN_POSITIVE).log10() } else { value };
        let share = ((value - self.from) / (self.to - self.from)).clamp(-0.02, 1.02);
        self.pixels.0 + share * (self.pixels.1 - self.pixels.0)
    }

    /// Values with short names, at most about seven.
    pub(super) fn ticks(&self) -> Vec<(f64, String)> {
        let span = self.to - self.from;
        let power = 10f64.powf((span / 6.).log10().floor());
        let step = if self.log {
            (span / 6.).ceil().max(1.)
        } else {
            [1., 2., 5., 10.].map(|k| k * power).into_iter().find(|s| span / s <= 7.).unwrap_or(10. * power)
        };
        let first = (self.from / step - 1e-9).ceil() as i64;
        let last = (self.to / step + 1e-9).floor() as i64;
        (first..=last)
            .map(|k| k as f64 * step)
            .map(|t| if self.log { (10f64.powf(t), format!("1e{t}")) } else { (t, short(t, step)) })
            .collect()
    }
}

/// `value` with as many digits as a step needs.
fn short(value: f64, step: f64) -> String {
    let digits = (-step.log10().floor()).clamp(0., 6.) as usize;
    format!("{:.digits$}", value + 0.)
}

/// Draws grid and names of both scales within (left, top, right, bottom).
pub(super) fn frame(
    svg: &mut Svg,
    x: &Scale,
    y: &Scale,
    names: [&str; 2],
    (left, top, right, bottom): (f64, f64, f64, f64),
) {
    for (value, name) in x.ticks() {
        svg.line((x.at(value), top), (x.at(value), bottom), "grid");
        svg.text((x.at(value), bottom + 15.), Anchor::Middle, "soft", &name);
    }
    for (value, name) in y.ticks() {
        svg.line((left, y.at(value)), (right, y.at(value)), "grid");
        svg.text((left - 6., y.at(value) + 4.), Anchor::End, "soft", &name);
    }
    svg.line((left, bottom), (right, bottom), "axis");
    svg.line((left, top), (left, bottom), "axis");
    svg.text(((left + right) / 2., bottom + 32.), Anchor::Middle, "", names[0]);
    svg.text((left - 40., top - 10.), Anchor::Start, "", names[1]);
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn ticks_are_round_and_within() {
        let names = |scale: &Scale| scale.ticks().into_iter().map(|t| t.1).collect::<Vec<_>>();
        assert_eq!(names(&Scale::linear(0., 1., (0., 100.))), ["0.0", "0.2", "0.4", "0.6", "0.8", "1.0"]);
        assert_eq!(names(&Scale::linear(0., 30., (0., 100.))), ["0", "5", "10", "15", "20", "25", "30"]);
        assert_eq!(
            names(&Scale::decades([0.02, 30.].into_iter(), (0., 100.))),
            ["1e-2", "1e-1", "1e0", "1e1", "1e2"]
        );
        assert!(Scale::decades([].into_iter(), (0., 1.)).at(1.).is_finite());
        assert_eq!(Scale::linear(2., 2., (0., 10.)).at(2.), 0.);
    }
}
