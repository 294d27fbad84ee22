//! `modiolus compare`.

use std::path::Path;

use modiolus::face::Pose;
use modiolus::io::{AnswerFiles, ComparedLandmarkJson, ComparisonJson, ContactJson};
use modiolus::render::{MovedScene, Scene, side_by_side};
use modiolus::study::{Comparison, Posed};
use modiolus::units::Vec3;

use super::Outcome;
use super::arguments::CompareOptions;
use super::error::CliError;
use super::export::keep_inputs;
use super::load::{LoadedFace, input_name, pose};
use super::progress::Progress;
use super::render::{read_moved, write_image};

/// Activations that change by less are not listed.
const SHOWN_CHANGE: f64 = 0.005;
/// Movements and rest positions that change by less are not listed, mm.
const SHOWN_MM: f64 = 0.05;

/// A result with its face.
struct Side {
    answer: AnswerFiles,
    loaded: LoadedFace,
    activation: Vec<f64>,
    pose: Pose,
}

pub(crate) fn run(options: &CompareOptions) -> Result<Outcome, CliError> {
    let mut progress = Progress::new();
    let folders = [&options.first, &options.second];
    let [first, second] = folders.map(|folder| side(folder, &mut progress));
    let sides = [first?, second?];
    for side in &sides {
        keep_inputs(&side.loaded.inputs, options.out.clone())?;
    }
    let comparison = Comparison::of([0, 1].map(|k| Posed {
        face: &sides[k].loaded.face,
        activation: &sides[k].activation,
        displacement: &sides[k].answer.displacement,
    }));
    let names = folders.map(|folder| input_name(folder));
    let json = ComparisonJson::new(&names, [&sides[0].answer, &sides[1].answer], &comparison);
    if let Some(out) = &options.out {
        let scenes = progress.step("prepare", || [0, 1].map(|k| Scene::new(&sides[k].loaded.face)));
        let moved = [0, 1].map(|k| MovedScene {
            scene: &scenes[k],
            displacement: &sides[k].answer.displacement,
            pose: sides[k].pose.clone(),
            title: format!("{}: {}", ["A", "B"][k], input_name(folders[k])),
        });
        let image = progress.step("draw", || side_by_side(&moved, options.view))?;
        write_image(out, &image)?;
    }
    let text = if options.json { json.to_text()? } else { table(&json) };
    Ok(Outcome { text, solved: true })
}

fn side(folder: &Path, progress: &mut Progress) -> Result<Side, CliError> {
    let (loaded, answer) = read_moved(folder, progress)?;
    if answer.operated.is_some() {
        return Err(CliError::ResultOfOperation(folder.to_owned()));
    }
    for (input, sha256) in &loaded.inputs {
        if answer.inputs.get(input).is_some_and(|known| known != sha256) {
            return Err(CliError::ChangedInput { dir: folder.to_owned(), input: input.clone() });
        }
    }
    let of = |name: &String| answer.activations.get(name).copied().unwrap_or(0.0);
    let activation = loaded.face.muscles.iter().map(|m| of(&m.name)).collect();
    let pose = pose(&loaded.face, answer.jaw_opening_mm);
    Ok(Side { answer, loaded, activation, pose })
}

fn table(json: &ComparisonJson) -> String {
    let mut text = String::new();
    for (letter, result) in [("A", &json.a), ("B", &json.b)] {
        let what = result.target.as_deref().unwrap_or("activations");
        text += &format!("{letter}  {}: {what} on {}\n", result.folder, result.face);
    }
    text += &conditions(json);
    let parts =
        [activations(json), markers(json), rest(json), landmarks(json), contact(json), symmetry(json)];
    text + &parts.concat()
}

/// What was not the same in both.
fn conditions(json: &ComparisonJson) -> String {
    let opening = |mm: Option<f64>| mm.map_or("unsaid".to_owned(), |mm| format!("{mm:.1} mm"));
    let of = |r: &modiolus::io::ComparedResultJson| {
        [
            ("strain", r.strain.clone()),
            ("stiffness", r.stiffness.clone()),
            ("strength", r.strength.to_string()),
            ("jaw opening", opening(r.jaw_opening_mm)),
        ]
    };
    let both = of(&json.a).into_iter().zip(of(&json.b)).filter(|(a, b)| a != b);
    both.map(|((what, a), (_, b))| format!("not alike: {what}, {a} in A and {b} in B\n")).collect()
}

fn activations(json: &ComparisonJson) -> String {
    let mut rows: Vec<_> =
        json.activations.iter().filter(|row| row.change.is_some_and(|c| c.abs() >= SHOWN_CHANGE)).collect();
    rows.sort_by(|x, y| {
        let size = |c: Option<f64>| c.unwrap_or(0.).abs();
        size(y.change).total_cmp(&size(x.change)).then(x.name.cmp(&y.name))
    });
    let width = width(rows.iter().map(|row| row.name.as_str()));
    let mut text = format!("\n{:width$} {:>7}{:>7}{:>9}\n", "Activation, per cent", "A", "B", "change");
    for row in &rows {
        let per_cent = |a: Option<f64>| a.map_or("-".to_owned(), |a| format!("{:.0}", 100. * a));
        let change = row.change.map_or("-".to_owned(), |c| format!("{:+.0}", 100. * c));
        text += &format!("{:width$} {:>7}{:>7}{change:>9}\n", row.name, per_cent(row.a), per_cent(row.b));
    }
    let alike = json.activations.iter().filter(|row| row.change.is_some()).count() - rows.len();
    text += &format!("{alike} alike within half a per cent\n");
    for (names, which) in [(&json.only_a, "A"), (&json.only_b, "B")] {
        if !names.is_empty() {
            text += &format!("only in {which}: {}\n", names.join(", "));
        }
    }
    text
}

