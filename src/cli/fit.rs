//! `modiolus fit`.

use std::collections::BTreeMap;
use std::path::Path;
use std::sync::Arc;

use modiolus::certainty::Certainty;
use modiolus::face::Face;
use modiolus::forward::Deformation;
use modiolus::inverse::{
    self, Expected, InverseError, Marker, Observations, Solution, Status, TangentProgram, Target, Warning,
};
use modiolus::io::{
    CertaintyJson, CertificateJson, ContactJson, DeformationJson, ExpectedJson, FeatureJson, FileSet,
    LimitJson, LinearJson, MarkerJson, OtherJson, ReadOptions, RecordedFrame, ResidualJson, SolutionJson,
    StepJson, TargetDocument, TargetJson, read_mapped_recording, read_target,
};
use modiolus::mesh::{Locator, Site};
use modiolus::study::{self, Fit, LinearAnswer, Stiffness, Strain, StudyError, Verdict, residual_rms_mm};
use modiolus::units::Vec3;

use super::arguments::{ContactMode, FitOptions};
use super::error::CliError;
use super::export::{ANSWER, Answer, beyond, default_out, export, keep_inputs};
use super::forward::contact_report;
use super::load::{LoadedFace, input_name, load, pose};
use super::progress::Progress;
use super::{Outcome, suite};

/// How far off the face a rest point may lie, mm.
const OFF_FACE_MM: f64 = 5.0;

pub(crate) fn run(options: &FitOptions) -> Result<Outcome, CliError> {
    let [target] = &options.targets[..] else { return suite::fit(options) };
    if options.junit.is_some() || target.is_dir() {
        return suite::fit(options);
    }
    // A wrong target is told before a large face is read.
    let document = read_target(target)?;
    let mut progress = Progress::new();
    let loaded = load(&options.common.face, &mut progress)?.with_strength(options.common.strength);
    let out = match &options.out {
        Some(out) => out.clone(),
        None => default_out(&loaded, &document.target.name, Some(target))?,
    };
    keep_inputs(&loaded.inputs, ANSWER.map(|name| out.join(name)))?;
    let fitted = fit_on(&loaded, &document, target, options, progress)?;
    let text = export(fitted.answer, &loaded.face, FileSet::new(&out), options.json)?;
    Ok(Outcome { text, solved: fitted.solved })
}

/// The fit of the one target of `options`, and its face; nothing is written.
pub(crate) fn fit(options: &FitOptions, target: &Path) -> Result<(Fitted, LoadedFace), CliError> {
    let document = read_target(target)?;
    let mut progress = Progress::new();
    let loaded = load(&options.common.face, &mut progress)?.with_strength(options.common.strength);
    let fitted = fit_on(&loaded, &document, target, options, progress)?;
    Ok((fitted, loaded))
}

/// A fit before anything of it is written.
pub(crate) struct Fitted {
    pub(crate) answer: Answer,
    pub(crate) solved: bool,
    /// Root mean square of all residuals, mm, where there is an answer.
    pub(crate) rms_mm: Option<f64>,
    pub(crate) verdict: Verdict,
    /// The program of the answer, if there is one.
    pub(crate) program: Option<Arc<TangentProgram>>,
}

/// A target that fits the face.
pub(crate) struct Asked<'a> {
    loaded: &'a LoadedFace,
    /// Its file.
    path: &'a Path,
    document: TargetDocument,
    recorded: Recorded,
    observations: Observations,
}

/// What a target takes from a frame of a recording.
#[derive(Default)]
struct Recorded {
    markers: Vec<Marker>,
    warnings: Vec<String>,
    /// SHA-256 of each file, by its name.
    inputs: BTreeMap<String, String>,
}

impl Recorded {
    fn of(face: &Face, reference: &RecordedFrame) -> Result<Self, CliError> {
        let RecordedFrame { file, frame, map } = reference;
        let read = read_mapped_recording(file, map.as_deref(), &ReadOptions::default())?;
        let (markers, odd) = study::recorded_markers(face, &read.document.recording, &read.map, frame)
            .map_err(|error| CliError::Subject { recording: file.clone(), error: Box::new(error) })?;
        let odd = odd.iter().map(ToString::to_string);
        let warnings = read.document.warnings.iter().map(ToString::to_string).chain(odd).collect();
        let inputs = read.files.iter().map(|f| (input_name(&f.path), f.sha256.clone())).collect();
        Ok(Self { markers, warnings, inputs })
    }
}

