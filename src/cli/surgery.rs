//! `modiolus surgery`.

use modiolus::face::{ContactLoad, Face, Pose, SurgicalPlan};
use modiolus::forward::{OperationError, operate, operate_at_finite_strain};
use modiolus::io::{FileSet, put_face, read_plan};
use modiolus::render::{Scene, before_and_after};
use modiolus::study::{Mechanics, MovedContact, Strain};
use modiolus::units::Vec3;

use super::Outcome;
use super::arguments::SurgeryOptions;
use super::error::CliError;
use super::export::{ANSWER, Answer, export, keep_inputs};
use super::forward::{State, contact_report, forward_json, unsettled};
use super::load::{input_name, load as load_face};
use super::progress::{Progress, say};
use super::render::write_image;

pub(crate) fn run(options: &SurgeryOptions) -> Result<Outcome, CliError> {
    let mut progress = Progress::new();
    let document = read_plan(&options.plan)?;
    let mut loaded = load_face(&options.face, &mut progress)?;
    loaded.inputs.insert(input_name(&options.plan), document.sha256.clone());
    // Before the work: the names of its files are those of any written face.
    let mut set = FileSet::new(&options.out);
    put_face(&mut set, &loaded.face)?;
    let files = set.names().chain(ANSWER).map(|name| options.out.join(name));
    keep_inputs(&loaded.inputs, files.chain(options.picture.clone()))?;
    let face = &loaded.face;
    let operated = progress.step("operate", || match options.strain {
        Strain::Linear => linear(&document.plan, face),
        Strain::Finite => finite(&document.plan, face),
    });
    let Operated { face: healed, pose, state, contact_load } = operated.map_err(|error| match error {
        OperationError::Plan(error) => {
            CliError::Plan { at: document.lines.location(error.field()), error: Box::new(error) }
        }
        other => CliError::Operation { plan: options.plan.clone(), error: Box::new(other) },
    })?;
    let picture = match &options.picture {
        Some(path) => {
            let scenes = progress.step("prepare", || [face, &healed].map(Scene::new));
            Some((path, progress.step("draw", || before_and_after(scenes.each_ref(), &[]))?))
        }
        None => None,
    };
    let mechanics = Mechanics { strain: options.strain, contact: true, ..Mechanics::default() };
    let json = forward_json(&loaded, &state, (mechanics, 1.), progress);
    put_face(&mut set, &healed)?;
    let heading = format!("{} on {}: how the tissue follows the bones", document.plan.name, loaded.called);
    let State { activation, displacement, .. } = state;
    let answer = Answer { heading, json, displacement: Some(displacement), activation, contact_load };
    let mut text = export(answer, face, set, options.json)?;
    if !options.json {
        text += &moved_bones(&healed, &pose);
    }
    say(&format!("wrote the new face to {}", options.out.join("face.toml").display()));
    if let Some((path, image)) = picture {
        write_image(path, &image)?;
    }
    Ok(Outcome { text, solved: true })
}

/// How far each bone and piece went: the middle of what it holds, and by how much it turned.
fn moved_bones(face: &Face, pose: &Pose) -> String {
    let mut text = String::from("\nBones\n");
    let width = face.supports.iter().map(|s| s.bone.chars().count()).max().unwrap_or(0);
    for support in &face.supports {
        let motion = pose.motion(face, &support.bone);
        let n = support.nodes.len().max(1) as f64;
        let middle = support.nodes.iter().map(|n| face.mesh.points[*n]).sum::<Vec3>() / n;
        let way = middle - motion.origin_of(middle);
        let whole = support.part_of.as_ref().map_or_else(String::new, |bone| format!(", a piece of {bone}"));
        text += &match motion.is_rest() {
            true => format!("{:width$}  stays{whole}\n", support.bone),
            false => format!(
                "{:width$}  its middle goes {:.1} mm: {:.1} to the left, {:.1} up, {:.1} forward; turned by {:.1} degrees{whole}\n",
                support.bone,
                way.norm(),
                way.x + 0.,
                way.y + 0.,
                way.z + 0.,
                motion.angle_deg()
            ),
        };
    }
    text
}

/// A plan carried out by either strain model.
struct Operated {
    face: Face,
    pose: Pose,
    state: State,
    contact_load: Option<ContactLoad>,
}

fn linear(plan: &SurgicalPlan, face: &Face) -> Result<Operated, OperationError> {
    let done = operate(plan, face)?;
    let movement = &done.movement;
    let mut warnings: Vec<String> = done.large_turns.iter().map(ToString::to_string).collect();
    warnings.extend((!movement.settled).then(|| unsettled(movement.penetration_mm)));
    let contact = MovedContact::of_linear(face, movement);
    let state = at_rest(face, movement.equilibrium.displacement.clone(), Some(&contact), warnings);
    Ok(Operated { face: done.face, pose: done.pose, state, contact_load: Some(contact.load) })
}

fn finite(plan: &SurgicalPlan, face: &Face) -> Result<Operated, OperationError> {
    let done = operate_at_finite_strain(plan, face)?;
    // The arches go with the pieces that they are cut with.
    let cut = plan.prepare(face)?.face;
    let contact = MovedContact::of_finite(&cut, &done.movement);
    let state = at_rest(face, done.movement.displacement().to_vec(), contact.as_ref(), Vec::new());
    Ok(Operated {
        face: done.face,
        pose: done.pose,
        state,
        contact_load: contact.map(|contact| contact.load),
    })
}

/// The tissue of `face` moved by `displacement` (3n, mm), its muscles at rest.
fn at_rest(
    face: &Face,
    displacement: Vec<f64>,
    contact: Option<&MovedContact>,
    warnings: Vec<String>,
) -> State {
    State {
        activation: vec![0.; face.muscles.len()],
        jaw_opening_mm: None,
        displacement,
        contact: contact.map(contact_report),
        warnings,
    }
}
