//! The sparse effort, `w sum c a`: closed forms, another solver, optimality of the objective itself, and what it decides.

#![allow(clippy::unwrap_used)] // A test that unwraps fails where it should.

use std::path::Path;

use crate::common::Random;
use crate::common::block_face::{block_face, front_pairs};
use crate::common::faces::{Body, names, observations, target};
use modiolus::certainty::{Certainty, Discrepancy};
use modiolus::contact::PairKind;
use modiolus::face::standard::{Resolution, standard};
use modiolus::face::{Face, Pose};
use modiolus::forward::finite::FiniteModel;
use modiolus::forward::{ContactResponse, Model, Response};
use modiolus::inverse::{
    ActivatedProblem, Bound, ContactMode, EffortMeasure, EffortNorm, FiniteFit, Goal, Marker, MuscleCost,
    Observations, Place, Problem, Solution, State, Status, Target, Warning, objective,
};
use modiolus::io::read_target;
use modiolus::mesh::Site;
use nalgebra::{DMatrix, DVector};

fn sparse(wish: Target, effort: f64) -> Target {
    Target { effort, effort_norm: EffortNorm::L1, ..wish }
}

fn mapped(map: DMatrix<f64>) -> Response {
    let (muscles, offset) = (names(map.ncols()), DVector::zeros(map.nrows()));
    Response { muscles, jaw: None, offset, map, contact: None }
}

fn solve(target: &Target, observed: &Observations, response: &Response) -> Solution {
    Problem::new(target, observed, response).unwrap().solve(ContactMode::Off).unwrap()
}

fn activations(solution: &Solution) -> DVector<f64> {
    DVector::from_column_slice(&solution.activations.values)
}

fn acting(a: &[f64]) -> usize {
    a.iter().filter(|a| **a > 1e-6).count()
}

/// With orthogonal columns each muscle has its own problem, of which soft thresholding is the answer: Tibshirani (1996).
#[test]
fn orthogonal_columns_are_thresholded() {
    let mut random = Random(71);
    for _ in 0..30 {
        let (m, points, sigma, effort) = (7, 5, 0.4, 6.);
        let directions = random.matrix(3 * points, m).qr().q();
        let sizes = DVector::from_fn(m, |_, _| 2. + 6. * random.unit());
        let response = mapped(&directions * DMatrix::from_diagonal(&sizes));
        let mut observed = observations(&mut random, points);
        observed.cost = (0..m).map(|_| 0.3 + 1.4 * random.unit()).collect();
        let d = random.vector(3 * points) * 3.;
        let solution = solve(&sparse(target(&d, sigma), effort), &observed, &response);
        let pull = response.map.tr_mul(&d) / (sigma * sigma);
        let expected = DVector::from_fn(m, |k, _| {
            let curvature = (sizes[k] / sigma).powi(2);
            f64::clamp((pull[k] - effort * observed.cost[k]) / curvature, 0., 1.)
        });
        assert_eq!(solution.status, Status::Solved, "{:?}", solution.warnings);
        assert!((activations(&solution) - &expected).amax() < 1e-9);
        assert!(expected.iter().zip(&solution.activations.values).all(|(e, a)| *e > 0. || *a == 0.));
        let misfit = (&response.map * &expected - &d).norm_squared() / (sigma * sigma);
        let cost: f64 = expected.iter().zip(&observed.cost).map(|(a, c)| effort * c * a).sum();
        let value = 0.5 * misfit + cost;
        assert!((solution.objective - value).abs() < 1e-9 * value, "{} {value}", solution.objective);
    }
}

/// The least of `1/2 |M a - v|^2 + slope'a` within [0, 1] by cyclic coordinate descent: Friedman, Hastie, Hoefling and
/// Tibshirani (2007).
fn coordinate_descent(map: &DMatrix<f64>, d: &DVector<f64>, slope: &DVector<f64>) -> DVector<f64> {
    let (gram, pull) = (map.tr_mul(map), map.tr_mul(d));
    let mut a = DVector::zeros(map.ncols());
    for _ in 0..2_000_000 {
        let mut change = 0_f64;
        for k in 0..a.len() {
            let rest = pull[k] - gram.column(k).dot(&a) + gram[(k, k)] * a[k];
            let next = f64::clamp((rest - slope[k]) / gram[(k, k)], 0., 1.);
            change = change.max((next - a[k]).abs());
            a[k] = next;
        }
        if change < 1e-15 {
            break;
        }
    }
    a
}

