//! Contact in the inverse: local answers against every contact state tried, bounds, invariances, and
//! contacts that repeat each other.

#![allow(clippy::unwrap_used)] // A test that unwraps fails where it should.

use crate::common::Random;
use crate::common::faces::{Body, names, observations, seen, target};
use modiolus::contact::PairKind;
use modiolus::face::ContactReach;
use modiolus::face::standard::{Resolution, standard};
use modiolus::forward::{ContactResponse, Model, Response, Touching, contact_forces};
use modiolus::inverse::{ContactMode, Observations, Problem, RelaxationEnd, Solution, Status};
use modiolus::io::read_target;
use modiolus::mesh::Locator;
use modiolus::qp::{self, Answer};
use nalgebra::{DMatrix, DVector};

/// Largest violation of `0 <= lambda _|_ g >= 0`, in mm and N.
fn complementarity(contact: &ContactResponse, a: &DVector<f64>, force: &DVector<f64>) -> f64 {
    let gap = &contact.gap + &contact.approach * a + &contact.compliance * force;
    (0..gap.len()).map(|i| (-gap[i]).max(-force[i]).max(gap[i].min(force[i]))).fold(0.0, f64::max)
}

fn activations(solution: &Solution) -> DVector<f64> {
    DVector::from_vec(solution.activations.values.clone())
}

/// Least `1/2 |(u - d) / sigma|^2 + w/2 |a|^2` on one contact state, from matrices written here:
/// unknowns (a, lambda) with `keep` saying which contacts may push, and `zero` which gaps are closed.
fn on_state(
    response: &Response,
    d: &DVector<f64>,
    effort: f64,
    keep: &dyn Fn(usize) -> bool,
    zero: &dyn Fn(usize) -> bool,
) -> Option<f64> {
    let contact = response.contact.as_ref().unwrap();
    let (m, c) = (response.map.ncols(), contact.gap.len());
    let mut j = DMatrix::zeros(d.len() + m, m + c);
    j.view_mut((0, 0), (d.len(), m)).copy_from(&response.map);
    j.view_mut((0, m), (d.len(), c)).copy_from(&contact.reach);
    for k in 0..m {
        j[(d.len() + k, k)] = effort.sqrt();
    }
    let mut r = DVector::zeros(d.len() + m);
    r.rows_mut(0, d.len()).copy_from(&-d);
    let mut problem = qp::Problem::unconstrained(j.tr_mul(&j), j.tr_mul(&r));
    problem.constant = 0.5 * r.norm_squared();
    problem.lower.fill(0.0);
    problem.upper.rows_mut(0, m).fill(1.0);
    let mut gaps = DMatrix::zeros(c, m + c);
    gaps.columns_mut(0, m).copy_from(&contact.approach);
    gaps.columns_mut(m, c).copy_from(&contact.compliance);
    problem.inequality = -&gaps;
    problem.inequality_limit = contact.gap.clone();
    let closed: Vec<usize> = (0..c).filter(|&i| zero(i)).collect();
    problem.equality = gaps.select_rows(&closed);
    problem.equality_value = -contact.gap.select_rows(&closed);
    for i in 0..c {
        if !keep(i) {
            problem.upper[m + i] = 0.0;
        }
    }
    match qp::solve(&problem).unwrap() {
        Answer::Solved(solution) => Some(solution.objective),
        Answer::Infeasible(_) => None,
        other => panic!("{other:?}"),
    }
}

fn global(response: &Response, d: &DVector<f64>, effort: f64) -> f64 {
    let c = response.contact.as_ref().unwrap().gap.len();
    (0..1_usize << c)
        .filter_map(|state| {
            let closed = |i: usize| state >> i & 1 == 1;
            on_state(response, d, effort, &closed, &closed)
        })
        .fold(f64::INFINITY, f64::min)
}

/// A body whose contacts are met, with a target that an activation made, plus noise.
fn pressing(random: &mut Random, c: usize) -> (Response, DVector<f64>) {
    let m = 2 + random.below(5);
    let points = 1 + random.below(4);
    let response = Body::random(random, 12, m, points, c).response();
    let d = seen(random, &response, 0.5);
    (response, d)
}