fn markers(json: &ComparisonJson) -> String {
    if json.markers.is_empty() {
        return String::new();
    }
    let width = width(json.markers.iter().map(|row| row.name.as_str()));
    let mut text = format!("\n{:width$} {:>7}{:>7}\n", "Markers, off by mm", "A", "B");
    for row in &json.markers {
        let [a, b] = [row.residual_a_mm, row.residual_b_mm].map(millimetres);
        text += &format!("{:width$} {a:>7}{b:>7}\n", row.name);
    }
    text
}

fn rest(json: &ComparisonJson) -> String {
    if !json.faces_differ {
        return String::new();
    }
    let title = "Landmarks at rest, mm from A to B";
    vectors(title, &json.landmarks, |row| row.rest_change_mm)
}

fn landmarks(json: &ComparisonJson) -> String {
    let change = |row: &ComparedLandmarkJson| {
        let (a, b) = row.displacement_a_mm.zip(row.displacement_b_mm)?;
        Some((Vec3::from(b) - Vec3::from(a)).into())
    };
    vectors("Movements, mm more in B", &json.landmarks, change)
}

/// The landmarks whose `of` is not small, the largest first.
fn vectors(
    title: &str,
    landmarks: &[ComparedLandmarkJson],
    of: impl Fn(&ComparedLandmarkJson) -> Option<[f64; 3]>,
) -> String {
    let known: Vec<(&str, Vec3)> =
        landmarks.iter().filter_map(|row| Some((row.name.as_str(), Vec3::from(of(row)?)))).collect();
    let mut rows: Vec<_> = known.iter().filter(|(_, d)| d.norm() >= SHOWN_MM).collect();
    rows.sort_by(|x, y| y.1.norm().total_cmp(&x.1.norm()).then(x.0.cmp(y.0)));
    let width = width(rows.iter().map(|row| row.0)).max(title.len());
    let mut text = format!("\n{title:width$} {:>7}{:>7}{:>7}{:>8}\n", "x left", "y up", "z fwd", "length");
    for (name, d) in &rows {
        let [x, y, z] = [d.x, d.y, d.z].map(|x| (10. * x).round() / 10. + 0.);
        text += &format!("{name:width$} {x:7.1}{y:7.1}{z:7.1}{:8.1}\n", d.norm());
    }
    let alike = known.len() - rows.len();
    text + &format!("{alike} alike within {SHOWN_MM} mm\n")
}

fn contact(json: &ComparisonJson) -> String {
    let width = 20;
    let both = [json.contact.a, json.contact.b];
    let mut text = format!("\n{:width$} {:>7}{:>7}\n", "Contact", "A", "B");
    let mut row = |name: &str, of: &dyn Fn(&ContactJson) -> String| {
        let [a, b] = both.map(|c| c.as_ref().map_or("off".to_owned(), of));
        text += &format!("{name:width$} {a:>7}{b:>7}\n");
    };
    row("pairs that push", &|c| c.active.to_string());
    row("force, N", &|c| format!("{:.2}", c.force_n));
    row("upper teeth, N", &|c| format!("{:.2}", c.upper_teeth_n));
    row("lower teeth, N", &|c| format!("{:.2}", c.lower_teeth_n));
    row("lip on lip, N", &|c| format!("{:.2}", c.lips_n));
    row("overlap, mm", &|c| c.overlap_mm.map_or("-".to_owned(), |mm| format!("{:.3}", mm.max(0.))));
    text
}

fn symmetry(json: &ComparisonJson) -> String {
    let both = [&json.a.symmetry, &json.b.symmetry];
    let width = 44;
    let mut text = format!("\n{:width$} {:>7}{:>7}\n", "Symmetry", "A", "B");
    let per_cent = |x: Option<f64>| x.map_or("-".to_owned(), |x| format!("{:.0}", 100. * x));
    let [a, b] = both.map(|s| per_cent(s.activations_rms));
    text += &format!("{:width$} {a:>7}{b:>7}\n", "left against right, activations rms, per cent");
    let [a, b] = both.map(|s| millimetres(s.landmarks_rms_mm));
    text += &format!("{:width$} {a:>7}{b:>7}\n", "left against mirrored right, landmarks rms, mm");
    text
}

fn millimetres(mm: Option<f64>) -> String {
    mm.map_or("-".to_owned(), |mm| format!("{mm:.2}"))
}

fn width<'a>(names: impl Iterator<Item = &'a str>) -> usize {
    names.map(|name| name.chars().count()).max().unwrap_or(0).max(20)
}