fn coarse() -> (Face, Vec<String>) {
    let face = standard(&Resolution::COARSE);
    let names = face.muscles.iter().map(|m| m.name.clone()).collect();
    (face, names)
}

fn shipped(name: &str, names: &[String]) -> Target {
    let file = Path::new(env!("CARGO_MANIFEST_DIR")).join("targets").join(name);
    read_target(&file).unwrap().expand_patterns(names).unwrap().target
}

/// The shipped smile's markers alone, without limits.
fn smile(names: &[String]) -> Target {
    let own = shipped("symmetric_smile.toml", names);
    Target { markers: own.markers, ..Target::default() }
}

#[test]
fn agrees_with_coordinate_descent_on_a_face() {
    let (face, names) = coarse();
    let model = Model::new(&face, Vec::new()).unwrap();
    for (effort, effort_by) in [(30., EffortMeasure::Activation), (30., EffortMeasure::Force)] {
        let wish = Target { effort_by, ..sparse(smile(&names), effort) };
        let observed = Observations::resolve(&wish, &face, |_| Err(f64::INFINITY)).unwrap();
        let response = model.at(&vec![0.5; names.len()]).unwrap().response(&observed.sites);
        let solution = solve(&wish, &observed, &response);
        assert_eq!(solution.status, Status::Solved, "{:?}", solution.warnings);
        let (mut rows, mut values) = (Vec::new(), Vec::new());
        for (marker, &point) in wish.markers.iter().zip(&observed.markers) {
            let Goal::Displacement(d) = marker.goal else { unreachable!("the smile states displacements") };
            for (axis, value) in d.iter().enumerate().filter_map(|(axis, d)| Some((axis, (*d)?))) {
                rows.push(response.map.row(3 * point + axis) / marker.sigma_mm);
                values.push(value / marker.sigma_mm);
            }
        }
        let forces: Vec<f64> = face.muscles.iter().map(|m| m.max_force_n).collect();
        let mean = forces.iter().sum::<f64>() / forces.len() as f64;
        let slope = DVector::from_fn(names.len(), |k, _| match effort_by {
            EffortMeasure::Force => effort * forces[k] / mean,
            _ => effort,
        });
        let other =
            coordinate_descent(&DMatrix::from_rows(&rows), &DVector::from_column_slice(&values), &slope);
        let off = (activations(&solution) - &other).amax();
        let active = acting(&solution.activations.values);
        println!("{effort_by:?}: {active} of {} act, {off:.1e} off", names.len());
        assert!(off < 1e-7, "{off:e}");
        assert!(active > 2 && active < names.len() / 2);
        assert!(solution.activations.values.iter().all(|a| *a == 0. || *a > 1e-9), "exactly zero or not");
    }
}

/// The terms' own objective and that of the program, with unequal costs.
#[test]
fn the_program_is_the_objective() {
    let mut random = Random(72);
    let response = Body::random(&mut random, 15, 5, 3, 0).response();
    let mut observed = observations(&mut random, 3);
    observed.cost = vec![0.5, 2., 1., 0., 1.5];
    let wish = sparse(target(&random.vector(9), 0.6), 3.);
    let problem = Problem::new(&wish, &observed, &response).unwrap();
    let program = problem.build(ContactMode::Off, &[], &problem.rest()).problem;
    for _ in 0..10 {
        let a = random.vector(5);
        let seen = &response.map * &a;
        let d = wish.markers.iter().flat_map(|m| match m.goal {
            Goal::Displacement(d) | Goal::Position(d) => d.map(|d| d.unwrap()),
        });
        let misfit: f64 = seen.iter().zip(d).map(|(u, d)| ((u - d) / 0.6).powi(2)).sum();
        let value = 0.5 * misfit + 3. * (0.5 * a[0] + 2. * a[1] + a[2] + 1.5 * a[4]);
        let state = State { observed: seen, activation: a.clone() };
        let terms = objective(problem.terms(), &state);
        assert!((terms - value).abs() < 1e-10 * value.abs().max(1.), "{terms} {value}");
        assert!((program.objective(&a) - value).abs() < 1e-10 * value.abs().max(1.));
        let linearised = problem.linearise(&problem.rest()).objective(&state);
        assert!((linearised - value).abs() < 1e-10 * value.abs().max(1.));
    }
}

