//! How the jaw moves in time.

use super::activations::thinned;
use super::chart::{Scale, frame};
use super::svg::{Anchor, Svg};
use crate::io::FrameRow;

/// Opening, protrusion and shift to the left over time.
pub(in super::super) fn jaw_inline(times_s: &[f64], frames: &[FrameRow]) -> String {
    let all = || frames.iter().flat_map(|frame| frame.jaw_mm);
    let (lo, hi) = all().fold((0., 1.), |(lo, hi): (f64, f64), mm| (lo.min(mm), hi.max(mm)));
    let (left, top, right, bottom) = (56., 30., 560., 230.);
    let mut svg = Svg::new(right + 170., bottom + 44.);
    let ends = times_s.first().zip(times_s.last()).map_or((0., 1.), |(a, b)| (*a, *b));
    let (x, y) = (Scale::linear(ends.0, ends.1, (left, right)), Scale::linear(lo, hi, (bottom, top)));
    frame(&mut svg, &x, &y, ["time, s", "jaw, mm"], (left, top, right, bottom));
    for (k, name) in ["opening", "protrusion", "to the left"].into_iter().enumerate() {
        let points: Vec<(f64, f64)> =
            thinned(times_s.len()).map(|f| (x.at(times_s[f]), y.at(frames[f].jaw_mm[k]))).collect();
        svg.run(&points, &format!("s{k}"));
        let row = top + 10. + 20. * k as f64;
        svg.run(&[(right + 14., row), (right + 36., row)], &format!("s{k}"));
        svg.text((right + 42., row + 4.), Anchor::Start, "", name);
    }
    svg.inline("Opening, protrusion and shift to the left of the jaw over time")
}
