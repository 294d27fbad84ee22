//! `modiolus face check` and `modiolus face export`.

use std::path::Path;

use modiolus::face::{standard, standard::Resolution};
use modiolus::io::write_face;

use super::Outcome;
use super::arguments::FaceChoice;
use super::error::CliError;
use super::load::load;
use super::progress::Progress;

pub(crate) fn check(choice: &FaceChoice) -> Result<Outcome, CliError> {
    let loaded = load(choice, &mut Progress::new())?;
    let face = &loaded.face;
    let counts = [
        ("nodes", face.mesh.n_nodes()),
        ("cells", face.mesh.cells.len()),
        ("nodes on bone", face.supports.iter().map(|s| s.nodes.len()).sum()),
        ("muscles", face.muscles.len()),
        ("fibres", face.muscles.iter().map(|m| m.fibres.len()).sum()),
        ("landmarks", face.landmarks.len()),
        ("tooth surfaces", face.teeth.len()),
        ("mucosa nodes", face.mucosa.len()),
        ("skin nodes", face.skin.len()),
    ];
    let mut text = format!("{}: usable\n\n", loaded.called);
    for (what, count) in counts {
        text += &format!("{what:15} {count:7}\n");
    }
    if !loaded.warnings.is_empty() {
        text += "\nWarnings\n";
        text += &loaded.warnings.iter().map(|w| format!("- {w}\n")).collect::<String>();
    }
    Ok(Outcome { text, solved: true })
}

pub(crate) fn export(resolution: Resolution, out: &Path) -> Result<Outcome, CliError> {
    let mut face = standard(&resolution);
    // What is written is there to be edited: results that are stated for the built-in face are not its own.
    face.name += "_exported";
    let files = write_face(out, &face)?;
    let text = files.iter().map(|file| format!("{}\n", file.display())).collect();
    Ok(Outcome { text, solved: true })
}
