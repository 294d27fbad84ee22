//! `modiolus report`.

use std::path::Path;

use modiolus::face::Face;
use modiolus::io::{AnswerFiles, TrackFiles, read_activations, read_track, write_atomically};
use modiolus::report::{
    MOST_FRAMES, MOST_RESULTS, Motion, MotionState, ReportError, ShownResult, Told, page, tracked_motion,
};
use modiolus::study::{Mechanics, Strain};

use super::Outcome;
use super::arguments::{ContactMode, FaceChoice, ReportOptions, parse_stiffness};
use super::error::CliError;
use super::export::keep_inputs;
use super::load::{LoadedFace, input_name, load, pose};
use super::progress::{Progress, say};
use super::render::read_moved;

/// A result that was read, with its face.
pub(crate) struct Read {
    pub(crate) title: String,
    pub(crate) loaded: LoadedFace,
    pub(crate) answer: AnswerFiles,
}

pub(crate) fn run(options: &ReportOptions) -> Result<Outcome, CliError> {
    if let Some(track) = options.results.iter().find(|folder| TrackFiles::is_in(folder)) {
        return tracked(track, options);
    }
    if let (Some(_), [first, ..]) = (options.every, &options.results[..]) {
        return Err(CliError::EveryOfNoTrack(first.clone()));
    }
    let found = options.results.len();
    if found > MOST_RESULTS && !options.sequence {
        return Err(ReportError::Results { found }.into());
    }
    let mut progress = Progress::new();
    let mut read: Vec<Read> = Vec::new();
    for folder in &options.results {
        read.push(result(folder, &mut progress)?);
    }
    for Read { loaded, answer, .. } in &read {
        let inputs =
            answer.inputs.iter().chain(&loaded.inputs).map(|(name, sha)| (name.clone(), sha.clone()));
        keep_inputs(&inputs.collect(), [options.out.clone()])?;
    }
    let (faces, of) = faces(&read);
    if options.sequence
        && let Some(other) = of.iter().position(|face| *face != of[0])
    {
        let [first, other] = [0, other].map(|k| options.results[k].clone());
        return Err(CliError::SequenceOfFaces { first, other });
    }
    let shown = match options.sequence {
        true => vec![sequence(&read, options, &mut progress)?],
        false => {
            let one = |(read, face): (_, &usize)| shown(read, *face, options, &mut progress);
            read.iter().zip(&of).map(one).collect::<Result<_, _>>()?
        }
    };
    write(&faces, &shown, options, &mut progress)
}

