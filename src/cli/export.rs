//! The files of an answer, and what stdout gets.

use std::collections::BTreeMap;
use std::fs;
use std::path::{Path, PathBuf};

use modiolus::contact::PairKind;
use modiolus::face::{ContactLoad, Face};
use modiolus::forward::{Deformation, cell_muscles};
use modiolus::io::{ContactJson, FileSet, SolutionJson, Standing, VtuData, WriteError, vtu_text};
use modiolus::study::Strain;
use modiolus::units::{Vec3, counted};

use super::error::CliError;
use super::file_name;
use super::load::LoadedFace;
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

/// Stretch above which no cell of the face is believed.
const LARGEST_STRETCH: f64 = 2.5;
/// Volume ratio below which no cell of the face is believed.
const LEAST_VOLUME_RATIO: f64 = 0.1;

/// The warnings about a field that the mechanics does not describe.
pub(crate) fn beyond(strain: Strain, d: &Deformation) -> Vec<String> {
    let at = |p: Vec3| format!("({:.0}, {:.0}, {:.0}) mm", p.x, p.y, p.z);
    // The linear rotation has no greatest angle; a turn has.
    let turned = match d.rotation_deg {
        deg if deg > 180.0 => "more than 180 degrees".to_owned(),
        deg => format!("{deg:.0} degrees"),
    };
    let large = format!(
        "{:.0} per cent of the tissue strains by more than 0.1 or turns by more than 10 degrees, where linear \
         elasticity ends (at most {:.2} at {} and {} at {}): take --strain finite, read directions and \
         proportions rather than millimetres there, or ask for less movement",
        100. * d.beyond_share,
        d.strain,
        at(d.strain_at),
        turned,
        at(d.rotation_at)
    );
    let inverted = format!(
        "{} of the mesh turned inside out (most about {}): linear elasticity has no state for the tissue \
         there, and contact with it may not settle; take --strain finite, or ask for less activation of the muscles \
         that gather it",
        counted(d.inverted_cells, "cell"),
        at(d.inverted_at)
    );
    let stretched = format!(
        "a cell about {} stretches {:.1}-fold, where tissue would tear: ask for less activation of the muscles that \
         meet there, or refine the mesh",
        at(d.stretch_at),
        d.stretch
    );
    let squeezed = format!(
        "a point about {} is squeezed to {:.2} of its volume: the mesh does not describe the tissue there; ask for less \
         activation of the muscles that gather it, or refine the mesh",
        at(d.inverted_at),
        d.volume_ratio
    );
    let told = match strain {
        Strain::Linear => [(!d.is_small()).then_some(large), (d.inverted_cells > 0).then_some(inverted)],
        Strain::Finite => [
            (d.stretch > LARGEST_STRETCH).then_some(stretched),
            (d.volume_ratio < LEAST_VOLUME_RATIO).then_some(squeezed),
        ],
    };
    told.into_iter().flatten().collect()
}

/// The files of an answer.
pub(crate) const ANSWER: [&str; 2] = ["solution.json", "face.vtu"];

/// The folder for a result where none is given, `out/FACE/NAME`: no result of another face or `target` is overwritten there.
pub(crate) fn default_out(
    loaded: &LoadedFace,
    name: &str,
    target: Option<&Path>,
) -> Result<PathBuf, CliError> {
    let folder = PathBuf::from("out").join(file_name(&loaded.face.name)).join(name);
    let standing = Standing::of(&folder)?;
    if standing.gives_way(&loaded.name, target) {
        return Ok(folder);
    }
    Err(CliError::OtherResult { folder, standing })
}

/// Refuses to write to any of the `paths` that is one of the `inputs`, by name.
pub(crate) fn keep_inputs(
    inputs: &BTreeMap<String, String>,
    paths: impl IntoIterator<Item = PathBuf>,
) -> Result<(), CliError> {
    let inputs: Vec<PathBuf> = inputs.keys().filter_map(|name| fs::canonicalize(name).ok()).collect();
    for path in paths {
        WriteError::check(&path)?;
        if fs::canonicalize(&path).is_ok_and(|path| inputs.contains(&path)) {
            return Err(CliError::OverInput(path));
        }
    }
    Ok(())
}

/// Writes `solution.json` and `face.vtu` with what is in the `set` already; returns the text for stdout.
pub(crate) fn export(
    mut answer: Answer,
    face: &Face,
    mut set: FileSet,
    as_json: bool,
) -> Result<String, CliError> {
    let [json_name, vtu_name] = ANSWER;
    let mut files = json_name.to_owned();
    match &answer.displacement {
        Some(u) => {
            let text = vtu_text(vtu_name.as_ref(), &face.mesh, &vtu_data(face, u, &answer))?;
            set.put(vtu_name, text.into_bytes());
            files += &format!(" and {vtu_name}");
        }
        None => set.without(vtu_name),
    }
    answer.json.files = set.sha256();
    let json = answer.json.to_text()?;
    set.put(json_name, json.clone().into_bytes());
    set.write()?;
    say(&format!("wrote {files} to {}", set.folder().display()));
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
