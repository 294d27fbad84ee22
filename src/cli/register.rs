//! `modiolus register`.

use std::collections::BTreeMap;
use std::path::Path;

use modiolus::contact::{closed_surface, oriented};
use modiolus::face::Teeth;
use modiolus::face::standard::Resolution;
use modiolus::io::{
    FileSet, RegistrationJson, VtuData, put_face, read_landmarks, read_surface_file, vtu_text,
};
use modiolus::mesh::Surface;
use modiolus::registration::{GivenLandmark, Registration, Subject, Template, register};

use super::Outcome;
use super::arguments::{FaceChoice, RegisterOptions};
use super::error::CliError;
use super::export::keep_inputs;
use super::file_name;
use super::load::{input_name, load};
use super::progress::{Progress, say};

/// What is written beside the face.
const FILES: [&str; 2] = ["registration.json", "registration.vtu"];

pub(crate) fn run(options: &RegisterOptions) -> Result<Outcome, CliError> {
    let mut progress = Progress::new();
    let (template, called, mut inputs) = match &options.face {
        FaceChoice::Standard(resolution) => {
            let called = resolution.face_name().unwrap_or_default().to_owned();
            (Template::Standard(*resolution), called, BTreeMap::new())
        }
        choice => {
            let loaded = load(choice, &mut progress)?;
            (Template::Face(Box::new(loaded.face)), loaded.name, loaded.inputs)
        }
    };
    let subject = progress.step("read_scan", || read(options, &mut inputs))?;
    let told =
        |bar: indicatif::ProgressBar| register(&subject, &template, |step| bar.set_message(step.to_owned()));
    let mut found = progress
        .told_step("register", told)
        .map_err(|error| CliError::Registration { scan: options.scan.clone(), error: Box::new(error) })?;
    found.face.name = name_of(options);
    for warning in &found.warnings {
        say(&format!("warning: {warning}"));
    }
    let json = RegistrationJson::new(&found, called, inputs, progress.timings_s());
    let text = serde_json::to_string_pretty(&json)? + "\n";
    write(options, &found, &json, &text)?;
    say(&format!("wrote the face to {}", options.out.join("face.toml").display()));
    Ok(Outcome { text: if options.json { text } else { table(&json) }, solved: true })
}

/// The name of the face: as asked for, or that of the scan; never that of a face that is built in.
fn name_of(options: &RegisterOptions) -> String {
    let stem = options.scan.file_stem().and_then(|stem| stem.to_str()).unwrap_or("scan");
    let name = options.name.clone().unwrap_or_else(|| file_name(stem));
    if Resolution::of_face(&name).is_some() { name + "_registered" } else { name }
}

fn read(options: &RegisterOptions, inputs: &mut BTreeMap<String, String>) -> Result<Subject, CliError> {
    let mut surface = |path: &Path| -> Result<Surface, CliError> {
        let (surface, file) = read_surface_file(path, options.unit)?;
        inputs.insert(input_name(path), file.sha256);
        Ok(surface)
    };
    let scan = surface(&options.scan)?;
    let mut teeth = Vec::new();
    for (upper, path) in [(true, &options.teeth_upper), (false, &options.teeth_lower)] {
        let Some(path) = path else { continue };
        let (turned, _) = oriented(&surface(path)?);
        let (closed, warnings) = closed_surface(&turned, true)
            .map_err(|error| CliError::Teeth { path: path.clone(), error: Box::new(error) })?;
        warnings.iter().for_each(|warning| say(&format!("warning: {}: {warning}", path.display())));
        let bone = if upper { "skull" } else { "mandible" }.to_owned();
        teeth.push(Teeth { upper, bone, surface: closed });
    }
    let mut bones = Vec::new();
    for (name, path) in [("skull", &options.skull), ("mandible", &options.mandible)] {
        if let Some(path) = path {
            bones.push((name.to_owned(), surface(path)?));
        }
    }
    let (landmarks, file) = read_landmarks(&options.landmarks, options.unit)?;
    inputs.insert(input_name(&options.landmarks), file.sha256);
    let landmarks = landmarks.into_iter().map(|(name, position)| GivenLandmark { name, position }).collect();
    Ok(Subject { scan, landmarks, teeth, bones })
}

fn write(
    options: &RegisterOptions,
    found: &Registration,
    json: &RegistrationJson,
    text: &str,
) -> Result<(), CliError> {
    let (face, quality) = (&found.face, &found.quality);
    let mut set = FileSet::new(&options.out);
    put_face(&mut set, face)?;
    let maps = [
        ("distance_mm", &quality.distance_map_mm),
        ("depth_mm", &quality.depth_map_mm),
        ("asymmetry_mm", &quality.asymmetry_map_mm),
    ];
    let data = VtuData {
        point_scalars: maps.map(|(name, map)| (name.to_owned(), map.clone())).into(),
        ..VtuData::default()
    };
    let [json_name, vtu_name] = FILES;
    set.put(vtu_name, vtu_text(vtu_name.as_ref(), &face.mesh, &data)?.into_bytes());
    set.put(json_name, text.as_bytes().to_vec());
    let names: Vec<_> = set.names().map(|name| options.out.join(name)).collect();
    keep_inputs(&json.inputs, names)?;
    set.write()?;
    Ok(())
}

fn table(json: &RegistrationJson) -> String {
    let mut text = format!("{} from {}\n\n", json.face, json.template);
    let s = &json.similarity;
    text += &format!(
        "size {:.3} of the template, turned by {:.1} degrees, landmarks to {:.2} mm\n",
        s.scale, s.angle_deg, s.landmark_rms_mm
    );
    for (name, mm) in json.proportions.iter().flatten() {
        text += &format!("{name:20} {mm:8.2}\n");
    }
    text += "\ndistance, mm          mean     rms    95 %     max\n";
    for (what, d) in [("skin to scan", &json.skin_to_scan), ("scan to skin", &json.scan_to_skin)] {
        let [mean, rms, p95, max] = [d.mean_mm, d.rms_mm, d.p95_mm, d.max_mm];
        text += &format!("{what:18} {mean:7.3} {rms:7.3} {p95:7.3} {max:7.3}\n");
    }
    text += &format!("{:.0} per cent of the skin is covered by the scan\n", 100. * json.covered);
    text += &format!(
        "smallest scaled Jacobian {:.3}, {} cells inside out\n",
        json.scaled_jacobian, json.inverted_cells
    );
    text += "\nlandmark                  error   depth   template's, mm\n";
    for landmark in &json.landmarks {
        let depth = json.depths.iter().find(|d| d.landmark == landmark.name);
        let depths = depth.map(|d| format!("{:7.1} {:7.1}", d.depth_mm, d.template_mm)).unwrap_or_default();
        let held = if landmark.held { "" } else { "  position only" };
        text += &format!("{:24} {:6.2} {depths}{held}\n", landmark.name, landmark.error_mm);
    }
    text += "\nasymmetry at rest, mm\n";
    for pair in &json.asymmetry {
        text += &format!("{:24} {:6.2}\n", pair.name, pair.distance_mm);
    }
    text += "\nmuscle, mm                                     length   template's\n";
    for m in &json.muscles {
        text += &format!("{:46} {:6.1}       {:6.1}\n", m.name, m.length_mm, m.template_mm);
    }
    text
}
