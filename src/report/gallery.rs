//! Targets and what fits them, as a page of pictures and figures.

use std::fmt::Write;

use crate::io::AnswerFiles;

/// Activation above which a muscle is said to be at 1.
const AT_ONE: f64 = 1. - 1e-6;

/// A target as the gallery shows it.
#[derive(Clone, Debug)]
pub struct GalleryTarget {
    /// Its name.
    pub name: String,
    /// What it asks, one sentence.
    pub description: String,
    /// Where its figures come from.
    pub provenance: String,
    /// Its picture, relative to the page.
    pub picture: String,
    /// Its fits, in the order in which the picture shows them.
    pub fits: Vec<GalleryFit>,
}

/// A fit as the gallery tells it.
#[derive(Clone, Debug)]
pub struct GalleryFit {
    /// By which strain and strength.
    pub model: String,
    /// What it gave; why there is no answer where there is none.
    pub answer: Result<GalleryFigures, String>,
}

/// The figures of an answer.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct GalleryFigures {
    /// How it ended.
    pub ends: &'static str,
    /// Root mean square of the residuals of all markers and features, mm.
    pub rms_mm: f64,
    /// Muscles at full activation.
    pub at_one: usize,
    /// Cells turned inside out, and the least ratio of volumes; `None` where the result does not say.
    pub squeezed: Option<(usize, f64)>,
    /// Deepest overlap of surfaces beyond that at rest, mm; `None` where it was not measured.
    pub overlap_mm: Option<f64>,
}

impl GalleryFigures {
    /// Those of `answer`.
    pub fn of(answer: &AnswerFiles) -> Self {
        let features = answer.features.iter().map(|feature| feature.residual_mm);
        let all: Vec<f64> = answer.markers.iter().filter_map(|m| m.residual_mm).chain(features).collect();
        let squares: f64 = all.iter().map(|r| r * r).sum();
        Self {
            ends: answer.status.map_or("unsaid", |status| status.said()),
            rms_mm: (squares / all.len().max(1) as f64).sqrt(),
            at_one: answer.activations.values().filter(|a| **a >= AT_ONE).count(),
            squeezed: answer.deformation.as_ref().map(|d| (d.inverted_cells, d.volume_ratio)),
            overlap_mm: answer.contact.as_ref().and_then(|contact| contact.overlap_mm),
        }
    }

    fn cells(&self) -> [String; 6] {
        let (inside_out, least) = match self.squeezed {
            Some((cells, ratio)) => (cells.to_string(), format!("{ratio:.2}")),
            None => Default::default(),
        };
        let overlap = self.overlap_mm.map_or_else(String::new, |mm| format!("{:.3}", mm.max(0.)));
        let rms = format!("{:.2}", self.rms_mm);
        [self.ends.to_owned(), rms, self.at_one.to_string(), inside_out, least, overlap]
    }
}

/// The index of a gallery of `targets` on the face called `face` as Markdown; `command` draws it anew.
pub fn gallery_text(face: &str, command: &str, targets: &[GalleryTarget]) -> String {
    let models: Vec<&str> =
        targets.first().iter().flat_map(|target| &target.fits).map(|fit| fit.model.as_str()).collect();
    let mut text = format!(
        "# Gallery\n\nEach target on {face}, from the front and in profile: {}. The line in the profiles is the face at \
         rest. Drawn by\n\n```sh\n{command}\n```\n\n",
        words(&models.join("; then "))
    );
    text += "*rms* is the root mean square of all residuals, of markers and features; *at 1* how many muscles do all they can; \
             *inside out* how many cells\nthe answer turns over, about which it means nothing; *least J* the smallest ratio of \
             volumes; *overlap* how deep surfaces lie in each other\nbeyond what they do at rest.\n";
    for target in targets {
        let GalleryTarget { name, description, provenance, picture, fits } = target;
        let _ = write!(text, "\n## {}\n\n{}\n\n", words(name), words(description));
        let _ = writeln!(text, "![{}: front and profile of each fit]({picture})\n", words(name));
        text += "| fit | ends | rms, mm | at 1 | inside out | least J | overlap, mm |\n|---|---|---|---|---|---|---|\n";
        for GalleryFit { model, answer } in fits {
            let cells = match answer {
                Ok(figures) => figures.cells().join(" | "),
                Err(why) => format!("{} | | | | | ", words(why)),
            };
            let _ = writeln!(text, "| {} | {cells} |", words(model));
        }
        let _ = writeln!(text, "\nThe figures: {}", words(provenance));
    }
    text
}

/// `text` as one line of Markdown that holds no markup.
fn words(text: &str) -> String {
    let mut plain = String::with_capacity(text.len());
    for word in text.split_whitespace() {
        if !plain.is_empty() {
            plain.push(' ');
        }
        for c in word.chars() {
            match c {
                '<' => plain.push_str("&lt;"),
                '\\' | '`' | '*' | '_' | '[' | ']' | '|' => plain.extend(['\\', c]),
                c if c.is_control() => {}
                c => plain.push(c),
            }
        }
    }
    plain
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_fit_without_an_answer_says_why_and_has_no_figures() {
        let figures = GalleryFigures {
            ends: "solved",
            rms_mm: 1.234,
            at_one: 3,
            squeezed: Some((0, 0.5)),
            overlap_mm: Some(-1e-9),
        };
        let fits = vec![
            GalleryFit { model: "linear".into(), answer: Ok(figures) },
            GalleryFit { model: "finite".into(), answer: Err("no answer within 1 min".into()) },
        ];
        let target = GalleryTarget {
            name: "a_b".into(),
            description: "A <b>\n| c.".into(),
            provenance: "Posed.".into(),
            picture: "a_b.png".into(),
            fits,
        };
        let text = gallery_text("the face", "modiolus gallery", &[target]);
        assert!(text.contains("| linear | solved | 1.23 | 3 | 0 | 0.50 | 0.000 |\n"), "{text}");
        assert!(text.contains("| finite | no answer within 1 min | | | | |  |\n"), "{text}");
        assert!(text.contains("## a\\_b\n\nA &lt;b> \\| c.\n"), "{text}");
    }
}
