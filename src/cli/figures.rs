//! `modiolus figures`.

use std::fs;
use std::path::Path;

use modiolus::certainty::Discrepancy;
use modiolus::forward::operate;
use modiolus::io::{WriteError, read_plan, read_target};
use modiolus::render::{
    Action, Drawing, Image, Scene, Show, action_sheet, before_and_after, contact_sheet, force_sheet,
    muscle_stems, three_views,
};

use modiolus::study::Stiffness;

use super::Outcome;
use super::arguments::{ContactMode, FiguresOptions, FitOptions};
use super::error::CliError;
use super::file_name;
use super::fit::fit_on;
use super::load::{LoadedFace, load};
use super::progress::Progress;
use super::render::{displacements, write_image};

/// The muscles of the seed's figure 3.
const FORCES: [&str; 2] = ["zygomaticus_major", "orbicularis_oris_peripheralis"];
pub(crate) fn run(options: &FiguresOptions) -> Result<Outcome, CliError> {
    let mut progress = Progress::new();
    let loaded = load(&options.common.face, &mut progress)?.with_strength(options.common.strength);
    let face = &loaded.face;
    let out = &options.out;
    only_figures(out, &[])?;
    fs::create_dir_all(out).map_err(|reason| WriteError::new(out, reason))?;
    let stems = muscle_stems(face);
    let stem_of = |name: &str| {
        stems.iter().find(|s| [(*s).clone(), format!("{s}_l"), format!("{s}_r")].contains(&name.to_owned()))
    };
    let pose = |of: &dyn Fn(&str) -> f64| -> Vec<f64> {
        face.muscles.iter().map(|m| stem_of(&m.name).map_or(0.0, |s| of(s))).collect()
    };
    let poses: Vec<Vec<f64>> =
        stems.iter().map(|stem| pose(&|s| if s == stem { options.activation } else { 0.0 })).collect();
    let asked = FitOptions {
        targets: vec![options.smile.clone()],
        common: options.common.clone(),
        out: None,
        contact: ContactMode::Reactions,
        discrepancy: Discrepancy::ANATOMY,
        json: false,
        junit: None,
    };
    let target = read_target(&options.smile)?;
    let smile = fit_on(&loaded, &target, &options.smile, &asked, Progress::new())?;
    let plan = read_plan(&options.plan)?.plan;
    let operated = progress
        .step("operate", || operate(&plan, face))
        .map_err(|error| CliError::Operation { plan: options.plan.clone(), error: Box::new(error) })?;
    let after = LoadedFace { face: operated.face, ..loaded.clone() };
    let smile_after = fit_on(&after, &target, &options.smile, &asked, Progress::new())?;
    let stiffness = options.common.stiffness;
    let mechanics = options.common.mechanics(ContactMode::Reactions);
    let moved = displacements(&loaded, &poses, mechanics, &mut progress)?;

    let scene = progress.step("prepare", || Scene::new(face));
    let mut list = String::new();
    let mut write = |name: &str, image: &Image| -> Result<(), CliError> {
        let path = out.join(name);
        list += &format!("{}\n", path.display());
        write_image(&path, image)
    };
    write("rest.png", &three_views(&scene, &Drawing::default())?)?;
    if let Some(u) = &smile.answer.displacement {
        write("smile.png", &three_views(&scene, &Drawing { displacement: Some(u), ..Drawing::default() })?)?;
    }
    let after_scene = progress.step("prepare", || Scene::new(&after.face));
    let both = [&smile, &smile_after].map(|fitted| fitted.answer.displacement.as_deref());
    let sheet = before_and_after([&scene, &after_scene], &[("smile", both)])?;
    write(&format!("{}.png", file_name(&plan.name)), &sheet)?;
    let muscles = Drawing { show: Show { muscles: true, ..Show::FACE }, ..Drawing::default() };
    write("muscles.png", &scene.draw(&Drawing { size: (800, 430), ..muscles })?)?;
    let known: Vec<&str> = FORCES.into_iter().filter(|f| stems.iter().any(|s| s == f)).collect();
    if !known.is_empty() {
        write("forces.png", &progress.step("draw", || force_sheet(&scene, &known))?)?;
    }
    let held = match stiffness {
        Stiffness::Activated => "stiffness as activated".to_owned(),
        Stiffness::Fixed(a) => format!("stiffness held at {a}"),
    };
    let conditions = format!(
        "both sides at activation {}, contact on, {held}, {} strain",
        options.activation,
        options.common.strain.name()
    );
    let action = |((muscle, activation), displacement): ((&String, Vec<f64>), Vec<f64>)| Action {
        muscle: muscle.clone(),
        activation,
        displacement,
        conditions: conditions.clone(),
    };
    let actions: Vec<Action> = stems.iter().zip(poses).zip(moved).map(action).collect();
    for action in &actions {
        let sheet = progress.step("draw", || action_sheet(&scene, action))?;
        write(&format!("action_{}.png", file_name(&action.muscle)), &sheet)?;
    }
    write("actions.png", &progress.step("draw", || contact_sheet(&scene, &actions))?)?;
    Ok(Outcome { text: list, solved: true })
}

/// Refuses a folder in which anything but pictures and files of the names `also` stands: it was not made here.
pub(crate) fn only_figures(folder: &Path, also: &[&str]) -> Result<(), CliError> {
    let Ok(entries) = fs::read_dir(folder) else { return Ok(()) };
    let is_figure = |path: &Path| {
        path.extension().is_some_and(|e| e == "png" || e == "svg")
            || also.iter().any(|name| path.ends_with(name))
    };
    let mut others: Vec<_> =
        entries.flatten().filter(|e| !is_figure(&e.path())).map(|e| e.file_name()).collect();
    others.sort();
    match others.first() {
        Some(found) => {
            let found = found.to_string_lossy().into_owned();
            Err(CliError::OtherFolder { folder: folder.to_owned(), found })
        }
        None => Ok(()),
    }
}