impl<'a> Asked<'a> {
    /// What the file `path`, which is `document`, asks of a face.
    pub(crate) fn new(
        loaded: &'a LoadedFace,
        document: &TargetDocument,
        path: &'a Path,
        progress: &mut Progress,
    ) -> Result<Self, CliError> {
        let face = &loaded.face;
        let muscles: Vec<String> = face.muscles.iter().map(|m| m.name.clone()).collect();
        let mut document = document.expand_patterns(&muscles)?;
        let mut recorded = Recorded::default();
        if let Some(reference) = &document.recording {
            recorded = progress.step("read_recording", || Recorded::of(face, reference))?;
            document.target.markers.append(&mut recorded.markers);
        }
        let resolve = || Observations::resolve(&document.target, face, locate(face));
        let observations =
            progress.step("read_face", resolve).map_err(|error| of_target(&document, error))?;
        Ok(Self { loaded, path, document, recorded, observations })
    }

    /// The face.
    pub(crate) fn loaded(&self) -> &LoadedFace {
        self.loaded
    }

    /// The file.
    pub(crate) fn path(&self) -> &Path {
        self.path
    }

    /// What is asked.
    pub(crate) fn target(&self) -> &Target {
        &self.document.target
    }

    /// Its points on the face.
    pub(crate) fn observations(&self) -> &Observations {
        &self.observations
    }

    /// SHA-256 of the files behind it but for those of the face, by their names.
    pub(crate) fn inputs(&self) -> BTreeMap<String, String> {
        let mut inputs = self.recorded.inputs.clone();
        inputs.insert(input_name(self.path), self.document.sha256.clone());
        inputs
    }

    /// The fit, and where it is wanted what the data determine of it, which takes its time.
    pub(crate) fn fit(
        &self,
        options: &FitOptions,
        wants_certainty: bool,
        mut progress: Progress,
    ) -> Result<Fitted, CliError> {
        let Self { loaded, document, observations, .. } = self;
        let (face, target) = (&loaded.face, &document.target);
        let mode = match options.contact {
            ContactMode::Reactions => inverse::ContactMode::Reactions,
            ContactMode::Kinematic => inverse::ContactMode::Kinematic,
            ContactMode::Off => inverse::ContactMode::Off,
        };
        let mechanics = options.common.mechanics(options.contact);
        if let (Strain::Finite, Stiffness::Fixed(share)) = (mechanics.strain, mechanics.stiffness) {
            let error = Box::new(StudyError::FixedAtFiniteStrain { share });
            return Err(CliError::Study { face: loaded.called.clone(), error });
        }
        let found = progress.told_step("fit", |bar| {
            study::fit(face, target, observations, mechanics, mode, move |step, objective| {
                bar.set_message(format!("fit: step {step}, objective {objective:.4}"));
            })
        });
        let found = found.map_err(|error| match error {
            InverseError::Target(error) => of_target(document, error),
            InverseError::Forward(error) => {
                CliError::Forward { face: loaded.called.clone(), error: Box::new(error) }
            }
            other => CliError::Inverse(Box::new(other)),
        })?;
        let solution = &found.solution;
        let solved = solution.status == Status::Solved;
        let rms_mm = found.displacement.is_some().then(|| residual_rms_mm(solution));
        let stated = stated(target, loaded, options);
        let verdict = Verdict::of(solution.status, residual_rms_mm(solution), stated);
        let heading = format!("{} on {}: {}", target.name, loaded.called, solution.status);
        let deformation = found.displacement.as_ref().map(|u| Deformation::of(&face.mesh, u));
        let certainty = progress.step("identify", || {
            let program = solution.program.as_ref().filter(|_| wants_certainty)?;
            Certainty::of(program, options.discrepancy)
        });
        let deformation = deformation.as_ref();
        let json = solution_json(&found, certainty.as_ref(), deformation, options, self, progress);
        let activation = solution.activations.values.clone();
        let contact_load = found.contact.map(|c| c.load);
        let answer = Answer { heading, json, displacement: found.displacement, activation, contact_load };
        Ok(Fitted { answer, solved, rms_mm, verdict, program: found.solution.program })
    }
}

