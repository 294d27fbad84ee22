//! The answer as a table that is read without colour and without this program's manual.

use std::collections::BTreeMap;

use modiolus::certainty::percent;
use modiolus::io::{
    ContactJson, LimitJson, LimitKindWord, LinearJson, MarkerJson, RelaxationEndWord, SolutionJson,
    UnknownJson,
};
use modiolus::units::counted;

/// Characters of a full bar.
const BAR: usize = 20;

/// Characters of an interval.
const INTERVAL: usize = 12;

/// Limits that are listed; the strongest come first.
const SHOWN_LIMITS: usize = 12;

/// Muscles named of another solution.
const SHOWN_DIFFERENCES: usize = 4;

/// The whole table.
pub(crate) fn render(heading: &str, answer: &SolutionJson) -> String {
    let parts = [
        format!("{heading}\n"),
        activations(answer),
        answer.jaw_opening_mm.map(|q| format!("Jaw open by {:.1} mm\n", tidy(q, 1))).unwrap_or_default(),
        markers(answer),
        features(answer),
        answer.contact.as_ref().map(contact).unwrap_or_default(),
        limits(answer),
        expected(answer),
        nonlinear(answer),
        warnings(answer),
        certificate(answer),
    ];
    let parts: Vec<String> = parts.into_iter().filter(|p| !p.is_empty()).collect();
    parts.join("\n")
}

/// Muscles with the strongest side first, left and right side by side.
fn activations(answer: &SolutionJson) -> String {
    if answer.activations.is_empty() {
        return String::new();
    }
    let unknowns = answer.certainty.iter().flat_map(|certainty| &certainty.unknowns);
    let known: BTreeMap<&str, &UnknownJson> =
        unknowns.map(|unknown| (unknown.name.as_str(), unknown)).collect();
    let interval = |stem: &str, side: &str| {
        known
            .get(format!("{stem}{side}").as_str())
            .map(|u| format!("({} to {})", percent(u.min), percent(u.max)))
    };
    let mut rows: BTreeMap<&str, [Option<f64>; 3]> = BTreeMap::new();
    for (name, &a) in &answer.activations {
        let (stem, column) = match (name.strip_suffix("_r"), name.strip_suffix("_l")) {
            (Some(stem), _) => (stem, 0),
            (_, Some(stem)) => (stem, 1),
            _ => (name.as_str(), 2),
        };
        rows.entry(stem).or_default()[column] = Some(a);
    }
    let mut rows: Vec<(&str, [Option<f64>; 3])> = rows.into_iter().collect();
    let strongest = |sides: &[Option<f64>; 3]| sides.iter().flatten().copied().fold(0.0, f64::max);
    rows.sort_by(|a, b| strongest(&b.1).total_cmp(&strongest(&a.1)));
    let width = rows.iter().map(|(stem, _)| stem.len()).max().unwrap_or(0).max(20);
    let within = if known.is_empty() { 0 } else { INTERVAL };
    let side = within + BAR + 5;
    let mut text =
        format!("{:width$}  {:>side$} | subject's left\n", "Activation, per cent", "subject's right");
    for (stem, [right, left, both]) in rows {
        let right = right.map(|a| {
            format!("{:within$}{:>BAR$} {:3.0} ", interval(stem, "_r").unwrap_or_default(), bar(a), 100.0 * a)
        });
        let left = left.map(|a| (a, "_l")).or(both.map(|a| (a, ""))).map(|(a, side)| {
            let interval = interval(stem, side).unwrap_or_default();
            format!("{:3.0}  {:BAR$}  {interval}", 100.0 * a, bar(a))
        });
        let line =
            format!("{stem:width$}  {:>side$} | {}", right.unwrap_or_default(), left.unwrap_or_default());
        text += line.trim_end();
        text += if both.is_some() { "  (one muscle)\n" } else { "\n" };
    }
    if let Some(certainty) = &answer.certainty {
        let of = |word: &str| certainty.unknowns.iter().filter(|u| u.determination == word).count();
        text += &format!(
            "In brackets what the noise allows: {} of {} determined to within 20 per cent, {} roughly; identify tells more\n",
            of("determined"),
            certainty.unknowns.len(),
            of("roughly")
        );
        if certainty.noise_factor > 1.05 {
            text += &format!(
                "The residuals are {:.1} times as large as noise and model explain: the brackets are wider by as much\n",
                certainty.noise_factor
            );
        }
    }
    text
}

