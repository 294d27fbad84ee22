//! Activations with what the data leave open, and over time.

use super::chart::Scale;
use super::svg::{Anchor, Svg, standalone};
use crate::io::{ActivationTable, AnswerFiles};

/// Height of a row, pixels.
const ROW: f64 = 20.;
/// Muscles that are drawn over time, those that act most.
const MOST_RUNS: usize = 8;

/// Height of a muscle's strip over time, pixels.
const STRIP: f64 = 46.;
/// Points of a run at most: more are not told apart.
const MOST_POINTS: usize = 900;

/// A muscle of both sides, or one in the middle.
struct Row<'a> {
    stem: &'a str,
    /// Names of the right and the left one; the same twice in the middle.
    sides: [&'a str; 2],
}

fn rows(answer: &AnswerFiles) -> Vec<Row<'_>> {
    let names: Vec<&str> = answer.activations.keys().map(String::as_str).collect();
    let mut rows: Vec<Row<'_>> = Vec::new();
    for &name in &names {
        if let Some(stem) = name.strip_suffix("_l")
            && let Some(right) = names.iter().copied().find(|n| n.strip_suffix("_r") == Some(stem))
        {
            rows.push(Row { stem, sides: [right, name] });
        } else if !name
            .strip_suffix("_r")
            .is_some_and(|stem| names.iter().any(|n| n.strip_suffix("_l") == Some(stem)))
        {
            rows.push(Row { stem: name, sides: [name, name] });
        }
    }
    let of = |name: &str| answer.activations.get(name).copied().unwrap_or(0.);
    rows.sort_by(|a, b| {
        let sum = |row: &Row<'_>| of(row.sides[0]) + of(row.sides[1]);
        sum(b).total_cmp(&sum(a)).then(a.stem.cmp(b.stem))
    });
    rows
}

/// The activations of `answer` in per cent, the subject's right to the left as seen from the front, with the intervals that
/// the data leave open at 95 per cent.
pub(in super::super) fn activations_inline(answer: &AnswerFiles) -> String {
    let rows = rows(answer);
    let (names, half, top) = (230., 200., 34.);
    let middle = names + half + 10.;
    let (width, height) = (middle + half + 40., top + ROW * rows.len() as f64 + 44.);
    let mut svg = Svg::new(width, height);
    let bottom = height - 40.;
    let sides = [
        Scale::linear(0., 1., (middle - 8., middle - half)),
        Scale::linear(0., 1., (middle + 8., middle + half)),
    ];
    for scale in &sides {
        for percent in [0., 0.5, 1.] {
            svg.line(
                (scale.at(percent), top - 6.),
                (scale.at(percent), bottom),
                if percent == 0. { "axis" } else { "grid" },
            );
            svg.text(
                (scale.at(percent), bottom + 15.),
                Anchor::Middle,
                "soft",
                &format!("{:.0}", 100. * percent),
            );
        }
    }
    svg.text((middle, bottom + 32.), Anchor::Middle, "", "activation, per cent");
    svg.text((middle - half / 2., 16.), Anchor::Middle, "bold", "subject's right");
    svg.text((middle + half / 2., 16.), Anchor::Middle, "bold", "subject's left");
    for (k, row) in rows.iter().enumerate() {
        let y = top + ROW * (k as f64 + 0.5);
        svg.text((names - 6., y + 4.), Anchor::End, "", &row.stem.replace('_', " "));
        for (side, (scale, name)) in sides.iter().zip(row.sides).enumerate() {
            let a = answer.activations.get(name).copied().unwrap_or(0.);
            let (from, to) = (scale.at(0.).min(scale.at(a)), scale.at(0.).max(scale.at(a)));
            svg.bar((from, y - 6.), (to - from, 12.), if side == 0 { "f1" } else { "f0" });
            let unknown = answer.certainty.as_ref().and_then(|c| c.unknowns.iter().find(|u| u.name == name));
            if let Some(u) = unknown {
                svg.interval((scale.at(u.min), scale.at(u.max)), y);
            }
        }
    }
    svg.inline("Activation of each muscle, right and left, with the intervals that the data leave open; the table has the numbers")
}

/// The activations of `answer`, mirrored left and right with their intervals, as an SVG file.
pub fn activation_plot(answer: &AnswerFiles) -> String {
    standalone(&activations_inline(answer))
}

/// Indices of `frames` times, at most [`MOST_POINTS`] of them, evenly.
pub(super) fn thinned(frames: usize) -> impl Iterator<Item = usize> {
    (0..frames).step_by(frames.div_ceil(MOST_POINTS).max(1))
}

/// The activations of `table` over time, of the eight muscles that act most, as an SVG file.
pub fn time_plot(table: &ActivationTable) -> String {
    standalone(&time_inline(table))
}

/// The same for a page.
pub(in super::super) fn time_inline(table: &ActivationTable) -> String {
    let most = |m: usize| table.rows.iter().map(|row| row[m]).fold(0., f64::max);
    let mut shown: Vec<usize> = (0..table.muscles.len()).filter(|m| most(*m) > 0.).collect();
    shown.sort_by(|a, b| most(*b).total_cmp(&most(*a)).then(a.cmp(b)));
    shown.truncate(MOST_RUNS);
    let (left, top, right) = (56., 14., 640.);
    let bottom = top + STRIP * shown.len().max(1) as f64;
    let mut svg = Svg::new(right + 270., bottom + 44.);
    let ends = table.times_s.first().zip(table.times_s.last()).map_or((0., 1.), |(a, b)| (*a, *b));
    let x = Scale::linear(ends.0, ends.1, (left, right));
    for (value, name) in x.ticks() {
        svg.line((x.at(value), top), (x.at(value), bottom), "grid");
        svg.text((x.at(value), bottom + 15.), Anchor::Middle, "soft", &name);
    }
    svg.text(((left + right) / 2., bottom + 32.), Anchor::Middle, "", "time, s");
    // A strip a muscle: runs that cross each other are not told apart.
    for (k, m) in shown.iter().enumerate() {
        let foot = top + STRIP * (k + 1) as f64;
        let y = Scale::linear(0., 1., (foot, foot - STRIP + 8.));
        for share in [0., 1.] {
            svg.line((left, y.at(share)), (right, y.at(share)), if share == 0. { "axis" } else { "grid" });
            svg.text((left - 6., y.at(share) + 4.), Anchor::End, "soft", &format!("{:.0} %", 100. * share));
        }
        let point = |f: usize| (x.at(table.times_s[f]), y.at(table.rows[f][*m]));
        let points: Vec<(f64, f64)> = thinned(table.rows.len()).map(point).collect();
        svg.run(&points, &format!("s{}", usize::from(table.muscles[*m].ends_with("_r"))));
        let name = table.muscles[*m].replace('_', " ");
        svg.text((right + 12., y.at(0.5) + 4.), Anchor::Start, "", &name);
    }
    svg.inline("Activations over time of the muscles that act most")
}