#[test]
fn local_answers_lie_between_the_global_one_and_nothing_below_the_relaxation() {
    let mut random = Random(31);
    let (mut reached, mut touched, trials) = (0, 0, 150);
    for trial in 0..trials {
        let c = 1 + random.below(6);
        let (response, d) = pressing(&mut random, c);
        let observed = observations(&mut random, d.len() / 3);
        let mut wish = target(&d, 1.0);
        wish.effort = 1e-3;
        let problem = Problem::new(&wish, &observed, &response).unwrap();
        let solution = problem.solve(ContactMode::Reactions).unwrap();
        assert_eq!(solution.status, Status::Solved, "trial {trial}: {:?}", solution.certificate);
        let contact = response.contact.as_ref().unwrap();
        let violation = complementarity(contact, &activations(&solution), &solution.contact_forces);
        assert!(violation < 1e-9, "trial {trial}: {violation:e}");
        let best = global(&response, &d, wish.effort);
        assert!(solution.objective >= best - 1e-9 * best, "trial {trial}: better than every state");
        let relaxed = solution.objective - solution.contact.relaxation_gap;
        assert!(relaxed <= best + 1e-9 * (1.0 + best), "trial {trial}: {relaxed} above {best}");
        // Before any contact is split the bound is that without complementarity; splitting only raises it.
        let bound = on_state(&response, &d, wish.effort, &|_| true, &|_| false).unwrap();
        assert!(relaxed >= bound - 1e-8 * (1.0 + bound), "trial {trial}: {relaxed} below {bound}");
        reached += usize::from(solution.objective <= best + 1e-8 * (1.0 + best));
        touched += usize::from(solution.contact.active > 0);
    }
    eprintln!("global optimum reached in {reached} of {trials}; contact forces in {touched}");
    assert!(touched > trials / 2);
    assert!(reached >= trials * 9 / 10, "{reached}");
}

#[test]
fn a_thousand_small_problems_against_every_contact_state() {
    let mut random = Random(131);
    let (mut before, mut excess, mut touched, mut nodes, trials) = (0, 0.0_f64, 0, 0, 1000);
    for trial in 0..trials {
        let c = 1 + random.below(8);
        let (response, d) = pressing(&mut random, c);
        let observed = observations(&mut random, d.len() / 3);
        let mut wish = target(&d, 1.0);
        wish.effort = 1e-3;
        let problem = Problem::new(&wish, &observed, &response).unwrap();
        let solution = problem.solve(ContactMode::Reactions).unwrap();
        assert_eq!(solution.status, Status::Solved, "trial {trial}: {:?}", solution.certificate);
        let best = global(&response, &d, wish.effort);
        let above = solution.objective / best - 1.0;
        assert!(above.abs() <= 1e-6, "trial {trial}: {above:e} above the best of every state");
        assert_eq!(solution.contact.relaxation_end, Some(RelaxationEnd::Closed), "trial {trial}");
        let tolerance = 1e-6 * best + 1e-10 * 0.5 * d.norm_squared();
        assert!(solution.contact.relaxation_gap <= 1.01 * tolerance, "trial {trial}: {:?}", solution.contact);
        let local = (solution.objective + solution.contact.branching_gain) / best - 1.0;
        before += usize::from(local <= 1e-6);
        excess = excess.max(local);
        nodes += solution.contact.relaxation_nodes;
        touched += usize::from(solution.contact.active > 0);
    }
    eprintln!(
        "{before} of {trials} are global optima before branching, the others up to {excess:.3} above; all of them \
         after {nodes} relaxations; {touched} touch"
    );
    assert!(touched > trials * 7 / 10, "{touched}");
}

#[test]
fn forces_of_given_activations_are_complementary_and_those_of_the_program() {
    let mut random = Random(32);
    for trial in 0..100 {
        let c = 1 + random.below(30);
        let dofs = 6 + random.below(40);
        // Fewer unknowns than contacts in some trials: singular compliance.
        let body = Body::random(&mut random, dofs, 3, 1, c);
        let response = body.response();
        let contact = response.contact.as_ref().unwrap();
        let a = DVector::from_fn(3, |_, _| random.unit());
        let force = contact_forces(contact, &a).unwrap();
        let violation = complementarity(contact, &a, &force);
        assert!(violation < 1e-8, "trial {trial}: {violation:e}");
        let mut problem =
            qp::Problem::unconstrained(contact.compliance.clone(), &contact.gap + &contact.approach * &a);
        problem.lower.fill(0.0);
        let Answer::Solved(oracle) = qp::solve(&problem).unwrap() else { panic!("trial {trial}") };
        let effect = &contact.compliance * (force - oracle.point.x);
        assert!(effect.amax() < 1e-7, "trial {trial}: {:e}", effect.amax());
    }
}

