//! How hard muscles pull at their lengths.

use super::chart::{Scale, frame};
use super::svg::{Anchor, Svg, standalone};
use crate::face::{Face, Muscle};
use crate::io::AnswerFiles;
use crate::render::muscle_stems;
use crate::study::{Mechanics, muscle_force, muscle_stretches};

/// Muscles, without sides, that are drawn: those that pull most.
const MOST_STEMS: usize = 8;
/// Room beside the shortest and the longest muscle, in shares of the length at rest.
const BESIDE: f64 = 0.04;
/// Pieces of a curve.
const PIECES: usize = 40;
const ROW: f64 = 20.;

/// A muscle where it is.
struct Pulling<'a> {
    muscle: &'a Muscle,
    activation: f64,
    stretch: f64,
    force_n: f64,
}

/// Force over length of the muscles of `face` that pull most in `answer`, as an SVG file: of each the curve of its activation by
/// the laws of `mechanics`, that of its tissue at rest, and the answer; `None` where no muscle acts. The strength of the muscles
/// is that of `face`.
pub fn length_plot(face: &Face, answer: &AnswerFiles, mechanics: Mechanics) -> Option<String> {
    let stretches = muscle_stretches(face, &answer.displacement);
    let total = |muscle: &Muscle, a: f64, stretch: f64| {
        let force = muscle_force(face, muscle, mechanics, a, stretch);
        force.active_n + force.passive_n
    };
    let all: Vec<Pulling<'_>> = face
        .muscles
        .iter()
        .zip(stretches)
        .filter_map(|(muscle, stretch)| {
            let activation = answer.activations.get(&muscle.name).copied().filter(|a| *a > 0.)?;
            Some(Pulling { muscle, activation, stretch, force_n: total(muscle, activation, stretch) })
        })
        .collect();
    let stem_of =
        |name: &str, stem: &str| name.strip_prefix(stem).is_some_and(|side| ["", "_l", "_r"].contains(&side));
    let mut groups: Vec<(String, Vec<&Pulling<'_>>)> = muscle_stems(face)
        .into_iter()
        .map(|stem| {
            let own = all.iter().filter(|p| stem_of(&p.muscle.name, &stem)).collect();
            (stem, own)
        })
        .filter(|(_, own): &(String, Vec<&Pulling<'_>>)| !own.is_empty())
        .collect();
    let most = |own: &[&Pulling<'_>]| own.iter().map(|p| p.force_n).fold(f64::MIN, f64::max);
    groups.sort_by(|a, b| most(&b.1).total_cmp(&most(&a.1)).then(a.0.cmp(&b.0)));
    groups.truncate(MOST_STEMS);
    let shown = || groups.iter().flat_map(|(_, own)| own.iter());
    let (lo, hi) = shown().fold((1.0_f64, 1.0_f64), |(lo, hi), p| (lo.min(p.stretch), hi.max(p.stretch)));
    let (lo, hi) = (lo - BESIDE, hi + BESIDE);
    let strongest = shown().map(|p| total(p.muscle, p.activation, hi).max(p.force_n)).fold(0., f64::max);
    let weakest = shown().map(|p| total(p.muscle, 0., lo).min(0.)).fold(0., f64::min);
    if groups.is_empty() || strongest <= 0. {
        return None;
    }
    let (left, top, right, bottom) = (60., 30., 560., 380.);
    let mut svg = Svg::new(right + 270., bottom + 44.);
    let x = Scale::linear(100. * lo, 100. * hi, (left, right));
    let y = Scale::linear(weakest, 1.05 * strongest, (bottom, top));
    let names = ["length, per cent of that at rest", "force along the muscle, N"];
    frame(&mut svg, &x, &y, names, (left, top, right, bottom));
    svg.line((x.at(100.), top), (x.at(100.), bottom), "axis");
    svg.text((x.at(100.) + 4., top + 10.), Anchor::Start, "soft", "rest");
    let curve = |muscle: &Muscle, a: f64| -> Vec<(f64, f64)> {
        let at = |k: usize| lo + (hi - lo) * k as f64 / PIECES as f64;
        (0..=PIECES).map(|k| (x.at(100. * at(k)), y.at(total(muscle, a, at(k))))).collect()
    };
    for (k, (stem, own)) in groups.iter().enumerate() {
        svg.run(&curve(own[0].muscle, 0.), &format!("s{k} dashed"));
        for p in own {
            svg.run(&curve(p.muscle, p.activation), &format!("s{k}"));
            let at = (x.at(100. * p.stretch), y.at(p.force_n));
            match p.muscle.name.ends_with("_r") {
                true => svg.ring(at, 6., &format!("s{k}")),
                false => svg.dot(at, 4.5, &format!("f{k}")),
            }
        }
        let row = top + 10. + ROW * k as f64;
        svg.run(&[(right + 14., row), (right + 36., row)], &format!("s{k}"));
        svg.text((right + 42., row + 4.), Anchor::Start, "", &stem.replace('_', " "));
    }
    let mut row = top + 24. + ROW * groups.len() as f64;
    svg.dot((right + 25., row), 4.5, "f7");
    svg.text((right + 42., row + 4.), Anchor::Start, "soft", "the answer, left or unpaired");
    row += ROW;
    svg.ring((right + 25., row), 6., "s7");
    svg.text((right + 42., row + 4.), Anchor::Start, "soft", "the answer, right");
    row += ROW;
    svg.run(&[(right + 14., row), (right + 36., row)], "s7 dashed");
    svg.text((right + 42., row + 4.), Anchor::Start, "soft", "at activation 0");
    Some(standalone(&svg.inline(
        "Force along the muscles that pull most over their length, at the activations of the answer and at none, and where the answer is",
    )))
}