fn bar(activation: f64) -> String {
    "#".repeat((activation.clamp(0.0, 1.0) * BAR as f64).round() as usize)
}

fn markers(answer: &SolutionJson) -> String {
    if answer.markers.is_empty() {
        return String::new();
    }
    let with_target = answer.markers.iter().any(|m| m.target_mm.iter().any(Option::is_some));
    let width = answer.markers.iter().map(|m| m.name.len()).max().unwrap_or(0).max(11);
    let axes = format!("{:>7}{:>7}{:>7}", "x left", "y up", "z fwd");
    let mut text = if with_target {
        format!(
            "{:width$} {:>21}  {:>21}\n{:width$} {axes}  {axes}   off by\n",
            "Markers, mm", "target", "model", ""
        )
    } else {
        format!("{:width$} {axes}\n", "Points, mm")
    };
    for marker in &answer.markers {
        text += &format!("{:width$} ", marker.name);
        if with_target {
            text += &row(marker.target_mm);
            text += "  ";
        }
        text += &row(marker.model_mm.map(Some));
        if with_target {
            text += &off_by(marker);
        }
        text.push('\n');
    }
    if let (Some(rms), Some(max)) = (answer.residual_mm.rms, answer.residual_mm.max) {
        text += &format!("root mean square {rms:.2} mm, farthest {max:.2} mm\n");
    }
    text
}

fn row(components: [Option<f64>; 3]) -> String {
    components.map(|c| c.map_or_else(|| format!("{:>7}", "-"), |x| format!("{:7.1}", tidy(x, 1)))).concat()
}

fn off_by(marker: &MarkerJson) -> String {
    marker.residual_mm.map_or_else(|| format!("{:>9}", "-"), |r| format!("{r:9.2}"))
}

/// A number that prints without the sign of a zero.
fn tidy(x: f64, digits: i32) -> f64 {
    let scale = 10f64.powi(digits);
    (x * scale).round() / scale + 0.0
}

fn features(answer: &SolutionJson) -> String {
    if answer.features.is_empty() {
        return String::new();
    }
    let width = answer.features.iter().map(|f| f.name.len()).max().unwrap_or(0).max(11);
    let mut text = format!("{:width$} {:>7}{:>7}   off by\n", "Lengths, mm", "target", "model");
    for f in &answer.features {
        let (target, model) = (tidy(f.target_mm, 1), tidy(f.model_mm, 1));
        text += &format!("{:width$} {target:7.1}{model:7.1}{:9.2}\n", f.name, f.residual_mm);
    }
    text
}

fn contact(contact: &ContactJson) -> String {
    let ContactJson { pairs, active, force_n, upper_teeth_n, lower_teeth_n, lips_n, .. } = contact;
    let ContactJson { max_penetration_mm, overlap_mm, .. } = contact;
    let ContactJson { relaxation_gap, relaxation_nodes, relaxation_end, .. } = contact;
    let mut text = format!(
        "Contact\n{active} of {} touching, with {force_n:.2} N in all; deepest penetration beyond rest {:.3} mm\n",
        counted(*pairs, "pair"),
        tidy(*max_penetration_mm, 3)
    );
    text += &format!(
        "upper teeth {upper_teeth_n:.2} N, lower teeth {lower_teeth_n:.2} N, lip on lip {lips_n:.2} N\n"
    );
    if let Some(overlap) = overlap_mm {
        text +=
            &format!("overlap of the deformed surfaces beyond rest, off bone, {:.3} mm\n", tidy(*overlap, 3));
    }
    text += &match relaxation_end {
        None => String::new(),
        Some(RelaxationEndWord::Closed) => {
            let relaxations = counted(*relaxation_nodes, "relaxation");
            format!("no other set of contacts is better ({relaxations})\n")
        }
        Some(end) => {
            let end = match end {
                RelaxationEndWord::NotConverged => "one did not converge",
                _ => "then the limit",
            };
            format!(
                "another set of contacts could lower the objective by {relaxation_gap:.3} at most \
                 ({}, {end})\n",
                counted(*relaxation_nodes, "relaxation")
            )
        }
    };
    text
}

