//! `modiolus track`.

use std::collections::BTreeMap;
use std::path::Path;
use std::sync::Mutex;
use std::sync::atomic::{AtomicBool, Ordering};

use modiolus::forward::Deformation;
use modiolus::forward::finite::FiniteError;
use modiolus::io::{
    AlignmentJson, BoundJson, CheckedJson, FileSet, HeadJson, IntervalsJson, MappedRecording, MetJson,
    OutlierJson, ReadOptions, RecordingDocument, SettledJson, SwapJson, TrackBlocks, TrackJson, VtuData,
    frames_csv, intervals_csv, read_mapped_recording, residuals_csv, sha256, sto_text, tracked_activations,
    vtu_text,
};
use modiolus::recording::{FrameStatus, Met, TrackSummary, TrackedFrame};
use modiolus::study::{Strain, Track, TrackError};
use modiolus::units::counted;

use super::Outcome;
use super::arguments::{ContactMode, TrackOptions};
use super::error::CliError;
use super::export::{beyond, keep_inputs};
use super::load::{LoadedFace, input_name, load};
use super::progress::{Progress, say};

/// The files of a track.
const FILES: [&str; 6] = [
    "activations.csv",
    "activations.parquet",
    "activations.sto",
    "frames.csv",
    "residuals.csv",
    "summary.json",
];
/// The table of intervals, where they were asked for.
const INTERVALS: &str = "intervals.csv";
/// The list of the series and what its files begin with.
const SERIES: [&str; 2] = ["series.pvd", "frame_"];

pub(crate) fn run(options: &TrackOptions) -> Result<Outcome, CliError> {
    let stiffness = options.stiffness()?;
    let mut progress = Progress::new();
    let read =
        || read_mapped_recording(&options.input.recording, options.map.as_deref(), &options.input.stated());
    let MappedRecording { document, map, files } = progress.step("read_recording", read)?;
    let mut inputs: BTreeMap<String, String> =
        files.iter().map(|file| (input_name(&file.path), file.sha256.clone())).collect();
    let loaded = load(&options.face, &mut progress)?.with_strength(options.strength);
    inputs.extend(loaded.inputs.clone());
    keep_inputs(&inputs, FILES.iter().chain([&INTERVALS]).map(|name| options.out.join(name)))?;
    let failed =
        |error| CliError::Track { recording: options.input.recording.clone(), error: Box::new(error) };
    let track = progress
        .step("prepare", || {
            let has_contact = options.contact != ContactMode::Off;
            Track::new(&loaded.face, &document.recording, map, stiffness, has_contact)
        })
        .map_err(failed)?;
    let track = match options.strain {
        Strain::Linear => track,
        Strain::Finite => progress
            .counted_step("settle", Track::MOST_STATES, "faces at most", |done| track.at_finite_strain(done))
            .map_err(failed)?,
    };

    let key = key(options, &loaded, &inputs)?;
    let blocks = TrackBlocks::new(&options.out, &key);
    let frames = fit(&track, &blocks, &mut progress)?;
    let summary = progress.step("sum_up", || track.summary(&loaded.face, &frames));
    let n_checked = track.to_check(&frames).len();
    // At finite strain the frames are right to first order: how far that carries is always told.
    let check = options.check.or((options.strain == Strain::Finite).then_some(Strain::Finite));
    let checked = check.map(|strain| {
        progress.counted_step("check", n_checked, "frames", |done| track.check(&frames, strain, done))
    });
    let checked = checked
        .transpose()
        .map_err(|error| CliError::Study { face: loaded.called.clone(), error: Box::new(error) })?;
    let beyond = progress.step("strongest_frame", || beyond_reach(&track, &frames, &loaded))?;

    let intervals = options.intervals.map(usize::from).map(|every| {
        let found = progress.step("intervals", || track.intervals(&frames, every, &options.discrepancy));
        (IntervalsJson::of(&track, &found, every, &options.discrepancy), found)
    });

    let mut set = FileSet::new(&options.out);
    let table = tracked_activations(&track, &frames);
    set.put("activations.csv", table.to_csv().into_bytes());
    set.put("activations.sto", sto_text("activations", &table).into_bytes());
    #[cfg(feature = "parquet")]
    set.put("activations.parquet", table.parquet().map_err(CliError::Parquet)?);
    set.put("frames.csv", frames_csv(&track, &frames, document.recording.frame_names()).into_bytes());
    set.put("residuals.csv", residuals_csv(&track, &frames).into_bytes());
    match &intervals {
        Some((_, found)) => set.put(INTERVALS, intervals_csv(&track, &frames, found).into_bytes()),
        None => set.without(INTERVALS),
    }
    if let Some(every) = options.series {
        let shown: Vec<usize> = (0..frames.len()).step_by(every.into()).collect();
        let fields = progress
            .counted_step("series", shown.len(), "frames", |done| track.displacements(&frames, &shown, done))
            .map_err(|error| CliError::Displacements(Box::new(error)))?;
        put_series(&mut set, &track, &shown, fields, &loaded)?;
    }
    for old in old_series(&options.out) {
        set.without(&old);
    }
    let mut json = json(options, &document, &loaded, &track, &frames, &summary, inputs);
    json.warnings.extend(beyond);
    json.checked = checked.as_ref().map(CheckedJson::of);
    json.warnings.extend(checked.iter().flat_map(|checked| &checked.failed).map(|(frame, error)| {
        format!(
            "frame {frame}, in which the muscles of its block do most, could not be settled anew: {error}"
        )
    }));
    json.intervals = intervals.map(|(told, _)| told);
    json.timings_s = progress.timings_s();
    json.files = set.sha256();
    let text = json.to_text()?;
    set.put("summary.json", text.clone().into_bytes());
    let written = set.write()?;
    blocks.remove();
    say(&format!("wrote {} to {}", counted(written.len(), "file"), options.out.display()));
    let solved = summary.frames[&FrameStatus::Ok] > 0 && summary.frames[&FrameStatus::NotSolved] == 0;
    Ok(Outcome { text: if options.json { text } else { told(options, &json) }, solved })
}