/// At an optimum of `value` over [0, 1], its slopes by central differences of half width `h` vanish, or push outward.
fn assert_optimal(value: impl Fn(&[f64]) -> f64, a: &[f64], h: f64, tolerance: f64) {
    let mut held = 0;
    for k in 0..a.len() {
        let moved = |by: f64| {
            let mut b = a.to_vec();
            b[k] += by;
            value(&b)
        };
        // One side alone where the other is no activation; of second order all the same.
        let slope = if a[k] < h {
            (4. * moved(h) - moved(2. * h) - 3. * value(a)) / (2. * h)
        } else if a[k] > 1. - h {
            (3. * value(a) - 4. * moved(-h) + moved(-2. * h)) / (2. * h)
        } else {
            (moved(h) - moved(-h)) / (2. * h)
        };
        let wrong = match a[k] {
            0. => (-slope).max(0.),
            1. => slope.max(0.),
            _ => slope.abs(),
        };
        held += usize::from(a[k] == 0. && slope > tolerance);
        assert!(wrong <= tolerance, "muscle {k} at {}: slope {slope}", a[k]);
    }
    assert!(held > 0, "the effort holds a muscle at zero: {a:?}");
}

fn markers(face: &Face, observed: &[f64], sigma_mm: f64) -> Target {
    let of = |(landmark, d): (&modiolus::face::Landmark, &[f64])| Marker {
        name: landmark.name.clone(),
        at: Place::Landmark(landmark.name.clone()),
        goal: Goal::Displacement([Some(d[0]), Some(d[1]), Some(d[2])]),
        sigma_mm,
    };
    let markers = face.landmarks.iter().zip(observed.chunks_exact(3)).map(of).collect();
    Target { markers, ..Target::default() }
}

#[test]
fn no_activation_has_a_slope_left_with_stiffening_and_contact() {
    let face = block_face([10, 8, 4]);
    let sites: Vec<Site> = face.landmarks.iter().map(|l| l.site.clone()).collect();
    for contact in [false, true] {
        let pairs = if contact { front_pairs(&face, 0.01) } else { Vec::new() };
        let model = Model::new(&face, pairs).unwrap();
        let mode = if contact { ContactMode::Reactions } else { ContactMode::Off };
        let at_rest = |a: &[f64]| {
            let stiff = model.at(a).unwrap();
            let response = stiff.response(&sites);
            let equilibrium = stiff.equilibrium(response.contact.as_ref()).unwrap();
            let seen: Vec<f64> = sites
                .iter()
                .flat_map(|site| {
                    let u = site.displacement(&equilibrium.displacement);
                    [u.x, u.y, u.z]
                })
                .collect();
            (seen, equilibrium.contact_forces)
        };
        let (wanted, pressed) = at_rest(&[0.6, 0.15, 0.5]);
        assert_eq!(contact, pressed.iter().any(|f| *f > 0.));
        let (sigma, effort) = (0.05, 120.);
        let wish = sparse(markers(&face, &wanted, sigma), effort);
        let observed = Observations::resolve(&wish, &face, |_| Err(0.)).unwrap();
        let problem = ActivatedProblem::new(&model, &wish, &observed, mode);
        let mut answers: Vec<Vec<f64>> = Vec::new();
        for start in [0., 0.5, 1.] {
            let found = problem.solve(DVector::from_element(3, start), |_| {}).unwrap();
            let solution = found.solution;
            assert_eq!(solution.status, Status::Solved, "{contact} {start}: {:?}", solution.warnings);
            assert!(solution.certificate.worst() <= 1e-8);
            answers.push(solution.activations.values);
        }
        let a = &answers[0];
        println!("contact {contact}: {a:?}, pressing {}", at_rest(a).1.iter().filter(|f| **f > 0.).count());
        assert!(answers.iter().all(|b| a.iter().zip(b).all(|(a, b)| (a - b).abs() < 1e-6)), "{answers:?}");
        assert_eq!(contact, at_rest(a).1.iter().any(|f| *f > 0.));
        let value = |a: &[f64]| {
            let misfit: f64 = at_rest(a).0.iter().zip(&wanted).map(|(u, d)| ((u - d) / sigma).powi(2)).sum();
            0.5 * misfit + effort * a.iter().sum::<f64>()
        };
        assert_optimal(value, a, 1e-4, 1e-4 * effort);
    }
}

