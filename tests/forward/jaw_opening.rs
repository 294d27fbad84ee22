//! The jaw's opening in the inverse: prescribed, or found beside the activations.
#![allow(clippy::unwrap_used, reason = "a test that cannot go on should say where")]

use crate::common::Random;
use crate::common::block_face::{block_face, jaw_block, jaw_pairs};
use modiolus::face::standard::{Resolution, standard};
use modiolus::face::{ContactReach, Face, JawRange, Pose};
use modiolus::forward::Model;
use modiolus::inverse::{
    ActivatedProblem, ContactMode, Goal, JawOpening, Marker, Observations, Place, Solution, Status, Target,
    TargetError,
};
use modiolus::io::read_target;
use modiolus::mesh::{Locator, Site};
use modiolus::units::Vec3;
use nalgebra::{DMatrix, DVector};

const CELLS: [usize; 3] = [10, 8, 4];
const WANTED: ([f64; 3], f64) = ([0.6, 0.25, 0.5], 3.);

/// Rest places of markers all over the front, not at nodes.
fn places() -> Vec<Vec3> {
    let at = |k: usize| Vec3::new(-24.3 + 8.1 * (k % 7) as f64, -16.4 + 6.3 * (k / 7) as f64, 12.);
    (0..42).map(at).collect()
}

fn locate(face: &Face) -> impl Fn(Vec3) -> Result<Site, f64> {
    let locator = Locator::new(&face.mesh);
    move |p| locator.locate(p).map(|found| found.site).ok_or(f64::INFINITY)
}

/// Displacement of the places on `face` under activations `a` with the jaw open.
fn moved(face: &Face, contact: bool, a: &[f64], opening_mm: f64) -> Vec<Vec3> {
    let model = model(face, contact);
    let stiff = model.at_pose(a, &Pose::opened(face.jaw.as_ref().unwrap(), opening_mm)).unwrap();
    let response = stiff.response(&[]);
    let u = stiff.equilibrium(response.contact.as_ref()).unwrap().displacement;
    let site = locate(face);
    places().into_iter().map(|p| site(p).unwrap().displacement(&u)).collect()
}

fn model(face: &Face, contact: bool) -> Model {
    Model::new(face, if contact { jaw_pairs(face, 0.01) } else { Vec::new() }).unwrap()
}

fn target(d: &[Vec3], jaw_opening: JawOpening, sigma_mm: f64) -> Target {
    let marker = |(k, (p, d)): (usize, (Vec3, &Vec3))| Marker {
        name: format!("marker_{k}"),
        at: Place::Point(p),
        goal: Goal::Displacement([Some(d.x), Some(d.y), Some(d.z)]),
        sigma_mm,
    };
    let markers = places().into_iter().zip(d).enumerate().map(marker).collect();
    Target { markers, jaw_opening: Some(jaw_opening), effort: 1e-6, ..Target::default() }
}

fn within(min_mm: f64, max_mm: f64) -> JawOpening {
    JawOpening::Within(JawRange { min_mm, max_mm })
}

/// The answer on `face` from the start `x`, or from rest.
fn fit(face: &Face, contact: bool, target: &Target, start: Option<&[f64]>) -> Solution {
    let model = model(face, contact);
    let observations = Observations::resolve(target, face, locate(face)).unwrap();
    let mode = if contact { ContactMode::Reactions } else { ContactMode::Off };
    let problem = ActivatedProblem::new(&model, target, &observations, mode);
    let start = start.map_or_else(|| problem.rest(), DVector::from_column_slice);
    problem.solve(start, |_| {}).unwrap().solution
}