/// Everything on which the frames depend, as one fingerprint.
fn key(
    options: &TrackOptions,
    loaded: &LoadedFace,
    inputs: &BTreeMap<String, String>,
) -> Result<String, CliError> {
    let TrackOptions { input, strength, strain, stiffness, contact, .. } = options;
    let ReadOptions { unit, rate_hz, image, scale, .. } = input.stated();
    let version = env!("CARGO_PKG_VERSION");
    let contents: Vec<&String> = inputs.values().collect();
    let all = format!(
        "{version} {} {} {strength} {strain:?} {stiffness:?} {contact:?} {unit:?} {rate_hz:?} {image:?} {scale:?} {}",
        loaded.name,
        options.map.is_some(),
        serde_json::to_string(&contents)?
    );
    Ok(sha256(all.as_bytes()))
}

/// All frames; those of blocks that are kept already are not fitted again.
fn fit(track: &Track, blocks: &TrackBlocks, progress: &mut Progress) -> Result<Vec<TrackedFrame>, CliError> {
    let total = track.times_s().len();
    let failed = Mutex::new(None);
    let has_failed = AtomicBool::new(false);
    let frames = progress.counted_step("track", total, "frames", |done| {
        track.fit_all(|block| {
            // Nothing more can be kept: what is left is not worth fitting.
            if has_failed.load(Ordering::Relaxed) {
                return Vec::new();
            }
            let frames = blocks.load(&block).unwrap_or_else(|| {
                let frames = track.fit(block.clone());
                if let Err(error) = blocks.save(&block, &frames) {
                    has_failed.store(true, Ordering::Relaxed);
                    failed.lock().unwrap_or_else(|e| e.into_inner()).get_or_insert(error);
                }
                frames
            });
            done(block.len());
            frames
        })
    });
    match failed.into_inner().unwrap_or_else(|e| e.into_inner()) {
        Some(error) => Err(error.into()),
        None => Ok(frames),
    }
}

/// What is told of the tissue in the frame in which the muscles do most, where it is more than tissue can bear.
fn beyond_reach(
    track: &Track,
    frames: &[TrackedFrame],
    loaded: &LoadedFace,
) -> Result<Vec<String>, CliError> {
    let effort = |frame: &TrackedFrame| frame.unknowns[..track.held.len()].iter().map(|a| a * a).sum::<f64>();
    let most = (0..frames.len()).max_by(|a, b| effort(&frames[*a]).total_cmp(&effort(&frames[*b])));
    let Some(most) = most else { return Ok(Vec::new()) };
    let fields = match track.displacements(frames, &[most], |_| ()) {
        Ok(fields) => fields,
        Err(TrackError::Finite(error @ FiniteError::NoRest { .. })) => {
            return Ok(vec![format!("frame {most}, in which the muscles do most: {error}")]);
        }
        Err(error) => return Err(CliError::Displacements(Box::new(error))),
    };
    let told = |u: &Vec<f64>| beyond(track.strain(), &Deformation::of(&loaded.face.mesh, u));
    Ok(fields
        .iter()
        .flat_map(told)
        .map(|warning| format!("frame {most}, in which the muscles do most: {warning}"))
        .collect())
}

