//! `modiolus fit`.

use std::collections::BTreeMap;
use std::path::PathBuf;

use modiolus::certainty::Certainty;
use modiolus::face::Face;
use modiolus::forward::Deformation;
use modiolus::inverse::{self, Expected, InverseError, Observations, Solution, Status, Target, Warning};
use modiolus::io::{
    CertaintyJson, CertificateJson, ContactJson, DeformationJson, ExpectedJson, FeatureJson, FileSet,
    LimitJson, LinearJson, MarkerJson, OtherJson, ResidualJson, SolutionJson, StepJson, TargetDocument,
    read_target,
};
use modiolus::mesh::{Locator, Site};
use modiolus::study::{self, Fit, LinearAnswer, Stiffness, Strain, StudyError};
use modiolus::units::Vec3;

use super::Outcome;
use super::arguments::{ContactMode, FitOptions};
use super::error::CliError;
use super::export::{ANSWER, Answer, beyond, export, keep_inputs};
use super::forward::contact_report;
use super::load::{LoadedFace, input_name, load, pose};
use super::progress::Progress;

/// How far off the face a rest point may lie, mm.
const OFF_FACE_MM: f64 = 5.0;

pub(crate) fn run(options: &FitOptions) -> Result<Outcome, CliError> {
    let Fitted { answer, loaded, out, solved } = fit(options)?;
    let text = export(answer, &loaded.face, FileSet::new(&out), options.json)?;
    Ok(Outcome { text, solved })
}

/// A fit before anything of it is written.
pub(crate) struct Fitted {
    pub(crate) answer: Answer,
    pub(crate) loaded: LoadedFace,
    out: PathBuf,
    pub(crate) solved: bool,
}

