//! `modiolus map`.

use modiolus::forward::Model;
use modiolus::io::{MapNpz, write_atomically};
use modiolus::units::counted;

use super::Outcome;
use super::arguments::MapOptions;
use super::error::CliError;
use super::export::keep_inputs;
use super::load::load;
use super::progress::{Progress, say};

pub(crate) fn run(options: &MapOptions) -> Result<Outcome, CliError> {
    let mut progress = Progress::new();
    let loaded = load(&options.face, &mut progress)?;
    keep_inputs(&loaded.inputs, [options.out.clone()])?;
    let face = &loaded.face;
    let forward = |error| CliError::Forward { face: loaded.called.clone(), error: Box::new(error) };
    let model = progress.step("assemble", || Model::new(face, Vec::new())).map_err(forward)?;
    let stiffness = options.stiffness;
    let held = vec![stiffness; model.muscles().len()];
    let fixed = progress.step("factorise", || model.at(&held)).map_err(forward)?;
    let displacement = progress.step("solve", || fixed.map());
    let muscles = model.muscles();
    let map = MapNpz {
        points: &face.mesh.points,
        landmarks: &face.landmarks,
        muscles,
        displacement: &displacement,
        stiffness,
    };
    let bytes = map.to_bytes()?;
    write_atomically(&options.out, &bytes)?;
    say(&format!("wrote {}", options.out.display()));
    let mut text = format!(
        "Activation map of {}: {}, {}, stiffness held at {stiffness}\n\n",
        loaded.called,
        counted(muscles.len(), "muscle"),
        counted(face.mesh.n_nodes(), "point")
    );
    let width = muscles.iter().map(String::len).max().unwrap_or(0);
    text += &format!("{:width$}   farthest point, mm at full activation\n", "muscle");
    for (muscle, u) in muscles.iter().zip(&displacement) {
        let farthest = u.chunks(3).map(|d| d.iter().map(|x| x * x).sum::<f64>()).fold(0.0, f64::max).sqrt();
        text += &format!("{muscle:width$}   {farthest:6.1}\n");
    }
    Ok(Outcome { text, solved: true })
}