#[test]
fn forces_of_touching_contacts_close_their_gaps() {
    let mut random = Random(38);
    let factor = random.matrix(4, 6);
    // Rank 4: at most four of six contacts are independent.
    let compliance = factor.tr_mul(&factor);
    let free_gap = random.vector(6);
    let touching = Touching::new(&compliance, [5, 0, 3, 1, 2, 4]);
    assert_eq!(touching.contacts(), [5, 0, 3, 1]);
    let gap = &free_gap + &compliance * touching.forces(&free_gap);
    assert!(touching.contacts().iter().all(|&i| gap[i].abs() < 1e-10));
}

#[test]
fn a_touching_set_changed_by_one_contact_at_a_time_is_the_one_built_anew() {
    let mut random = Random(39);
    let factor = random.matrix(14, 12);
    let compliance = factor.tr_mul(&factor);
    let free_gap = random.vector(12);
    let mut touching = Touching::new(&compliance, 0..9);
    for contact in [0, 8, 4, 5] {
        touching.drop(contact);
    }
    assert!([11, 4, 9].iter().all(|&i| touching.add(&compliance, i)) && !touching.add(&compliance, 4));
    assert_eq!(touching.contacts(), [1, 2, 3, 6, 7, 11, 4, 9]);
    let anew = Touching::new(&compliance, touching.contacts().iter().copied());
    let difference = (touching.forces(&free_gap) - anew.forces(&free_gap)).amax();
    assert!(difference < 1e-10 * anew.forces(&free_gap).amax(), "{difference:e}");
}

/// The same response with contact `i` at every position of `which`.
fn with_contacts(response: &Response, which: &[usize]) -> Response {
    let contact = response.contact.as_ref().unwrap();
    let mut repeated = response.clone();
    repeated.contact = Some(ContactResponse {
        kinds: which.iter().map(|&i| contact.kinds[i]).collect(),
        gap: contact.gap.select_rows(which),
        approach: contact.approach.select_rows(which),
        compliance: contact.compliance.select_rows(which).select_columns(which),
        reach: contact.reach.select_columns(which),
    });
    repeated
}

#[test]
fn repeated_contacts_change_nothing() {
    let mut random = Random(33);
    for trial in 0..60 {
        let c = 1 + random.below(5);
        let (response, d) = pressing(&mut random, c);
        let observed = observations(&mut random, d.len() / 3);
        let mut wish = target(&d, 1.0);
        wish.effort = 1e-3;
        let solve = |response: &Response| {
            let solution =
                Problem::new(&wish, &observed, response).unwrap().solve(ContactMode::Reactions).unwrap();
            assert_eq!(solution.status, Status::Solved, "trial {trial}: {:?}", solution.certificate);
            solution
        };
        let once = solve(&response);
        let which: Vec<usize> = (0..c).chain(0..c).chain([0]).collect();
        let repeated = solve(&with_contacts(&response, &which));
        let difference = (activations(&once) - activations(&repeated)).amax();
        assert!(difference < 1e-7, "trial {trial}: {difference:e}");
        assert!(
            (once.contact.force_n - repeated.contact.force_n).abs() < 1e-6 * (1.0 + once.contact.force_n)
        );
        let order = random.permutation(c);
        let permuted = solve(&with_contacts(&response, &order));
        let difference = (activations(&once) - activations(&permuted)).amax();
        assert!(difference < 1e-8, "trial {trial}: order of contacts: {difference:e}");
    }
}

#[test]
fn units_and_the_order_of_muscles_change_nothing() {
    let mut random = Random(34);
    for trial in 0..40 {
        let (response, d) = pressing(&mut random, 5);
        let observed = observations(&mut random, d.len() / 3);
        let solve = |response: &Response, d: &DVector<f64>, sigma: f64| {
            let mut wish = target(d, sigma);
            wish.effort = 1e-3;
            Problem::new(&wish, &observed, response).unwrap().solve(ContactMode::Reactions).unwrap()
        };
        let reference = solve(&response, &d, 1.0);
        for factor in [1e-3, 1e3] {
            let mut scaled = response.clone();
            scaled.map *= factor;
            let contact = scaled.contact.as_mut().unwrap();
            contact.gap *= factor;
            contact.approach *= factor;
            contact.compliance *= factor;
            contact.reach *= factor;
            let solution = solve(&scaled, &(&d * factor), factor);
            let difference = (activations(&reference) - activations(&solution)).amax();
            assert!(difference < 1e-8, "trial {trial}, lengths x {factor}: {difference:e}");
        }
        let order = random.permutation(response.muscles.len());
        let mut permuted = response.clone();
        permuted.muscles = order.iter().map(|&k| response.muscles[k].clone()).collect();
        permuted.map = response.map.select_columns(&order);
        let contact = permuted.contact.as_mut().unwrap();
        contact.approach = contact.approach.select_columns(&order);
        let solution = solve(&permuted, &d, 1.0);
        for (name, value) in reference.activations.names.iter().zip(&reference.activations.values) {
            let other = solution.activations.get(name).unwrap();
            assert!((value - other).abs() < 1e-8, "trial {trial}: {name} {value} {other}");
        }
    }
}

