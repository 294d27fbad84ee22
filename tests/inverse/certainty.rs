//! What the data determine: intervals, posterior and sides against closed forms, other samplers and other meshes.
#![allow(clippy::unwrap_used, reason = "a test that cannot go on should say where")]

use std::path::{Path, PathBuf};

use crate::common::Random;
use crate::common::block_face::pulled_block;
use crate::common::faces::{Body, observations, target};
use modiolus::calibration::{
    Calibration, CalibrationError, Expression, HeldContact, Knowledge, LogNormal, Parameters, Sensitivity,
    StatedPrior,
};
use modiolus::certainty::{Certainty, Determination, Discrepancy, SeenPoints};
use modiolus::face::standard::Resolution;
use modiolus::face::{ContactReach, ContactSearch, Face, Pose, Symmetry, standard};
use modiolus::forward::{Model, Response, ScaledModel};
use modiolus::inverse::{
    ActivationBounds, Bound, ContactMode, EffortMeasure, Goal, LimitKind, Loss, Marker, MuscleCost,
    Observations, Place, Prior, Problem, Solution, Status, Target, Warning,
};
use modiolus::io::read_face;
use modiolus::mesh::{CellKind, Locator, Site};
use modiolus::study::{Mechanics, Mover, Stiffness, Strain, calibrate};
use modiolus::units::Vec3;
use nalgebra::{DMatrix, DVector};

fn solved(target: &Target, observations: &Observations, response: &Response, mode: ContactMode) -> Solution {
    Problem::new(target, observations, response).unwrap().solve(mode).unwrap()
}

fn certainty(solution: &Solution, discrepancy: Discrepancy) -> Certainty {
    Certainty::of(solution.program.as_ref().unwrap(), discrepancy).unwrap()
}

/// A response of one marker, whose columns are the rows of `columns`.
fn one_marker(columns: &[[f64; 3]]) -> (Response, Observations) {
    let mut random = Random(1);
    let map = DMatrix::from_fn(3, columns.len(), |i, j| columns[j][i]);
    let response = Response {
        muscles: (0..columns.len()).map(|k| format!("muscle_{k}")).collect(),
        jaw: None,
        offset: DVector::zeros(3),
        map,
        contact: None,
    };
    (response, observations(&mut random, 1))
}

#[test]
fn one_muscle_has_the_interval_of_its_noise() {
    let (response, observed) = one_marker(&[[10., 0., 0.]]);
    let seen = target(&DVector::from_vec(vec![4., 0., 0.]), 0.5);
    let found = certainty(&solved(&seen, &observed, &response, ContactMode::Off), Discrepancy::NONE);
    let muscle = &found.unknowns[0];
    let half = 1.959_963_985 * 0.5 / 10.;
    assert!(
        (muscle.min - (0.4 - half)).abs() < 1e-6 && (muscle.max - (0.4 + half)).abs() < 1e-6,
        "{muscle:?}"
    );
    assert!((muscle.sd - 0.05).abs() < 2e-3 && (muscle.mean - 0.4).abs() < 3e-3, "{muscle:?}");
    assert_eq!(muscle.to_string(), "determined: 40 % (30 to 50)");
    // A strength that is known to 20 per cent: the variance of 0.4 x 10 mm x 0.2 beside that of the noise.
    let strength = Discrepancy { strength: 0.2, ..Discrepancy::NONE };
    let found = certainty(&solved(&seen, &observed, &response, ContactMode::Off), strength);
    let sd = found.unknowns[0].sd;
    let expected = (0.05f64.powi(2) + (0.4f64.powi(2) + sd * sd) * 0.04).sqrt();
    assert!((sd / expected - 1.).abs() < 0.05, "{sd} {expected}");
}

/// Two markers of one component each want 2 and 6 mm of a muscle that moves both alike: residuals of 2 mm at sigma 0.5 have
/// a misfit of 32 with one degree of freedom, so that the noise is raised by its root.
#[test]
fn residuals_that_noise_does_not_explain_raise_it() {
    let mut random = Random(2);
    let response = Response {
        muscles: vec!["muscle".into()],
        jaw: None,
        map: DMatrix::from_column_slice(6, 1, &[10., 0., 0., 10., 0., 0.]),
        offset: DVector::zeros(6),
        contact: None,
    };
    let mut seen = target(&DVector::zeros(6), 0.5);
    for (marker, x) in seen.markers.iter_mut().zip([2., 6.]) {
        marker.goal = Goal::Displacement([Some(x), None, None]);
    }
    let found = certainty(
        &solved(&seen, &observations(&mut random, 2), &response, ContactMode::Off),
        Discrepancy::NONE,
    );
    assert!((found.noise_factor - 32f64.sqrt()).abs() < 1e-6, "{}", found.noise_factor);
    let half = 1.959_963_985 * 0.5 * 32f64.sqrt() / (200f64).sqrt();
    assert!((found.unknowns[0].max - (0.4 + half)).abs() < 1e-5, "{:?}", found.unknowns[0]);
}

/// One marker of one component: what a cap would gain is the slope of the residual by the cap, whatever the effort is.
/// A point that one muscle moves by 2 mm, seen 0.1 mm farther along than an activation of one half puts it, and `across` beside that.
fn seen_point(across: f64) -> SeenPoints {
    SeenPoints {
        points_mm: vec![Vec3::zeros()],
        map: DMatrix::from_column_slice(3, 1, &[2., 0., 0.]),
        n_muscles: 1,
        residual_mm: DVector::from_vec(vec![0.1, across, 0.]),
        weights: DVector::from_element(3, 10.),
        x: DVector::from_element(1, 0.5),
        bounds: ActivationBounds { min: DVector::zeros(1), max: DVector::from_element(1, 1.) },
    }
}

#[test]
fn seen_points_have_the_interval_of_their_noise_about_what_fits_best() {
    // 0.1 mm of 2 mm a unit, at 95 per cent.
    let half = 1.959_964 * 0.1 / 2.;
    let found = seen_point(0.).intervals(&Discrepancy::NONE).expect("an interval");
    assert!((found.min[0] - (0.55 - half)).abs() < 1e-5, "{found:?}");
    assert!((found.max[0] - (0.55 + half)).abs() < 1e-5, "{found:?}");
    assert!((found.noise_factor - 1.).abs() < 1e-9, "{found:?}");
    // Six standard deviations across leave 36 over two degrees of freedom.
    let found = seen_point(0.6).intervals(&Discrepancy::NONE).expect("an interval");
    assert!((found.noise_factor.powi(2) - 18.).abs() < 1e-6, "{found:?}");
    assert!((found.max[0] - (0.55 + 18_f64.sqrt() * half)).abs() < 1e-5, "{found:?}");
    // Where the muscle itself may be off, more is allowed.
    let off = Discrepancy { strength: 0.2, shape: 0., length_mm: 10. };
    let wider = seen_point(0.).intervals(&off).expect("an interval");
    assert!(wider.max[0] - wider.min[0] > 2.2 * half, "{wider:?}");
}

