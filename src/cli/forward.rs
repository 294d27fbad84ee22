//! `modiolus forward`.

use std::collections::BTreeMap;

use modiolus::forward::Deformation;
use modiolus::inverse::Warning;
use modiolus::io::{ContactJson, FileSet, MarkerJson, ResidualJson, SolutionJson, StatusWord};
use modiolus::mesh::Site;
use modiolus::study::{Mechanics, MovedContact, Mover, Strain};

use super::Outcome;
use super::activation_list::resolve;
use super::arguments::ForwardOptions;
use super::error::CliError;
use super::export::{ANSWER, Answer, beyond, default_out, export, keep_inputs, tell_load};
use super::load::{LoadedFace, load, pose};
use super::progress::Progress;

pub(crate) fn run(options: &ForwardOptions) -> Result<Outcome, CliError> {
    let mut progress = Progress::new();
    let loaded = load(&options.common.face, &mut progress)?.with_strength(options.common.strength);
    let out = match &options.out {
        Some(out) => out.clone(),
        None => default_out(&loaded, "forward", None)?,
    };
    keep_inputs(&loaded.inputs, ANSWER.map(|name| out.join(name)))?;
    let face = &loaded.face;
    let muscles: Vec<String> = face.muscles.iter().map(|m| m.name.clone()).collect();
    let activation = resolve(&options.activate, &muscles)?;

    if options.jaw_opening.is_some() && face.jaw.is_none() {
        return Err(CliError::NoJaw { face: loaded.called });
    }
    let pose = pose(face, options.jaw_opening);
    let study = |error| CliError::Study { face: loaded.called.clone(), error: Box::new(error) };
    let mechanics = options.common.mechanics(options.contact);
    let mover = progress.step("assemble", || Mover::new(face, mechanics)).map_err(study)?;
    let moved = progress.step("settle", || mover.settle(&activation, &pose)).map_err(study)?;
    let mut warnings: Vec<String> = match mechanics.strain {
        Strain::Linear => pose.large_turns().iter().map(ToString::to_string).collect(),
        Strain::Finite => Vec::new(),
    };
    if !moved.is_stable {
        warnings.push(format!("{}: {}", Warning::Unstable, Warning::Unstable.remedy()));
    }
    let contact = moved.contact.as_ref();
    warnings.extend(contact.filter(|c| !c.settled).map(|c| unsettled(c.overlap_mm)));
    let state = State {
        activation,
        jaw_opening_mm: options.jaw_opening,
        displacement: moved.displacement,
        contact: contact.map(contact_report),
        warnings,
    };
    let contact_load = moved.contact.map(|c| c.load);
    let json = forward_json(&loaded, &state, (mechanics, options.common.strength), progress);
    let heading = format!("Activations on {}", loaded.called);
    let State { activation, displacement, .. } = state;
    let answer = Answer { heading, json, displacement: Some(displacement), activation, contact_load };
    let text = export(answer, face, FileSet::new(&out), options.json)?;
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

/// Contact as reported.
pub(crate) fn contact_report(contact: &MovedContact) -> ContactJson {
    let mut report = ContactJson {
        pairs: contact.candidates,
        active: contact.active,
        force_n: contact.force_n,
        max_penetration_mm: contact.linear_penetration_mm,
        overlap_mm: Some(contact.overlap_mm),
        linearisations: contact.linearisations,
        ..ContactJson::default()
    };
    tell_load(&mut report, &contact.load);
    report
}

/// The answer of a forward computation.
pub(crate) fn forward_json(
    loaded: &LoadedFace,
    state: &State,
    (mechanics, strength): (Mechanics, f64),
    progress: Progress,
) -> SolutionJson {
    let (face, u) = (&loaded.face, &state.displacement);
    let deformation = Deformation::of(&face.mesh, u);
    let mut warnings = state.warnings.clone();
    warnings.extend(beyond(mechanics.strain, &deformation));
    let landmark = |name: &str, site: &Site| MarkerJson {
        name: name.to_owned(),
        rest_mm: Some(site.position.into()),
        target_mm: [None; 3],
        model_mm: site.displacement(u).into(),
        residual_mm: None,
        explained: None,
    };
    let muscles = face.muscles.iter().map(|m| m.name.clone());
    SolutionJson {
        status: StatusWord::Solved,
        target: None,
        strain: mechanics.strain.name().to_owned(),
        stiffness: mechanics.stiffness.text(),
        strength,
        contact_mode: if mechanics.contact { "reactions" } else { "off" }.to_owned(),
        activations: muscles.zip(state.activation.iter().copied()).collect::<BTreeMap<_, _>>(),
        jaw_opening_mm: state.jaw_opening_mm,
        residual_mm: ResidualJson { rms: None, max: None },
        explained: None,
        markers: face.landmarks.iter().map(|l| landmark(&l.name, &l.site)).collect(),
        features: Vec::new(),
        active_limits: Vec::new(),
        contact: state.contact,
        certificate: None,
        certainty: None,
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
