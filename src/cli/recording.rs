//! `modiolus recording`.

use std::collections::BTreeMap;

use modiolus::io::{RecordingDocument, read_recording, recording_csv, write_atomically};
use modiolus::recording::Recording;
use modiolus::units::counted;
use serde_json::{Value, json};

use super::Outcome;
use super::arguments::RecordingOptions;
use super::error::CliError;
use super::export::keep_inputs;
use super::progress::say;

pub(crate) fn run(options: &RecordingOptions) -> Result<Outcome, CliError> {
    let document = read_recording(&options.input.recording, &options.input.stated())?;
    let markers: Vec<Marker> =
        (0..document.recording.names().len()).map(|m| Marker::of(&document.recording, m)).collect();
    if let Some(out) = &options.out {
        let read: BTreeMap<String, String> =
            document.files.iter().map(|f| (f.path.display().to_string(), f.sha256.clone())).collect();
        keep_inputs(&read, [out.clone()])?;
        write_atomically(out, recording_csv(&document.recording).as_bytes())?;
        say(&format!("wrote {}", out.display()));
    }
    let text = match options.json {
        true => serde_json::to_string_pretty(&summary(&document, &markers))? + "\n",
        false => table(options, &document, &markers),
    };
    Ok(Outcome { text, solved: true })
}

/// What there is of a marker.
struct Marker<'a> {
    name: &'a str,
    /// Frames in which it was not seen.
    gaps: usize,
    /// The most of them in a row.
    longest: usize,
    /// From where to where along x, y and z, mm; nothing if it was never seen.
    span_mm: Option<[[f64; 2]; 3]>,
}

impl<'a> Marker<'a> {
    fn of(recording: &'a Recording, m: usize) -> Self {
        let (mut gaps, mut run, mut longest) = (0, 0, 0);
        let mut span_mm: Option<[[f64; 2]; 3]> = None;
        for frame in 0..recording.n_frames() {
            let Some(p) = recording.frame(frame)[m] else {
                gaps += 1;
                run += 1;
                longest = longest.max(run);
                continue;
            };
            run = 0;
            let span = span_mm.get_or_insert([0, 1, 2].map(|k| [p[k]; 2]));
            for (k, [least, most]) in span.iter_mut().enumerate() {
                (*least, *most) = (least.min(p[k]), most.max(p[k]));
            }
        }
        Self { name: &recording.names()[m], gaps, longest, span_mm }
    }
}

fn summary(document: &RecordingDocument, markers: &[Marker]) -> Value {
    let r = &document.recording;
    let markers: Vec<Value> = markers
        .iter()
        .map(|m| json!({ "name": m.name, "gaps": m.gaps, "longest_gap": m.longest, "span_mm": m.span_mm }))
        .collect();
    let files: Vec<Value> = document
        .files
        .iter()
        .map(|f| json!({ "file": f.path.display().to_string(), "sha256": f.sha256 }))
        .collect();
    json!({
        "files": files,
        "format": document.format.to_string(),
        "unit": document.unit,
        "frames": r.n_frames(),
        "frame_names": r.frame_names(),
        "time_s": [r.times_s()[0], r.times_s()[r.n_frames() - 1]],
        "rate_hz": r.rate_hz(),
        "depth_weight": r.depth_weight(),
        "markers": markers,
        "warnings": document.warnings.iter().map(ToString::to_string).collect::<Vec<_>>(),
    })
}

fn table(options: &RecordingOptions, document: &RecordingDocument, markers: &[Marker]) -> String {
    let r = &document.recording;
    let mut text = format!(
        "{}: {} in {}, {} of {}",
        options.input.recording.display(),
        document.format,
        document.unit,
        counted(r.n_frames(), "frame"),
        counted(markers.len(), "marker")
    );
    match (r.frame_names(), r.rate_hz()) {
        (Some(names), _) => text += &format!("\nframes: {}", names.join(", ")),
        (_, Some(rate)) => {
            let (first, last) = (r.times_s()[0], r.times_s()[r.n_frames() - 1]);
            text += &format!(", {first:.3} to {last:.3} s at {rate:.6} a second");
        }
        _ => {}
    }
    let width = markers.iter().map(|m| m.name.chars().count()).max().unwrap_or(0).max("marker".len());
    text += &format!(
        "\n\n{:width$}  {:>6}  {:>7}  {:>17}  {:>17}  {:>17}\n",
        "marker", "unseen", "longest", "x mm", "y mm", "z mm"
    );
    for m in markers {
        text += &format!("{:width$}  {:6}  {:7}", m.name, m.gaps, m.longest);
        for [least, most] in m.span_mm.into_iter().flatten() {
            text += &format!("  {least:7.1} to{most:7.1}");
        }
        text.push('\n');
    }
    let seen: usize = markers.iter().map(|m| r.n_frames() - m.gaps).sum();
    text += &format!("seen: {:.2} per cent\n", 100. * seen as f64 / (r.n_frames() * markers.len()) as f64);
    if !document.warnings.is_empty() {
        text += "\nWarnings\n";
    }
    for warning in &document.warnings {
        text += &format!("- {warning}\n");
    }
    text
}
