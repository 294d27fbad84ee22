//! Misfit against effort.

use super::chart::{Scale, frame};
use super::svg::{Anchor, Svg, standalone};
use crate::io::{AnswerFiles, NormJson};

/// The L-curve of `answer`, effort (sum of activations or of their squares) over misfit (squared standard deviations), with the weights
/// that three rules choose, as an SVG file; `None` where there is none.
pub fn l_curve_plot(answer: &AnswerFiles) -> Option<String> {
    let effort = answer.certainty.as_ref()?.effort.as_ref()?;
    let curve: Vec<[f64; 3]> = effort.curve.iter().copied().filter(|[_, m, e]| *m > 0. && *e > 0.).collect();
    if curve.is_empty() {
        return None;
    }
    let (left, top, right, bottom) = (60., 30., 560., 360.);
    let mut svg = Svg::new(right + 30., bottom + 44.);
    let x = Scale::decades(curve.iter().map(|p| p[1]), (left, right));
    let y = Scale::decades(curve.iter().map(|p| p[2]), (bottom, top));
    let sum = match effort.norm {
        NormJson::L1 => "effort, sum of activations",
        NormJson::L2 => "effort, sum of squared activations",
    };
    let names = ["misfit, squared standard deviations", sum];
    frame(&mut svg, &x, &y, names, (left, top, right, bottom));
    let points: Vec<(f64, f64)> = curve.iter().map(|p| (x.at(p[1]), y.at(p[2]))).collect();
    svg.run(&points, "s0");
    points.iter().for_each(|p| svg.dot(*p, 2.5, "f0"));
    let chosen = [
        ("corner", Some(effort.l_curve)),
        ("cross-validation", Some(effort.cross_validation)),
        ("discrepancy", effort.discrepancy),
    ];
    for (k, (rule, weight)) in chosen.into_iter().enumerate() {
        let Some(weight) = weight.filter(|w| *w > 0.) else { continue };
        let far = |p: &[f64; 3]| (p[0].max(f64::MIN_POSITIVE).ln() - weight.ln()).abs();
        let Some(at) = curve.iter().min_by(|a, b| far(a).total_cmp(&far(b))) else { continue };
        let (px, py) = (x.at(at[1]), y.at(at[2]));
        svg.dot((px, py), 6., &format!("f{}", k + 1));
        let row = top + 16. + 18. * k as f64;
        svg.dot((right - 225., row - 4.), 5., &format!("f{}", k + 1));
        svg.text((right - 215., row), Anchor::Start, "", &format!("{rule}: weight {weight:.2e}"));
    }
    Some(standalone(
        &svg.inline(
            "Effort against misfit over the weight of effort, and the weights that three rules choose",
        ),
    ))
}