/// The frames `shown` as VTU, their displacements being `fields`, and a PVD that says when each is.
fn put_series(
    set: &mut FileSet,
    track: &Track,
    shown: &[usize],
    fields: Vec<Vec<f64>>,
    loaded: &LoadedFace,
) -> Result<(), CliError> {
    let mut pvd = String::from(
        "<?xml version=\"1.0\"?>\n<VTKFile type=\"Collection\" version=\"0.1\">\n<Collection>\n",
    );
    for (&frame, displacement) in shown.iter().zip(fields) {
        let name = format!("{}{frame:06}.vtu", SERIES[1]);
        let data = VtuData {
            point_vectors: [("displacement".to_owned(), displacement)].into(),
            ..VtuData::default()
        };
        set.put(&name, vtu_text(name.as_ref(), &loaded.face.mesh, &data)?.into_bytes());
        let time_s = track.times_s()[frame];
        pvd += &format!("<DataSet timestep=\"{time_s}\" part=\"0\" file=\"{name}\"/>\n");
    }
    pvd += "</Collection>\n</VTKFile>\n";
    set.put(SERIES[0], pvd.into_bytes());
    Ok(())
}

/// Files of an older series in `out`.
fn old_series(out: &Path) -> Vec<String> {
    let names =
        std::fs::read_dir(out).into_iter().flatten().filter_map(|e| e.ok()?.file_name().into_string().ok());
    let is_of_series = |name: &String| {
        let number = name.strip_prefix(SERIES[1]).and_then(|n| n.strip_suffix(".vtu"));
        name == SERIES[0] || number.is_some_and(|n| n.bytes().all(|b| b.is_ascii_digit()))
    };
    names.filter(is_of_series).collect()
}

fn json(
    options: &TrackOptions,
    document: &RecordingDocument,
    loaded: &LoadedFace,
    track: &Track,
    frames: &[TrackedFrame],
    summary: &TrackSummary,
    inputs: BTreeMap<String, String>,
) -> TrackJson {
    let m = track.held.len();
    let range = |of: &dyn Fn(&TrackedFrame) -> f64| {
        let values = || frames.iter().map(of);
        let mean = values().sum::<f64>() / frames.len() as f64;
        [values().fold(f64::INFINITY, f64::min), mean, values().fold(f64::NEG_INFINITY, f64::max)]
    };
    let opening = |frame: &TrackedFrame| track.mechanism().jaw_mm(&frame.unknowns).map_or(0., |jaw| jaw[0]);
    let muscles = &track.mechanism().muscles;
    let mut warnings: Vec<String> = document.warnings.iter().map(ToString::to_string).collect();
    warnings.extend(track.subject.warnings.iter().map(ToString::to_string));
    warnings.extend(track.movement.swaps.iter().map(|swap| {
        let [a, b] = &swap.labels;
        let [from, to] = swap.frames;
        format!("`{a}` and `{b}` were exchanged in frames {from} to {to}, and exchanged back; check the labels there")
    }));
    let without_rest: usize = track.rounds().iter().map(|round| round.without_rest).sum();
    if without_rest > 0 {
        warnings.push(format!(
            "the face does not come to rest at {} about which frames were to be described: they are described from farther away",
            counted(without_rest, "place")
        ));
    }
    let times_s = track.times_s();
    TrackJson {
        recording: input_name(&options.input.recording),
        face: loaded.name.clone(),
        strength: options.strength,
        contact_mode: options.contact.name().to_owned(),
        frames: times_s.len(),
        from_s: times_s.first().copied().unwrap_or_default(),
        to_s: times_s.last().copied().unwrap_or_default(),
        statuses: summary.frames.iter().map(|(status, n)| (status.name().to_owned(), *n)).collect(),
        all: MetJson::from(&summary.all),
        regions: summary.regions.iter().map(|(name, met)| (name.clone(), MetJson::from(met))).collect(),
        markers: BoundJson::of(track, summary),
        alignment: AlignmentJson::of(track),
        head: HeadJson::of(track),
        swaps: track.movement.swaps.iter().map(SwapJson::from).collect(),
        outliers: summary
            .outliers
            .iter()
            .map(|o| OutlierJson { frame: o.frame, marker: o.marker.clone(), residual_mm: o.residual_mm })
            .collect(),
        strain: track.strain().name().to_owned(),
        settled: track.rounds().iter().map(SettledJson::from).collect(),
        stiffness: track.stiffness().text(),
        held_stiffness: muscles.iter().cloned().zip(track.held.iter().copied()).collect(),
        activations: muscles.iter().cloned().zip((0..m).map(|k| range(&|frame| frame.unknowns[k]))).collect(),
        jaw_opening_mm: track.mechanism().jaw().map(|_| range(&opening)),
        intervals: None,
        checked: None,
        certificate: summary.certificate,
        warnings,
        face_warnings: loaded.warnings.clone(),
        timings_s: BTreeMap::new(),
        inputs,
        files: BTreeMap::new(),
        version: env!("CARGO_PKG_VERSION").to_owned(),
    }
}

