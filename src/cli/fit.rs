//! `modiolus fit`.

use std::collections::BTreeMap;
use std::path::PathBuf;

use argmin::core::State;
use indicatif::ProgressBar;
use modiolus::face::{ContactReach, ContactSearch, Face};
use modiolus::forward::{Deformation, Model};
use modiolus::inverse::{
    self, ActivatedProblem, ContactFit, Expected, FittedContact, InverseError, Observations, SequentialState,
    Solution, Status, Target, Warning,
};
use modiolus::io::{
    CertificateJson, DeformationJson, ExpectedJson, FeatureJson, FileSet, LimitJson, LinearJson, MarkerJson,
    OtherJson, ResidualJson, SolutionJson, StepJson, TargetDocument, read_target,
};
use modiolus::mesh::{Locator, Site};
use modiolus::units::Vec3;

use super::Outcome;
use super::arguments::{ContactMode, FitOptions, Stiffness};
use super::error::CliError;
use super::export::{ANSWER, Answer, beyond_linear, export, keep_inputs, tell_load};
use super::load::{LoadedFace, input_name, load, pose};
use super::progress::Progress;

/// The activation at which a nonlinear fit first holds the stiffness, to find a start.
const MIDDLE: f64 = 0.5;

/// How far off the face a rest point may lie, mm.
const OFF_FACE_MM: f64 = 5.0;

/// An answer with what was learnt on the way.
struct Found {
    fitted: FittedContact,
    steps: Vec<StepJson>,
    linear: Option<LinearJson>,
    others: Vec<OtherJson>,
}

pub(crate) fn run(options: &FitOptions) -> Result<Outcome, CliError> {
    let Fitted { answer, loaded, out, solved } = fit(options)?;
    let text = export(answer, &loaded.face, FileSet::new(&out), options.json)?;
    Ok(Outcome { text, solved })
}

/// A fit before anything of it is written.
pub(crate) struct Fitted {
    pub(crate) answer: Answer,
    loaded: LoadedFace,
    out: PathBuf,
    solved: bool,
}

fn fit(options: &FitOptions) -> Result<Fitted, CliError> {
    // A wrong target is told before a large face is read.
    let document = read_target(&options.target)?;
    let mut progress = Progress::new();
    let loaded = load(&options.common.face, &mut progress)?;
    let out = out_of(options, &document.target);
    keep_inputs(&loaded, ANSWER.map(|name| out.join(name)))?;
    fit_on(loaded, &document, options, progress)
}

/// The fit of a target on a face that is there already.
pub(crate) fn fit_on(
    mut loaded: LoadedFace,
    document: &TargetDocument,
    options: &FitOptions,
    mut progress: Progress,
) -> Result<Fitted, CliError> {
    loaded.inputs.insert(input_name(&options.target), document.sha256.clone());
    let face = &loaded.face;
    let muscles: Vec<String> = face.muscles.iter().map(|m| m.name.clone()).collect();
    let document = document.expand_patterns(&muscles)?;
    let target = &document.target;
    let at = |error: inverse::TargetError| CliError::Target {
        at: document.lines.location(error.field()),
        error: Box::new(error),
    };
    let observations =
        progress.step("read_face", || Observations::resolve(target, face, locate(face))).map_err(at)?;

    let search = progress.step("contact_pairs", || match options.contact {
        ContactMode::Off => None,
        _ => Some(ContactSearch::new(face, ContactReach::default())),
    });
    let pairs = search.as_ref().map_or_else(Vec::new, |s| s.rest().to_vec());
    let forward = |error| CliError::Forward { face: loaded.called.clone(), error: Box::new(error) };
    let model = progress.step("assemble", || Model::new(face, pairs)).map_err(forward)?;
    let mode = match options.contact {
        ContactMode::Reactions => inverse::ContactMode::Reactions,
        ContactMode::Kinematic => inverse::ContactMode::Kinematic,
        ContactMode::Off => inverse::ContactMode::Off,
    };
    let problem = ActivatedProblem::new(&model, target, &observations, mode);
    let stiffness = options.common.stiffness;
    let held = match stiffness {
        Stiffness::Activated => MIDDLE,
        Stiffness::Fixed(a) => a,
    };
    let linear = progress.step("fit_at_fixed_stiffness", || problem.solve_at_fixed_stiffness(held)).map_err(
        |error| match error {
            InverseError::Target(error) => at(error),
            other => CliError::Inverse(Box::new(other)),
        },
    )?;
    let (search, observed) = (search.as_ref(), &observations);
    let contact = ContactFit { face, search, model: &model, target, observations: observed, mode };
    let is_nonlinear = stiffness == Stiffness::Activated && !linear.activations.values.is_empty();
    let found = progress.told_step("fit", |bar| match is_nonlinear {
        true => activated(contact, problem.start(&linear).as_slice(), &linear, &bar),
        false => Ok(Found {
            fitted: contact.fixed(held, linear)?,
            steps: Vec::new(),
            linear: None,
            others: Vec::new(),
        }),
    });
    let found = found.map_err(|e| CliError::Inverse(Box::new(e)))?;
    let FittedContact { solution, pairs, displacement, overlap_mm, linearisations, .. } = &found.fitted;

    let solved = solution.status == Status::Solved;
    let heading = format!("{} on {}: {}", target.name, loaded.called, solution.status);
    let out = out_of(options, target);
    let deformation = displacement.as_ref().map(|u| Deformation::of(&face.mesh, u));
    let mut json = solution_json(&found, deformation.as_ref(), options, &document, &loaded, progress);
    let mut contact_load = None;
    if let Some(contact) = &mut json.contact {
        (contact.overlap_mm, contact.linearisations) = (*overlap_mm, *linearisations);
        let load = face.contact_load(pairs, solution.contact_forces.as_slice());
        tell_load(contact, &load);
        contact_load = Some(load);
    }
    let (displacement, activation) = (displacement.clone(), solution.activations.values.clone());
    let answer = Answer { heading, json, displacement, activation, contact_load };
    Ok(Fitted { answer, loaded, out, solved })
}

