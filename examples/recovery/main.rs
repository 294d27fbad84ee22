//! Known activations recovered from another mesh and from another anatomist's muscles: `docs/recovery.md`.
#![allow(clippy::unwrap_used, clippy::print_stdout, reason = "an example that cannot go on should say where")]

use std::path::{Path, PathBuf};

use modiolus::certainty::{Certainty, Discrepancy};
use modiolus::face::standard::Resolution;
use modiolus::face::{Face, standard};
use modiolus::forward::{Model, Response};
use modiolus::inverse::{ContactMode, Goal, Marker, Observations, Place, Problem, Target};
use modiolus::io::read_face;
use modiolus::mesh::{Locator, Site};
use modiolus::units::Vec3;
use nalgebra::DVector;
use rand_xoshiro::Xoshiro256PlusPlus;
use rand_xoshiro::rand_core::{RngCore, SeedableRng};

/// A face and what its muscles do to the markers.
struct Subject {
    muscles: Vec<String>,
    sites: Vec<Site>,
    response: Response,
}

impl Subject {
    fn new(face: &Face, points: &[Vec3]) -> Self {
        let locator = Locator::new(&face.mesh);
        let sites: Vec<Site> = points.iter().map(|p| locator.locate(*p).unwrap().site).collect();
        let model = Model::new(face, Vec::new()).unwrap();
        let fixed = model.at(&vec![0.5; face.muscles.len()]).unwrap();
        let muscles = face.muscles.iter().map(|m| m.name.clone()).collect();
        let response = fixed.response(&sites);
        Self { muscles, sites, response }
    }
}

/// `count` points of the skin about the mouth, each as far from the others as can be.
fn markers(face: &Face, count: usize) -> Vec<Vec3> {
    let near = |p: &Vec3| p.x.abs() < 50. && p.y > -45. && p.y < 40. && p.z > -60.;
    let mut nodes: Vec<usize> = face.skin.iter().copied().collect();
    nodes.sort_unstable();
    nodes.dedup();
    let skin: Vec<Vec3> = nodes.iter().map(|&n| face.mesh.points[n]).filter(near).collect();
    let mut chosen = vec![face.landmark("cheilion_l").unwrap().site.position];
    while chosen.len() < count {
        let apart = |p: &Vec3| chosen.iter().map(|q| (p - q).norm()).fold(f64::INFINITY, f64::min);
        let next = skin.iter().max_by(|a, b| apart(a).total_cmp(&apart(b))).unwrap();
        chosen.push(*next);
    }
    chosen
}

struct Random(Xoshiro256PlusPlus);

impl Random {
    fn unit(&mut self) -> f64 {
        (self.0.next_u64() >> 11) as f64 / (1u64 << 53) as f64
    }

    fn normal(&mut self) -> f64 {
        let (u, v) = (1. - self.unit(), self.unit());
        (-2. * u.ln()).sqrt() * (std::f64::consts::TAU * v).cos()
    }
}

fn badin(original: bool) -> Face {
    let root = Path::new(env!("CARGO_MANIFEST_DIR"));
    let data = std::env::var_os("MODIOLUS_DATA").map_or_else(|| root.join("../shared/data"), PathBuf::from);
    let base = data.join("badin_face");
    let mut text = std::fs::read_to_string(root.join("examples/badin/face.toml")).unwrap();
    if original {
        text = text
            .replace("fibres = \"fibres.csv\"", "fibres = \"fibres_original.csv\"\nmax_projection_mm = 20.0");
        let start = text.find("[[muscles]]\nname = \"levator_labii_superioris\"\n").unwrap();
        let end = start + text[start + 1..].find("[[muscles]]").unwrap() + 1;
        text.replace_range(start..end, "");
    }
    let file = std::env::temp_dir().join(format!("modiolus_recovery_{original}.toml"));
    std::fs::write(&file, text).unwrap();
    read_face(&file, Some(&base)).unwrap_or_else(|e| panic!("{e}")).face
}

/// How far the columns of `other` are from those of `here`.
fn discrepancy(title: &str, here: &Subject, other: &Subject) {
    let points: Vec<Vec3> = here.sites.iter().map(|s| s.position).collect();
    let (mut strengths, mut shapes) = (Vec::new(), Vec::new());
    let mut near = vec![(0., 0usize); 12];
    for (k, name) in here.muscles.iter().enumerate() {
        let Some(j) = other.muscles.iter().position(|n| n == name) else { continue };
        let (f, g) = (here.response.map.column(k), other.response.map.column(j));
        let s = f.dot(&g) / f.norm_squared() - 1.;
        let e = g - f * (1. + s);
        let shape = e.norm() / f.norm();
        println!("  {name:50} {s:7.3} {shape:7.3}");
        strengths.push(s);
        shapes.push(shape);
        let relative: Vec<Vec3> = (0..points.len())
            .map(|p| Vec3::from(e.fixed_rows::<3>(3 * p)) / f.rows(3 * p, 3).norm())
            .collect();
        let size: f64 = relative.iter().map(|r| r.norm_squared()).sum::<f64>() / points.len() as f64;
        for p in 0..points.len() {
            for q in 0..p {
                let bin = ((points[p] - points[q]).norm() / 5.) as usize;
                if bin < near.len() {
                    near[bin].0 += relative[p].dot(&relative[q]) / size;
                    near[bin].1 += 1;
                }
            }
        }
    }
    let rms = |x: &[f64]| (x.iter().map(|v| v * v).sum::<f64>() / x.len() as f64).sqrt();
    let near: Vec<String> = near.iter().map(|(s, n)| format!("{:.2}", s / (*n).max(1) as f64)).collect();
    println!(
        "{title}: strength {:.3}, shape {:.3}, correlation by 5 mm {}",
        rms(&strengths),
        rms(&shapes),
        near.join(" ")
    );
}

