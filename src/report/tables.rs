//! What a page says in words and numbers.

use super::markup::escaped;
use super::plot::{activations_inline, residuals_inline};
use crate::certainty::percent;
use crate::io::{AnswerFiles, LimitJson, LimitKindWord, MarkerJson, UnknownJson};

/// Limits that are listed.
const MOST_LIMITS: usize = 12;

/// Everything about `answer` that is not seen on the face, as HTML; its headings are of level 3.
pub(super) fn article(answer: &AnswerFiles, muscles: &[String]) -> String {
    let mut html = summary(answer);
    html += "<h3>Activations</h3>";
    html += &figure(&activations_inline(answer));
    html += &activations(answer, muscles);
    html += &markers(&answer.markers);
    html += &residuals_inline(answer).map_or_else(String::new, |svg| figure(&svg));
    html += &limits(&answer.active_limits);
    html + &warnings(answer.warnings.iter().chain(&answer.face_warnings))
}

/// What is odd.
pub(super) fn warnings<'a>(warnings: impl Iterator<Item = &'a String>) -> String {
    let items: String = warnings.map(|w| format!("<li>{}</li>", escaped(w))).collect();
    match items.as_str() {
        "" => items,
        _ => format!("<h3>Warnings</h3><ul class=\"warnings\">{items}</ul>"),
    }
}

/// Names with what is said of each; what is said is HTML already.
pub(super) fn facts(facts: &[(&str, String)]) -> String {
    let list: String =
        facts.iter().map(|(name, said)| format!("<div><dt>{name}</dt><dd>{said}</dd></div>")).collect();
    format!("<dl class=\"facts\">{list}</dl>")
}

/// A table with a caption; cells are HTML already, the first of each row is its heading.
pub(super) fn table(caption: &str, heads: &[&str], rows: &[Vec<String>]) -> String {
    let head: String = heads.iter().map(|h| format!("<th scope=\"col\">{h}</th>")).collect();
    let row = |cells: &Vec<String>| {
        let cells = cells.iter().enumerate().map(|(k, cell)| match k {
            0 => format!("<th scope=\"row\">{cell}</th>"),
            _ => format!("<td>{cell}</td>"),
        });
        format!("<tr>{}</tr>", cells.collect::<String>())
    };
    let body: String = rows.iter().map(row).collect();
    format!(
        "<div class=\"wide\"><table><caption>{caption}</caption><thead><tr>{head}</tr></thead><tbody>{body}</tbody></table></div>"
    )
}

/// A plot within the text.
pub(super) fn figure(svg: &str) -> String {
    format!("<figure>{svg}</figure>")
}

fn summary(answer: &AnswerFiles) -> String {
    let mm = |x: Option<f64>| x.map_or_else(|| "none".to_owned(), |x| format!("{x:.2} mm"));
    let mut told: Vec<(&str, String)> = Vec::new();
    if let Some(status) = answer.status {
        told.push(("Status", status.said().to_owned()));
    }
    if let Some(target) = &answer.target {
        told.push(("Target", escaped(&format!("{} ({})", target.name, target.file))));
    }
    told.push(("Face", escaped(&answer.face)));
    let model = [&answer.strain, &answer.stiffness, &answer.contact_mode];
    if model.iter().all(|word| !word.is_empty()) {
        let [strain, stiffness, contact] = model.map(|word| escaped(word));
        told.push((
            "Model",
            format!("{strain} strain, stiffness {stiffness}, contact {contact}, muscles {} times as strong as the face file says", answer.strength),
        ));
    }
    if let Some(residual) = answer.residual_mm.filter(|r| r.rms.is_some()) {
        told.push((
            "Residuals of the markers",
            format!("root mean square {}, largest {}", mm(residual.rms), mm(residual.max)),
        ));
    }
    if let Some(explained) = answer.explained {
        told.push(("Explained movement", format!("{} %", percent(explained))));
    }
    if let Some(opening) = answer.jaw_opening_mm {
        told.push(("Jaw", format!("open by {opening:.1} mm")));
    }
    if let Some(contact) = &answer.contact {
        told.push((
            "Contact",
            format!(
                "{} of {} pairs touching, {:.2} N: upper teeth {:.2}, lower teeth {:.2}, lip on lip {:.2}",
                contact.active,
                contact.pairs,
                contact.force_n,
                contact.upper_teeth_n,
                contact.lower_teeth_n,
                contact.lips_n
            ),
        ));
    }
    if let Some(c) = &answer.certificate {
        told.push((
            "Certificate",
            format!("primal {:.1e}, dual {:.1e}, gap {:.1e}", c.primal, c.dual, c.gap),
        ));
    }
    if let Some(certainty) = &answer.certainty {
        let of = |word: &str| certainty.unknowns.iter().filter(|u| u.determination == word).count();
        told.push((
            "What the data determine",
            format!(
                "{} of {} activations to within 20 per cent, {} roughly{}",
                of("determined"),
                certainty.unknowns.len(),
                of("roughly"),
                match certainty.noise_factor {
                    factor if factor > 1.05 =>
                        format!("; the noise raised {factor:.1} times to explain the residuals"),
                    _ => String::new(),
                }
            ),
        ));
    }
    facts(&told)
}