/// At the misfit that the sparse effort leaves, the squared one has more muscles act, whatever the weight.
#[test]
fn fewer_muscles_act_at_an_equal_misfit() {
    let (face, names) = coarse();
    let model = Model::new(&face, Vec::new()).unwrap();
    let wish = smile(&names);
    let observed = Observations::resolve(&wish, &face, |_| Err(f64::INFINITY)).unwrap();
    let response = model.at(&vec![0.5; names.len()]).unwrap().response(&observed.sites);
    let misfit = |solution: &Solution, own: f64| solution.objective - own;
    for weight in [10., 30.] {
        let few = solve(&sparse(wish.clone(), weight), &observed, &response);
        let goal = misfit(&few, weight * few.activations.values.iter().sum::<f64>());
        let squared = |power: f64| {
            let effort = 10_f64.powf(power);
            let found = solve(&Target { effort, ..wish.clone() }, &observed, &response);
            let own = 0.5 * effort * found.activations.values.iter().map(|a| a * a).sum::<f64>();
            (misfit(&found, own), found)
        };
        let (mut low, mut high) = (-3., 5.);
        for _ in 0..50 {
            let middle = 0.5 * (low + high);
            if squared(middle).0 < goal { low = middle } else { high = middle }
        }
        let (reached, many) = squared(low);
        assert!((reached / goal - 1.).abs() < 1e-6, "{reached} {goal}");
        let [few, many] = [&few, &many].map(|s| acting(&s.activations.values));
        println!(
            "weight {weight}: misfit {goal:.2}, {few} of {} muscles act, {many} with squares",
            names.len()
        );
        assert!(few + 4 <= many, "{few} {many}");
    }
}

/// The loop at finite strain ends at an optimum of the objective itself.
#[test]
fn no_slope_is_left_at_finite_strain() {
    let (face, names) = coarse();
    let model = FiniteModel::new(&face, None).unwrap();
    let stems = ["zygomaticus_major", "levator_labii_superioris_l", "depressor_anguli"];
    let made: Vec<f64> = names
        .iter()
        .map(|name| if stems.iter().any(|stem| name.starts_with(stem)) { 0.3 } else { 0. })
        .collect();
    let rest = model.settle(&made, &Pose::rest()).unwrap();
    let seen: Vec<f64> = face
        .landmarks
        .iter()
        .flat_map(|l| {
            let u = l.site.displacement(rest.displacement());
            [u.x, u.y, u.z]
        })
        .collect();
    let (sigma, effort) = (0.3, 2.);
    let wish = sparse(markers(&face, &seen, sigma), effort);
    let observed = Observations::resolve(&wish, &face, |_| Err(f64::INFINITY)).unwrap();
    let fit = FiniteFit { model: &model, target: &wish, observations: &observed };
    let answer = fit.solve(&DVector::from_element(names.len(), 0.1), |_| {}).unwrap();
    assert_eq!(answer.solution.status, Status::Solved, "{:?}", answer.solution.warnings);
    let a = &answer.solution.activations.values;
    println!("{} of {} act in {} steps", acting(a), names.len(), answer.history.len());
    assert!(acting(a) <= 12, "{a:?}");
    let value = |a: &[f64]| {
        let state = model.settle(a, &Pose::rest()).unwrap();
        let moved = face.landmarks.iter().flat_map(|l| {
            let u = l.site.displacement(state.displacement());
            [u.x, u.y, u.z]
        });
        let misfit: f64 = moved.zip(&seen).map(|(u, d)| ((u - d) / sigma).powi(2)).sum();
        0.5 * misfit + effort * a.iter().sum::<f64>()
    };
    // Of the muscles that act, and of as many that do not.
    let held = (0..a.len()).filter(|&k| a[k] == 0.).take(4);
    for k in (0..a.len()).filter(|&k| a[k] > 0.).chain(held) {
        let h = 1e-3;
        let moved = |by: f64| {
            let mut b = a.clone();
            b[k] += by;
            value(&b)
        };
        let slope = match a[k] < h {
            true => (4. * moved(h) - moved(2. * h) - 3. * value(a)) / (2. * h),
            false => (moved(h) - moved(-h)) / (2. * h),
        };
        let wrong = if a[k] == 0. { (-slope).max(0.) } else { slope.abs() };
        assert!(wrong < 1e-2 * effort, "{} at {}: {slope}", names[k], a[k]);
    }
}

