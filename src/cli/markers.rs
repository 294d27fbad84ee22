//! `modiolus markers`.

use modiolus::certainty::MarkerDesign;
use modiolus::face::Face;
use modiolus::forward::Model;
use modiolus::mesh::Site;
use modiolus::units::{Vec3, counted};
use serde_json::json;

use super::Outcome;
use super::arguments::MarkersOptions;
use super::error::CliError;
use super::load::load;
use super::progress::Progress;

/// Candidates besides the landmarks.
const CANDIDATES: usize = 150;
/// How far from the stomion a candidate may lie, mm.
const REACH_MM: f64 = 70.;

pub(crate) fn run(options: &MarkersOptions) -> Result<Outcome, CliError> {
    let mut progress = Progress::new();
    let loaded = load(&options.face, &mut progress)?.with_strength(options.strength);
    let face = &loaded.face;
    let candidates = candidates(face);
    let points: Vec<Vec3> = candidates.iter().map(|(_, site)| site.position).collect();
    let sites: Vec<Site> = candidates.iter().map(|(_, site)| site.clone()).collect();
    let forward = |error| CliError::Forward { face: loaded.called.clone(), error: Box::new(error) };
    let response = progress.step("assemble", || {
        let model = Model::new(face, Vec::new())?;
        Ok(model.at(&vec![options.stiffness; face.muscles.len()])?.response(&sites))
    });
    let response = response.map_err(forward)?;
    let design = MarkerDesign {
        points: &points,
        map: &response.map,
        sigma_mm: options.sigma_mm,
        discrepancy: options.discrepancy,
    };
    let chosen = progress.step("choose", || design.choose(usize::from(options.count)));
    let all = design.all();
    let mean = |sd: &nalgebra::DVector<f64>| sd.mean();
    if options.json {
        let rows: Vec<serde_json::Value> = chosen
            .iter()
            .map(|c| {
                let (name, site) = &candidates[c.candidate];
                json!({ "name": name, "point_mm": [site.position.x, site.position.y, site.position.z], "mean_sd": mean(&c.sd) })
            })
            .collect();
        let text = json!({ "markers": rows, "candidates": candidates.len(), "mean_sd_of_all": all.as_ref().map(mean) });
        return Ok(Outcome { text: serde_json::to_string_pretty(&text)? + "\n", solved: true });
    }
    let mut text = format!(
        "Markers on {} that determine {} best, of {} candidates, seen to {} mm\n",
        loaded.called,
        counted(face.muscles.len(), "activation"),
        candidates.len(),
        options.sigma_mm
    );
    let width = candidates.iter().map(|(name, _)| name.len()).max().unwrap_or(0);
    text += &format!(
        "{:>3}  {:width$}  {:>7}{:>7}{:>7}  mean standard deviation of an activation, per cent\n",
        "", "marker", "x left", "y up", "z fwd"
    );
    for (k, c) in chosen.iter().enumerate() {
        let (name, site) = &candidates[c.candidate];
        let p = site.position.map(|x| (10. * x).round() / 10. + 0.);
        text += &format!(
            "{:3}  {name:width$}  {:7.1}{:7.1}{:7.1}  {:5.1}\n",
            k + 1,
            p.x,
            p.y,
            p.z,
            100. * mean(&c.sd)
        );
    }
    if let Some(all) = &all {
        text += &format!(
            "all {} candidates: {:.1}; with none: {:.1}\n",
            candidates.len(),
            100. * mean(all),
            100. / 12f64.sqrt()
        );
    }
    if let Some(last) = chosen.last() {
        text += &worst(face, &last.sd);
    }
    Ok(Outcome { text, solved: true })
}

/// The muscles that these markers leave most open.
fn worst(face: &Face, sd: &nalgebra::DVector<f64>) -> String {
    const NAMED: usize = 5;
    let mut order: Vec<usize> = (0..sd.len()).collect();
    order.sort_by(|&i, &j| sd[j].total_cmp(&sd[i]).then(i.cmp(&j)));
    let named: Vec<String> = order
        .into_iter()
        .take(NAMED)
        .map(|k| format!("{} {:.0}", face.muscles[k].name, 100. * sd[k]))
        .collect();
    format!("least determined with these: {}\n", named.join(", "))
}

/// Landmarks, and points of the skin each as far from the others as can be.
fn candidates(face: &Face) -> Vec<(String, Site)> {
    let mut all: Vec<(String, Site)> =
        face.landmarks.iter().map(|l| (l.name.clone(), l.site.clone())).collect();
    let skin: Vec<usize> =
        face.skin.iter().copied().filter(|&n| face.mesh.points[n].norm() <= REACH_MM).collect();
    let mut apart: Vec<f64> = skin
        .iter()
        .map(|&n| {
            let p = face.mesh.points[n];
            all.iter().map(|(_, site)| (site.position - p).norm()).fold(f64::INFINITY, f64::min)
        })
        .collect();
    for _ in 0..CANDIDATES.min(skin.len()) {
        let Some(farthest) = (0..skin.len()).max_by(|&i, &j| apart[i].total_cmp(&apart[j]).then(j.cmp(&i)))
        else {
            break;
        };
        let p = face.mesh.points[skin[farthest]];
        for (apart, &n) in apart.iter_mut().zip(&skin) {
            *apart = apart.min((face.mesh.points[n] - p).norm());
        }
        all.push((format!("skin node {}", skin[farthest]), Site::node(skin[farthest], p)));
    }
    all
}