fn limits(answer: &SolutionJson) -> String {
    let (at_rest, caps): (Vec<&LimitJson>, Vec<&LimitJson>) =
        answer.active_limits.iter().partition(|limit| limit.kind == LimitKindWord::AtRest);
    let mut text = String::new();
    if let Some(explained) = answer.explained {
        text += &format!("The answer explains {} per cent of the observed movement\n", percent(explained));
    }
    if !caps.is_empty() {
        text += "What holds the answer back, and what giving way would gain at first\n";
        text += &limit_rows(&caps);
    }
    if !at_rest.is_empty() {
        text += "Muscles at rest that would have to push, which no muscle does\n";
        text += &limit_rows(&at_rest);
    }
    text
}

fn limit_rows(limits: &[&LimitJson]) -> String {
    let width = limits.iter().map(|l| l.name.len()).max().unwrap_or(0);
    let mut text = String::new();
    for limit in limits.iter().take(SHOWN_LIMITS) {
        // A unit of activation is the whole of it: a tenth is a step that means something.
        text += &match (limit.gain_mm, limit.unit.as_str()) {
            (Some(gain), "1") => format!("{:width$}  {:8.3} mm per 10 %\n", limit.name, 0.1 * gain),
            (Some(gain), "1/mm") => format!("{:width$}  {gain:8.3} mm per mm\n", limit.name),
            (_, unit) => {
                let per = if unit == "1" { "per unit" } else { unit };
                format!("{:width$}  {:8.3} {per} of the objective\n", limit.name, limit.multiplier)
            }
        };
    }
    let more = limits.len().saturating_sub(SHOWN_LIMITS);
    if more > 0 {
        text += &format!("and {}, in solution.json\n", counted(more, "weaker one"));
    }
    text
}

/// Whether the fit is as good as the target file says it is on this face.
fn expected(answer: &SolutionJson) -> String {
    answer.expected.map_or_else(String::new, |e| {
        let verdict = if e.met { "as stated" } else { "NOT as stated" };
        format!(
            "All residuals: root mean square {:.3} mm, {verdict} in the target file ({:.3} mm, within {:.3})\n",
            e.found_rms_mm, e.residual_rms_mm, e.tolerance_mm
        )
    })
}

/// What the muscles' stiffening did to the answer, and whether the target determines it.
fn nonlinear(answer: &SolutionJson) -> String {
    let mut text = String::new();
    if let Some(linear) = &answer.linear_answer {
        let LinearJson { stiffness, muscle, activation_off, markers_off_mm, residual_rms_mm, .. } = linear;
        text += &format!(
            "The linear answer, muscles held at the stiffness of {stiffness}: {residual_rms_mm:.2} mm root mean square by its \
             own count; it differs by up to {:.0} per cent ({muscle}), and its activations lead {markers_off_mm:.1} mm \
             (root mean square) from where it puts the points\n",
            100.0 * activation_off
        );
    }
    for other in &answer.other_solutions {
        let difference =
            |(name, a): (&String, &f64)| Some(((answer.activations.get(name)? - a).abs(), name.clone()));
        let mut off: Vec<(f64, String)> = other.activations.iter().filter_map(difference).collect();
        off.sort_by(|a, b| b.0.total_cmp(&a.0).then(a.1.cmp(&b.1)));
        let named: Vec<String> = off
            .into_iter()
            .take(SHOWN_DIFFERENCES)
            .filter(|(by, _)| *by > 0.005)
            .map(|(by, name)| format!("{name} by {:.0} per cent", 100.0 * by))
            .collect();
        text += &format!(
            "A second local solution fits with {:.2} mm root mean square: {}\n",
            other.residual_rms_mm,
            named.join(", ")
        );
    }
    text
}

fn warnings(answer: &SolutionJson) -> String {
    let mut lines: String = answer.warnings.iter().map(|w| format!("- {w}\n")).collect();
    match &answer.face_warnings[..] {
        [] => {}
        [one] => lines += &format!("- {one}\n"),
        more => {
            lines += &format!(
                "- {} remarks about the face: face_warnings in solution.json, or face check\n",
                more.len()
            );
        }
    }
    if lines.is_empty() { lines } else { format!("Warnings\n{lines}") }
}

fn certificate(answer: &SolutionJson) -> String {
    answer.certificate.map_or_else(String::new, |c| {
        format!("Certificate: primal {:.1e}, dual {:.1e}, gap {:.1e}\n", c.primal, c.dual, c.gap)
    })
}