#[test]
fn a_symmetric_smile_on_the_standard_face_is_symmetric() {
    let face = standard(&Resolution::COARSE);
    let muscles: Vec<String> = face.muscles.iter().map(|m| m.name.clone()).collect();
    let path = std::path::Path::new(env!("CARGO_MANIFEST_DIR")).join("targets/symmetric_smile.toml");
    let wish = read_target(&path).unwrap().expand_patterns(&muscles).unwrap().target;
    let locator = Locator::new(&face.mesh);
    let observed = Observations::resolve(&wish, &face, |p| Ok(locator.locate(p).unwrap().site)).unwrap();
    let model = Model::new(&face, face.contact_pairs(ContactReach::default())).unwrap();
    let response = model.at(&vec![0.5; muscles.len()]).unwrap().response(&observed.sites);
    let solution = Problem::new(&wish, &observed, &response).unwrap().solve(ContactMode::Reactions).unwrap();
    assert_eq!(solution.status, Status::Solved);
    assert!(solution.contact.active > 20, "{:?}", solution.contact);
    for (name, value) in solution.activations.names.iter().zip(&solution.activations.values) {
        let Some(stem) = name.strip_suffix("_l") else { continue };
        let other = solution.activations.get(&format!("{stem}_r")).unwrap();
        assert!((value - other).abs() < 1e-9, "{name}: {value} {other}");
    }
}

#[test]
fn kinematic_contact_forbids_every_push() {
    let mut random = Random(35);
    let mut lost = 0;
    for _ in 0..40 {
        let (response, d) = pressing(&mut random, 6);
        let observed = observations(&mut random, d.len() / 3);
        let problem = Problem::new(&target(&d, 1.0), &observed, &response).unwrap();
        let kinematic = problem.solve(ContactMode::Kinematic).unwrap();
        // Some of these observe fewer components than there are activations.
        assert!(kinematic.status.is_optimum());
        let contact = response.contact.as_ref().unwrap();
        let gap = &contact.gap + &contact.approach * activations(&kinematic);
        assert!(gap.min() > -1e-9 && kinematic.contact_forces.is_empty());
        assert!(kinematic.contact.max_penetration_mm < 1e-9);
        // What it allows, reactions allow too.
        let reactions = problem.solve(ContactMode::Reactions).unwrap();
        assert!(reactions.objective <= kinematic.objective * (1.0 + 1e-9));
        lost += usize::from(reactions.objective < 0.99 * kinematic.objective);
        let off = problem.solve(ContactMode::Off).unwrap();
        assert!(off.objective <= kinematic.objective * (1.0 + 1e-9) && off.contact.pairs == 0);
    }
    assert!(lost > 10, "{lost}");
}

#[test]
fn a_contact_out_of_reach_changes_nothing() {
    let mut random = Random(36);
    let (mut response, d) = pressing(&mut random, 4);
    response.contact.as_mut().unwrap().gap.fill(1e3);
    let observed = observations(&mut random, d.len() / 3);
    let problem = Problem::new(&target(&d, 1.0), &observed, &response).unwrap();
    let (with, without) =
        (problem.solve(ContactMode::Reactions).unwrap(), problem.solve(ContactMode::Off).unwrap());
    assert!((activations(&with) - activations(&without)).amax() < 1e-12);
    assert_eq!((with.contact.pairs, with.contact.active, with.contact.force_n), (4, 0, 0.0));
    assert!(with.contact.relaxation_gap >= 0.0);
}

