//! `modiolus face check` and `modiolus face export`.

use std::path::Path;

use modiolus::face::Face;
use modiolus::face::standard::{Parameters, Resolution, parametric, sample as draw, standard};
use modiolus::io::{write_atomically, write_face};

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

pub(crate) fn sample(count: u16, seed: u64, resolution: Resolution, out: &Path) -> Result<Outcome, CliError> {
    let mut table = "face".to_owned();
    Parameters::PROPORTIONS.iter().for_each(|proportion| table += &format!(",{}", proportion.name));
    table += "\n";
    let mut text = String::new();
    for (k, parameters) in draw(count.into(), seed).iter().enumerate() {
        let name = format!("sample_{seed}_{:04}", k + 1);
        let face = Face { name: name.clone(), ..parametric(parameters, &resolution)? };
        write_face(&out.join(&name), &face)?;
        table += &name;
        Parameters::PROPORTIONS.iter().for_each(|p| table += &format!(",{:?}", p.of(parameters)));
        table += "\n";
        text += &format!("{}\n", out.join(&name).join("face.toml").display());
    }
    write_atomically(&out.join("faces.csv"), table.as_bytes())?;
    Ok(Outcome { text, solved: true })
}
