//! Activations that were known, and what was found of them.

use super::chart::{Scale, frame};
use super::svg::{Anchor, Svg, standalone};

/// Rows that are drawn at most: more hide each other.
const MOST_ROWS: usize = 120;

/// An activation that is known, 0 to 1, and what was found of it.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Recovered {
    /// What it is.
    pub truth: f64,
    /// What was found.
    pub value: f64,
    /// Least that the data allow.
    pub min: f64,
    /// Greatest that the data allow.
    pub max: f64,
}

impl Recovered {
    /// Whether the truth lies in the interval, to a millionth.
    pub fn holds(&self) -> bool {
        (self.min - 1e-6..=self.max + 1e-6).contains(&self.truth)
    }
}

/// Intervals and answers over the truth, one line an activation of the first 120 `rows` that act, as an SVG file; intervals that do not
/// hold the truth have another colour.
pub fn recovery_plot(title: &str, rows: &[Recovered]) -> String {
    let (left, top, right, bottom) = (60., 56., 600., 340.);
    let mut svg = Svg::new(right + 30., bottom + 44.);
    let (x, y) = (Scale::linear(0., 100., (left, right)), Scale::linear(0., 100., (bottom, top)));
    svg.text((left - 40., 18.), Anchor::Start, "bold", title);
    let names = ["true activation, per cent", "interval and answer, per cent"];
    frame(&mut svg, &x, &y, names, (left, top, right, bottom));
    svg.run(&[(x.at(0.), y.at(0.)), (x.at(100.), y.at(100.))], "s7 dashed");
    for row in rows.iter().filter(|row| row.truth > 0.).take(MOST_ROWS) {
        let colour = if row.holds() { 0 } else { 1 };
        let at = |value: f64| (x.at(100. * row.truth), y.at(100. * value));
        svg.run(&[at(row.min), at(row.max)], &format!("s{colour}"));
        svg.dot(at(row.value), 2.5, &format!("f{colour}"));
    }
    standalone(&svg.inline(&format!("{title}: intervals and answers over true activations")))
}