#[test]
fn the_gain_of_a_cap_is_the_slope_of_the_residual() {
    let (response, observed) = one_marker(&[[10., 0., 0.]]);
    let mut seen = target(&DVector::from_vec(vec![8., 0., 0.]), 0.5);
    seen.markers[0].goal = Goal::Displacement([Some(8.), None, None]);
    seen.effort = 40.;
    let capped = |max: f64| {
        let bounds = vec![Bound { muscle: "muscle_0".into(), min: 0., max }];
        solved(&Target { bounds, ..seen.clone() }, &observed, &response, ContactMode::Off)
    };
    let solution = capped(0.3);
    let cap = &solution.active_limits[0];
    assert_eq!((cap.kind, cap.name.as_str()), (LimitKind::Cap, "muscle_0 <= 0.3"));
    // The effort takes its part of the multiplier: (10 x 5 / 0.25 - 40 x 0.3), by sigma^2 / residual.
    let expected = (10. * 5. / 0.25 - 40. * 0.3) * 0.25 / 5.;
    assert!((cap.gain_mm.unwrap() - expected).abs() < 1e-6, "{cap:?}");
    assert!((solution.explained.unwrap() - (1. - 25. / 64.)).abs() < 1e-9);
    // A muscle that would have to push is told apart.
    seen.markers[0].goal = Goal::Displacement([Some(-8.), None, None]);
    let pushed = solved(&seen, &observed, &response, ContactMode::Off);
    assert_eq!(pushed.active_limits[0].kind, LimitKind::AtRest);
    let unreachable = |w: &Warning| matches!(w, Warning::Unreachable { limits, .. } if limits.is_empty());
    assert!(pushed.warnings.iter().any(unreachable), "{:?}", pushed.warnings);
}

#[test]
fn muscles_that_pull_alike_trade_against_each_other() {
    let (response, observed) = one_marker(&[[10., 0., 0.], [10., 0., 0.], [0., 8., 0.], [0., 0., 0.]]);
    let mut seen = target(&DVector::from_vec(vec![5., 4., 0.]), 0.1);
    seen.effort = 1e-6;
    let found = certainty(&solved(&seen, &observed, &response, ContactMode::Off), Discrepancy::NONE);
    let [first, second, third, fourth] = &found.unknowns[..] else { unreachable!() };
    assert_eq!(
        (first.trades.as_slice(), first.determination),
        (&["muscle_1".to_owned()][..], Determination::Undetermined)
    );
    assert!(first.min < 1e-3 && (first.max - 0.5).abs() < 0.03 && second.max > 0.49, "{first:?} {second:?}");
    assert_eq!(
        (third.determination, fourth.determination),
        (Determination::Determined, Determination::Unseen)
    );
    assert!(third.resolution > 0.99 && fourth.resolution < 0.05, "{third:?} {fourth:?}");
    assert!(found.correlations[(0, 1)] < -0.98, "{}", found.correlations);
    assert_eq!(found.groups, [["muscle_0", "muscle_1"]]);
    assert!(found.condition.is_infinite());
    // Tied they are one, and determined; a fixed one is held.
    seen.tied = vec![["muscle_0".into(), "muscle_1".into()]];
    seen.bounds = vec![Bound { muscle: "muscle_3".into(), min: 0.2, max: 0.2 }];
    let found = certainty(&solved(&seen, &observed, &response, ContactMode::Off), Discrepancy::NONE);
    assert_eq!(found.unknowns[0].determination, Determination::Determined);
    assert!((found.unknowns[1].value - 0.25).abs() < 1e-3 && found.unknowns[1].trades.is_empty());
    assert_eq!(found.unknowns[3].to_string(), "held at 20 %");
}

#[test]
fn where_every_muscle_is_held_there_is_nothing_to_determine() {
    let (response, observed) = one_marker(&[[10., 0., 0.], [0., 8., 0.]]);
    let mut seen = target(&DVector::from_vec(vec![5., 4., 0.]), 0.5);
    let held = |k: usize| Bound { muscle: format!("muscle_{k}"), min: 0.5, max: 0.5 };
    seen.bounds = vec![held(0), held(1)];
    let found = certainty(&solved(&seen, &observed, &response, ContactMode::Off), Discrepancy::ANATOMY);
    assert!(
        found.unknowns.iter().all(|u| u.determination == Determination::Held && u.min == 0.5 && u.max == 0.5)
    );
    assert!(found.effort.is_none() && found.condition == 1.);
}

/// Gibbs sampling of the normal distribution with precision `h` and mean `mean`, truncated to [0, 1]: an algorithm that has
/// nothing in common with the one under test.
fn gibbs(
    random: &mut Random,
    h: &DMatrix<f64>,
    mean: &DVector<f64>,
    samples: usize,
) -> (DVector<f64>, DMatrix<f64>) {
    let n = mean.len();
    let mut x = DVector::from_element(n, 0.5);
    let (mut sum, mut squares) = (DVector::zeros(n), DMatrix::zeros(n, n));
    for step in 0..samples + 1000 {
        for k in 0..n {
            let off: f64 = (0..n).filter(|&j| j != k).map(|j| h[(k, j)] * (x[j] - mean[j])).sum();
            let (centre, sd) = (mean[k] - off / h[(k, k)], h[(k, k)].sqrt().recip());
            // Of a density on [0, 1] by its own sum on a fine grid.
            let density = |v: f64| (-0.5 * ((v - centre) / sd).powi(2)).exp();
            let peak = centre.clamp(0., 1.);
            x[k] = loop {
                let reach = 8. * sd;
                let (lo, hi) = ((peak - reach).max(0.), (peak + reach).min(1.));
                let v = random.within(lo, hi);
                if random.unit() * density(peak) <= density(v) {
                    break v;
                }
            };
        }
        if step >= 1000 {
            sum += &x;
            squares += &x * x.transpose();
        }
    }
    let mean = sum / samples as f64;
    let covariance = squares / samples as f64 - &mean * mean.transpose();
    (mean, covariance)
}

#[test]
fn the_posterior_is_that_of_another_sampler() {
    let mut random = Random(11);
    let (m, points) = (5, 4);
    let body = Body::random(&mut random, 20, m, points, 0);
    let response = body.response();
    let observed = observations(&mut random, points);
    let truth = DVector::from_vec(vec![0.9, 0.02, 0.5, 0.1, 0.4]);
    let sigma = 0.5;
    let d = &response.map * truth + random.vector(3 * points) * sigma;
    let solution = solved(&target(&d, sigma), &observed, &response, ContactMode::Off);
    let found = certainty(&solution, Discrepancy::NONE);
    let scale = (sigma * found.noise_factor).powi(2);
    let h = response.map.tr_mul(&response.map) / scale;
    let mean = h.clone().lu().solve(&(response.map.tr_mul(&d) / scale)).unwrap();
    let (mean, covariance) = gibbs(&mut random, &h, &mean, 60_000);
    for k in 0..m {
        let (unknown, sd) = (&found.unknowns[k], covariance[(k, k)].sqrt());
        assert!((unknown.mean - mean[k]).abs() < 0.08 * sd + 2e-3, "{k}: {} {}", unknown.mean, mean[k]);
        assert!((unknown.sd / sd - 1.).abs() < 0.06, "{k}: {} {sd}", unknown.sd);
        for j in 0..k {
            let correlation = covariance[(j, k)] / (sd * covariance[(j, j)].sqrt());
            assert!((found.correlations[(j, k)] - correlation).abs() < 0.06, "{j} {k}");
        }
    }
}

