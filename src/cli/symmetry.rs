//! `modiolus symmetry`.

use std::collections::BTreeMap;
use std::path::Path;

use modiolus::certainty::percent;
use modiolus::face::{Face, Symmetry};
use modiolus::io::{CertaintyJson, FileSet, PairJson, SideJson, SymmetryJson, VtuData, given_side, vtu_text};
use modiolus::render::{Drawing, Scene, Show, three_views};

use super::Outcome;
use super::arguments::SymmetryOptions;
use super::error::CliError;
use super::export::keep_inputs;
use super::fit;
use super::progress::{Progress, say};
use super::render;

/// The files that are written.
const FILES: [&str; 3] = ["symmetry.json", "symmetry.vtu", "symmetry.png"];
/// Difference of the sides that is told, per cent.
const TOLD: f64 = 0.005;

pub(crate) fn run(options: &SymmetryOptions) -> Result<Outcome, CliError> {
    let mut progress = Progress::new();
    let moved = match options.what.is_dir() {
        true => of_result(&options.what, &mut progress)?,
        false => of_target(options)?,
    };
    let Moved { heading, loaded, displacement, sides, solved } = moved;
    if let Some(out) = &options.out {
        keep_inputs(&loaded.inputs, FILES.map(|name| out.join(name)))?;
    }
    let symmetry = progress.step("mirror", || Symmetry::of(&loaded.face, &displacement));
    let json = SymmetryJson::new(heading, &symmetry, sides, options.max_asymmetry_mm);
    let text = serde_json::to_string_pretty(&json)? + "\n";
    if let Some(out) = &options.out {
        let picture = progress.step("draw", || picture(&loaded.face, &displacement, &symmetry))?;
        write(out, &loaded.face, &displacement, &symmetry, [text.clone().into_bytes(), picture])?;
    }
    let solved = solved && json.within != Some(false);
    let text = if options.json { text } else { table(&json, options.max_asymmetry_mm) };
    Ok(Outcome { text, solved })
}

/// A face that was moved.
struct Moved {
    heading: String,
    loaded: super::load::LoadedFace,
    displacement: Vec<f64>,
    /// The sides of the muscles, and by how much the noise was raised.
    sides: (Vec<SideJson>, Option<f64>),
    solved: bool,
}

fn of_result(dir: &Path, progress: &mut Progress) -> Result<Moved, CliError> {
    let (loaded, files) = render::read_moved(dir, progress)?;
    let sides = sides(files.certainty.as_ref(), &files.activations);
    let heading = dir.display().to_string();
    Ok(Moved { heading, loaded, displacement: files.displacement, sides, solved: true })
}

fn of_target(options: &SymmetryOptions) -> Result<Moved, CliError> {
    let (fit::Fitted { answer, solved, .. }, loaded) =
        fit::fit(&options.fit.of(&options.what), &options.what)?;
    let heading = answer.heading;
    let Some(displacement) = answer.displacement else { return Err(CliError::NothingToIdentify { heading }) };
    let sides = sides(answer.json.certainty.as_ref(), &answer.json.activations);
    Ok(Moved { heading, loaded, displacement, sides, solved })
}

fn sides(
    certainty: Option<&CertaintyJson>,
    activations: &BTreeMap<String, f64>,
) -> (Vec<SideJson>, Option<f64>) {
    if let Some(certainty) = certainty {
        return (certainty.sides.clone(), Some(certainty.noise_factor));
    }
    let both = activations.iter().filter_map(|(name, &left)| {
        let stem = name.strip_suffix("_l")?;
        Some(given_side(stem, left, *activations.get(&format!("{stem}_r"))?))
    });
    (both.collect(), None)
}

fn write(
    out: &Path,
    face: &Face,
    displacement: &[f64],
    symmetry: &Symmetry,
    [json, picture]: [Vec<u8>; 2],
) -> Result<(), CliError> {
    let data = VtuData {
        point_vectors: [("displacement".to_owned(), displacement.to_vec())].into(),
        point_scalars: [("asymmetry_mm".to_owned(), symmetry.map_mm.clone())].into(),
        cell_scalars: BTreeMap::new(),
        cell_labels: BTreeMap::new(),
    };
    let mut set = FileSet::new(out);
    let [json_name, vtu_name, picture_name] = FILES;
    set.put(vtu_name, vtu_text(vtu_name.as_ref(), &face.mesh, &data)?.into_bytes());
    set.put(json_name, json);
    set.put(picture_name, picture);
    set.write()?;
    say(&format!("wrote {json_name}, {vtu_name} and {picture_name} to {}", out.display()));
    Ok(())
}

/// The moved face, coloured by how far each point of the skin is from the mirror image of the other side, as PNG.
fn picture(face: &Face, displacement: &[f64], symmetry: &Symmetry) -> Result<Vec<u8>, CliError> {
    let drawing = Drawing {
        show: Show { displacement: true, ..Show::FACE },
        displacement: Some(displacement),
        length_mm: Some(&symmetry.map_mm),
        ..Drawing::default()
    };
    Ok(three_views(&Scene::new(face), &drawing)?.to_png()?)
}

