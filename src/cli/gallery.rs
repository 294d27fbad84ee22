//! `modiolus gallery`.

use std::fs;
use std::path::{Path, PathBuf};
use std::process::{Child, Command, ExitStatus, Stdio};
use std::thread;
use std::time::{Duration, Instant};

use modiolus::io::{AnswerFiles, TargetDocument, WriteError, read_answer, read_targets, write_atomically};
use modiolus::render::{Scene, TitledPose, front_and_profile};
use modiolus::report::{GalleryFigures, GalleryFit, GalleryTarget, gallery_text};
use modiolus::study::Strain;

use super::Outcome;
use super::arguments::GalleryOptions;
use super::error::CliError;
use super::figures::only_figures;
use super::load::{LoadedFace, input_name, load, pose};
use super::progress::{Progress, say};
use super::render::write_image;

/// The page.
const INDEX: &str = "README.md";
/// How often a fit is looked after.
const GLANCE: Duration = Duration::from_millis(100);

/// By which strain and strength a target is fitted.
#[derive(Clone, Copy)]
struct Model {
    strain: Strain,
    strength: f64,
}

impl Model {
    fn called(self) -> String {
        match self.strength {
            1. => format!("{} strain", self.strain.name()),
            strength => format!("{} strain, muscles {strength} times as strong", self.strain.name()),
        }
    }
}

pub(crate) fn run(options: &GalleryOptions) -> Result<Outcome, CliError> {
    let targets = read_targets(&options.targets)?;
    let mut progress = Progress::new();
    let loaded = load(&options.face, &mut progress)?;
    let out = &options.out;
    only_figures(out, &[INDEX])?;
    fs::create_dir_all(out).map_err(|reason| WriteError::new(out, reason))?;
    let models = [
        Model { strain: Strain::Linear, strength: 1. },
        Model { strain: Strain::Finite, strength: options.strength },
    ];
    let scene = progress.step("prepare", || Scene::new(&loaded.face));
    let (mut shown, mut list) = (Vec::new(), String::new());
    for (path, document) in &targets {
        let target = &document.target;
        let mut answers = Vec::new();
        for model in models {
            let folder = options.answers.join(&target.name).join(model.strain.name());
            answers.push(answer(&loaded, (path, document), model, &folder, options)?);
        }
        let poses: Vec<TitledPose<'_>> = models
            .iter()
            .zip(&answers)
            .map(|(model, answer)| TitledPose {
                title: match answer {
                    Ok(_) => model.called(),
                    Err(why) => format!("{}: {why}", model.called()),
                },
                displacement: answer.as_ref().ok().map(|answer| answer.displacement.as_slice()),
                pose: answer
                    .as_ref()
                    .map_or_else(|_| pose(&loaded.face, None), |a| pose(&loaded.face, a.jaw_opening_mm)),
            })
            .collect();
        let picture = format!("{}.png", target.name);
        let image = progress.step("draw", || front_and_profile(&scene, &poses))?;
        write_image(&out.join(&picture), &image)?;
        list += &format!("{}\n", out.join(&picture).display());
        let fit = |(model, answer): (Model, Result<AnswerFiles, String>)| GalleryFit {
            model: model.called(),
            answer: answer.map(|answer| GalleryFigures::of(&answer)),
        };
        shown.push(GalleryTarget {
            name: target.name.clone(),
            description: target.description.clone(),
            provenance: target.provenance.clone(),
            picture,
            fits: models.into_iter().zip(answers).map(fit).collect(),
        });
    }
    let command = format!("modiolus gallery --out {}", out.display());
    let text = gallery_text(&loaded.called, &command, &shown);
    write_atomically(&out.join(INDEX), text.as_bytes())?;
    list += &format!("{}\n", out.join(INDEX).display());
    Ok(Outcome { text: list, solved: true })
}

/// The answer to a target in `folder`, fitted where none of the same target, face and model is there yet; why there is none.
fn answer(
    loaded: &LoadedFace,
    target: (&Path, &TargetDocument),
    model: Model,
    folder: &Path,
    options: &GalleryOptions,
) -> Result<Result<AnswerFiles, String>, CliError> {
    if let Some(known) = stored(loaded, target, model, folder) {
        return Ok(Ok(known));
    }
    let minutes = options.minutes;
    say(&format!("{}, {}: fitted for at most {minutes} min", target.1.target.name, model.called()));
    // A process of its own can be ended wherever it is.
    let fit = fit_command(loaded, target.0, model, folder)?;
    let limit = Duration::from_secs(60 * u64::from(minutes));
    let Some(ended) = within(fit, limit).map_err(CliError::Process)? else {
        return Ok(Err(format!("no answer within {minutes} min")));
    };
    match stored(loaded, target, model, folder) {
        Some(found) => Ok(Ok(found)),
        None if ended.code() == Some(1) => Ok(Err("no answer".to_owned())),
        None => Err(CliError::GalleryFit { target: target.0.to_owned() }),
    }
}

/// `modiolus fit` of the file `target`, whose talk is ours.
fn fit_command(loaded: &LoadedFace, target: &Path, model: Model, folder: &Path) -> Result<Child, CliError> {
    let program: PathBuf = std::env::current_exe().map_err(CliError::Process)?;
    Command::new(program)
        .arg("fit")
        .arg(target)
        .args(["--face", &loaded.name, "--strain", model.strain.name()])
        .args(["--strength", &model.strength.to_string(), "--out"])
        .arg(folder)
        .stdin(Stdio::null())
        .stdout(Stdio::null())
        .spawn()
        .map_err(CliError::Process)
}

/// How `child` ended; `None` where it did not within `limit` and was ended.
fn within(mut child: Child, limit: Duration) -> std::io::Result<Option<ExitStatus>> {
    let start = Instant::now();
    loop {
        if let Some(status) = child.try_wait()? {
            return Ok(Some(status));
        }
        if start.elapsed() >= limit {
            child.kill()?;
            child.wait()?;
            return Ok(None);
        }
        thread::sleep(GLANCE);
    }
}

/// The answer in `folder`, if it is one to this target on this face by this model, and moves it.
fn stored(
    loaded: &LoadedFace,
    (path, document): (&Path, &TargetDocument),
    model: Model,
    folder: &Path,
) -> Option<AnswerFiles> {
    let answer = read_answer(folder).ok()?;
    let inputs = loaded.inputs.iter().map(|(name, sha)| (name.clone(), sha));
    let mut inputs = inputs.chain([(input_name(path), &document.sha256)]);
    let is_same = answer.face == loaded.name
        && answer.strain == model.strain.name()
        && answer.strength == model.strength
        && answer.displacement.len() == 3 * loaded.face.mesh.n_nodes()
        && inputs.all(|(name, sha)| answer.inputs.get(&name) == Some(sha));
    is_same.then_some(answer)
}