#[test]
fn the_ends_of_an_interval_are_reached_and_no_sample_lies_beyond() {
    let mut random = Random(5);
    let (m, points) = (4, 3);
    let response = Body::random(&mut random, 16, m, points, 0).response();
    let observed = observations(&mut random, points);
    let truth = DVector::from_fn(m, |_, _| random.unit());
    let d = &response.map * truth + random.vector(3 * points) * 0.3;
    let found =
        certainty(&solved(&target(&d, 0.3), &observed, &response, ContactMode::Off), Discrepancy::NONE);
    let misfit =
        |a: &DVector<f64>| (&response.map * a - &d).norm_squared() / (0.3 * found.noise_factor).powi(2);
    // All of a grid whose misfit is allowed.
    let grid = 24;
    let points: Vec<DVector<f64>> = (0..(grid + 1usize).pow(4))
        .map(|k| {
            DVector::from_fn(4, |i, _| (k / (grid + 1usize).pow(i as u32) % (grid + 1)) as f64 / grid as f64)
        })
        .collect();
    let least = points.iter().map(&misfit).fold(f64::INFINITY, f64::min);
    let allowed: Vec<&DVector<f64>> = points.iter().filter(|a| misfit(a) <= least + 3.841_459).collect();
    for (k, unknown) in found.unknowns.iter().enumerate() {
        let lo = allowed.iter().map(|a| a[k]).fold(1., f64::min);
        let hi = allowed.iter().map(|a| a[k]).fold(0., f64::max);
        let cell = 1. / grid as f64;
        assert!(
            (unknown.min - lo).abs() < 1.5 * cell && (unknown.max - hi).abs() < 1.5 * cell,
            "{unknown:?} {lo} {hi}"
        );
    }
}

/// What a face's muscles do to markers on its skin, without contact.
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
        Self { muscles, response: fixed.response(&sites), sites }
    }
}

/// `count` points of the skin about the mouth, each as far from the others as can be.
fn markers(face: &Face, count: usize) -> Vec<Vec3> {
    let near = |p: &Vec3| p.x.abs() < 50. && p.y > -45. && p.y < 40. && p.z > -60.;
    let skin: Vec<Vec3> = face.skin.iter().map(|&n| face.mesh.points[n]).filter(near).collect();
    let mut chosen = vec![face.landmark("cheilion_l").unwrap().site.position];
    while chosen.len() < count {
        let apart = |p: &Vec3| chosen.iter().map(|q| (p - q).norm()).fold(f64::INFINITY, f64::min);
        chosen.push(*skin.iter().max_by(|a, b| apart(a).total_cmp(&apart(b))).unwrap());
    }
    chosen
}

/// Of activations of `truth` seen with `noise_mm` and recovered on `here`: intervals of muscles that act which hold the
/// truth, their number, the largest error and the root mean square one.
struct Recovered {
    held: usize,
    acting: usize,
    rmse: f64,
}

impl Recovered {
    fn coverage(&self) -> f64 {
        self.held as f64 / self.acting as f64
    }
}

fn recover(
    here: &Subject,
    truth: &Subject,
    noise_mm: f64,
    discrepancy: Discrepancy,
    only: Option<&[&str]>,
) -> Recovered {
    let mut random = Random(7);
    let mut found = Recovered { held: 0, acting: 0, rmse: 0. };
    let (m, mut squares, mut count) = (truth.muscles.len(), 0., 0);
    for _ in 0..40 {
        let mut a = DVector::zeros(m);
        for k in 0..10 {
            let muscle = match only {
                Some(names) => truth.muscles.iter().position(|n| n == names[k % names.len()]).unwrap(),
                None => random.below(m),
            };
            a[muscle] = random.unit();
        }
        let d = &truth.response.map * &a + random.vector(3 * here.sites.len()) * noise_mm;
        let marker = |(k, site): (usize, &Site)| Marker {
            name: format!("marker_{k}"),
            at: Place::Point(site.position),
            goal: Goal::Displacement([0, 1, 2].map(|axis| Some(d[3 * k + axis]))),
            sigma_mm: noise_mm,
        };
        let still = |name: &String| Bound { muscle: name.clone(), min: 0., max: 0. };
        let seen = Target {
            markers: here.sites.iter().enumerate().map(marker).collect(),
            bounds: only.map_or_else(Vec::new, |names| {
                here.muscles.iter().filter(|m| !names.contains(&m.as_str())).map(still).collect()
            }),
            effort: 1e-3,
            ..Target::default()
        };
        let observed = Observations {
            sites: here.sites.clone(),
            markers: (0..here.sites.len()).collect(),
            ..Observations::default()
        };
        let solution = solved(&seen, &observed, &here.response, ContactMode::Off);
        for unknown in certainty(&solution, discrepancy).unknowns {
            let truth = truth.muscles.iter().position(|n| *n == unknown.name).map_or(0., |k| a[k]);
            if unknown.determination != Determination::Held {
                squares += (unknown.value - truth).powi(2);
                count += 1;
            }
            if truth > 0. {
                found.acting += 1;
                found.held += usize::from(unknown.min <= truth && truth <= unknown.max);
            }
        }
    }
    found.rmse = (squares / f64::from(count)).sqrt();
    found
}

/// VERIFICATION 25 and 26: activations of muscles that act, of ten of 28 drawn at random, on 40 markers.
#[test]
fn intervals_hold_the_truth_on_the_same_and_on_another_mesh() {
    let [coarse, usual] = [Resolution::COARSE, Resolution::STANDARD].map(|r| standard(&r));
    let points = markers(&usual, 40);
    let [coarse, usual] = [coarse, usual].map(|face| Subject::new(&face, &points));
    let same = recover(&usual, &usual, 0.1, Discrepancy::NONE, None).coverage();
    assert!((0.93..=0.97).contains(&same), "same mesh: {same:.3}");
    for (noise_mm, limits) in [(0.1, 0.90..=0.985), (0.5, 0.90..=0.985)] {
        let [there, back] = [(&usual, &coarse), (&coarse, &usual)]
            .map(|(here, truth)| recover(here, truth, noise_mm, Discrepancy::MESH, None).coverage());
        assert!(limits.contains(&there) && limits.contains(&back), "{noise_mm} mm: {there:.3} {back:.3}");
    }
    // Without a discrepancy the intervals are too narrow: this is what it is for.
    let bare = recover(&usual, &coarse, 0.1, Discrepancy::NONE, None).coverage();
    assert!(bare < 0.90, "without: {bare:.3}");
    let eight = [
        "zygomaticus_major_l",
        "zygomaticus_major_r",
        "levator_labii_superioris_l",
        "levator_labii_superioris_r",
        "depressor_anguli_oris_l",
        "depressor_anguli_oris_r",
        "orbicularis_oris_peripheralis",
        "mentalis_l",
    ];
    let honest = recover(&coarse, &usual, 0.1, Discrepancy::MESH, Some(&eight)).rmse;
    println!("same {same:.3}, without {bare:.3}, eight muscles {honest:.4}");
    assert!(honest <= 0.03, "eight muscles from another mesh: {honest:.4}");
}

