//! `modiolus render`.

use std::path::Path;

use modiolus::face::Pose;
use modiolus::io::{AnswerFiles, read_answer, write_atomically};
use modiolus::render::{Drawing, Image, RenderError, Scene, Show};
use modiolus::study::{Mechanics, Mover};

use super::Outcome;
use super::activation_list::resolve;
use super::arguments::{FaceChoice, RenderOptions};
use super::error::CliError;
use super::export::keep_inputs;
use super::load::{LoadedFace, load, pose};
use super::progress::{Progress, say};

/// A face and how it is moved.
struct Posed {
    loaded: LoadedFace,
    activation: Option<Vec<f64>>,
    displacement: Option<Vec<f64>>,
    pose: Pose,
}

pub(crate) fn run(options: &RenderOptions) -> Result<Outcome, CliError> {
    let mut progress = Progress::new();
    let posed = match &options.face {
        FaceChoice::File(path) if path.is_dir() || path.extension().is_none_or(|e| e != "toml") => {
            answer(path, options, &mut progress)?
        }
        face => activated(face, options, &mut progress)?,
    };
    let Posed { loaded, activation, displacement, pose } = &posed;
    keep_inputs(&loaded.inputs, [options.out.clone()])?;
    let show = options.show.unwrap_or(Show::FACE);
    // By default teeth are shown where there are any.
    if options.show.is_some_and(|show| show.teeth) && loaded.face.teeth.is_empty() {
        return Err(CliError::NoTeeth { face: loaded.called.clone() });
    }
    if show.displacement && displacement.is_none() {
        return Err(CliError::NothingMoves);
    }
    let scene = progress.step("prepare", || Scene::new(&loaded.face));
    let drawing = Drawing {
        view: options.view,
        size: (options.size.0, options.size.1),
        show,
        displacement: displacement.as_deref(),
        pose: pose.clone(),
        activation: activation.as_deref(),
        rest_outline: options.rest_outline,
        ..Drawing::default()
    };
    let image = progress.step("draw", || scene.draw(&drawing))?;
    write_image(&options.out, &image)?;
    Ok(Outcome { text: format!("{}\n", options.out.display()), solved: true })
}

/// Writes a picture as a PNG file.
pub(crate) fn write_image(path: &Path, image: &Image) -> Result<(), CliError> {
    let bytes = image.to_png()?;
    write_atomically(path, &bytes)?;
    say(&format!(
        "wrote {}, {} x {} pixels, {} kB",
        path.display(),
        image.width,
        image.height,
        bytes.len() / 1000
    ));
    Ok(())
}

fn activated(face: &FaceChoice, options: &RenderOptions, progress: &mut Progress) -> Result<Posed, CliError> {
    let loaded = load(face, progress)?.with_strength(options.strength);
    if options.activate.is_empty() {
        return Ok(Posed { loaded, activation: None, displacement: None, pose: Pose::rest() });
    }
    let muscles: Vec<String> = loaded.face.muscles.iter().map(|m| m.name.clone()).collect();
    let activation = resolve(&options.activate, &muscles)?;
    let poses = [activation.clone()];
    let mut moved = displacements(&loaded, &poses, options.mechanics(), progress)?;
    Ok(Posed { loaded, activation: Some(activation), displacement: moved.pop(), pose: Pose::rest() })
}

/// Displacement (3n, mm) under each of the activations `poses`.
pub(crate) fn displacements(
    loaded: &LoadedFace,
    poses: &[Vec<f64>],
    mechanics: Mechanics,
    progress: &mut Progress,
) -> Result<Vec<Vec<f64>>, CliError> {
    let study = |error| CliError::Study { face: loaded.called.clone(), error: Box::new(error) };
    let mover = progress.step("assemble", || Mover::new(&loaded.face, mechanics)).map_err(study)?;
    let settle = |pose: &Vec<f64>| {
        let moved = progress.step("settle", || mover.settle(pose, &Pose::rest())).map_err(study)?;
        Ok(moved.displacement)
    };
    poses.iter().map(settle).collect()
}

fn answer(dir: &Path, options: &RenderOptions, progress: &mut Progress) -> Result<Posed, CliError> {
    if !options.activate.is_empty() {
        return Err(CliError::ActivatedAnswer { dir: dir.to_owned() });
    }
    let (mut loaded, files) = read_moved(dir, progress)?;
    let of = |name: &String| files.activations.get(name).copied().unwrap_or(0.0);
    let activation = loaded.face.muscles.iter().map(|m| of(&m.name)).collect();
    let pose = pose(&loaded.face, files.jaw_opening_mm);
    if let Some(index) = files.operated {
        loaded.face.teeth = load(&FaceChoice::File(index), progress)?.face.teeth;
    }
    Ok(Posed { loaded, activation: Some(activation), displacement: Some(files.displacement), pose })
}

/// The answer in the folder `dir`, and the face that it moves.
pub(crate) fn read_moved(dir: &Path, progress: &mut Progress) -> Result<(LoadedFace, AnswerFiles), CliError> {
    let files = read_answer(dir)?;
    let choice = FaceChoice::named(&files.face);
    let unread = |reason| CliError::FaceOfAnswer {
        dir: dir.to_owned(),
        face: files.face.clone(),
        reason: Box::new(reason),
    };
    let loaded = load(&choice, progress).map_err(unread)?;
    let expected = 3 * loaded.face.mesh.n_nodes();
    if files.displacement.len() != expected {
        let (what, found) = ("displacement", files.displacement.len());
        let error = RenderError::Length { what, found, expected };
        return Err(CliError::AnswerOfOtherFace { path: files.vtu, error });
    }
    Ok((loaded, files))
}