/// The fit of a target on a face that is there already.
pub(crate) fn fit_on(
    loaded: &LoadedFace,
    document: &TargetDocument,
    path: &Path,
    options: &FitOptions,
    mut progress: Progress,
) -> Result<Fitted, CliError> {
    Asked::new(loaded, document, path, &mut progress)?.fit(options, true, progress)
}

/// An error of a target with the line of its field.
fn of_target(document: &TargetDocument, error: inverse::TargetError) -> CliError {
    CliError::Target { at: document.lines.location(error.field()), error: Box::new(error) }
}

/// What the target file states for this face under these options.
pub(crate) fn stated<'a>(
    target: &'a Target,
    loaded: &LoadedFace,
    options: &FitOptions,
) -> Option<&'a Expected> {
    let face = loaded.stated_as().filter(|_| has_defaults(options))?;
    target.expected.iter().find(|e| e.face == face)
}

/// Whether the options are those for which target files state results.
pub(crate) fn has_defaults(options: &FitOptions) -> bool {
    options.common.strain == Strain::Linear
        && options.common.strength == 1.
        && options.common.stiffness == Stiffness::Activated
        && options.contact == ContactMode::Reactions
}

fn locate(face: &Face) -> impl Fn(Vec3) -> Result<Site, f64> {
    let locator = Locator::new(&face.mesh);
    move |point| match locator.locate(point) {
        Some(found) if found.distance_mm <= OFF_FACE_MM => Ok(found.site),
        Some(found) => Err(found.distance_mm),
        None => Err(f64::INFINITY),
    }
}

/// What is stated for this face, held against the answer.
fn expected(solution: &Solution, stated: &Expected) -> ExpectedJson {
    let found_rms_mm = residual_rms_mm(solution);
    let Expected { residual_rms_mm, tolerance_mm, .. } = *stated;
    let met = Verdict::of(solution.status, found_rms_mm, Some(stated)) == Verdict::AsStated;
    ExpectedJson { residual_rms_mm, tolerance_mm, found_rms_mm, met }
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
        residual_rms_mm: residual_rms_mm(&linear.solution),
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
    asked: &Asked,
    progress: Progress,
) -> SolutionJson {
    let Asked { loaded, path, document, recorded, .. } = asked;
    let mut inputs = loaded.inputs.clone();
    inputs.extend(asked.inputs());
    let solution = &found.solution;
    let mut warnings: Vec<String> = document.warnings.iter().map(ToString::to_string).collect();
    warnings.extend(recorded.warnings.iter().cloned());
    // The file's own warning about a zero names the line.
    let told = |w: &&Warning| !matches!(w, Warning::ExactZero { .. });
    warnings.extend(solution.warnings.iter().filter(told).map(|w| format!("{w}: {}", w.remedy())));
    let jaw = pose(&loaded.face, solution.jaw_opening_mm);
    if options.common.strain == Strain::Linear {
        warnings.extend(jaw.large_turns().iter().map(ToString::to_string));
    }
    let strain = options.common.strain;
    warnings.extend(deformation.into_iter().flat_map(|d| beyond(strain, d)));
    let observed = solution.markers.iter().any(|m| m.residual_mm.is_some());
    let a = &solution.activations;
    SolutionJson {
        status: solution.status.into(),
        target: Some(TargetJson { name: document.target.name.clone(), file: input_name(path) }),
        strain: options.common.strain.name().to_owned(),
        stiffness: options.common.stiffness.text(),
        strength: options.common.strength,
        contact_mode: options.contact.name().to_owned(),
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
        expected: stated(&document.target, loaded, options).map(|stated| expected(solution, stated)),
        deformation: deformation.map(DeformationJson::from),
        steps: found.history.iter().map(StepJson::from).collect(),
        linear_answer: found.linear.as_ref().and_then(|linear| linear_json(linear, solution)),
        other_solutions: found.others.iter().map(OtherJson::from).collect(),
        warnings,
        face_warnings: loaded.warnings.clone(),
        timings_s: progress.timings_s(),
        face: loaded.name.clone(),
        inputs,
        files: BTreeMap::new(),
        version: env!("CARGO_PKG_VERSION").to_owned(),
    }
}