/// VERIFICATION 26 with another anatomist's muscles on the same face.
#[test]
#[ignore = "needs MODIOLUS_DATA"]
fn intervals_hold_the_truth_of_another_set_of_muscles() {
    let data = std::env::var_os("MODIOLUS_DATA").expect("MODIOLUS_DATA names the folder of the real data");
    let root = Path::new(env!("CARGO_MANIFEST_DIR"));
    let base = root.join(PathBuf::from(data)).join("badin_face");
    let folder = tempfile::tempdir().unwrap();
    let read = |name: &str, text: &str| {
        let file = folder.path().join(name);
        std::fs::write(&file, text).unwrap();
        read_face(&file, Some(&base)).unwrap_or_else(|e| panic!("{e}")).face
    };
    let text = std::fs::read_to_string(root.join("examples/badin/face.toml")).unwrap();
    let own = read("own.toml", &text);
    // The other set lacks one muscle, and its paths leave the mesh by more.
    let other =
        text.replace("fibres = \"fibres.csv\"", "fibres = \"fibres_original.csv\"\nmax_projection_mm = 20.0");
    let start = other.find("[[muscles]]\nname = \"levator_labii_superioris\"\n").unwrap();
    let end = start + 1 + other[start + 1..].find("[[muscles]]").unwrap();
    let other = read("other.toml", &format!("{}{}", &other[..start], &other[end..]));
    let points = markers(&own, 40);
    let [own, other] = [own, other].map(|face| Subject::new(&face, &points));
    for noise_mm in [0.1, 0.5] {
        for (here, truth) in [(&own, &other), (&other, &own)] {
            let coverage = recover(here, truth, noise_mm, Discrepancy::ANATOMY, None).coverage();
            assert!((0.85..=0.985).contains(&coverage), "{noise_mm} mm: {coverage:.3}");
        }
    }
}

/// The rules for the effort on a problem whose noise is known: misfit and effort go against each other, the misfit at the
/// weight that the noise chooses is the number of components, and no neighbour has less cross-validation.
#[test]
fn the_weight_of_the_effort_follows_the_noise() {
    let mut random = Random(23);
    let (m, points) = (8, 6);
    let response = Body::random(&mut random, 24, m, points, 0).response();
    let observed = observations(&mut random, points);
    let truth = DVector::from_fn(m, |_, _| 0.2 + 0.6 * random.unit());
    let d = &response.map * truth + random.vector(3 * points) * 0.2;
    let weighed = |effort: f64| {
        let seen = Target { effort, ..target(&d, 0.2) };
        let solution = solved(&seen, &observed, &response, ContactMode::Off);
        let misfit = solution.markers.iter().map(|f| f.residual_mm.unwrap().powi(2)).sum::<f64>() / 0.04;
        (misfit, certainty(&solution, Discrepancy::NONE).effort.unwrap())
    };
    let (_, choice) = weighed(0.1);
    for pair in choice.curve.windows(2) {
        assert!(
            pair[1].misfit >= pair[0].misfit - 1e-9 && pair[1].effort <= pair[0].effort + 1e-9,
            "{pair:?}"
        );
    }
    // The target's own solver at the weights that were chosen on the tangent.
    let (misfit, _) = weighed(choice.discrepancy.unwrap());
    assert!((misfit / (3 * points) as f64 - 1.).abs() < 0.01, "{misfit}");
    let least = choice.curve.iter().map(|p| p.cross_validation).fold(f64::INFINITY, f64::min);
    let nearest = choice.curve.iter().find(|p| p.cross_validation == least).unwrap();
    assert!((choice.cross_validation / nearest.weight).log10().abs() <= 0.25, "{}", choice.cross_validation);
}

/// Two muscles pull alike; the first costs four times as much and so does a fifth of the work: `a_1 c_1 = a_2 c_2`.
#[test]
fn the_effort_of_muscles_that_cost_more_is_less() {
    let (response, mut observed) = one_marker(&[[10., 0., 0.], [10., 0., 0.]]);
    let mut seen = target(&DVector::from_vec(vec![5., 0., 0.]), 0.001);
    seen.effort = 1.;
    let shared = |seen: &Target, observed: &Observations| {
        let a = solved(seen, observed, &response, ContactMode::Off).activations.values;
        (a[0] / a[1], a[0] + a[1])
    };
    let (ratio, sum) = shared(&seen, &observed);
    assert!((ratio - 1.).abs() < 1e-6 && (sum - 0.5).abs() < 1e-6);
    observed.cost = vec![1.6, 0.4];
    let (ratio, sum) = shared(&seen, &observed);
    assert!((ratio - 0.25).abs() < 1e-6 && (sum - 0.5).abs() < 1e-6, "{ratio}");
    seen.costs = vec![MuscleCost { muscle: "muscle_1".into(), factor: 2. }];
    assert!((shared(&seen, &observed).0 - 0.5).abs() < 1e-6);
}

/// Of the standard face: what a muscle costs by force and by volume, relative to the mean.
#[test]
fn costs_are_those_of_the_muscles() {
    let face = standard(&Resolution::COARSE);
    let cost = |effort_by| {
        let target = Target { effort: 1., effort_by, ..Target::default() };
        Observations::resolve(&target, &face, |_| Err(0.)).unwrap().cost
    };
    let (force, volume) = (cost(EffortMeasure::Force), cost(EffortMeasure::Volume));
    assert!(cost(EffortMeasure::Activation).is_empty());
    for costs in [&force, &volume] {
        assert!((costs.iter().sum::<f64>() / costs.len() as f64 - 1.).abs() < 1e-12);
    }
    let [a, b] = ["zygomaticus_major_l", "risorius_l"].map(|name| face.muscle_index(name).unwrap());
    let by = face.muscles[a].max_force_n / face.muscles[b].max_force_n;
    assert!((force[a] / force[b] - by * by).abs() < 1e-9 && volume[a] > volume[b]);
}

/// Electromyography, to 10 per cent, tells apart what markers cannot.
#[test]
fn an_observed_activation_determines_what_markers_leave_open() {
    let (response, observed) = one_marker(&[[10., 0., 0.], [10., 0., 0.]]);
    let mut seen = target(&DVector::from_vec(vec![5., 0., 0.]), 0.1);
    let width = |seen: &Target| {
        let found = certainty(&solved(seen, &observed, &response, ContactMode::Off), Discrepancy::NONE);
        found.unknowns[1].max - found.unknowns[1].min
    };
    let without = width(&seen);
    seen.priors = vec![Prior { muscle: "muscle_0".into(), activation: 0.2, sigma: 0.02 }];
    let solution = solved(&seen, &observed, &response, ContactMode::Off);
    assert!(
        (solution.activations.values[0] - 0.2).abs() < 1e-6
            && (solution.activations.values[1] - 0.3).abs() < 1e-6
    );
    let with = width(&seen);
    let expected = 2. * 1.959_963_985 * 0.02f64.hypot(0.01);
    assert!(without > 0.48 && (with / expected - 1.).abs() < 1e-3, "{without} {with} {expected}");
}