/// Where the effort does not decide, the answer says so and names who trades; where it decides, fewer components than
/// muscles are no obstacle.
#[test]
fn equal_columns_are_told_as_undecided() {
    let mut random = Random(73);
    let map = DMatrix::from_row_slice(3, 3, &[10., 10., 0., 0., 0., 5., 0., 0., 0.]);
    let response = mapped(map);
    let mut observed = observations(&mut random, 1);
    let wish = sparse(target(&DVector::from_vec(vec![5., 2., 0.]), 0.5), 1.);
    let found = solve(&wish, &observed, &response);
    assert_eq!(found.status, Status::Underdetermined);
    let told = Warning::Undecided { muscles: vec!["muscle_0".into(), "muscle_1".into()] };
    assert!(found.warnings.contains(&told), "{:?}", found.warnings);
    // Ties, bounds, costs and data decide.
    let decides = |change: &dyn Fn(&mut Target, &mut Observations), expected: [f64; 2]| {
        let (mut wish, mut observed) = (wish.clone(), observed.clone());
        change(&mut wish, &mut observed);
        let found = solve(&wish, &observed, &response);
        assert_eq!(found.status, Status::Solved, "{:?}", found.warnings);
        for (a, expected) in found.activations.values.iter().zip(expected) {
            assert!((a - expected).abs() < 1e-9, "{:?}", found.activations.values);
        }
    };
    // 0.5 of what the marker asks for, less 1 x 0.25 / 100 by soft thresholding.
    let sum = 0.4975;
    decides(&|t, _| t.tied = vec![["muscle_0".into(), "muscle_1".into()]], [sum / 2., sum / 2.]);
    decides(&|t, _| t.bounds = vec![Bound { muscle: "muscle_1".into(), min: 0., max: 0. }], [sum, 0.]);
    decides(&|t, _| t.costs = vec![MuscleCost { muscle: "muscle_0".into(), factor: 2. }], [0., sum]);
    decides(&|t, _| t.effort_norm = EffortNorm::L2, [0.5 / (2. + 1. / 400.), 0.5 / (2. + 1. / 400.)]);
    observed.cost = vec![1., 1.1, 1.];
    assert_eq!(solve(&wish, &observed, &response).status, Status::Solved);
    // The cheaper of the two closes a gap that must stay open, and the dearer does the rest: the gap decides.
    let contact = ContactResponse {
        kinds: vec![PairKind::UpperTeeth],
        gap: DVector::from_element(1, 0.3),
        approach: DMatrix::from_row_slice(1, 3, &[-1., 0., 0.]),
        compliance: DMatrix::from_element(1, 1, 1.),
        reach: DMatrix::zeros(3, 1),
    };
    let walled = Response { contact: Some(contact), ..response.clone() };
    observed.cost = vec![1., 2., 1.];
    let found = Problem::new(&wish, &observed, &walled).unwrap().solve(ContactMode::Kinematic).unwrap();
    assert_eq!(found.status, Status::Solved, "{:?}", found.warnings);
    for (a, expected) in found.activations.values.iter().zip([0.3, 0.195]) {
        assert!((a - expected).abs() < 1e-9, "{:?}", found.activations.values);
    }
    // Three components and nine muscles in general position.
    let response = mapped(random.matrix(3, 9));
    let observed = observations(&mut random, 1);
    let wish = target(&DVector::from_vec(vec![1., -0.5, 0.8]), 0.2);
    assert_eq!(solve(&wish, &observed, &response).status, Status::Underdetermined);
    let found = solve(&sparse(wish, 0.5), &observed, &response);
    assert_eq!(found.status, Status::Solved, "{:?}", found.warnings);
    assert!(acting(&found.activations.values) <= 3);
}