/// A sheet of 24 x 25 nodes on springs over a floor, pushed and pulled by `m` patches.
fn sheet(random: &mut Random, m: usize, points: usize) -> (Response, DVector<f64>) {
    let (rows, columns) = (24, 25);
    let n = rows * columns;
    let mut stiffness = DMatrix::<f64>::identity(n, n) * 0.02;
    for r in 0..rows {
        for c in 0..columns {
            let i = r * columns + c;
            let mut join = |j: usize| {
                stiffness[(i, i)] += 1.0;
                stiffness[(j, j)] += 1.0;
                stiffness[(i, j)] -= 1.0;
                stiffness[(j, i)] -= 1.0;
            };
            if r + 1 < rows {
                join(i + columns);
            }
            if c + 1 < columns {
                join(i + 1);
            }
        }
    }
    let inverse = stiffness.cholesky().unwrap().inverse();
    let patches = DMatrix::from_fn(n, m, |_, _| 0.0);
    let forces = (0..m).fold(patches, |mut forces, k| {
        let (r0, c0) = (random.within(0.0, 24.0), random.within(0.0, 25.0));
        let strength = random.normal() * 0.4;
        for i in 0..n {
            let (dr, dc) = ((i / columns) as f64 - r0, (i % columns) as f64 - c0);
            forces[(i, k)] = strength * (-(dr * dr + dc * dc) / 18.0).exp();
        }
        forces
    });
    let mut observe = DMatrix::zeros(3 * points, n);
    for row in 0..3 * points {
        observe[(row, random.below(n))] = 1.0;
    }
    let body = Body {
        normals: DMatrix::identity(n, n),
        gap: DVector::from_fn(n, |_, _| if random.below(2) == 0 { 0.0 } else { 0.3 * random.unit() }),
        inverse,
        forces,
        observe,
    };
    let response = body.response();
    let d = seen(random, &response, 0.1);
    (response, d)
}

#[test]
fn six_hundred_contacts() {
    let mut random = Random(37);
    for effort in [1e-2, 0.0] {
        let (response, d) = sheet(&mut random, 25, 14);
        let observed = observations(&mut random, d.len() / 3);
        let mut wish = target(&d, 0.1);
        wish.effort = effort;
        let problem = Problem::new(&wish, &observed, &response).unwrap();
        let started = std::time::Instant::now();
        let solution = problem.solve(ContactMode::Reactions).unwrap();
        eprintln!(
            "{} contacts, {} with force, gap {:.3} of {:.3}, {:?}, {:.2} s",
            solution.contact.pairs,
            solution.contact.active,
            solution.contact.relaxation_gap,
            solution.objective,
            solution.certificate,
            started.elapsed().as_secs_f64()
        );
        assert_eq!(solution.status, Status::Solved);
        let contact = response.contact.as_ref().unwrap();
        let violation = complementarity(contact, &activations(&solution), &solution.contact_forces);
        assert!(violation < 1e-8, "{violation:e}");
        assert!(solution.contact.active > 30);
        assert_eq!(problem.solve(ContactMode::Reactions).unwrap(), solution, "the same twice");
    }
}

#[test]
fn one_spring_against_a_wall() {
    // u = a + lambda, g = 1/2 - a + lambda >= 0 pushes back once a > 1/2; the point follows u_x = a - lambda.
    let response = Response {
        jaw: None,
        muscles: names(1),
        map: DMatrix::from_column_slice(3, 1, &[1.0, 0.0, 0.0]),
        offset: DVector::zeros(3),
        contact: Some(ContactResponse {
            kinds: vec![PairKind::LowerTeeth],
            gap: DVector::from_element(1, 0.5),
            approach: DMatrix::from_element(1, 1, -1.0),
            compliance: DMatrix::from_element(1, 1, 1.0),
            reach: DMatrix::from_column_slice(3, 1, &[-1.0, 0.0, 0.0]),
        }),
    };
    let observed = observations(&mut Random(1), 1);
    let mut wish = target(&DVector::from_vec(vec![2.0, 0.0, 0.0]), 1.0);
    wish.bounds = vec![modiolus::inverse::Bound { muscle: "muscle_0".to_string(), min: 0.75, max: 1.0 }];
    let problem = Problem::new(&wish, &observed, &response).unwrap();
    let solution = problem.solve(ContactMode::Reactions).unwrap();
    assert_eq!(solution.status, Status::Solved);
    // However hard it pushes the wall holds it at 1/2; the force is what the activation exceeds.
    assert!((solution.observed_mm[0] - 0.5).abs() < 1e-12);
    let a = solution.activations.values[0];
    assert!((solution.contact.force_n - (a - 0.5)).abs() < 1e-12);
    assert_eq!(solution.contact.active, 1);
    // Without a push there is no such activation.
    let kinematic = problem.solve(ContactMode::Kinematic).unwrap();
    assert_eq!(kinematic.status, Status::Infeasible);
    assert!(kinematic.infeasible.is_some() && kinematic.activations.values.is_empty());
}