#[derive(Default)]
struct Score {
    covered: usize,
    count: usize,
    width: f64,
    error: f64,
    mean_error: f64,
    worst: f64,
    active: [usize; 2],
}

/// Activations of `truth` seen with `noise_mm` and recovered on `here`.
fn recover(
    here: &Subject,
    truth: &Subject,
    noise_mm: f64,
    discrepancy: Discrepancy,
    active: usize,
    trials: usize,
) -> Score {
    let mut random = Random(Xoshiro256PlusPlus::seed_from_u64(7));
    let mut score = Score::default();
    for _ in 0..trials {
        let m = truth.muscles.len();
        let mut a = DVector::zeros(m);
        for _ in 0..active {
            a[(random.unit() * m as f64) as usize] = random.unit();
        }
        let seen = &truth.response.map * &a + &truth.response.offset;
        let seen = seen.map(|v| v + noise_mm * random.normal());
        let markers = here.sites.iter().enumerate().map(|(k, site)| Marker {
            name: format!("m{k}"),
            at: Place::Point(site.position),
            goal: Goal::Displacement([0, 1, 2].map(|axis| Some(seen[3 * k + axis]))),
            sigma_mm: noise_mm,
        });
        let target =
            Target { name: "t".into(), markers: markers.collect(), effort: 1e-3, ..Target::default() };
        let observations = Observations {
            sites: here.sites.clone(),
            markers: (0..here.sites.len()).collect(),
            ..Observations::default()
        };
        let problem = Problem::new(&target, &observations, &here.response).unwrap();
        let solution = problem.solve(ContactMode::Off).unwrap();
        let certainty = Certainty::of(solution.program.as_ref().unwrap(), discrepancy).unwrap();
        for unknown in &certainty.unknowns {
            let true_value = truth.muscles.iter().position(|n| *n == unknown.name).map_or(0., |k| a[k]);
            let inside = unknown.min - 1e-6 <= true_value && true_value <= unknown.max + 1e-6;
            score.covered += usize::from(inside);
            score.count += 1;
            score.width += unknown.max - unknown.min;
            score.error += (unknown.value - true_value).powi(2);
            score.mean_error += (unknown.mean - true_value).powi(2);
            score.worst = score.worst.max((unknown.value - true_value).abs());
            if true_value > 0. {
                score.active[1] += 1;
                score.active[0] += usize::from(inside);
            }
        }
    }
    score
}

fn main() {
    let faces = [Resolution::COARSE, Resolution::STANDARD].map(|r| standard(&r));
    let points = markers(&faces[1], 40);
    let [coarse, usual] = faces.each_ref().map(|face| Subject::new(face, &points));
    discrepancy("standard -> coarse", &usual, &coarse);
    discrepancy("coarse -> standard", &coarse, &usual);
    let (own, original) = (badin(false), badin(true));
    let points = markers(&own, 40);
    let [own, original] = [own, original].map(|face| Subject::new(&face, &points));
    discrepancy("badin -> original", &own, &original);
    discrepancy("original -> badin", &original, &own);
    let cases: [(&str, &Subject, &Subject, Discrepancy); 6] = [
        ("same mesh, none", &usual, &usual, Discrepancy::NONE),
        ("coarse truth, none", &usual, &coarse, Discrepancy::NONE),
        ("coarse truth, mesh", &usual, &coarse, Discrepancy::MESH),
        ("standard truth, mesh", &coarse, &usual, Discrepancy::MESH),
        ("badin original truth, anatomy", &own, &original, Discrepancy::ANATOMY),
        ("badin own truth, anatomy", &original, &own, Discrepancy::ANATOMY),
    ];
    for (title, here, truth, model) in cases {
        for noise in [0.1, 0.5] {
            let start = std::time::Instant::now();
            let s = recover(here, truth, noise, model, 10, 40);
            println!(
                "{title:32} {noise} mm: coverage {:.3} (active {:.3}), mean width {:.3}, RMSE {:.3} (mean {:.3}), worst {:.2}; {:.1} s",
                s.covered as f64 / s.count as f64,
                s.active[0] as f64 / s.active[1] as f64,
                s.width / s.count as f64,
                (s.error / s.count as f64).sqrt(),
                (s.mean_error / s.count as f64).sqrt(),
                s.worst,
                start.elapsed().as_secs_f64()
            );
        }
    }
}
