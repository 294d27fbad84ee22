//! How far the markers are off.

use super::chart::{Scale, frame};
use super::svg::{Anchor, Svg, standalone};
use crate::io::AnswerFiles;

/// Bins of the histogram.
const BINS: usize = 10;

pub(in super::super) fn residuals_inline(answer: &AnswerFiles) -> Option<String> {
    let residuals: Vec<f64> = answer.markers.iter().filter_map(|m| m.residual_mm).collect();
    let largest = residuals.iter().copied().fold(0., f64::max);
    if residuals.is_empty() {
        return None;
    }
    // Bins of a round width.
    let raw = largest.max(1e-6) / BINS as f64;
    let power = 10f64.powf(raw.log10().floor());
    let width = [1., 2., 5., 10.].map(|k| k * power).into_iter().find(|w| *w >= raw).unwrap_or(10. * power);
    let bins = ((largest / width).floor() as usize + 1).min(BINS + 1);
    let mut counts = vec![0usize; bins];
    residuals.iter().for_each(|r| counts[((r / width) as usize).min(bins - 1)] += 1);
    let (left, top, right, bottom) = (56., 30., 560., 250.);
    let mut svg = Svg::new(right + 20., bottom + 44.);
    let most = counts.iter().copied().max().unwrap_or(0) as f64;
    let x = Scale::linear(0., width * bins as f64, (left, right));
    let y = Scale::linear(0., most.max(1.), (bottom, top));
    frame(&mut svg, &x, &y, ["residual, mm", "markers"], (left, top, right, bottom));
    for (k, count) in counts.iter().enumerate() {
        let (from, to) = (x.at(k as f64 * width), x.at((k + 1) as f64 * width));
        let height = bottom - y.at(*count as f64);
        svg.bar((from + 1., bottom - height), (to - from - 2., height), "f0");
    }
    let rms = (residuals.iter().map(|r| r * r).sum::<f64>() / residuals.len() as f64).sqrt();
    svg.line((x.at(rms), top), (x.at(rms), bottom), "thin");
    svg.text((x.at(rms) + 5., top + 10.), Anchor::Start, "", &format!("root mean square {rms:.2} mm"));
    Some(svg.inline(&format!("How many markers are off by how much; root mean square {rms:.2} mm")))
}

/// A histogram of the residuals of the markers of `answer` as an SVG file; `None` where no marker has one.
pub fn residual_plot(answer: &AnswerFiles) -> Option<String> {
    residuals_inline(answer).map(|inline| standalone(&inline))
}
