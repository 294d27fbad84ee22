//! Muscles that stiffen as they act: the exact Jacobian and the nonlinear fit.

use crate::common::block_face::{block_face, front_pairs, pair, pulled_block};
use crate::common::grid;
use crate::common::piece::{jacobian_on_piece, observed_at};
use modiolus::face::{Face, Fibre, Landmark, Muscle, MuscleLaw, Support};
use modiolus::forward::Model;
use modiolus::inverse::{
    ActivatedProblem, ContactMode, Goal, Marker, Observations, Place, SequentialStep, Status, Target,
};
use modiolus::mesh::{CellKind, Site};
use modiolus::units::Vec3;
use nalgebra::DVector;

const CELLS: [usize; 3] = [10, 8, 4];

fn model(law: MuscleLaw, contact: bool) -> (Face, Model) {
    let mut face = block_face(CELLS);
    face.muscle_tissue.law = law;
    let pairs = if contact { front_pairs(&face, 0.01) } else { Vec::new() };
    let model = Model::new(&face, pairs).unwrap();
    (face, model)
}

/// Displacement of the landmarks and contact forces at rest under `a`, at the stiffness of `a`.
fn at_rest(model: &Model, sites: &[Site], a: &[f64]) -> (Vec<f64>, DVector<f64>, Vec<f64>) {
    let stiff = model.at(a).unwrap();
    let response = stiff.response(sites);
    let equilibrium = stiff.equilibrium(response.contact.as_ref()).unwrap();
    let seen = sites.iter().flat_map(|s| {
        let u = s.displacement(&equilibrium.displacement);
        [u.x, u.y, u.z]
    });
    (seen.collect(), equilibrium.contact_forces, equilibrium.displacement)
}

#[test]
fn the_jacobian_is_the_derivative_with_contact_on_and_off() {
    for law in [MuscleLaw::Reinforced, MuscleLaw::Orthotropic] {
        for contact in [false, true] {
            let (face, model) = model(law, contact);
            let sites: Vec<Site> = face.landmarks.iter().map(|l| l.site.clone()).collect();
            let a = [0.6, 0.35, 0.5];
            let (observed, forces, u) = at_rest(&model, &sites, &a);
            let stiff = model.at(&a).unwrap();
            let tangent = stiff.tangent(&sites, &stiff.response(&sites), &u);
            assert_eq!(contact, forces.iter().any(|f| *f > 0.), "contact presses when it is on");
            let jacobian = jacobian_on_piece(&tangent, &forces);
            // The tangent meets the state it was taken at.
            assert!(
                (observed_at(&tangent, &a, &forces) - DVector::from_column_slice(&observed)).amax() < 1e-10
            );
            let h = 1e-4;
            for muscle in 0..3 {
                let moved = |step: f64| {
                    let mut b = a;
                    b[muscle] += step;
                    at_rest(&model, &sites, &b)
                };
                let (hi, lo) = (moved(h), moved(-h));
                let same = |f: &DVector<f64>| (0..f.len()).all(|i| (f[i] > 0.) == (forces[i] > 0.));
                assert!(same(&hi.1) && same(&lo.1), "the difference stays on one piece");
                for row in 0..observed.len() {
                    let difference = (hi.0[row] - lo.0[row]) / (2. * h);
                    let error = (jacobian[(row, muscle)] - difference).abs() / jacobian.amax();
                    assert!(error < 1e-6, "{law:?} contact {contact} muscle {muscle} row {row}: {error:e}");
                }
            }
        }
    }
}

fn target(face: &Face, observed: &[f64], effort: f64) -> Target {
    let markers = face.landmarks.iter().zip(observed.chunks_exact(3)).map(|(landmark, d)| Marker {
        name: landmark.name.clone(),
        at: Place::Landmark(landmark.name.clone()),
        goal: Goal::Displacement([Some(d[0]), Some(d[1]), Some(d[2])]),
        sigma_mm: 0.1,
    });
    Target { markers: markers.collect(), effort, ..Target::default() }
}