#[test]
fn every_start_finds_the_opening_and_the_activations_that_made_the_target() {
    // Same mesh on purpose: what is tested is the search, not the accuracy of the model.
    let face = jaw_block(CELLS);
    for contact in [false, true] {
        let target = target(&moved(&face, contact, &WANTED.0, WANTED.1), within(0., 10.), 0.1);
        for start in [[0.; 4], [1.; 4], [0.5, 0.5, 0.5, 1.], [0., 1., 1., 0.2]] {
            let found = fit(&face, contact, &target, Some(&start));
            assert_eq!(found.status, Status::Solved, "contact {contact} from {start:?}");
            let opening = found.jaw_opening_mm.unwrap();
            assert!((opening - WANTED.1).abs() < 1e-4, "contact {contact} from {start:?}: {opening}");
            for (a, wanted) in found.activations.values.iter().zip(WANTED.0) {
                assert!((a - wanted).abs() < 1e-4, "contact {contact} from {start:?}: {a} {wanted}");
            }
        }
    }
}

/// What a small change of the markers (3p) does to the unknowns, `(J'J)^-1 J'` (4 x 3p): `J` by differences of the
/// forward model alone, at the wanted activations and `opening_mm`.
fn sensitivity(face: &Face, opening_mm: f64) -> DMatrix<f64> {
    let h = 1e-3;
    let column = |k: usize| {
        let at = |step: f64| {
            let (mut a, mut opening) = (WANTED.0, opening_mm);
            *a.get_mut(k).unwrap_or(&mut opening) += step;
            stacked(&moved(face, true, &a, opening))
        };
        (at(h) - at(-h)) / (2. * h)
    };
    let j = DMatrix::from_columns(&[0, 1, 2, 3].map(column));
    j.tr_mul(&j).try_inverse().unwrap() * j.transpose()
}

fn stacked(d: &[Vec3]) -> DVector<f64> {
    DVector::from_iterator(3 * d.len(), d.iter().flat_map(|d| [d.x, d.y, d.z]))
}

#[test]
fn the_opening_is_recovered_from_noisy_markers_of_a_finer_mesh() {
    let (truth, own) = (jaw_block([20, 16, 6]), jaw_block(CELLS));
    let mut random = Random(7);
    for opening in [0.8, 3., 7.5] {
        let mut seen = moved(&truth, true, &WANTED.0, opening);
        seen.iter_mut()
            .for_each(|d| *d += 0.1 * Vec3::new(random.normal(), random.normal(), random.normal()));
        let found = fit(&own, true, &target(&seen, within(0., 12.), 0.1), None);
        assert_eq!(found.status, Status::Solved);
        let unknowns = found.activations.values.iter().copied().chain(found.jaw_opening_mm);
        let wanted = WANTED.0.into_iter().chain([opening]);
        let error = DVector::from_iterator(4, unknowns.zip(wanted).map(|(x, w)| x - w));
        // What the coarser mesh and the noise put into the markers must come out as linear least squares says.
        let off = stacked(&seen) - stacked(&moved(&own, true, &WANTED.0, opening));
        let expected = sensitivity(&own, opening) * off;
        assert!((&error - &expected).amax() < 2e-3, "{opening} mm: {error} {expected}");
        // Of 0.17 mm at 7.5 mm the mesh makes 0.13, the noise 0.04: one and a half of its standard deviations.
        assert!(error[3].abs() < 0.2 && (error.rows(0, 3).norm_squared() / 3.).sqrt() < 0.05, "{error}");
    }
}

#[test]
fn the_multiplier_of_a_bound_is_the_slope_of_the_objective_by_the_opening() {
    let face = jaw_block(CELLS);
    let seen = moved(&face, true, &WANTED.0, 6.);
    let best = |max: f64| fit(&face, true, &target(&seen, within(0.5, max), 0.1), None);
    let found = best(4.);
    assert_eq!(found.jaw_opening_mm, Some(4.), "at its bound exactly");
    let limit = found.active_limits.iter().find(|l| l.name == "jaw_opening_mm <= 4").unwrap();
    assert_eq!(limit.unit, "1/mm");
    let h = 1e-3;
    let slope = (best(4. - h).objective - best(4. + h).objective) / (2. * h);
    assert!((slope / limit.multiplier - 1.).abs() < 1e-4, "{slope} {}", limit.multiplier);
    // Prescribed there, the answer is the same.
    let held = fit(&face, true, &target(&seen, JawOpening::Held(4.), 0.1), None);
    assert_eq!((held.status, held.jaw_opening_mm), (Status::Solved, Some(4.)));
    assert!((held.objective / found.objective - 1.).abs() < 1e-9);
    // The opening itself costs no effort.
    let least = best(6.5);
    assert!(
        (least.jaw_opening_mm.unwrap() - 6.).abs() < 1e-3 && least.objective < 1e-4,
        "{}",
        least.objective
    );
}