/// Twelve markers, of which one is 20 mm off: squares follow it, Huber's loss does not, and it is named.
#[test]
fn an_outlier_turns_squares_and_not_hubers_loss() {
    let mut random = Random(3);
    let (m, points) = (4, 12);
    let response = Body::random(&mut random, 24, m, points, 0).response();
    let observed = observations(&mut random, points);
    let truth = DVector::from_vec(vec![0.3, 0.5, 0.2, 0.7]);
    let mut d = &response.map * &truth + random.vector(3 * points) * 0.05;
    d[15] += 20.;
    let fit =
        |loss: Loss| solved(&Target { loss, ..target(&d, 0.05) }, &observed, &response, ContactMode::Off);
    let off = |solution: &Solution| {
        solution.activations.values.iter().zip(truth.iter()).map(|(a, b)| (a - b).abs()).fold(0., f64::max)
    };
    let (squares, huber) = (fit(Loss::Squares), fit(Loss::Huber(3.)));
    assert_eq!(huber.status, Status::Solved);
    assert!(off(&huber) < 0.05 && off(&squares) > 5. * off(&huber), "{} {}", off(&huber), off(&squares));
    let outlier = |w: &Warning| matches!(w, Warning::Outlier { marker, .. } if marker == "marker_5");
    assert!(huber.warnings.iter().any(outlier), "{:?}", huber.warnings);
}

#[test]
fn the_least_odd_activations_are_none_where_even_ones_explain() {
    let (mut response, observed) = one_marker(&[[10., 0., 0.], [10., 1., 0.]]);
    response.muscles = vec!["zygomaticus_l".into(), "zygomaticus_r".into()];
    let side = |d: Vec<f64>| {
        let solution = solved(&target(&DVector::from_vec(d), 0.2), &observed, &response, ContactMode::Off);
        certainty(&solution, Discrepancy::NONE).sides.remove(0)
    };
    let even = side(vec![8., 0.4, 0.]);
    assert!(even.least_odd.unwrap().abs() < 1e-4 && !even.is_uneven(), "{even:?}");
    // 0 in y: the right one is at rest, give or take 1.96 x 0.2.
    let odd = side(vec![10., -0.6, 0.]);
    assert!(odd.least_odd.unwrap() > 0.01 && odd.odd[1] > 0. && odd.is_uneven(), "{odd:?}");
    assert!(odd.least_odd.unwrap() >= odd.odd[1] - 1e-4, "{odd:?}");
}

#[test]
fn a_mirrored_movement_is_symmetric_and_a_turned_one_is_not() {
    let face = standard(&Resolution::COARSE);
    let field = |f: &dyn Fn(Vec3) -> Vec3| -> Vec<f64> {
        face.mesh.points.iter().flat_map(|p| f(*p).iter().copied().collect::<Vec<_>>()).collect()
    };
    let even = Symmetry::of(&face, &field(&|p| Vec3::new(0.1 * p.x, 0.02 * p.x.abs(), 1.)));
    assert!(even.mirror_rms_mm < 1e-9 && even.worst().unwrap().difference_mm() < 1e-9);
    let seen: Vec<f64> = even.map_mm.iter().copied().filter(|mm| mm.is_finite()).collect();
    assert!(seen.len() > face.skin.len() / 2 && seen.iter().all(|mm| *mm < 1e-6), "{}", seen.len());
    // Only the left corner of the mouth moves, 3 mm out and 4 mm up.
    let left = Symmetry::of(&face, &field(&|p| if p.x > 1. { Vec3::new(3., 4., 0.) } else { Vec3::zeros() }));
    let corner = left.pairs.iter().find(|pair| pair.name == "cheilion").unwrap();
    assert!((corner.difference_mm() - 5.).abs() < 1e-9 && (corner.height_mm - 4.).abs() < 1e-9);
    assert_eq!(corner.excursion_ratio(), Some(0.));
    assert!(
        (corner.direction_deg()[0].unwrap() - 53.130_102).abs() < 1e-5 && corner.direction_deg()[1].is_none()
    );
}

/// What the landmarks of `face` do under `known` activations (muscle, activation, standard deviation), without contact.
fn known_expression(face: &Face, name: &str, known: &[(&str, f64, f64)], sigma_mm: f64) -> Target {
    known_expression_with(false, face, name, known, sigma_mm)
}

/// The same, with `contact` where it is asked for.
fn known_expression_with(
    contact: bool,
    face: &Face,
    name: &str,
    known: &[(&str, f64, f64)],
    sigma_mm: f64,
) -> Target {
    let mut a = vec![0.; face.muscles.len()];
    known.iter().for_each(|(muscle, value, _)| a[face.muscle_index(muscle).unwrap()] = *value);
    let mechanics = Mechanics { strain: Strain::Linear, stiffness: Stiffness::Activated, contact };
    let u = Mover::new(face, mechanics).unwrap().settle(&a, &Pose::rest()).unwrap().displacement;
    let marker = |landmark: &modiolus::face::Landmark| Marker {
        name: landmark.name.clone(),
        at: Place::Landmark(landmark.name.clone()),
        goal: Goal::Displacement(<[f64; 3]>::from(landmark.site.displacement(&u)).map(Some)),
        sigma_mm,
    };
    let prior = |(muscle, activation, sigma): &(&str, f64, f64)| Prior {
        muscle: (*muscle).into(),
        activation: *activation,
        sigma: *sigma,
    };
    Target {
        name: name.into(),
        markers: face.landmarks.iter().map(marker).collect(),
        priors: known.iter().map(prior).collect(),
        ..Target::default()
    }
}

fn expression(face: &Face, target: &Target) -> Expression {
    let muscles: Vec<String> = face.muscles.iter().map(|m| m.name.clone()).collect();
    let observations = Observations::resolve(target, face, |_| Err(f64::INFINITY)).unwrap();
    Expression::new(target, &observations, &muscles).unwrap()
}

/// A prior that holds `name` at `median`.
fn held(name: &str, median: f64) -> StatedPrior {
    StatedPrior { name: name.into(), prior: LogNormal { median, spread: 0. } }
}