fn activations(answer: &AnswerFiles, muscles: &[String]) -> String {
    let unknown = |name: &String| answer.certainty.as_ref()?.unknowns.iter().find(|u| u.name == *name);
    let capped = |name: &String| {
        answer.active_limits.iter().find(|l| {
            l.kind == LimitKindWord::Cap
                && l.name.strip_prefix(name.as_str()).is_some_and(|rest| rest.starts_with(' '))
        })
    };
    let row = |name: &String| {
        let value = answer.activations.get(name).copied().unwrap_or(0.);
        let between = unknown(name).map_or_else(String::new, interval);
        let word = unknown(name).map_or_else(String::new, |u| escaped(&u.determination.replace('_', " ")));
        let cap = capped(name).map_or_else(String::new, |limit| match limit.gain_mm {
            Some(gain) => format!("at its cap; 10 % more would gain {:.3} mm", 0.1 * gain),
            None => "at its cap".to_owned(),
        });
        let trades = unknown(name).map_or_else(String::new, |u| escaped(&spoken(&u.trades.join(", "))));
        vec![escaped(&spoken(name)), format!("{} %", percent(value)), between, word, cap, trades]
    };
    let rows: Vec<Vec<String>> = muscles.iter().map(row).collect();
    table(
        "Activation of each muscle; in brackets what the noise allows, at 95 per cent",
        &["Muscle", "Activation", "Interval", "Determined", "Cap", "Trades against"],
        &rows,
    )
}

fn interval(u: &UnknownJson) -> String {
    format!("({} to {})", percent(u.min), percent(u.max))
}

/// A name as text: underscores are spaces, and the side is a word.
pub(super) fn spoken(name: &str) -> String {
    let word = |word: &str| {
        let sided = |end: &str, side: &str| word.strip_suffix(end).map(|stem| format!("{stem} {side}"));
        let comma = if word.ends_with(',') { "," } else { "" };
        let bare = word.trim_end_matches(',');
        match bare.len() == word.len() {
            true => sided("_l", "left").or_else(|| sided("_r", "right")).unwrap_or_else(|| word.to_owned()),
            false => spoken(bare) + comma,
        }
    };
    name.split(' ').map(word).collect::<Vec<_>>().join(" ").replace('_', " ")
}

/// `x` with one digit, nothing being no less than nothing.
fn tenths(x: f64) -> String {
    format!("{:.1}", (10. * x).round() / 10. + 0.)
}

fn markers(markers: &[MarkerJson]) -> String {
    if markers.is_empty() {
        return String::new();
    }
    let number = |x: Option<f64>| x.map_or_else(|| "\u{2013}".to_owned(), tenths);
    let rows: Vec<Vec<String>> = markers
        .iter()
        .map(|marker| {
            let mut cells = vec![escaped(&spoken(&marker.name))];
            cells.extend(marker.target_mm.map(number));
            cells.extend(marker.model_mm.map(|x| number(Some(x))));
            cells.push(marker.residual_mm.map_or_else(|| "\u{2013}".to_owned(), |mm| format!("{mm:.2}")));
            cells
        })
        .collect();
    let heads = ["Marker", "measured, left", "up", "forward", "model, left", "up", "forward", "off by"];
    format!("<h3>Markers</h3>{}", table("Displacements of the markers, mm", &heads, &rows))
}

fn limits(limits: &[LimitJson]) -> String {
    if limits.is_empty() {
        return String::new();
    }
    let mut sorted: Vec<&LimitJson> = limits.iter().filter(|l| l.kind != LimitKindWord::Contact).collect();
    let gain = |l: &LimitJson| l.gain_mm.unwrap_or(l.multiplier);
    sorted.sort_by(|a, b| gain(b).total_cmp(&gain(a)));
    let rows: Vec<Vec<String>> = sorted
        .iter()
        .take(MOST_LIMITS)
        .map(|limit| {
            let word = match limit.kind {
                LimitKindWord::Cap => "cap",
                LimitKindWord::AtRest => "at rest",
                LimitKindWord::Tie => "tie",
                LimitKindWord::Contact => "contact",
            };
            let gain = limit.gain_mm.map_or_else(|| "\u{2013}".to_owned(), |mm| format!("{:.3}", 0.1 * mm));
            vec![escaped(&spoken(&limit.name)), word.to_owned(), gain]
        })
        .collect();
    let more = sorted.len().saturating_sub(MOST_LIMITS);
    let more =
        if more > 0 { format!("<p>And {more} weaker ones, in solution.json.</p>") } else { String::new() };
    format!(
        "<h3>What holds the answer back</h3>{}{more}",
        table(
            "Limits, and by how many mm the root mean square of the residuals falls at first where one gives way by a tenth",
            &["Limit", "Kind", "Gain, mm"],
            &rows
        )
    )
}
