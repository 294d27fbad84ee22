//! How the two sides differ.

use super::chart::Scale;
use super::svg::{Anchor, Svg, standalone};
use crate::io::AnswerFiles;

const ROW: f64 = 20.;

/// For each muscle of both sides the activation of the left one less that of the right one, per cent, with the interval that the
/// data leave open, as an SVG file; `None` where nothing was fitted or no muscle has two sides.
pub fn symmetry_plot(answer: &AnswerFiles) -> Option<String> {
    let sides = &answer.certainty.as_ref()?.sides;
    if sides.is_empty() {
        return None;
    }
    let (left, right, top) = (240., 640., 34.);
    let mut svg = Svg::new(right + 30., top + ROW * sides.len() as f64 + 44.);
    let bottom = top + ROW * sides.len() as f64;
    let x = Scale::linear(-1., 1., (left, right));
    for tick in [-1., -0.5, 0., 0.5, 1.] {
        svg.line((x.at(tick), top - 6.), (x.at(tick), bottom), if tick == 0. { "axis" } else { "grid" });
        svg.text((x.at(tick), bottom + 15.), Anchor::Middle, "soft", &format!("{:.0}", 100. * tick));
    }
    svg.text(((left + right) / 2., bottom + 32.), Anchor::Middle, "", "left less right, per cent");
    svg.text(((left + x.at(0.)) / 2., 16.), Anchor::Middle, "bold", "right stronger");
    svg.text(((right + x.at(0.)) / 2., 16.), Anchor::Middle, "bold", "left stronger");
    for (k, side) in sides.iter().enumerate() {
        let y = top + ROW * (k as f64 + 0.5);
        // The odd part is half the difference.
        let [value, min, max] = [side.odd.value, side.odd.min, side.odd.max].map(|odd| x.at(2. * odd));
        svg.text(
            (left - 8., y + 4.),
            Anchor::End,
            if side.uneven { "bold" } else { "" },
            &side.name.replace('_', " "),
        );
        let (from, to) = (value.min(x.at(0.)), value.max(x.at(0.)));
        svg.bar((from, y - 6.), (to - from, 12.), if value < x.at(0.) { "f1" } else { "f0" });
        svg.interval((min, max), y);
    }
    Some(standalone(
        &svg.inline("Left less right activation of each muscle, with the interval that the data leave open"),
    ))
}
