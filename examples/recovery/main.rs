//! Known activations recovered from another mesh and from another anatomist's muscles: writes `docs/recovery.md` and its
//! figures. `cargo run --release --example recovery`; the faces of other anatomists are in `MODIOLUS_DATA`.
#![allow(clippy::unwrap_used, clippy::print_stdout, reason = "an example that cannot go on should say where")]

use std::path::{Path, PathBuf};

use modiolus::certainty::{Certainty, Discrepancy};
use modiolus::face::standard::Resolution;
use modiolus::face::{ContactReach, ContactSearch};
use modiolus::face::{Face, Pose, standard};
use modiolus::forward::contact_forces;
use modiolus::forward::{Model, Response};
use modiolus::inverse::{ContactMode, Goal, Marker, Observations, Place, Prior, Problem, Target};
use modiolus::io::read_face;
use modiolus::mesh::{Locator, Site};
use modiolus::report::{Recovered, recovery_plot};
use modiolus::study::{Mechanics, Mover, Stiffness, Strain, fit};
use modiolus::units::Vec3;
use nalgebra::DVector;
use rand_xoshiro::Xoshiro256PlusPlus;
use rand_xoshiro::rand_core::{RngCore, SeedableRng};

/// A face and what its muscles do to the markers.
struct Subject {
    face: Face,
    muscles: Vec<String>,
    sites: Vec<Site>,
    response: Response,
}

impl Subject {
    fn new(face: &Face, points: &[Vec3], contact: bool) -> Self {
        let locator = Locator::new(&face.mesh);
        let sites: Vec<Site> = points.iter().map(|p| locator.locate(*p).unwrap().site).collect();
        let pairs = match contact {
            true => ContactSearch::new(face, ContactReach::default()).rest().to_vec(),
            false => Vec::new(),
        };
        let model = Model::new(face, pairs).unwrap();
        let fixed = model.at(&vec![0.5; face.muscles.len()]).unwrap();
        let muscles = face.muscles.iter().map(|m| m.name.clone()).collect();
        let response = fixed.response(&sites);
        Self { face: face.clone(), muscles, sites, response }
    }
}

