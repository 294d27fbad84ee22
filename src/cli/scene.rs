//! `modiolus export`: a result as other programs open it.

use std::path::{Path, PathBuf};

use modiolus::face::{Face, Symmetry};
use modiolus::forward::cell_muscles;
use modiolus::io::{ActivationTable, VtuData, sto_text, vtu_text, write_atomically};
use modiolus::report::{Motion, MotionState, glb, obj_text};

use super::Outcome;
use super::arguments::{ExportOptions, SceneFormat};
use super::error::CliError;
use super::export::keep_inputs;
use super::load::LoadedFace;
use super::progress::{Progress, say};
use super::report::{motion, result};

/// Parts of the way from rest to the answer in a series of states.
const PARTS: u8 = 4;

pub(crate) fn run(options: &ExportOptions, format: SceneFormat) -> Result<Outcome, CliError> {
    let (out, ending) = (&options.out, format.ending());
    if out.extension().is_none_or(|own| !own.eq_ignore_ascii_case(ending)) {
        return Err(CliError::Ending { out: out.with_extension(ending), ending });
    }
    let mut progress = Progress::new();
    let read = result(&options.result, &mut progress)?;
    let mut kept = read.answer.inputs.clone();
    kept.insert(options.result.join("face.vtu").display().to_string(), String::new());
    keep_inputs(&kept, [out.clone()])?;
    let LoadedFace { face, .. } = &read.loaded;
    // Only a series needs states between.
    let parts = if format == SceneFormat::Pvd { PARTS } else { 1 };
    let motion = motion(&read, parts, &mut progress)?;
    let files: Vec<(PathBuf, Vec<u8>)> = match format {
        SceneFormat::Glb => vec![(out.clone(), progress.step("put together", || glb(face, &motion)))],
        SceneFormat::Obj => vec![(out.clone(), obj_text(face, &motion).into_bytes())],
        SceneFormat::Vtu => vec![(out.clone(), vtu(out, face, &motion.answer)?)],
        SceneFormat::Pvd => series(out, face, &motion)?,
        SceneFormat::Csv => vec![(out.clone(), table(face, &motion).to_csv().into_bytes())],
        SceneFormat::Sto => vec![(out.clone(), sto_text(&read.title, &table(face, &motion)).into_bytes())],
    };
    let mut list = String::new();
    for (path, bytes) in &files {
        write_atomically(path, bytes)?;
        say(&format!("wrote {}, {} kB", path.display(), bytes.len().div_ceil(1000)));
        list += &format!("{}\n", path.display());
    }
    Ok(Outcome { text: list, solved: true })
}

fn vtu(path: &Path, face: &Face, state: &MotionState) -> Result<Vec<u8>, CliError> {
    let u = state.displacement.clone().unwrap_or_else(|| vec![0.; 3 * face.mesh.n_nodes()]);
    let muscles = cell_muscles(face);
    let active = |m: &Option<usize>| m.and_then(|m| state.activation.get(m)).copied().unwrap_or(0.);
    let asymmetry = Symmetry::of(face, &u).map_mm;
    let mut data = VtuData {
        point_vectors: [("displacement".to_owned(), u)].into(),
        point_scalars: [("asymmetry_mm".to_owned(), asymmetry)].into(),
        cell_scalars: [("activation".to_owned(), muscles.iter().map(active).collect())].into(),
        cell_labels: [("muscle_id".to_owned(), muscles.iter().map(|m| m.map_or(-1, |m| m as i64)).collect())]
            .into(),
    };
    if let Some(pressure) = &state.pressure_kpa {
        data.point_scalars.insert("contact_pressure_kpa".to_owned(), pressure.clone());
    }
    Ok(vtu_text(path, &face.mesh, &data)?.into_bytes())
}

/// A VTU file of each state beside `out`, and after them `out`, which lists them with their times.
fn series(out: &Path, face: &Face, motion: &Motion) -> Result<Vec<(PathBuf, Vec<u8>)>, CliError> {
    let stem = out.file_stem().unwrap_or_default().to_string_lossy().into_owned();
    let mut files = Vec::new();
    let mut list = String::new();
    for (k, state) in motion.states.iter().chain([&motion.answer]).enumerate() {
        let name = format!("{stem}_{k:03}.vtu");
        let path = out.with_file_name(&name);
        files.push((path.clone(), vtu(&path, face, state)?));
        let named = name.replace('&', "&amp;").replace('<', "&lt;").replace('"', "&quot;");
        list += &format!("<DataSet timestep=\"{}\" part=\"0\" file=\"{named}\"/>\n", state.time);
    }
    let text = format!(
        "<?xml version=\"1.0\"?>\n<VTKFile type=\"Collection\" version=\"1.0\" byte_order=\"LittleEndian\">\n<Collection>\n{list}</Collection>\n</VTKFile>\n"
    );
    files.push((out.to_owned(), text.into_bytes()));
    Ok(files)
}

/// The activations of the states, the times being shares of the way.
fn table(face: &Face, motion: &Motion) -> ActivationTable {
    let states = || motion.states.iter().chain([&motion.answer]);
    ActivationTable {
        muscles: face.muscles.iter().map(|m| m.name.clone()).collect(),
        times_s: states().map(|state| state.time).collect(),
        rows: states().map(|state| state.activation.clone()).collect(),
    }
}