pub(crate) fn fit(options: &FitOptions) -> Result<Fitted, CliError> {
    // A wrong target is told before a large face is read.
    let document = read_target(&options.target)?;
    let mut progress = Progress::new();
    let loaded = load(&options.common.face, &mut progress)?.with_strength(options.common.strength);
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

    let mode = match options.contact {
        ContactMode::Reactions => inverse::ContactMode::Reactions,
        ContactMode::Kinematic => inverse::ContactMode::Kinematic,
        ContactMode::Off => inverse::ContactMode::Off,
    };
    let mechanics = options.common.mechanics(options.contact);
    if let (Strain::Finite, Stiffness::Fixed(share)) = (mechanics.strain, mechanics.stiffness) {
        let error = Box::new(StudyError::FixedAtFiniteStrain { share });
        return Err(CliError::Study { face: loaded.called, error });
    }
    let found = progress.told_step("fit", |bar| {
        study::fit(face, target, &observations, mechanics, mode, move |step, objective| {
            bar.set_message(format!("fit: step {step}, objective {objective:.4}"));
        })
    });
    let found = found.map_err(|error| match error {
        InverseError::Target(error) => at(error),
        InverseError::Forward(error) => {
            CliError::Forward { face: loaded.called.clone(), error: Box::new(error) }
        }
        other => CliError::Inverse(Box::new(other)),
    })?;
    let solution = &found.solution;
    let solved = solution.status == Status::Solved;
    let heading = format!("{} on {}: {}", target.name, loaded.called, solution.status);
    let out = out_of(options, target);
    let deformation = found.displacement.as_ref().map(|u| Deformation::of(&face.mesh, u));
    let certainty = progress.step("identify", || {
        solution.program.as_ref().and_then(|program| Certainty::of(program, options.discrepancy))
    });
    let json = solution_json(
        &found,
        certainty.as_ref(),
        deformation.as_ref(),
        options,
        &document,
        &loaded,
        progress,
    );
    let activation = solution.activations.values.clone();
    let contact_load = found.contact.map(|c| c.load);
    let answer = Answer { heading, json, displacement: found.displacement, activation, contact_load };
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

/// How far the linear answer was from the nonlinear one.
fn linear_json(linear: &LinearAnswer, solution: &Solution) -> Option<LinearJson> {
    let expected = &linear.solution.observed_mm - &linear.leads_to_mm;
    let points = (expected.len() / 3).max(1) as f64;
    let names = &linear.solution.activations.names;
    let both = solution.activations.values.iter().zip(&linear.solution.activations.values);
    let off = both.map(|(a, b)| (a - b).abs()).enumerate();
    let (muscle, activation_off) = off.max_by(|a, b| a.1.total_cmp(&b.1).then(b.0.cmp(&a.0)))?;
    Some(LinearJson {
        stiffness: linear.stiffness,
        muscle: names[muscle].clone(),
        activation_off,
        markers_off_mm: (expected.norm_squared() / points).sqrt(),
        residual_rms_mm: linear.solution.residual.rms_mm,
        activations: names.iter().cloned().zip(linear.solution.activations.values.iter().copied()).collect(),
    })
}

/// Contact at the answer.
fn contact_json(found: &Fit) -> ContactJson {
    let mut json = ContactJson::from(&found.solution.contact);
    if let Some(contact) = &found.contact {
        let told = contact_report(contact);
        json = ContactJson {
            relaxation_gap: json.relaxation_gap,
            relaxation_nodes: json.relaxation_nodes,
            relaxation_end: json.relaxation_end,
            branching_gain: json.branching_gain,
            ..told
        };
    }
    json
}

fn solution_json(
    found: &Fit,
    certainty: Option<&Certainty>,
    deformation: Option<&Deformation>,
    options: &FitOptions,
    document: &TargetDocument,
    loaded: &LoadedFace,
    progress: Progress,
) -> SolutionJson {
    let solution = &found.solution;
    let mut warnings: Vec<String> = document.warnings.iter().map(ToString::to_string).collect();
    // The file's own warning about a zero names the line.
    let told = |w: &&Warning| !matches!(w, Warning::ExactZero { .. });
    warnings.extend(solution.warnings.iter().filter(told).map(|w| format!("{w}: {}", w.remedy())));
    let jaw = pose(&loaded.face, solution.jaw_opening_mm);
    if options.common.strain == Strain::Linear {
        warnings.extend(jaw.large_turns().iter().map(ToString::to_string));
    }
    let strain = options.common.strain;
    warnings.extend(deformation.into_iter().flat_map(|d| beyond(strain, d)));
    let is_default = strain == Strain::Linear
        && options.common.strength == 1.
        && options.common.stiffness == Stiffness::Activated
        && options.contact == ContactMode::Reactions;
    let observed = solution.markers.iter().any(|m| m.residual_mm.is_some());
    let a = &solution.activations;
    SolutionJson {
        status: solution.status.into(),
        strain: options.common.strain.name().to_owned(),
        stiffness: options.common.stiffness.text(),
        strength: options.common.strength,
        activations: a.names.iter().cloned().zip(a.values.iter().copied()).collect(),
        jaw_opening_mm: solution.jaw_opening_mm,
        residual_mm: ResidualJson {
            rms: observed.then_some(solution.residual.rms_mm),
            max: observed.then_some(solution.residual.max_mm),
        },
        explained: solution.explained,
        markers: solution.markers.iter().map(MarkerJson::from).collect(),
        features: solution.features.iter().map(FeatureJson::from).collect(),
        active_limits: solution.active_limits.iter().map(LimitJson::from).collect(),
        contact: (options.contact != ContactMode::Off).then(|| contact_json(found)),
        certificate: (!a.values.is_empty()).then(|| CertificateJson::from(&solution.certificate)),
        certainty: certainty.map(CertaintyJson::from),
        expected: is_default
            .then(|| expected(solution, &document.target.expected, &loaded.face.name))
            .flatten(),
        deformation: deformation.map(DeformationJson::from),
        steps: found.history.iter().map(StepJson::from).collect(),
        linear_answer: found.linear.as_ref().and_then(|linear| linear_json(linear, solution)),
        other_solutions: found.others.iter().map(OtherJson::from).collect(),
        warnings,
        face_warnings: loaded.warnings.clone(),
        timings_s: progress.timings_s(),
        face: loaded.name.clone(),
        inputs: loaded.inputs.clone(),
        files: BTreeMap::new(),
        version: env!("CARGO_PKG_VERSION").to_owned(),
    }
}