#[test]
fn sensitivities_are_those_of_central_differences() {
    let face = pulled_block(CellKind::Hex8, [4, 4, 2]);
    let (model, parameters) = (ScaledModel::new(&face).unwrap(), Parameters::of(&face, &[]).unwrap());
    let at = |left: f64, right: f64, theta: &[f64]| {
        let known = [("zygomaticus_l", left, 0.1), ("zygomaticus_r", right, 0.05)];
        let mut target = known_expression(&face, "pull", &known, 0.5);
        target.markers.iter_mut().for_each(|m| m.goal = Goal::Displacement([Some(0.1), None, Some(0.2)]));
        Sensitivity::of(&model, &parameters, &expression(&face, &target), theta, &HeldContact::none())
            .unwrap()
    };
    let theta = [0.3, -0.2, 0.4, 0.1];
    assert_eq!(parameters.list().len(), theta.len());
    let (a, h) = ([0.6, 0.3], 1e-5);
    let found = at(a[0], a[1], &theta);
    let slope = |ahead: Sensitivity, behind: Sensitivity| (ahead.residual - behind.residual) / (2. * h);
    for k in 0..theta.len() {
        let moved = |step: f64| {
            let mut theta = theta;
            theta[k] += step;
            at(a[0], a[1], &theta)
        };
        let expected = slope(moved(h), moved(-h));
        let off = (found.by_parameter.column(k) - &expected).amax();
        assert!(off < 1e-8 * expected.amax(), "parameter {k}: {off} of {}", expected.amax());
    }
    for (k, sigma) in [0.1, 0.05].into_iter().enumerate() {
        let moved = |step: f64| at(a[0] + step * f64::from(k == 0), a[1] + step * f64::from(k == 1), &theta);
        let expected = slope(moved(h), moved(-h)) * sigma;
        let off = (found.by_activation.column(k) - &expected).amax();
        assert!(off < 1e-8 * expected.amax(), "activation {k}: {off} of {}", expected.amax());
    }
    // With every parameter at 1 it is the model of the face.
    let rest = at(a[0], a[1], &[0.; 4]).displacement;
    let own = Model::new(&face, Vec::new()).unwrap();
    let direct = own.at(&a).unwrap().displacement(&a, &[]);
    let largest = direct.iter().fold(0f64, |most, u| most.max(u.abs()));
    assert!(rest.iter().zip(&direct).all(|(x, y)| (x - y).abs() < 1e-12 * largest));
}

/// The same where lips and cheeks press: what presses is held, and the derivatives are those of the equilibrium with it.
#[test]
fn sensitivities_with_contact_are_those_of_central_differences() {
    let face = standard(&Resolution::COARSE);
    let (model, parameters) = (ScaledModel::new(&face).unwrap(), Parameters::of(&face, &[]).unwrap());
    let known = [("zygomaticus_major_l", 0.4, 0.1), ("orbicularis_oris_marginalis", 0.3, 0.05)];
    let target = known_expression(&face, "press", &known, 0.5);
    let expression = expression(&face, &target);
    let search = ContactSearch::new(&face, ContactReach::default());
    let own = Model::new(&face, Vec::new()).unwrap();
    let stiff = own.at(expression.activation()).unwrap();
    let settled = stiff.settle(&face, &search, expression.activation(), None).unwrap();
    let touching = |forces: &DVector<f64>| (0..forces.len()).filter(|&k| forces[k] > 0.).collect::<Vec<_>>();
    let contact =
        HeldContact { touching: touching(&settled.equilibrium.contact_forces), pairs: settled.pairs.clone() };
    assert!(contact.touching.len() > 50, "{}", contact.touching.len());
    let theta = vec![0.; parameters.list().len()];
    let at = |theta: &[f64]| Sensitivity::of(&model, &parameters, &expression, theta, &contact).unwrap();
    let found = at(&theta);
    // With every parameter at 1 it is the face at rest on its true surfaces.
    let apart = found.displacement.iter().zip(&settled.equilibrium.displacement);
    assert!(apart.map(|(x, y)| (x - y).abs()).fold(0., f64::max) < 1e-9);
    let h = 1e-6;
    let ring = parameters.list().iter().position(|p| p.name == "orbicularis_oris_marginalis").unwrap();
    for k in [0, 1, 2, ring] {
        let moved = |step: f64| {
            let mut theta = theta.clone();
            theta[k] += step;
            at(&theta).residual
        };
        let expected = (moved(h) - moved(-h)) / (2. * h);
        let off = (found.by_parameter.column(k) - &expected).amax();
        println!("parameter {k}: {off:.1e} of {:.3}", expected.amax());
        assert!(off < 1e-6 * expected.amax(), "parameter {k}: {off} of {}", expected.amax());
    }
}

/// All moduli and the stress times 1.7 displace nothing, the data have no information along it, and so it is told; nor do they
/// tell the stress of all muscles from the strengths of all that act.
#[test]
fn stiffness_and_stress_together_are_not_determined() {
    let mut face = pulled_block(CellKind::Hex8, [4, 4, 2]);
    let mut idle =
        crate::common::block_face::pair("risorius", 3., 2., [[8., -6., -8.], [6., -2., -4.], [3., 4., -1.]]);
    face.muscles.append(&mut idle);
    let known = [("zygomaticus_l", 0.6, 1e-4), ("zygomaticus_r", 0.3, 1e-4)];
    let target = known_expression(&face, "pull", &known, 0.01);
    let expressions = [expression(&face, &target)];
    let (model, parameters) = (ScaledModel::new(&face).unwrap(), Parameters::of(&face, &[]).unwrap());
    let at = |theta: &[f64]| {
        Sensitivity::of(&model, &parameters, &expressions[0], theta, &HeldContact::none()).unwrap()
    };
    let (c, theta) = (1.7f64.ln(), [0.3, -0.2, 0.4, 0.1, 0.]);
    let scaled: Vec<f64> = theta.iter().enumerate().map(|(k, t)| t + if k < 3 { c } else { 0. }).collect();
    let (one, other) = (at(&theta), at(&scaled));
    let largest = one.displacement.iter().fold(0f64, |most, u| most.max(u.abs()));
    let apart =
        one.displacement.iter().zip(&other.displacement).map(|(x, y)| (x - y).abs()).fold(0., f64::max);
    assert!(apart < 1e-10 * largest, "{apart} of {largest}");

    let found = Calibration::of(&model, &parameters, &expressions, Discrepancy::NONE, None).unwrap();
    assert!(found.converged);
    let open: Vec<_> = found.combinations.iter().filter(|c| c.spread.is_none()).collect();
    assert_eq!(open.len(), 2, "{:?}", found.combinations);
    // tissue, muscle, stress, zygomaticus, risorius: of the two directions, and whatever basis was told of them.
    for flat in [[1., 1., 1., 0., 0.], [0., 0., 1., -1., 0.]] {
        let flat = DVector::from_column_slice(&flat);
        let basis: Vec<DVector<f64>> = open.iter().map(|c| DVector::from_column_slice(&c.weights)).collect();
        let basis = DMatrix::from_columns(&basis).qr().q();
        assert!((&flat - &basis * basis.tr_mul(&flat)).amax() < 1e-6, "{open:?}");
        let seen = at(&found.theta).by_parameter;
        assert!((&seen * &flat).amax() < 1e-10 * seen.amax());
    }
    // What was never active keeps its prior, and that is told.
    let [.., stress, zygomaticus, risorius] = &found.parameters[..] else { panic!() };
    assert_eq!((risorius.knowledge, risorius.factor, risorius.spread), (Knowledge::Unseen, 1., 0.4));
    assert!(stress.trades.iter().any(|(with, r)| with == "tissue_modulus" && *r > 0.5), "{stress:?}");
    assert!(zygomaticus.spread < zygomaticus.parameter.prior.spread);
    // The priors share out what the data leave: of stress and strength alone, by their variances.
    let (stress, strength) = (stress.spread, zygomaticus.spread);
    assert!(strength < stress, "{strength} {stress}");
}