#[test]
fn at_fixed_stiffness_the_answer_is_linearised_about_its_own_opening() {
    let face = jaw_block(CELLS);
    let target = target(&moved(&face, true, &WANTED.0, 9.), within(0., 12.), 0.1);
    let model = model(&face, true);
    let observations = Observations::resolve(&target, &face, locate(&face)).unwrap();
    let problem = ActivatedProblem::new(&model, &target, &observations, ContactMode::Reactions);
    let found = problem.solve_at_fixed_stiffness(0.5).unwrap();
    assert_eq!(found.status, Status::Solved);
    let stiff = problem.model_at(&[0.5; 3], problem.start(&found).as_slice()).unwrap();
    let u = stiff.displacement(&found.activations.values, found.contact_forces.as_slice());
    for (site, said) in observations.sites.iter().zip(found.observed_mm.as_slice().chunks(3)) {
        assert!((site.displacement(&u) - Vec3::from_column_slice(said)).norm() < 1e-8);
    }
}

#[test]
fn a_jaw_that_is_not_there_and_openings_that_cannot_be_are_refused() {
    let seen = vec![Vec3::x(); 42];
    let none = block_face(CELLS);
    let error = Observations::resolve(&target(&seen, JawOpening::Held(4.), 1.), &none, locate(&none));
    assert_eq!(error, Err(TargetError::NoJaw { field: "jaw_opening_mm".into() }));
    let face = jaw_block(CELLS);
    for (opening, field) in [
        (JawOpening::Held(-1.), "jaw_opening_mm"),
        (JawOpening::Held(f64::NAN), "jaw_opening_mm"),
        (within(0., 61.), "jaw_opening_mm.max"),
        (within(5., 5.), "jaw_opening_mm"),
    ] {
        let error = Observations::resolve(&target(&seen, opening, 1.), &face, locate(&face)).unwrap_err();
        assert_eq!(error.field(), field, "{error}");
    }
}

#[test]
fn the_lips_close_over_an_opened_jaw() {
    let face = standard(&Resolution::COARSE);
    let path = std::path::Path::new(env!("CARGO_MANIFEST_DIR")).join("targets/lip_closure.toml");
    let target = read_target(&path).unwrap().target;
    assert_eq!(target.jaw_opening, Some(JawOpening::Held(4.)));
    let observations = Observations::resolve(&target, &face, locate(&face)).unwrap();
    let model = Model::new(&face, face.contact_pairs(ContactReach::default())).unwrap();
    let problem = ActivatedProblem::new(&model, &target, &observations, ContactMode::Reactions);
    // Without muscles the lips stand apart by most of the opening.
    let pose = Pose::opened(face.jaw.as_ref().unwrap(), 4.);
    let u = model.at_pose(&vec![0.; face.muscles.len()], &pose).unwrap();
    let u = u.displacement(&vec![0.; face.muscles.len()], &[]);
    let lip = |name: &str| face.landmark(name).unwrap().site.displacement(&u).y;
    assert!(lip("stomion_superius") - lip("stomion_inferius") > 2.5);
    let start = problem.start(&problem.solve_at_fixed_stiffness(0.5).unwrap());
    let found = problem.solve(start, |_| {}).unwrap().solution;
    assert_eq!((found.status, found.jaw_opening_mm), (Status::Solved, Some(4.)));
    assert!(found.features[0].model_mm.abs() <= 0.1, "{:?}", found.features);
    assert!(found.contact.max_penetration_mm < 1e-9);
}