fn write(
    faces: &[&Face],
    shown: &[ShownResult<'_>],
    options: &ReportOptions,
    progress: &mut Progress,
) -> Result<Outcome, CliError> {
    let html = progress.step("put together", || page(faces, shown))?;
    write_atomically(&options.out, html.as_bytes())?;
    say(&format!("wrote {}, {:.1} MB", options.out.display(), html.len() as f64 / 1e6));
    Ok(Outcome { text: format!("{}\n", options.out.display()), solved: true })
}

/// The page of the track in `folder`.
fn tracked(folder: &Path, options: &ReportOptions) -> Result<Outcome, CliError> {
    if options.results.len() > 1 || options.sequence || options.frames.is_some() {
        return Err(CliError::TrackAlone(folder.to_owned()));
    }
    let mut progress = Progress::new();
    let track = progress.step("read", || read_track(folder))?;
    let summary = &track.summary;
    let loaded = load(&FaceChoice::named(&summary.face), &mut progress)?.with_strength(summary.strength);
    for (input, sha256) in &loaded.inputs {
        if summary.inputs.get(input) != Some(sha256) {
            return Err(CliError::ChangedInput { dir: folder.to_owned(), input: input.clone() });
        }
    }
    keep_inputs(&summary.inputs, [options.out.clone()])?;
    let every = options.every.map_or_else(|| track.frames.len().div_ceil(MOST_FRAMES), usize::from);
    let shown = track.frames.len().div_ceil(every.max(1));
    let motion = progress
        .counted_step("move the face", shown, "frames", |done| {
            tracked_motion(&loaded.face, &track, every, done)
        })
        .map_err(|error| CliError::Displacements(Box::new(error)))?;
    let recording = Path::new(&summary.recording).file_name().unwrap_or_default().to_string_lossy();
    let title = format!("{recording} on {}", loaded.face.name);
    let shown = [ShownResult { title, told: Told::Track(&track), face: 0, motion }];
    write(&[&loaded.face], &shown, options, &mut progress)
}

pub(crate) fn result(folder: &Path, progress: &mut Progress) -> Result<Read, CliError> {
    let (mut loaded, answer) = read_moved(folder, progress)?;
    if let Some(index) = &answer.operated {
        loaded.face.teeth = load(&FaceChoice::File(index.clone()), progress)?.face.teeth;
    }
    let named = answer.target.as_ref().map(|target| format!("{} on {}", target.name, loaded.face.name));
    Ok(Read { title: named.unwrap_or_else(|| input_name(folder)), loaded, answer })
}

/// The faces that differ, and which of them each result moves.
fn faces(read: &[Read]) -> (Vec<&Face>, Vec<usize>) {
    let mut faces: Vec<&Face> = Vec::new();
    let mut place = |face| {
        faces.iter().position(|known| *known == face).unwrap_or_else(|| {
            faces.push(face);
            faces.len() - 1
        })
    };
    let of = read.iter().map(|r| place(&r.loaded.face)).collect();
    (faces, of)
}

fn state(Read { loaded, answer, .. }: &Read, label: &str, time: f64) -> MotionState {
    let of = |name: &String| answer.activations.get(name).copied().unwrap_or(0.);
    MotionState {
        label: label.to_owned(),
        time,
        activation: loaded.face.muscles.iter().map(|m| of(&m.name)).collect(),
        displacement: Some(answer.displacement.clone()),
        pressure_kpa: answer.pressure_kpa.clone(),
        pose: pose(&loaded.face, answer.jaw_opening_mm),
        residual_mm: Vec::new(),
    }
}

/// How `read` is moved, from rest in so many parts.
pub(crate) fn motion(read: &Read, parts: u8, progress: &mut Progress) -> Result<Motion, CliError> {
    let answer = state(read, "the answer", 1.);
    let is_still = answer.pose.is_rest() && answer.activation.iter().all(|a| *a == 0.);
    let face = &read.loaded.face;
    let Some(mechanics) = mechanics(&read.answer).filter(|_| read.answer.operated.is_none() && !is_still)
    else {
        return Ok(Motion::straight(face, answer));
    };
    let strength = if read.answer.strength > 0. { read.answer.strength } else { 1. };
    let face = face.clone().with_strength(strength);
    progress
        .step("settle on the way", || Motion::loading(&face, mechanics, answer, usize::from(parts)))
        .map_err(|error| CliError::Study { face: read.loaded.called.clone(), error: Box::new(error) })
}

/// The mechanics that an answer was computed with; `None` where it does not say.
pub(crate) fn mechanics(answer: &AnswerFiles) -> Option<Mechanics> {
    Some(Mechanics {
        strain: Strain::parse(&answer.strain)?,
        stiffness: parse_stiffness(&answer.stiffness).ok()?,
        contact: ContactMode::named(&answer.contact_mode)? != ContactMode::Off,
    })
}

fn shown<'a>(
    read: &'a Read,
    face: usize,
    options: &ReportOptions,
    progress: &mut Progress,
) -> Result<ShownResult<'a>, CliError> {
    let mut motion = match options.frames {
        // Frames need the tangent alone.
        Some(_) => motion(read, 1, progress)?,
        None => motion(read, options.parts, progress)?,
    };
    if let Some(path) = &options.frames {
        if motion.tangent.is_empty() {
            return Err(CliError::NoTangent(read.title.clone()));
        }
        let muscles: Vec<String> = read.loaded.face.muscles.iter().map(|m| m.name.clone()).collect();
        let table = read_activations(path, &muscles)?;
        let frame = |(k, time): (usize, &f64)| MotionState {
            label: format!("{time:.2} s"),
            time: *time,
            activation: table.of(k, &muscles),
            displacement: None,
            pressure_kpa: None,
            pose: motion.answer.pose.clone(),
            residual_mm: Vec::new(),
        };
        let states = table.times_s.iter().enumerate().map(frame).collect();
        motion = motion.with_sequence(states);
    }
    Ok(ShownResult { title: read.title.clone(), told: Told::Answer(&read.answer), face, motion })
}

/// All results as one, a second apart; the tangent is that of the last.
fn sequence<'a>(
    read: &'a [Read],
    options: &ReportOptions,
    progress: &mut Progress,
) -> Result<ShownResult<'a>, CliError> {
    let last = &read[read.len() - 1];
    let states = read.iter().enumerate().map(|(k, read)| state(read, &read.title, k as f64)).collect();
    let motion = motion(last, 1, progress)?.with_sequence(states);
    let title = format!("{} results on {}", options.results.len(), last.loaded.face.name);
    Ok(ShownResult { title, told: Told::Answer(&last.answer), face: 0, motion })
}