/// Without stiffening and with all else held `u = s a u_1`: the strength is the ratio of displacements, and its spread that of
/// the noise and of the activation.
#[test]
fn one_strength_is_a_ratio_of_displacements() {
    let mut face = pulled_block(CellKind::Hex8, [4, 4, 2]);
    face.muscle_tissue.active_kpa = face.muscle_tissue.rest_kpa;
    let strong = face.clone().with_strength(1.7);
    let (a, sigma_a, sigma_mm) = (0.5, 0.04, 0.001);
    let target = known_expression(&strong, "pull", &[("zygomaticus_l", a, sigma_a)], sigma_mm);
    let squares: f64 = target.markers.iter().flat_map(|m| m.goal.observed()).map(|u| u * u).sum();
    let held = ["tissue_modulus", "muscle_modulus", "muscle_stress"].map(|name| held(name, 1.));
    let parameters = Parameters::of(&face, &held).unwrap();
    let expressions = [expression(&face, &target)];
    let model = ScaledModel::new(&face).unwrap();
    let found = Calibration::of(&model, &parameters, &expressions, Discrepancy::NONE, None).unwrap();
    let [.., strength] = &found.parameters[..] else { panic!() };
    // The observation |u| of ln s at s: slope |u_s|, noise sigma^2 + (|u_s| sigma_a / a)^2.
    let of = |s: f64| {
        let slope = squares.sqrt() * s / 1.7;
        slope * slope / (sigma_mm * sigma_mm + (slope * sigma_a / a).powi(2))
    };
    // The root of the slope of the objective at held covariance.
    let s = strength.factor;
    let pull = of(s) * (1.7 / s - 1.) - s.ln() / 0.16;
    assert!(pull.abs() < 1e-3 * of(s) && (s / 1.7).ln().abs() < 2. * strength.spread, "{pull} {s}");
    let expected = 1. / (of(s) + 1. / 0.16).sqrt();
    assert!((strength.spread - expected).abs() < 1e-9 * expected, "{} {expected}", strength.spread);
    let trade = &strength.trades[0];
    assert!(trade.0 == "activation of zygomaticus in pull" && trade.1 < -0.9, "{trade:?}");
    assert!(found.parameters[..3].iter().all(|p| p.knowledge == Knowledge::Held && p.factor == 1.));
}

/// Spreads and correlations are those of the joint normal distribution of parameters and activations, in which nothing was
/// integrated out, also where the residuals are larger than the noise.
#[test]
fn a_calibration_is_the_joint_distribution_with_the_activations() {
    let face = pulled_block(CellKind::Hex8, [4, 4, 2]);
    let known = [("zygomaticus_l", 0.6, 0.1), ("zygomaticus_r", 0.3, 0.04)];
    let mut target = known_expression(&face.clone().with_strength(1.4), "pull", &known, 0.02);
    // What no parameter explains.
    for (k, marker) in target.markers.iter_mut().enumerate() {
        let Goal::Displacement(goal) = &mut marker.goal else { panic!() };
        let off = if k % 2 == 0 { 0.15 } else { -0.15 };
        goal[k % 3] = goal[k % 3].map(|u| u + off);
    }
    let expressions = [expression(&face, &target)];
    let model = ScaledModel::new(&face).unwrap();
    let globals = ["tissue_modulus", "muscle_modulus", "muscle_stress"].map(|name| held(name, 1.));
    let mut with_activations = 0;
    for stated in [&[][..], &globals] {
        let parameters = Parameters::of(&face, stated).unwrap();
        let found = Calibration::of(&model, &parameters, &expressions, Discrepancy::NONE, None).unwrap();
        assert!(found.converged && found.noise_factor > 2., "{}", found.noise_factor);
        let at = Sensitivity::of(&model, &parameters, &expressions[0], &found.theta, &HeldContact::none())
            .unwrap();
        let prior = |i: usize| parameters.list()[i].prior.spread;
        let free: Vec<usize> = (0..parameters.list().len()).filter(|i| prior(*i) > 0.).collect();
        let (p, k) = (free.len(), at.by_activation.ncols());
        let slopes = DMatrix::from_fn(at.residual.len(), p + k, |row, column| match column.checked_sub(p) {
            None => at.by_parameter[(row, free[column])],
            Some(activation) => at.by_activation[(row, activation)],
        });
        // All standard deviations are larger by the factor, those of the activations too; priors are what they are.
        let ratio = found.noise_factor.powi(2);
        let mut precision = slopes.tr_mul(&slopes) / ratio;
        (0..p).for_each(|own| precision[(own, own)] += prior(free[own]).powi(-2));
        (p..p + k).for_each(|own| precision[(own, own)] += 1. / ratio);
        let covariance = precision.try_inverse().unwrap();
        let spread = |i: usize| covariance[(i, i)].sqrt();
        for (own, &i) in free.iter().enumerate() {
            let told = &found.parameters[i];
            assert!((told.spread / spread(own) - 1.).abs() < 1e-6, "{told:?} {}", spread(own));
            for (with, correlation) in &told.trades {
                let is_activation = with == "activation of zygomaticus in pull";
                let is_meant = |j: &usize| match j.checked_sub(p) {
                    None => parameters.list()[free[*j]].name == *with,
                    Some(_) => is_activation,
                };
                let off = |j: usize| (covariance[(own, j)] / spread(own) / spread(j) - correlation).abs();
                assert!((0..p + k).filter(is_meant).any(|j| off(j) < 1e-6), "{with} {correlation}");
                with_activations += usize::from(is_activation);
            }
        }
    }
    assert!(with_activations > 0, "no activation was told");
}

/// Stress, strengths and stiffness put into the standard face come back on the coarse one as well as one mesh knows another.
#[test]
fn parameters_of_one_mesh_are_found_on_another() {
    find_parameters_of_another_mesh(false);
}

/// So they do where lips and cheeks press on each other and on the teeth.
#[test]
fn parameters_of_one_mesh_are_found_on_another_with_contact() {
    find_parameters_of_another_mesh(true);
}