/// A preference tells nothing about the face: what the data determine is the same whatever the effort.
#[test]
fn the_posterior_knows_no_effort() {
    let mut random = Random(74);
    let (m, points) = (6, 5);
    let response = Body::random(&mut random, 24, m, points, 0).response();
    let observed = observations(&mut random, points);
    let truth = DVector::from_fn(m, |_, _| random.unit());
    let d = &response.map * truth + random.vector(3 * points) * 0.2;
    let of = |wish: Target| {
        let solution = solve(&wish, &observed, &response);
        let program = solution.program.clone().unwrap();
        (Certainty::of(&program, Discrepancy::NONE).unwrap(), solution)
    };
    let wish = target(&d, 0.2);
    let (linear, _) = of(sparse(wish.clone(), 2.));
    let (squared, _) = of(Target { effort: 2., ..wish });
    for (a, b) in linear.unknowns.iter().zip(&squared.unknowns) {
        assert!((a.mean - b.mean).abs() < 1e-9 && (a.sd - b.sd).abs() < 1e-9, "{a:?} {b:?}");
        assert!((a.min - b.min).abs() < 1e-6 || a.min == a.value || b.min == b.value, "{a:?} {b:?}");
    }
}

/// The rules for the weight are those of the same effort: the discrepancy reaches the noise with the target's own solver, and
/// the misfit grows with the weight while the effort falls.
#[test]
fn the_weight_follows_the_noise() {
    let mut random = Random(75);
    let (m, points) = (8, 6);
    let response = Body::random(&mut random, 24, m, points, 0).response();
    let mut observed = observations(&mut random, points);
    observed.cost = (0..m).map(|_| 0.5 + random.unit()).collect();
    let truth = DVector::from_fn(m, |k, _| if k < 3 { 0.3 + 0.4 * random.unit() } else { 0. });
    let d = &response.map * truth + random.vector(3 * points) * 0.2;
    let weighed = |effort: f64| {
        let solution = solve(&sparse(target(&d, 0.2), effort), &observed, &response);
        let program = solution.program.clone().unwrap();
        (Certainty::of(&program, Discrepancy::NONE).unwrap().effort.unwrap(), solution)
    };
    let (choice, _) = weighed(1.);
    assert_eq!(choice.norm, EffortNorm::L1);
    for pair in choice.curve.windows(2) {
        assert!(
            pair[1].misfit >= pair[0].misfit - 1e-9 && pair[1].effort <= pair[0].effort + 1e-9,
            "{pair:?}"
        );
    }
    let misfit = |solution: &Solution| {
        solution.markers.iter().map(|f| f.residual_mm.unwrap().powi(2)).sum::<f64>() / 0.04
    };
    if let Some(weight) = choice.discrepancy {
        let reached = misfit(&weighed(weight).1) / (3 * points) as f64;
        assert!((reached - 1.).abs() < 0.01, "{reached}");
    }
    let least = choice.curve.iter().map(|p| p.cross_validation).fold(f64::INFINITY, f64::min);
    let best = choice.curve.iter().find(|p| p.cross_validation == least).unwrap();
    assert_eq!(choice.cross_validation, best.weight);
    // By the formula, from the target's own solver.
    let (_, solution) = weighed(best.weight);
    let (n, used) = ((3 * points) as f64, acting(&solution.activations.values) as f64);
    let by_hand = n * misfit(&solution) / (n - used).powi(2);
    assert!((least / by_hand - 1.).abs() < 1e-6, "{least} {by_hand}");
    let cost: f64 = solution.activations.values.iter().zip(&observed.cost).map(|(a, c)| a * c).sum();
    assert!((best.effort - cost).abs() < 1e-7 * cost.max(1.), "{} {cost}", best.effort);
}

/// Of the coarse face: a sum of forces costs a muscle its force, and not its square.
#[test]
fn costs_by_force_are_of_the_first_power() {
    let (face, _) = coarse();
    let cost = |effort_by, effort_norm| {
        let target = Target { effort: 1., effort_by, effort_norm, ..Target::default() };
        Observations::resolve(&target, &face, |_| Err(0.)).unwrap().cost
    };
    let [a, b] = ["zygomaticus_major_l", "risorius_l"].map(|name| face.muscle_index(name).unwrap());
    let by = face.muscles[a].max_force_n / face.muscles[b].max_force_n;
    let force = cost(EffortMeasure::Force, EffortNorm::L1);
    assert!((force[a] / force[b] - by).abs() < 1e-9);
    assert!((force.iter().sum::<f64>() / force.len() as f64 - 1.).abs() < 1e-12);
    assert_eq!(cost(EffortMeasure::Volume, EffortNorm::L1), cost(EffortMeasure::Volume, EffortNorm::L2));
}
