//! `modiolus identify`.

use modiolus::certainty::percent;
use modiolus::io::{CertaintyJson, IntervalJson, UnknownJson, read_answer};
use modiolus::units::counted;

use super::Outcome;
use super::arguments::IdentifyOptions;
use super::error::CliError;
use super::fit;

pub(crate) fn run(options: &IdentifyOptions) -> Result<Outcome, CliError> {
    let what = &options.what;
    let (heading, certainty, solved) = if what.is_dir() {
        let answer = read_answer(what)?;
        let certainty = answer.certainty.ok_or_else(|| CliError::NoCertainty(what.clone()))?;
        (what.display().to_string(), certainty, true)
    } else {
        let (fitted, _) = fit::fit(&options.fit.of(what), what)?;
        let heading = fitted.answer.heading.clone();
        let solved = fitted.solved;
        match fitted.answer.json.certainty {
            Some(certainty) => (heading, certainty, solved),
            None => return Err(CliError::NothingToIdentify { heading }),
        }
    };
    let text = match options.json {
        true => serde_json::to_string_pretty(&certainty)? + "\n",
        false => table(&heading, &certainty),
    };
    Ok(Outcome { text, solved })
}

fn table(heading: &str, certainty: &CertaintyJson) -> String {
    let of = |word: &str| certainty.unknowns.iter().filter(|u| u.determination == word).count();
    let mut text = format!("What the data determine of {heading}\n");
    text += &format!(
        "{} of {}: {} determined to within 20 %, {} roughly, {} not, {} not observed, {} held\n",
        counted(certainty.components, "observed component"),
        counted(certainty.unknowns.len(), "unknown"),
        of("determined"),
        of("roughly"),
        of("not_determined"),
        of("not_observed"),
        of("held"),
    );
    text += &noise(certainty);
    let width = certainty.unknowns.iter().map(|u| u.name.len()).max().unwrap_or(0);
    let mut rows: Vec<&UnknownJson> = certainty.unknowns.iter().collect();
    rows.sort_by(|a, b| b.value.total_cmp(&a.value));
    text += "\nAnswer, with the interval that the noise allows (95 %)\n";
    for row in rows {
        text += &format!("{:width$}  {}\n", row.name, row.sentence);
    }
    if !certainty.groups.is_empty() {
        text += "\nDetermined only together\n";
        for group in &certainty.groups {
            text += &format!("- {}\n", group.join(", "));
        }
    }
    text += &sides(certainty);
    if let Some(effort) = &certainty.effort {
        let noise = effort.discrepancy.map_or_else(|| "none".to_owned(), |w| format!("{w:.2e}"));
        text += &format!(
            "\nWeight of the effort by the corner of the L-curve {:.2e}, by cross-validation {:.2e}, by the size of the noise {noise}\n",
            effort.l_curve, effort.cross_validation
        );
    }
    text
}

/// What the intervals rest on.
fn noise(certainty: &CertaintyJson) -> String {
    let d = &certainty.discrepancy;
    let mut text = match d.strength == 0. && d.shape == 0. {
        true => "The model is taken to be the face itself\n".to_owned(),
        false => format!(
            "The model is taken to be off by {:.0} % in the strength of a muscle and {:.0} % in its movement from point to \
             point (standard deviations)\n",
            100. * d.strength,
            100. * d.shape
        ),
    };
    if certainty.noise_factor > 1.005 {
        text += &format!(
            "The residuals are {:.1} times as large as noise and model explain: the intervals are wider by as much\n",
            certainty.noise_factor
        );
    }
    text += &match certainty.condition {
        Some(condition) => {
            format!("The best observed direction is observed {condition:.0} times as well as the worst\n")
        }
        None => "Some directions of the activations are not observed at all\n".to_owned(),
    };
    text
}

fn sides(certainty: &CertaintyJson) -> String {
    if certainty.sides.is_empty() {
        return String::new();
    }
    let width = certainty.sides.iter().map(|s| s.name.len()).max().unwrap_or(0);
    let shown = |i: &IntervalJson| format!("{} ({} to {})", percent(i.value), percent(i.min), percent(i.max));
    let mut text = format!("\n{:width$}  {:>18}  {:>18}\n", "Sides, per cent", "shared", "left - right");
    for side in &certainty.sides {
        let odd = IntervalJson { value: 2. * side.odd.value, min: 2. * side.odd.min, max: 2. * side.odd.max };
        let told = match (side.uneven, odd.min > 0.) {
            (false, _) => "",
            (true, true) => "  the left is stronger",
            (true, false) => "  the right is stronger",
        };
        text += &format!("{:width$}  {:>18}  {:>18}{told}\n", side.name, shown(&side.even), shown(&odd));
    }
    text
}