#[test]
fn every_start_finds_the_activations_that_made_the_target() {
    // Same mesh on purpose: what is tested is the search, not the accuracy of the model.
    for law in [MuscleLaw::Reinforced, MuscleLaw::Orthotropic] {
        for (mode, contact) in [(ContactMode::Off, false), (ContactMode::Reactions, true)] {
            let (face, model) = model(law, contact);
            let sites: Vec<Site> = face.landmarks.iter().map(|l| l.site.clone()).collect();
            let wanted = [0.8, 0.3, 0.4];
            let target = target(&face, &at_rest(&model, &sites, &wanted).0, 0.);
            let observations = Observations::resolve(&target, &face, |_| Err(0.)).unwrap();
            let problem = ActivatedProblem::new(&model, &target, &observations, mode);
            for start in [[0., 0., 0.], [1., 1., 1.], [0.5, 0.5, 0.5], [1., 0., 0.], [0., 1., 1.]] {
                let found = problem.solve(DVector::from_column_slice(&start), |_| {}).unwrap();
                assert_eq!(found.solution.status, Status::Solved, "{law:?} {mode:?} from {start:?}");
                assert!(found.solution.certificate.worst() <= 1e-8);
                for (value, wanted) in found.solution.activations.values.iter().zip(wanted) {
                    assert!(
                        (value - wanted).abs() < 1e-5,
                        "{law:?} {mode:?} from {start:?}: {value} {wanted}"
                    );
                }
            }
        }
    }
}

#[test]
fn an_unreachable_target_is_solved_at_its_bounds_with_falling_objectives() {
    let (face, model) = model(MuscleLaw::Reinforced, true);
    let target = target(&face, &[4., 3., 0., -4., 2., 0.], 1e-3);
    let observations = Observations::resolve(&target, &face, |_| Err(0.)).unwrap();
    let problem = ActivatedProblem::new(&model, &target, &observations, ContactMode::Reactions);
    let found = problem.solve(DVector::zeros(3), |_| {}).unwrap();
    assert_eq!(found.solution.status, Status::Solved);
    let values = &found.solution.activations.values;
    assert!(values.contains(&1.), "at its bound exactly: {values:?}");
    let taken: Vec<&SequentialStep> = found.history.iter().filter(|step| step.taken).collect();
    assert!(taken.windows(2).all(|w| w[1].objective <= w[0].objective), "{:?}", found.history);
    assert!(found.solution.active_limits.iter().any(|l| l.name.ends_with("<= 1")));
}

#[test]
fn a_wish_far_out_of_reach_is_solved_though_its_residual_stays_large() {
    // At a residual of 40 standard deviations the curvature of the face outweighs the tangent's own: without it each step
    // overshoots, and the way goes to and fro.
    let mut face = pulled_block(CellKind::Hex8, [8, 8, 3]);
    face.muscles.extend(pair("risorius", 2., 1., [[9., -6., -9.], [7., -5., -3.], [3., -5., -1.]]));
    // Along the bone it moves nothing, and only stiffens.
    face.muscles.extend(pair("levator", 2., 1., [[3., 8., -10.], [5., 8., -10.], [8., 8., -10.]]));
    let model = Model::new(&face, Vec::new()).unwrap();
    let wish = [20., 0., 0., 0.4, 0.5, -0.2];
    let mut target = target(&face, &wish, 0.1);
    target.markers.iter_mut().for_each(|marker| marker.sigma_mm = 0.5);
    let observations = Observations::resolve(&target, &face, |_| Err(0.)).unwrap();
    let problem = ActivatedProblem::new(&model, &target, &observations, ContactMode::Off);
    for start in [0., 0.5, 1.] {
        let found = problem.solve(DVector::from_element(6, start), |_| {}).unwrap();
        println!("{} steps to {:?}", found.history.len(), found.solution.activations.values);
        assert_eq!(found.solution.status, Status::Solved, "{:?}", found.history);
        assert!(found.history.len() < 40, "{:?}", found.history);
        // An optimum of the objective itself, not only by its certificate.
        let sites: Vec<Site> = face.landmarks.iter().map(|l| l.site.clone()).collect();
        let value = |a: &[f64]| {
            let seen = at_rest(&model, &sites, a).0;
            let fit: f64 = seen.iter().zip(wish).map(|(u, wish)| ((u - wish) / 0.5).powi(2)).sum();
            fit + 0.1 * a.iter().map(|a| a * a).sum::<f64>()
        };
        let a = &found.solution.activations.values;
        assert!(a.iter().any(|a| (0.01..0.99).contains(a)), "an optimum within the bounds: {a:?}");
        for muscle in 0..6 {
            for step in [-1e-3, 1e-3] {
                let mut b = a.clone();
                b[muscle] = (b[muscle] + step).clamp(0., 1.);
                assert!(value(&b) >= value(a) * (1. - 1e-12), "{muscle} {step}: {} {}", value(&b), value(a));
            }
        }
    }
}

