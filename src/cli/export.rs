//! The files of an answer, and what stdout gets.

use std::fs;
use std::path::Path;

use modiolus::contact::PairKind;
use modiolus::face::{ContactLoad, Face};
use modiolus::forward::{Deformation, cell_muscles};
use modiolus::io::{ContactJson, SolutionJson, VtuData, write_atomically, write_vtu};
use modiolus::units::Vec3;

use super::error::CliError;
use super::progress::say;
use super::table;

/// What a verb found.
pub(crate) struct Answer {
    /// The table's first line.
    pub(crate) heading: String,
    pub(crate) json: SolutionJson,
    /// Displacement (3n), mm; `None` when there is no answer to show.
    pub(crate) displacement: Option<Vec<f64>>,
    /// Activations (m) in the face's order.
    pub(crate) activation: Vec<f64>,
    /// Contact forces and pressures, where they were computed.
    pub(crate) contact_load: Option<ContactLoad>,
}

/// The sums of the contact forces in `json` from the load that they make.
pub(crate) fn tell_load(json: &mut ContactJson, load: &ContactLoad) {
    json.upper_teeth_n = load.of(PairKind::UpperTeeth);
    json.lower_teeth_n = load.of(PairKind::LowerTeeth);
    json.lips_n = load.of(PairKind::Lips);
}

/// The warning about a field that linear elasticity does not describe.
pub(crate) fn beyond_linear(d: &Deformation) -> Vec<String> {
    let at = |p: Vec3| format!("({:.0}, {:.0}, {:.0}) mm", p.x, p.y, p.z);
    let large = format!(
        "{:.0} per cent of the tissue strains by more than 0.1 or turns by more than 10 degrees, where linear \
         elasticity ends (at most {:.2} at {} and {:.0} degrees at {}): read directions and proportions rather than \
         millimetres there, or ask for less movement",
        100. * d.beyond_share,
        d.strain,
        at(d.strain_at),
        d.rotation_deg,
        at(d.rotation_at)
    );
    let inverted = format!(
        "{} cells of the mesh are turned inside out (most about {}): linear elasticity has no state for the tissue \
         there, and contact with it may not settle; ask for less activation of the muscles that gather it",
        d.inverted_cells,
        at(d.inverted_at)
    );
    let told = [(!d.is_small()).then_some(large), (d.inverted_cells > 0).then_some(inverted)];
    told.into_iter().flatten().collect()
}

/// Writes `solution.json` and `face.vtu` to the folder `out`; returns the text for stdout.
pub(crate) fn export(answer: &Answer, face: &Face, out: &Path, as_json: bool) -> Result<String, CliError> {
    let written = |path: &Path| {
        let path = path.to_owned();
        move |reason| CliError::Write { path, reason }
    };
    let json = answer.json.to_text()?;
    fs::create_dir_all(out).map_err(written(out))?;
    let mut files = "solution.json".to_owned();
    if let Some(u) = &answer.displacement {
        write_vtu(&out.join("face.vtu"), &face.mesh, &vtu_data(face, u, answer))?;
        files += " and face.vtu";
    }
    let path = out.join("solution.json");
    write_atomically(&path, json.as_bytes()).map_err(written(&path))?;
    say(&format!("wrote {files} to {}", out.display()));
    Ok(if as_json { json } else { table::render(&answer.heading, &answer.json) })
}

fn vtu_data(face: &Face, u: &[f64], answer: &Answer) -> VtuData {
    let activation = &answer.activation;
    let on_nodes = |load: &ContactLoad| {
        let force = load.force_n.iter().map(|f| f.norm()).collect();
        [
            ("contact_force_n".to_owned(), force),
            ("contact_pressure_kpa".to_owned(), load.pressure_kpa.clone()),
        ]
    };
    let muscles = cell_muscles(face);
    // -1 is passive tissue; 0 is a muscle.
    let ids = muscles.iter().map(|m| m.map_or(-1, |m| m as i64)).collect();
    let active = muscles.iter().map(|m| m.and_then(|m| activation.get(m)).copied().unwrap_or(0.0)).collect();
    VtuData {
        point_vectors: [("displacement".to_owned(), u.to_vec())].into(),
        point_scalars: answer.contact_load.iter().flat_map(on_nodes).collect(),
        cell_scalars: [("activation".to_owned(), active)].into(),
        cell_labels: [("muscle_id".to_owned(), ids)].into(),
    }
}