/// `count` points of the skin about the mouth, each as far from the others as can be.
fn markers(face: &Face, count: usize) -> Vec<Vec3> {
    let near = |p: &Vec3| p.x.abs() < 50. && p.y > -45. && p.y < 40. && p.z > -60.;
    let skin: Vec<Vec3> = face.skin.iter().map(|&n| face.mesh.points[n]).filter(near).collect();
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

/// How far the columns of one face are from those of another.
struct Off {
    strength: f64,
    shape: f64,
    /// Correlation of the errors of two points by their distance, in steps of 5 mm.
    near: Vec<Option<f64>>,
}

fn off(here: &Subject, other: &Subject) -> Off {
    let points: Vec<Vec3> = here.sites.iter().map(|s| s.position).collect();
    let (mut strengths, mut shapes) = (Vec::new(), Vec::new());
    let mut near = [(0., 0usize); 8];
    for (k, name) in here.muscles.iter().enumerate() {
        let Some(j) = other.muscles.iter().position(|n| n == name) else { continue };
        let (f, g) = (here.response.map.column(k), other.response.map.column(j));
        let s = f.dot(&g) / f.norm_squared() - 1.;
        let e = g - f * (1. + s);
        strengths.push(s);
        shapes.push(e.norm() / f.norm());
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
    let near = near.iter().map(|(s, n)| (*n > 0).then(|| s / *n as f64)).collect();
    Off { strength: rms(&strengths), shape: rms(&shapes), near }
}

/// One recovery: who fits, who was seen, and how.
#[derive(Clone, Copy)]
struct Case<'a> {
    title: &'a str,
    here: &'a Subject,
    truth: &'a Subject,
    markers: usize,
    noise_mm: f64,
    discrepancy: Discrepancy,
    /// Standard deviation of an observed activation of every muscle.
    prior: Option<f64>,
    trials: usize,
    /// How strain is measured where it is fitted, and where it was seen.
    strain: [Strain; 2],
}

/// What was found, and how many of the fits were solved.
#[derive(Default)]
struct Found {
    recovered: Vec<Recovered>,
    solved: usize,
}

const FINITE: Mechanics =
    Mechanics { strain: Strain::Finite, stiffness: Stiffness::Activated, contact: true };

/// The displacements (d) of the points of `truth` under the activations `a`, mm.
fn shown(truth: &Subject, strain: Strain, a: &DVector<f64>) -> DVector<f64> {
    if strain == Strain::Finite {
        let mover = Mover::new(&truth.face, FINITE).unwrap();
        let u = mover.settle(a.as_slice(), &Pose::rest()).unwrap().displacement;
        let seen = truth.sites.iter().flat_map(|site| <[f64; 3]>::from(site.displacement(&u)));
        return DVector::from_iterator(3 * truth.sites.len(), seen);
    }
    let mut seen = &truth.response.map * a + &truth.response.offset;
    if let Some(contact) = &truth.response.contact {
        seen += &contact.reach * contact_forces(contact, a).unwrap();
    }
    seen
}

/// Ten muscles of `truth`, drawn at random, act at random; what the markers show of it is fitted on `here`.
fn recover(case: &Case<'_>) -> Found {
    let Case { here, truth, noise_mm, .. } = *case;
    let mut random = Random(Xoshiro256PlusPlus::seed_from_u64(7));
    let m = truth.muscles.len();
    let mut found = Found::default();
    for _ in 0..case.trials {
        let mut a = DVector::zeros(m);
        for _ in 0..10 {
            a[(random.unit() * m as f64) as usize] = random.unit();
        }
        let seen = shown(truth, case.strain[1], &a);
        let seen = seen.map(|v| v + noise_mm * random.normal());
        let true_of = |name: &String| truth.muscles.iter().position(|n| n == name).map_or(0., |k| a[k]);
        let markers = here.sites.iter().take(case.markers).enumerate().map(|(k, site)| Marker {
            name: format!("m{k}"),
            at: Place::Point(site.position),
            goal: Goal::Displacement([0, 1, 2].map(|axis| Some(seen[3 * k + axis]))),
            sigma_mm: noise_mm,
        });
        let priors: Vec<Prior> = case.prior.map_or_else(Vec::new, |sigma| {
            let of = |name: &String| Prior {
                muscle: name.clone(),
                activation: (true_of(name) + sigma * random.normal()).clamp(0., 1.),
                sigma,
            };
            here.muscles.iter().map(of).collect()
        });
        let target = Target {
            name: "recovery".into(),
            markers: markers.collect(),
            priors,
            effort: 1e-3,
            ..Target::default()
        };
        let observations = Observations {
            sites: here.sites.clone(),
            markers: (0..case.markers).collect(),
            ..Observations::default()
        };
        let solution = if case.strain[0] == Strain::Finite {
            let solved = fit(&here.face, &target, &observations, FINITE, ContactMode::Reactions, |_, _| {});
            solved.unwrap().solution
        } else {
            let mode =
                if here.response.contact.is_some() { ContactMode::Reactions } else { ContactMode::Off };
            Problem::new(&target, &observations, &here.response).unwrap().solve(mode).unwrap()
        };
        found.solved += usize::from(solution.status.is_optimum());
        let Some(program) = &solution.program else { continue };
        for unknown in Certainty::of(program, case.discrepancy).unwrap().unknowns {
            let truth = true_of(&unknown.name);
            found.recovered.push(Recovered {
                truth,
                value: unknown.value,
                min: unknown.min,
                max: unknown.max,
            });
        }
    }
    found
}

/// The row of a case: coverage of all intervals and of those of muscles that act, their mean width, the error.
fn row(case: &Case<'_>, found: &[Recovered]) -> String {
    let share = |of: &dyn Fn(&&Recovered) -> bool| {
        let chosen: Vec<&Recovered> = found.iter().filter(of).collect();
        100. * chosen.iter().filter(|h| h.holds()).count() as f64 / chosen.len() as f64
    };
    let count = found.len() as f64;
    let rmse = (found.iter().map(|h| (h.value - h.truth).powi(2)).sum::<f64>() / count).sqrt();
    let worst = found.iter().map(|h| (h.value - h.truth).abs()).fold(0., f64::max);
    let width = found.iter().map(|h| h.max - h.min).sum::<f64>() / count;
    format!(
        "| {} | {} | {} | {:.1} | {:.1} | {:.2} | {rmse:.3} | {worst:.2} |\n",
        case.title,
        case.markers,
        case.noise_mm,
        share(&|_| true),
        share(&|h| h.truth > 0.),
        width
    )
}

/// Trials at finite strain, of which each takes minutes.
const FEW: usize = 5;

const INTRODUCTION: &str = "# Activations recovered

Ten activations of all muscles, drawn at random, are shown on points of the skin with noise, by another mesh or by another
anatomist's muscles than those that recover them; `certainty` gives the interval of each. Written by
`cargo run --release --example recovery`; the linear model at one stiffness in 20 trials, with contact in 8, and finite strain with
contact in 5. Coverage is the share of intervals that hold the truth, of all muscles and of those that act; 95 is wished for. An
error of the same mesh proves nothing about accuracy and stands here for the intervals alone.

";

fn main() {
    let faces = [Resolution::COARSE, Resolution::STANDARD].map(|r| standard(&r));
    let points = markers(&faces[1], 40);
    let [coarse, usual] = faces.each_ref().map(|face| Subject::new(face, &points, false));
    let touching = faces.each_ref().map(|face| Subject::new(face, &points, true));
    let bones = [badin(false), badin(true)];
    let own_points = markers(&bones[0], 40);
    let [own, other] = bones.each_ref().map(|face| Subject::new(face, &own_points, false));
    let mut text = INTRODUCTION.to_owned();
    text += "## How far models are apart\n\n\
             | from | to | strength of a muscle, rms | movement from point to point, rms | correlation of errors at 10-15, 15-20, 20-25, 25-30 mm |\n\
             |---|---|---|---|---|\n";
    let pairs = [
        ("standard", &usual, "coarse", &coarse),
        ("coarse", &coarse, "standard", &usual),
        ("badin", &own, "badin, other muscles", &other),
        ("badin, other muscles", &other, "badin", &own),
    ];
    for (a, here, b, there) in pairs {
        let Off { strength, shape, near } = off(here, there);
        let near: Vec<String> =
            near[2..6].iter().map(|c| c.map_or_else(|| "-".to_owned(), |c| format!("{c:.2}"))).collect();
        text += &format!("| {a} | {b} | {strength:.3} | {shape:.3} | {} |\n", near.join(", "));
    }
    text += "\n## Recovery\n\n| face that fits <- face that was seen | markers | noise, mm | coverage, % | of those that act, % | mean width | RMSE | worst |\n\
             |---|---|---|---|---|---|---|---|\n";
    let case = |title, here, truth, discrepancy| Case {
        title,
        here,
        truth,
        markers: 40,
        noise_mm: 0.1,
        discrepancy,
        prior: None,
        trials: 20,
        strain: [Strain::Linear; 2],
    };
    let mesh = case("coarse <- standard", &coarse, &usual, Discrepancy::MESH);
    let mut cases = vec![
        case("standard <- standard (same mesh)", &usual, &usual, Discrepancy::NONE),
        case("standard <- coarse, no discrepancy", &usual, &coarse, Discrepancy::NONE),
        case("standard <- coarse", &usual, &coarse, Discrepancy::MESH),
    ];
    for markers in [10, 20, 40] {
        cases.extend([0.1, 0.5, 1.].map(|noise_mm| Case { markers, noise_mm, ..mesh }));
    }
    for noise_mm in [0.1, 0.5] {
        let title = "coarse <- standard, each activation observed to 0.1";
        cases.push(Case { title, noise_mm, markers: 20, prior: Some(0.1), ..mesh });
    }
    cases.push(Case {
        trials: 8,
        ..case("coarse <- standard, with contact", &touching[0], &touching[1], Discrepancy::MESH)
    });
    for noise_mm in [0.1, 0.5] {
        cases.push(Case { noise_mm, ..case("badin <- other muscles", &own, &other, Discrepancy::ANATOMY) });
        cases.push(Case { noise_mm, ..case("other muscles <- badin", &other, &own, Discrepancy::ANATOMY) });
    }
    let finite = |title, prior, strain| {
        let case = case(title, &touching[0], &touching[1], Discrepancy::MESH);
        Case { prior, trials: FEW, strain, ..case }
    };
    cases.push(finite("coarse <- standard, both at finite strain", None, [Strain::Finite; 2]));
    cases.push(finite(
        "coarse <- standard, both at finite strain, each activation observed to 0.1",
        Some(0.1),
        [Strain::Finite; 2],
    ));
    let strains = [Strain::Linear, Strain::Finite];
    cases.push(finite("coarse, linear <- standard, finite strain", None, strains));
    let title = "badin <- other muscles, each activation observed to 0.1";
    cases.push(Case { prior: Some(0.1), ..case(title, &own, &other, Discrepancy::ANATOMY) });
    let figures = Path::new(env!("CARGO_MANIFEST_DIR")).join("docs/figures");
    let (mut fits, mut settled) = (0, 0);
    for case in &cases {
        let Found { recovered: found, solved } = recover(case);
        if case.strain[0] == Strain::Finite {
            fits += case.trials;
            settled += solved;
        }
        let row = row(case, &found);
        print!("{row}");
        text += &row;
        let name = match case.title {
            "coarse <- standard" if case.markers == 40 && case.noise_mm == 0.1 => "recovery_mesh.svg",
            "badin <- other muscles" if case.noise_mm == 0.1 => "recovery_anatomy.svg",
            _ => continue,
        };
        std::fs::write(figures.join(name), recovery_plot(case.title, &found)).unwrap();
    }
    text += &format!(
        "\n{settled} of {fits} fits at finite strain were solved; the others are counted as they ended.\n"
    );
    text += "\n![Intervals against the truth, another mesh](figures/recovery_mesh.svg)\n\n\
             ![Intervals against the truth, another anatomist's muscles](figures/recovery_anatomy.svg)\n";
    std::fs::write(Path::new(env!("CARGO_MANIFEST_DIR")).join("docs/recovery.md"), text).unwrap();
}