#[test]
fn the_answer_differs_from_that_at_fixed_stiffness() {
    let (face, model) = model(MuscleLaw::Reinforced, false);
    let sites: Vec<Site> = face.landmarks.iter().map(|l| l.site.clone()).collect();
    let target = target(&face, &at_rest(&model, &sites, &[0.9, 0.1, 0.1]).0, 0.);
    let observations = Observations::resolve(&target, &face, |_| Err(0.)).unwrap();
    let problem = ActivatedProblem::new(&model, &target, &observations, ContactMode::Off);
    let linear = problem.at_fixed_stiffness(0.5).unwrap().solve(ContactMode::Off).unwrap();
    let exact = problem.solve(DVector::from_vec(linear.activations.values.clone()), |_| {}).unwrap();
    let off = (exact.solution.activations.values[0] - linear.activations.values[0]).abs();
    assert!((exact.solution.activations.values[0] - 0.9).abs() < 1e-5);
    assert!(off > 0.02, "fixed stiffness errs by {off}");
}

#[test]
fn a_step_that_would_raise_the_objective_is_not_taken() {
    // A bar that is all muscle shortens by u(a) = a F / (K0 + a K1) with K1 = 17 K0: nearly all of u(1) is there
    // at small a. For a wish of 0.6 u(1) the tangent at a = 1, far too flat, says a = 0, where u = 0 is
    // farther off than u(1) was.
    let mut face = block_face([10, 2, 2]);
    face.mesh = grid(CellKind::Hex8, [12, 2, 2], |p| Vec3::new(60. * p.x, 12. * p.y - 6., 12. * p.z - 6.));
    let nodes =
        |x: f64| -> Vec<usize> { (0..face.mesh.n_nodes()).filter(|&n| face.mesh.points[n].x == x).collect() };
    let root = nodes(0.);
    let middle = *nodes(30.).iter().find(|&&n| face.mesh.points[n].yz().norm() < 1e-9).unwrap();
    let site = Site::node(middle, face.mesh.points[middle]);
    face.supports = vec![Support { bone: "skull".into(), nodes: root, part_of: None }];
    face.landmarks = vec![Landmark { name: "pogonion".into(), site }];
    face.muscles = vec![Muscle {
        name: "mentalis_l".into(),
        max_force_n: 0.5,
        radius_mm: 9.,
        area_mm2: None,
        insertion_mm: 10.,
        fibres: vec![Fibre {
            points: (0..=60).map(|x| Vec3::new(f64::from(x), 0., 0.)).collect(),
            closed: false,
        }],
    }];
    let model = Model::new(&face, Vec::new()).unwrap();
    let sites = [face.landmarks[0].site.clone()];
    let full = at_rest(&model, &sites, &[1.]).0;
    let wish: Vec<f64> = full.iter().map(|u| 0.6 * u).collect();
    let target = target(&face, &wish, 0.);
    let observations = Observations::resolve(&target, &face, |_| Err(0.)).unwrap();
    let problem = ActivatedProblem::new(&model, &target, &observations, ContactMode::Off);
    let found = problem.solve(DVector::from_element(1, 1.), |_| {}).unwrap();
    let first = found.history[0];
    assert!(!first.taken && first.change == 1., "to no activation at all: {first:?}");
    let falls = |w: &[SequentialStep]| w[1].objective <= w[0].objective;
    assert!(found.history.windows(2).all(falls), "{:?}", found.history);
    assert!(found.history[1].radius < first.radius);
    assert_eq!(found.solution.status, Status::Solved);
    let a = found.solution.activations.values[0];
    let reached = at_rest(&model, &sites, &[a]).0;
    assert!((reached[0] / wish[0] - 1.).abs() < 1e-3 && a > 0.02 && a < 0.3, "{a}: {reached:?} for {wish:?}");
}