fn table(json: &SymmetryJson, most_mm: Option<f64>) -> String {
    let mut text = format!("Symmetry of {}\n\n", json.result);
    let width = json.pairs.iter().map(|p| p.name.len()).max().unwrap_or(0).max(12);
    text += &format!(
        "{:width$}  {:>15}  {:>5}  {:>15}  {:>7}  {:>8}\n{:width$}  {:>7} {:>7}  {:>5}  {:>7} {:>7}  {:>7}  {:>8}\n",
        "Movement",
        "excursion, mm",
        "ratio",
        "direction, deg",
        "height",
        "mirrored",
        "",
        "left",
        "right",
        "",
        "left",
        "right",
        "l - r",
        "l - r",
    );
    let angle = |deg: Option<f64>| deg.map_or_else(|| "-".to_owned(), |deg| format!("{deg:.0}"));
    for PairJson {
        name,
        excursion_mm: [l, r],
        excursion_ratio,
        direction_deg,
        height_mm,
        difference_mm,
        ..
    } in &json.pairs
    {
        let ratio = excursion_ratio.map_or_else(|| "-".to_owned(), |ratio| format!("{ratio:.2}"));
        let [dl, dr] = direction_deg.map(angle);
        text += &format!(
            "{name:width$}  {l:7.1} {r:7.1}  {ratio:>5}  {dl:>7} {dr:>7}  {:7.1}  {difference_mm:8.2}\n",
            tidy(*height_mm)
        );
    }
    for middle in &json.middle {
        text += &format!("{:width$}  {:.1} mm to the left\n", middle.name, tidy(middle.to_left_mm));
    }
    text += &format!("mirror RMS of the landmarks {:.2} mm", json.mirror_rms_mm);
    if let Some(skin) = json.skin_rms_mm {
        text += &format!(", of the skin {skin:.2} mm");
    }
    text.push('\n');
    text += &activations(&json.activations, json.noise_factor);
    text += "\nPublished limits, mm\n";
    for limit in &json.published {
        let [least, most] = limit.mm;
        let range = if least == 0. { format!("{most}") } else { format!("{least} to {most}") };
        text += &format!("{range:>14}  {} ({})\n", limit.of, limit.source);
    }
    if let (Some(within), Some(most), Some(largest)) = (json.within, most_mm, json.largest_mm) {
        let verdict = if within { "within" } else { "NOT within" };
        text += &format!("\nLargest difference of a pair {largest:.2} mm: {verdict} the {most} mm allowed\n");
    }
    text
}

fn activations(sides: &[SideJson], noise_factor: Option<f64>) -> String {
    if sides.is_empty() {
        return String::new();
    }
    let width = sides.iter().map(|s| s.name.len()).max().unwrap_or(0);
    let mut text = format!(
        "\n{:width$}  {:>18}  {:>19}  {:>9}\n",
        "Activation, per cent", "shared", "left - right", "at least"
    );
    let shown = |[value, min, max]: [f64; 3]| match max - min > 0. {
        true => format!("{} ({} to {})", percent(value), percent(min), percent(max)),
        false => percent(value),
    };
    for side in sides {
        let even = shown([side.even.value, side.even.min, side.even.max]);
        let odd = shown([side.odd.value, side.odd.min, side.odd.max].map(|odd| 2. * odd));
        let least = side.least_odd.map_or_else(|| "-".to_owned(), |odd| percent(2. * odd));
        text += &format!("{:width$}  {even:>18}  {odd:>19}  {least:>9}\n", side.name);
    }
    let needed: Vec<String> = sides
        .iter()
        .filter_map(|side| Some((side, side.least_odd.filter(|odd| odd.abs() > TOLD)?)))
        .map(|(side, odd)| {
            let stronger = if odd > 0. { "left" } else { "right" };
            format!("{} {} % stronger on the {stronger}", side.name, percent(2. * odd.abs()))
        })
        .collect();
    let noise = match noise_factor {
        Some(factor) if factor > 1.05 => {
            format!(
                "Within the noise, raised {factor:.1} times as the residuals are larger than it explains,"
            )
        }
        _ => "Within the noise".to_owned(),
    };
    text += &match (needed.is_empty(), noise_factor) {
        (true, None) => "Both sides were given equal activations\n".to_owned(),
        (true, Some(_)) => format!("{noise} equal activations on both sides explain this\n"),
        (false, None) => String::new(),
        (false, Some(_)) => {
            format!("{noise} the smallest differences that explain this are: {}\n", needed.join(", "))
        }
    };
    text
}

fn tidy(x: f64) -> f64 {
    (10. * x).round() / 10. + 0.
}