/// The folder for the answer.
fn out_of(options: &FitOptions, target: &Target) -> PathBuf {
    options.out.clone().unwrap_or_else(|| PathBuf::from("out").join(&target.name))
}

fn locate(face: &Face) -> impl Fn(Vec3) -> Result<Site, f64> {
    let locator = Locator::new(&face.mesh);
    move |point| match locator.locate(point) {
        Some(found) if found.distance_mm <= OFF_FACE_MM => Ok(found.site),
        Some(found) => Err(found.distance_mm),
        None => Err(f64::INFINITY),
    }
}

/// What the target file states for this face, held against the answer.
fn expected(solution: &Solution, stated: &[Expected], face: &str) -> Option<ExpectedJson> {
    let stated = stated.iter().find(|e| e.face == face)?;
    let features = solution.features.iter().map(|f| (f.model_mm - f.target_mm).abs());
    let all: Vec<f64> = solution.markers.iter().filter_map(|m| m.residual_mm).chain(features).collect();
    let found_rms_mm = (all.iter().map(|r| r * r).sum::<f64>() / all.len().max(1) as f64).sqrt();
    let (residual_rms_mm, tolerance_mm) = (stated.residual_rms_mm, stated.tolerance_mm);
    let met = solution.status == Status::Solved && (found_rms_mm - residual_rms_mm).abs() <= tolerance_mm;
    Some(ExpectedJson { residual_rms_mm, tolerance_mm, found_rms_mm, met })
}

/// The nonlinear answer from the unknowns `start` of the `linear` one.
fn activated(
    contact: ContactFit<'_>,
    start: &[f64],
    linear: &Solution,
    bar: &ProgressBar,
) -> Result<Found, InverseError> {
    let bar = bar.clone();
    let fitted = contact.activated(start, move |state: &SequentialState| {
        bar.set_message(format!("fit: step {}, objective {:.4}", state.get_iter() + 1, state.get_cost()));
    })?;
    let expected = &linear.observed_mm - &fitted.start_mm;
    let points = (expected.len() / 3).max(1) as f64;
    let off = fitted.solution.activations.values.iter().zip(start).map(|(a, b)| (a - b).abs());
    let most = off.enumerate().max_by(|a, b| a.1.total_cmp(&b.1).then(b.0.cmp(&a.0)));
    let linear = most.map(|(muscle, activation_off)| LinearJson {
        stiffness: MIDDLE,
        muscle: linear.activations.names[muscle].clone(),
        activation_off,
        markers_off_mm: (expected.norm_squared() / points).sqrt(),
    });
    let steps = fitted.history.iter().map(StepJson::from).collect();
    let others = fitted.others.iter().map(OtherJson::from).collect();
    Ok(Found { fitted, steps, linear, others })
}

fn solution_json(
    found: &Found,
    deformation: Option<&Deformation>,
    options: &FitOptions,
    document: &TargetDocument,
    loaded: &LoadedFace,
    progress: Progress,
) -> SolutionJson {
    let solution = &found.fitted.solution;
    let mut warnings: Vec<String> = document.warnings.iter().map(ToString::to_string).collect();
    // The file's own warning about a zero names the line.
    let told = |w: &&Warning| !matches!(w, Warning::ExactZero { .. });
    warnings.extend(solution.warnings.iter().filter(told).map(|w| format!("{w}: {}", w.remedy())));
    let jaw = pose(&loaded.face, solution.jaw_opening_mm);
    warnings.extend(jaw.large_turns().iter().map(ToString::to_string));
    warnings.extend(deformation.map(beyond_linear).into_iter().flatten());
    let is_default =
        options.common.stiffness == Stiffness::Activated && options.contact == ContactMode::Reactions;
    let observed = solution.markers.iter().any(|m| m.residual_mm.is_some());
    let a = &solution.activations;
    SolutionJson {
        status: solution.status.into(),
        stiffness: options.common.stiffness.text(),
        activations: a.names.iter().cloned().zip(a.values.iter().copied()).collect(),
        jaw_opening_mm: solution.jaw_opening_mm,
        residual_mm: ResidualJson {
            rms: observed.then_some(solution.residual.rms_mm),
            max: observed.then_some(solution.residual.max_mm),
        },
        markers: solution.markers.iter().map(MarkerJson::from).collect(),
        features: solution.features.iter().map(FeatureJson::from).collect(),
        active_limits: solution.active_limits.iter().map(LimitJson::from).collect(),
        contact: (options.contact != ContactMode::Off).then(|| (&solution.contact).into()),
        certificate: (!a.values.is_empty()).then(|| CertificateJson::from(&solution.certificate)),
        expected: is_default
            .then(|| expected(solution, &document.target.expected, &loaded.face.name))
            .flatten(),
        deformation: deformation.map(DeformationJson::from),
        steps: found.steps.clone(),
        linear_answer: found.linear.clone(),
        other_solutions: found.others.clone(),
        warnings,
        face_warnings: loaded.warnings.clone(),
        timings_s: progress.timings_s(),
        face: loaded.name.clone(),
        inputs: loaded.inputs.clone(),
        files: BTreeMap::new(),
        version: env!("CARGO_PKG_VERSION").to_owned(),
    }
}
