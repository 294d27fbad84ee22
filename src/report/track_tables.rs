//! What a page says of a recording in words and numbers.

use super::markup::escaped;
use super::plot::{jaw_inline, time_inline};
use super::tables::{facts, figure, spoken, table, warnings};
use crate::certainty::percent;
use crate::io::{MetJson, TrackFiles};

/// Everything about `track` that is not seen on the face, as HTML; its headings are of level 3.
pub(super) fn article(track: &TrackFiles, muscles: &[String]) -> String {
    let mut html = summary(track);
    html += "<h3>Activations over time</h3>";
    html += &figure(&time_inline(&track.activations));
    html += &activations(track, muscles);
    if track.summary.jaw_opening_mm.is_some() {
        html += "<h3>Jaw</h3>";
        html += &figure(&jaw_inline(&track.activations.times_s, &track.frames));
    }
    html += &met(track);
    html + &warnings(track.summary.warnings.iter().chain(&track.summary.face_warnings))
}

fn summary(track: &TrackFiles) -> String {
    let summary = &track.summary;
    let statuses: Vec<String> = summary
        .statuses
        .iter()
        .filter(|(_, n)| **n > 0)
        .map(|(status, n)| format!("{n} {}", status.replace('_', " ")))
        .collect();
    let all = &summary.all;
    let mut told = vec![
        ("Recording", escaped(&summary.recording)),
        ("Face", escaped(&summary.face)),
        (
            "Frames",
            format!(
                "{} from {:.2} to {:.2} s: {}",
                summary.frames,
                summary.from_s,
                summary.to_s,
                escaped(&statuses.join(", "))
            ),
        ),
        (
            "Model",
            format!(
                "linear strain, stiffness held, contact {}, muscles {} times as strong as the face file says",
                escaped(&summary.contact_mode),
                summary.strength
            ),
        ),
        (
            "Residuals of the markers",
            format!("root mean square {:.2} mm of a movement of {:.2} mm", all.rms_mm, all.movement_mm),
        ),
    ];
    if let Some(explained) = all.explained {
        told.push(("Explained movement", format!("{} %", percent(explained))));
    }
    told.push((
        "Subject to face",
        format!(
            "scale {:.3}, landmarks {:.1} mm off; head followed to {:.2} mm",
            summary.alignment.scale, summary.alignment.rms_mm, summary.head.rms_mm
        ),
    ));
    if !summary.outliers.is_empty() {
        told.push(("Outliers", format!("{} observations, which did not count", summary.outliers.len())));
    }
    told.push(("Certificate", format!("{:.1e}", summary.certificate)));
    facts(&told)
}

fn activations(track: &TrackFiles, muscles: &[String]) -> String {
    let row = |name: &String| {
        let range = track.summary.activations.get(name).copied().unwrap_or_default();
        let mut cells = vec![escaped(&spoken(name))];
        cells.extend(range.map(|a| format!("{} %", percent(a))));
        cells
    };
    let rows: Vec<Vec<String>> = muscles.iter().map(row).collect();
    table("Activation of each muscle over all frames", &["Muscle", "Least", "Mean", "Most"], &rows)
}

/// How well regions and markers are met.
fn met(track: &TrackFiles) -> String {
    let cells = |name: &str, met: Option<&MetJson>| {
        let mut cells = vec![escaped(&spoken(name))];
        let told = |of: &dyn Fn(&MetJson) -> String| met.map_or_else(|| "\u{2013}".to_owned(), of);
        cells.push(told(&|met| met.observations.to_string()));
        cells.push(told(&|met| format!("{:.2}", met.movement_mm)));
        cells.push(told(&|met| format!("{:.2}", met.rms_mm)));
        let explained = met.and_then(|met| met.explained);
        cells.push(explained.map_or_else(|| "\u{2013}".to_owned(), |share| format!("{} %", percent(share))));
        cells
    };
    let regions: Vec<Vec<String>> =
        track.summary.regions.iter().map(|(name, met)| cells(name, Some(met))).collect();
    let markers: Vec<Vec<String>> =
        track.summary.markers.iter().map(|(name, bound)| cells(name, bound.met.as_ref())).collect();
    let heads = |first| [first, "Observations", "Moved, mm", "Residual, mm", "Explained"];
    format!(
        "<h3>Markers</h3>{}{}",
        table("Regions of the face, root mean squares over all frames", &heads("Region"), &regions),
        table("Markers, root mean squares over all frames", &heads("Marker"), &markers)
    )
}
