//! `modiolus forward`.

use std::collections::BTreeMap;

use modiolus::face::{ContactLoad, ContactReach, ContactSearch, Face};
use modiolus::forward::{Deformation, Model, SettledContact};
use modiolus::inverse::Warning;
use modiolus::io::{ContactJson, FileSet, MarkerJson, ResidualJson, SolutionJson, StatusWord};
use modiolus::mesh::Site;

use super::Outcome;
use super::activation_list::resolve;
use super::arguments::{ContactMode, ForwardOptions, Stiffness};
use super::error::CliError;
use super::export::{ANSWER, Answer, beyond_linear, export, keep_inputs, tell_load};
use super::load::{LoadedFace, load, pose};
use super::progress::Progress;

pub(crate) fn run(options: &ForwardOptions) -> Result<Outcome, CliError> {
    let mut progress = Progress::new();
    let loaded = load(&options.common.face, &mut progress)?;
    keep_inputs(&loaded, ANSWER.map(|name| options.out.join(name)))?;
    let face = &loaded.face;
    let muscles: Vec<String> = face.muscles.iter().map(|m| m.name.clone()).collect();
    let activation = resolve(&options.activate, &muscles)?;

    if options.jaw_opening.is_some() && face.jaw.is_none() {
        return Err(CliError::NoJaw { face: loaded.called });
    }
    let pose = pose(face, options.jaw_opening);
    let search = progress.step("contact_pairs", || match options.contact {
        ContactMode::Off => None,
        _ => Some(ContactSearch::new(face, ContactReach::default())),
    });
    let pairs = search.as_ref().map_or_else(Vec::new, |s| s.rest().to_vec());
    let forward = |error| CliError::Forward { face: loaded.called.clone(), error: Box::new(error) };
    let model = progress.step("assemble", || Model::new(face, pairs)).map_err(forward)?;
    let held = match options.common.stiffness {
        Stiffness::Activated => activation.clone(),
        Stiffness::Fixed(a) => vec![a; muscles.len()],
    };
    let fixed = progress.step("factorise", || model.at_pose(&held, &pose)).map_err(forward)?;
    let mut warnings: Vec<String> = pose.large_turns().iter().map(ToString::to_string).collect();
    let (u, contact_load, contact) = match &search {
        None => (progress.step("displace", || fixed.displacement(&activation, &[])), None, None),
        Some(search) => {
            let settled = progress.step("contact", || fixed.settle(face, search, &activation, None))?;
            warnings.extend((!settled.settled).then(|| unsettled(settled.penetration_mm)));
            let (report, load) = contact_report(face, &settled);
            (settled.equilibrium.displacement, Some(load), Some(report))
        }
    };
    let state = State { activation, jaw_opening_mm: options.jaw_opening, displacement: u, contact, warnings };
    let json = forward_json(&loaded, &state, options.common.stiffness.text(), progress);
    let heading = format!("Activations on {}", loaded.called);
    let State { activation, displacement, .. } = state;
    let answer = Answer { heading, json, displacement: Some(displacement), activation, contact_load };
    let text = export(answer, face, FileSet::new(&options.out), options.json)?;
    Ok(Outcome { text, solved: true })
}

/// What the tissue did when nothing was fitted.
pub(crate) struct State {
    pub(crate) activation: Vec<f64>,
    pub(crate) jaw_opening_mm: Option<f64>,
    /// Displacement (3n), mm.
    pub(crate) displacement: Vec<f64>,
    pub(crate) contact: Option<ContactJson>,
    pub(crate) warnings: Vec<String>,
}

/// Contact as reported, and what it loads the nodes with.
pub(crate) fn contact_report(face: &Face, settled: &SettledContact) -> (ContactJson, ContactLoad) {
    let forces = &settled.equilibrium.contact_forces;
    let load = face.contact_load(&settled.pairs, forces.as_slice());
    let mut report = ContactJson {
        pairs: forces.len(),
        active: forces.iter().filter(|f| **f > 0.0).count(),
        force_n: forces.sum(),
        max_penetration_mm: settled.linear_penetration_mm,
        overlap_mm: Some(settled.penetration_mm),
        linearisations: settled.rounds,
        ..ContactJson::default()
    };
    tell_load(&mut report, &load);
    (report, load)
}

/// The answer of a forward computation.
pub(crate) fn forward_json(
    loaded: &LoadedFace,
    state: &State,
    stiffness: String,
    progress: Progress,
) -> SolutionJson {
    let (face, u) = (&loaded.face, &state.displacement);
    let deformation = Deformation::of(&face.mesh, u);
    let mut warnings = state.warnings.clone();
    warnings.extend(beyond_linear(&deformation));
    let landmark = |name: &str, site: &Site| MarkerJson {
        name: name.to_owned(),
        target_mm: [None; 3],
        model_mm: site.displacement(u).into(),
        residual_mm: None,
    };
    let muscles = face.muscles.iter().map(|m| m.name.clone());
    SolutionJson {
        status: StatusWord::Solved,
        stiffness,
        activations: muscles.zip(state.activation.iter().copied()).collect::<BTreeMap<_, _>>(),
        jaw_opening_mm: state.jaw_opening_mm,
        residual_mm: ResidualJson { rms: None, max: None },
        markers: face.landmarks.iter().map(|l| landmark(&l.name, &l.site)).collect(),
        features: Vec::new(),
        active_limits: Vec::new(),
        contact: state.contact,
        certificate: None,
        expected: None,
        deformation: Some((&deformation).into()),
        steps: Vec::new(),
        linear_answer: None,
        other_solutions: Vec::new(),
        warnings,
        face_warnings: loaded.warnings.clone(),
        timings_s: progress.timings_s(),
        face: loaded.name.clone(),
        inputs: loaded.inputs.clone(),
        files: BTreeMap::new(),
        version: env!("CARGO_PKG_VERSION").to_owned(),
    }
}

/// The warning about contacts that still change.
pub(crate) fn unsettled(overlap_mm: f64) -> String {
    let left = Warning::left_by(overlap_mm);
    format!("the contacts did not settle where the tissue went: {left}; ask for less movement")
}