/// A search that begins where the muscles hardly move the face meets other contacts on its way, and ends on the true surfaces.
#[test]
fn a_calibration_from_afar_ends_where_contact_holds() {
    let face = standard(&Resolution::COARSE);
    let strong = face.clone().with_strength(2.);
    let known = [("orbicularis_oris_marginalis", 0.5, 0.005), ("zygomaticus_major_l", 0.3, 0.005)];
    let target = known_expression_with(true, &strong, "press", &known, 0.05);
    let observations = Observations::resolve(&target, &face, |_| Err(f64::INFINITY)).unwrap();
    let weak = StatedPrior { name: "muscle_stress".into(), prior: LogNormal { median: 0.3, spread: 2. } };
    let priors = [held("tissue_modulus", 1.), held("muscle_modulus", 1.), held("strength", 1.), weak];
    let found = calibrate(&face, &[(&target, &observations)], &priors, Discrepancy::NONE, true).unwrap();
    let stress = &found.calibration.parameters[2];
    println!(
        "stress 2 found {:.4} within {:.4}, overlap {:.4} mm",
        stress.factor, stress.spread, found.overlap_mm[0]
    );
    assert!(found.calibration.converged && found.overlap_mm[0] <= 0.01, "{:?}", found.overlap_mm);
    assert!((stress.factor / 2.).ln().abs() < 2. * stress.spread, "{stress:?}");
}

fn find_parameters_of_another_mesh(contact: bool) {
    let mut truth = standard(&Resolution::STANDARD).with_strength(1.5);
    truth.tissue.young_kpa *= 1.25;
    for (muscle, factor) in [("zygomaticus_major", 1.3), ("depressor_anguli_oris", 0.75)] {
        let of = truth.muscles.iter_mut().filter(|m| m.name.starts_with(muscle));
        of.for_each(|m| m.max_force_n *= factor);
    }
    let sets: [(&str, &[&str]); 4] = [
        ("smile", &["zygomaticus_major", "levator_labii_superioris"]),
        ("down", &["depressor_anguli_oris"]),
        ("grin", &["zygomaticus_major", "risorius"]),
        ("sneer", &["levator_labii_superioris"]),
    ];
    let coarse = standard(&Resolution::COARSE);
    let targets: Vec<Target> = sets
        .iter()
        .map(|(name, muscles)| {
            let both: Vec<String> =
                muscles.iter().flat_map(|m| ["l", "r"].map(|side| format!("{m}_{side}"))).collect();
            let known: Vec<_> = both.iter().map(|m| (m.as_str(), 0.3, 0.005)).collect();
            known_expression_with(contact, &truth, name, &known, 0.05)
        })
        .collect();
    let observations: Vec<Observations> =
        targets.iter().map(|t| Observations::resolve(t, &coarse, |_| Err(f64::INFINITY)).unwrap()).collect();
    let both: Vec<_> = targets.iter().zip(&observations).collect();
    let priors = [held("muscle_modulus", 1.)];
    let found = calibrate(&coarse, &both, &priors, Discrepancy::MESH, contact).unwrap();
    assert!(found.calibration.converged);
    assert!(!contact || found.overlap_mm.iter().all(|mm| *mm <= 0.01), "{:?}", found.overlap_mm);
    let factor = |name: &str| found.calibration.parameters.iter().find(|p| p.parameter.name == name).unwrap();
    // Where 4.4 per cent is what one mesh is off another in the strength of a muscle, and contact holds back more of the
    // movement on one mesh than on another.
    let (products, moduli) = if contact { (0.08, 0.1) } else { (0.06, 0.05) };
    for (muscle, expected) in [
        ("zygomaticus_major", 1.5 * 1.3),
        ("levator_labii_superioris", 1.5),
        ("risorius", 1.5),
        ("depressor_anguli_oris", 1.5 * 0.75),
    ] {
        let product = factor("muscle_stress").factor * factor(muscle).factor;
        println!("stress x {muscle}: {expected:.3} found {product:.3}");
        assert!((product / expected - 1.).abs() < products, "{muscle} {product} {expected}");
        assert_eq!(factor(muscle).knowledge, Knowledge::Data);
    }
    let (tissue, stress) = (factor("tissue_modulus"), factor("muscle_stress"));
    println!("tissue: 1.250 found {:.3}", tissue.factor);
    println!("stress: 1.500 found {:.3}, spread {:.3}", stress.factor, stress.spread);
    assert!((tissue.factor / 1.25 - 1.).abs() < moduli, "{tissue:?}");
    assert!((tissue.factor / 1.25).ln().abs() < 2. * tissue.spread);
    if contact {
        // What contact holds back is taken for stiffer tissue where it is left out.
        let without = calibrate(&coarse, &both, &priors, Discrepancy::MESH, false).unwrap();
        let tissue = &without.calibration.parameters[0];
        println!("tissue without contact: {:.3}", tissue.factor);
        assert!(tissue.factor > 1.2 * 1.25, "{tissue:?}");
    }
    assert_eq!(factor("mentalis").knowledge, Knowledge::Unseen);
    let [best, .., open] = &found.calibration.combinations[..] else { panic!() };
    assert!(best.spread.unwrap() < 0.02 && open.spread.is_none(), "{best:?} {open:?}");
    // The smile, whose muscles are half again as strong for their tissue, is explained.
    let smile = &found.calibration.expressions[0];
    assert!(smile.rms_after < 0.5 * smile.rms_before, "{} {}", smile.rms_after, smile.rms_before);
    let zygomaticus = found.face.muscle_index("zygomaticus_major_l").unwrap();
    let stronger = found.face.muscles[zygomaticus].max_force_n / coarse.muscles[zygomaticus].max_force_n;
    let expected = factor("muscle_stress").factor * factor("zygomaticus_major").factor;
    assert!((stronger / expected - 1.).abs() < 1e-12);
    assert!((found.face.tissue.young_kpa - 15. * tissue.factor).abs() < 1e-9);
}

#[test]
fn an_expression_that_says_nothing_of_its_activations_is_refused() {
    let face = pulled_block(CellKind::Hex8, [4, 4, 2]);
    let muscles: Vec<String> = face.muscles.iter().map(|m| m.name.clone()).collect();
    let known = known_expression(&face, "pull", &[("zygomaticus_l", 0.5, 0.1)], 0.5);
    let refused = |change: &dyn Fn(&mut Target)| {
        let mut target = known.clone();
        change(&mut target);
        let observations = Observations::resolve(&target, &face, |_| Err(f64::INFINITY)).unwrap();
        Expression::new(&target, &observations, &muscles).unwrap_err()
    };
    let expression = || "pull".to_owned();
    assert_eq!(refused(&|t| t.priors.clear()), CalibrationError::NoActivation { expression: expression() });
    assert_eq!(
        refused(&|t| t.priors[0].activation = 0.),
        CalibrationError::NoActivation { expression: expression() }
    );
    assert_eq!(refused(&|t| t.markers.clear()), CalibrationError::NoObservation { expression: expression() });
    let blank = |t: &mut Target| t.markers.iter_mut().for_each(|m| m.goal = Goal::Displacement([None; 3]));
    assert_eq!(refused(&blank), CalibrationError::NoObservation { expression: expression() });
    assert!(matches!(
        Parameters::of(&face, &[held("zygomaticus_l", 1.)]),
        Err(CalibrationError::UnknownParameter { .. })
    ));
    assert!(matches!(Parameters::of(&face, &[held("strength", 0.)]), Err(CalibrationError::Prior { .. })));
    let all = ["tissue_modulus", "muscle_modulus", "muscle_stress", "strength"].map(|name| held(name, 1.));
    assert_eq!(Parameters::of(&face, &all), Err(CalibrationError::NothingFree));
}
