//! `modiolus forward`.

use std::collections::BTreeMap;

use modiolus::face::{ContactReach, ContactSearch};
use modiolus::forward::{Deformation, Model, SettledContact};
use modiolus::io::{ContactJson, MarkerJson, ResidualJson, SolutionJson, StatusWord};
use modiolus::mesh::Site;

use super::Outcome;
use super::activation_list::resolve;
use super::arguments::{ContactMode, ForwardOptions, Stiffness};
use super::error::CliError;
use super::export::{Answer, beyond_linear, export, tell_load};
use super::load::load;
use super::progress::Progress;

pub(crate) fn run(options: &ForwardOptions) -> Result<Outcome, CliError> {
    let mut progress = Progress::new();
    let loaded = load(&options.common.face, &mut progress)?;
    let face = &loaded.face;
    let muscles: Vec<String> = face.muscles.iter().map(|m| m.name.clone()).collect();
    let activation = resolve(&options.activate, &muscles)?;

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
    let fixed = progress.step("factorise", || model.at(&held)).map_err(forward)?;
    let mut warnings = Vec::new();
    let (u, contact_load, contact) = match &search {
        None => (progress.step("displace", || fixed.displacement(&activation, &[])), None, None),
        Some(search) => {
            let settled = progress.step("contact", || fixed.settle(face, search, &activation, None))?;
            if !settled.settled {
                warnings.push(unsettled(settled.penetration_mm));
            }
            let SettledContact { pairs, equilibrium, linear_penetration_mm, penetration_mm, rounds, .. } =
                settled;
            let forces = equilibrium.contact_forces;
            let load = face.contact_load(&pairs, forces.as_slice());
            let mut report = ContactJson {
                pairs: forces.len(),
                active: forces.iter().filter(|f| **f > 0.0).count(),
                force_n: forces.sum(),
                max_penetration_mm: linear_penetration_mm,
                overlap_mm: Some(penetration_mm),
                linearisations: rounds,
                ..ContactJson::default()
            };
            tell_load(&mut report, &load);
            (equilibrium.displacement, Some(load), Some(report))
        }
    };

    let deformation = Deformation::of(&face.mesh, &u);
    if !deformation.is_small() {
        warnings.push(beyond_linear(&deformation));
    }
    let landmark = |name: &str, site: &Site| MarkerJson {
        name: name.to_owned(),
        target_mm: [None; 3],
        model_mm: site.displacement(&u).into(),
        residual_mm: None,
    };
    let json = SolutionJson {
        status: StatusWord::Solved,
        stiffness: options.common.stiffness.text(),
        activations: muscles.iter().cloned().zip(activation.iter().copied()).collect::<BTreeMap<_, _>>(),
        residual_mm: ResidualJson { rms: None, max: None },
        markers: face.landmarks.iter().map(|l| landmark(&l.name, &l.site)).collect(),
        features: Vec::new(),
        active_limits: Vec::new(),
        contact,
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
        version: env!("CARGO_PKG_VERSION").to_owned(),
    };
    let heading = format!("Activations on {}", loaded.called);
    let answer = Answer { heading, json, displacement: Some(u), activation, contact_load };
    let text = export(&answer, face, &options.out, options.json)?;
    Ok(Outcome { text, solved: true })
}

/// The warning about surfaces that still overlap.
fn unsettled(overlap_mm: f64) -> String {
    format!(
        "the gaps did not settle where the tissue went: it overlaps teeth or the other lip by {overlap_mm:.1} mm more \
         than at rest; ask for less activation"
    )
}