fn told(options: &TrackOptions, json: &TrackJson) -> String {
    let mut text = format!(
        "{} on {}: {} from {:.2} to {:.2} s\n",
        json.recording,
        json.face,
        counted(json.frames, "frame"),
        json.from_s,
        json.to_s
    );
    let statuses: Vec<String> =
        json.statuses.iter().filter(|(_, n)| **n > 0).map(|(status, n)| format!("{n} {status}")).collect();
    text += &format!("frames: {}\n", statuses.join(", "));
    text += &format!(
        "head: scale {:.3} to the face, landmarks {:.1} mm off, followed by {} to {:.2} mm\n",
        json.alignment.scale,
        json.alignment.rms_mm,
        counted(json.head.stable.len(), "marker"),
        json.head.rms_mm
    );
    text += "\nregion          markers x frames   moved mm   residual mm   explained\n";
    let mut row = |name: &str, met: &Met| {
        let explained = met.explained.map_or("      -".to_owned(), |share| format!("{:5.0} %", 100. * share));
        text += &format!(
            "{:15} {:16} {:10.2} {:13.2}     {explained}\n",
            name.replace('_', " "),
            met.observations,
            met.movement_mm,
            met.rms_mm
        );
    };
    let met = |m: &MetJson| Met {
        observations: m.observations,
        rms_mm: m.rms_mm,
        movement_mm: m.movement_mm,
        explained: m.explained,
    };
    json.regions.iter().for_each(|(name, m)| row(name, &met(m)));
    row("all", &met(&json.all));
    let width = json.activations.keys().map(String::len).max().unwrap_or(0);
    let widths = json.intervals.as_ref().map(|found| &found.mean_width);
    let head = if widths.is_some() { "   interval" } else { "" };
    text += &format!("\n{:width$}   activation, per cent: least   mean   most{head}\n", "muscle");
    for (muscle, [least, mean, most]) in &json.activations {
        text += &format!("{muscle:width$} {:29.0} {:6.0} {:6.0}", 100. * least, 100. * mean, 100. * most);
        if let Some(width) = widths.and_then(|widths| widths.get(muscle)) {
            text += &format!(" {:10.0}", 100. * width);
        }
        text.push('\n');
    }
    if let Some([least, mean, most]) = json.jaw_opening_mm {
        text += &format!("{:width$} {least:29.1} {mean:6.1} {most:6.1}\n", "jaw opening, mm");
    }
    let settled: usize = json.settled.iter().map(|round| round.states).sum();
    if let Some(last) = json.settled.last() {
        text += &format!(
            "\nat finite strain about {}: the markers of the last {} were {:.2} mm (rms) from where those before had them, {:.2} at most\n",
            counted(settled, "settled face"),
            last.states,
            last.rms_mm,
            last.most_mm
        );
    }
    if let Some(checked) = &json.checked {
        text += &format!(
            "\nsettled anew at {} strain, {}:\n",
            checked.strain,
            counted(checked.frames.len(), "frame")
        );
        for frame in &checked.frames {
            text += &format!(
                "frame {}: markers {:.2} mm (rms) from where they were fitted, {:.2} at most; residual {:.2} mm\n",
                frame.frame, frame.rms_mm, frame.most_mm, frame.residual_mm
            );
        }
    }
    if !json.outliers.is_empty() {
        let mut by_marker: BTreeMap<&str, usize> = BTreeMap::new();
        json.outliers.iter().for_each(|o| *by_marker.entry(&o.marker).or_default() += 1);
        let named: Vec<String> = by_marker.iter().map(|(marker, n)| format!("{marker} ({n})")).collect();
        text += &format!(
            "\nleft out as outliers, {}: {}; {} names the frames\n",
            counted(json.outliers.len(), "time"),
            named.join(", "),
            options.out.join("frames.csv").display()
        );
    }
    for warning in &json.warnings {
        text += &format!("warning: {warning}\n");
    }
    text
}
