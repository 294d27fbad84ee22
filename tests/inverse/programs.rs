//! The inverse without contact: recovery, oracles, gradients, invariances, limits, refusals and warnings.

#![allow(clippy::unwrap_used)] // A test that unwraps fails where it should.

use crate::common::Random;
use crate::common::faces::{Body, names, observations, target};
use modiolus::face::{Face, Landmark, Muscle, MuscleTissue, Tissue};
use modiolus::forward::Response;
use modiolus::inverse::{
    Axis, Bound, Component, ContactMode, Distance, Effort, EffortNorm, Feature, FeatureGoal, Goal, Marker,
    MarkerDisplacement, MarkerPosition, MirroredPair, MirroredPoints, Observations, Place, Problem, Solution,
    State, Status, Target, TargetError, Term, Warning, objective,
};
use modiolus::mesh::{Mesh, Site};
use modiolus::units::Vec3;
use nalgebra::{DMatrix, DVector};

fn activations(solution: &Solution) -> DVector<f64> {
    DVector::from_vec(solution.activations.values.clone())
}

fn solve(target: &Target, observed: &Observations, response: &Response) -> Solution {
    Problem::new(target, observed, response).unwrap().solve(ContactMode::Off).unwrap()
}

fn bound(k: usize, min: f64, max: f64) -> Bound {
    Bound { muscle: format!("muscle_{k}"), min, max }
}

fn mapped(map: DMatrix<f64>) -> Response {
    Response {
        muscles: names(map.ncols()),
        jaw: None,
        offset: DVector::zeros(map.nrows()),
        map,
        contact: None,
    }
}

#[test]
fn a_target_that_activations_made_gives_them_back() {
    let mut random = Random(41);
    for _ in 0..50 {
        let (m, points) = (1 + random.below(20), 7 + random.below(10));
        let response = Body::random(&mut random, 30, m, points, 0).response();
        let observed = observations(&mut random, points);
        let a = DVector::from_fn(m, |_, _| [0.0, 1.0, random.unit()][random.below(3)]);
        let solution = solve(&target(&(&response.map * &a), 0.5), &observed, &response);
        assert_eq!(solution.status, Status::Solved);
        assert!((activations(&solution) - a).amax() < 1e-9);
        assert!(solution.residual.max_mm < 1e-9 && solution.certificate.passes());
    }
}

#[test]
fn agrees_with_coordinate_descent() {
    let mut random = Random(42);
    for _ in 0..30 {
        let (m, points, sigma, effort) = (8, 6, 0.4, 0.3);
        let response = Body::random(&mut random, 20, m, points, 0).response();
        let observed = observations(&mut random, points);
        let d = random.vector(3 * points) * 2.0;
        let mut wish = target(&d, sigma);
        wish.effort = effort;
        let solution = solve(&wish, &observed, &response);
        let p = response.map.tr_mul(&response.map) / (sigma * sigma) + DMatrix::identity(m, m) * effort;
        let q = -response.map.tr_mul(&d) / (sigma * sigma);
        let mut x = DVector::zeros(m);
        for _ in 0..20_000 {
            for k in 0..m {
                let slope = p.row(k).transpose().dot(&x) + q[k];
                x[k] = f64::clamp(x[k] - slope / p[(k, k)], 0.0, 1.0);
            }
        }
        assert!((activations(&solution) - &x).amax() < 1e-9);
        let value = 0.5 * (&response.map * &x - &d).norm_squared() / (sigma * sigma)
            + 0.5 * effort * x.norm_squared();
        assert!((solution.objective - value).abs() < 1e-9 * value);
    }
}

/// Every term, on 3 points and 2 muscles.
fn every_term() -> Vec<Box<dyn Term>> {
    vec![
        Box::new(MarkerDisplacement { point: 1, target_mm: [Some(1.0), None, Some(-2.0)], sigma_mm: 0.3 }),
        Box::new(MarkerPosition {
            point: 0,
            rest_mm: Vec3::new(1.0, 2.0, 3.0),
            target_mm: [None, Some(4.0), Some(1.0)],
            sigma_mm: 0.7,
        }),
        Box::new(Component { from: 0, to: 2, axis: Axis::Y, rest_mm: 3.0, value_mm: 5.0, sigma_mm: 0.2 }),
        Box::new(Distance {
            from: 2,
            to: 1,
            rest_mm: Vec3::new(4.0, -1.0, 2.0),
            value_mm: 6.0,
            sigma_mm: 0.5,
        }),
        Box::new(MirroredPoints { left: 0, right: 2, sigma_mm: 0.9 }),
        Box::new(Effort::even(4, 0.4, EffortNorm::L2)),
    ]
}

#[test]
fn derivatives_of_every_term_match_central_differences() {
    let mut random = Random(43);
    for term in every_term() {
        for _ in 0..20 {
            let state = State { observed: random.vector(9), activation: random.vector(2) };
            let rows = term.rows(&state);
            assert!(!rows.is_empty());
            let h = 1e-5;
            for k in 0..11 {
                let shifted = |sign: f64| {
                    let mut state = state.clone();
                    if k < 9 {
                        state.observed[k] += sign * h;
                    } else {
                        state.activation[k - 9] += sign * h;
                    }
                    term.rows(&state)
                };
                for (row, (ahead, behind)) in rows.iter().zip(shifted(1.0).iter().zip(&shifted(-1.0))) {
                    let difference = (ahead.value - behind.value) / (2.0 * h);
                    let list = if k < 9 { &row.observed } else { &row.activation };
                    let index = if k < 9 { k } else { k - 9 };
                    let stated: f64 = list.iter().filter(|(i, _)| *i == index).map(|(_, w)| w).sum();
                    assert!((difference - stated).abs() < 1e-6, "{term:?}: {difference} {stated}");
                }
            }
        }
    }
}

#[test]
fn residuals_vanish_where_the_wish_is_met() {
    let mut random = Random(50);
    let mut observed = random.vector(9);
    let rest = Vec3::new(1.0, 2.0, 3.0);
    let there = rest + Vec3::new(observed[3], observed[4], observed[5]);
    // Point 2 moves as the mirror image of point 0.
    for (axis, mirror) in [-1.0, 1.0, 1.0].into_iter().enumerate() {
        observed[6 + axis] = mirror * observed[axis];
    }
    let state = State { observed, activation: DVector::zeros(2) };
    let met: [Box<dyn Term>; 2] = [
        Box::new(MirroredPoints { left: 0, right: 2, sigma_mm: 0.9 }),
        Box::new(MarkerPosition {
            point: 1,
            rest_mm: rest,
            target_mm: [Some(there.x), Some(there.y), Some(there.z)],
            sigma_mm: 0.1,
        }),
    ];
    for term in met {
        let rows = term.rows(&state);
        assert!(rows.len() == 3 && rows.iter().all(|row| row.value.abs() < 1e-13), "{term:?}");
    }
}

/// A target with every sort of term on three points, and its response.
fn everything(random: &mut Random) -> (Target, Observations, Response) {
    let response = Body::random(random, 15, 5, 3, 0).response();
    let mut observed = observations(random, 3);
    observed.features = vec![[0, 1], [1, 2]];
    observed.symmetry = vec![[0, 2]];
    let place = |k: usize| Place::Landmark(format!("landmark_{k}"));
    let mut wish = target(&(random.vector(9) * 2.0), 0.6);
    wish.markers[1].goal = Goal::Position([Some(observed.sites[1].position.x + 1.0), None, None]);
    wish.features = vec![
        Feature {
            name: "width".into(),
            from: place(0),
            to: place(1),
            axis: None,
            goal: FeatureGoal::Change(1.5),
            sigma_mm: 0.2,
        },
        Feature {
            name: "aperture".into(),
            from: place(1),
            to: place(2),
            axis: Some(Axis::Y),
            goal: FeatureGoal::Change(-1.0),
            sigma_mm: 0.3,
        },
    ];
    wish.symmetry = vec![MirroredPair { left: place(0), right: place(2), sigma_mm: 1.0 }];
    wish.effort = 0.05;
    (wish, observed, response)
}

#[test]
fn nonlinear_features_end_where_the_true_objective_is_stationary() {
    let mut random = Random(44);
    for trial in 0..40 {
        let (wish, observed, response) = everything(&mut random);
        let problem = Problem::new(&wish, &observed, &response).unwrap();
        let solution = problem.solve(ContactMode::Off).unwrap();
        assert_eq!(solution.status, Status::Solved, "trial {trial}: {:?}", solution.certificate);
        let value = |a: &DVector<f64>| {
            objective(problem.terms(), &State { observed: &response.map * a, activation: a.clone() })
        };
        let a = activations(&solution);
        assert!((value(&a) - solution.objective).abs() < 1e-12 * solution.objective);
        for k in 0..a.len() {
            let h = 1e-5;
            let (mut ahead, mut behind) = (a.clone(), a.clone());
            ahead[k] += h;
            behind[k] -= h;
            let slope = (value(&ahead) - value(&behind)) / (2.0 * h);
            // At a bound the objective may fall only outward.
            let pull = if a[k] == 0.0 {
                slope.min(0.0)
            } else if a[k] == 1.0 {
                slope.max(0.0)
            } else {
                slope
            };
            assert!(pull.abs() < 1e-5 * (1.0 + value(&a)), "trial {trial}: {pull}");
        }
    }
}

#[test]
fn the_program_is_the_objective() {
    let mut random = Random(45);
    let (mut wish, observed, response) = everything(&mut random);
    wish.features.remove(0);
    let mut observed = observed;
    observed.features.remove(0);
    let problem = Problem::new(&wish, &observed, &response).unwrap();
    let program = problem.build(ContactMode::Off, &[], &problem.rest()).problem;
    for _ in 0..10 {
        let a = random.vector(5);
        let state = State { observed: &response.map * &a, activation: a.clone() };
        let direct = objective(problem.terms(), &state);
        assert!((program.objective(&a) - direct).abs() < 1e-10 * direct);
    }
}

#[test]
fn mirrored_face_and_target_give_mirrored_activations() {
    // Points and muscles come in pairs (2k, 2k + 1); the mirror exchanges them and negates x.
    let mut random = Random(46);
    let (points, m) = (6, 8);
    let twin = |k: usize| k ^ 1;
    let flip = |v: &DVector<f64>| {
        DVector::from_fn(v.len(), |row, _| {
            (if row % 3 == 0 { -1.0 } else { 1.0 }) * v[3 * twin(row / 3) + row % 3]
        })
    };
    let plain = random.matrix(3 * points, m);
    let mut map = plain.clone();
    for k in 0..m {
        map.column_mut(k).copy_from(&(plain.column(k) + flip(&plain.column(twin(k)).into_owned())));
    }
    let response = mapped(map);
    let mut observed = observations(&mut random, points);
    observed.symmetry = vec![[0, 1], [2, 3]];
    let d = random.vector(3 * points) * 2.0;
    let pair = |l: usize| MirroredPair {
        left: Place::Landmark(format!("landmark_{l}")),
        right: Place::Landmark(format!("landmark_{}", l + 1)),
        sigma_mm: 0.5,
    };
    let solve_for = |d: &DVector<f64>| {
        let mut wish = target(d, 0.8);
        wish.symmetry = vec![pair(0), pair(2)];
        wish.effort = 0.1;
        activations(&solve(&wish, &observed, &response))
    };
    let (left, right) = (solve_for(&d), solve_for(&flip(&d)));
    for k in 0..m {
        assert!((left[k] - right[twin(k)]).abs() < 1e-8);
    }
}

#[test]
fn lengths_and_order_change_nothing() {
    let mut random = Random(47);
    for _ in 0..30 {
        let (mut wish, observed, response) = everything(&mut random);
        let reference = solve(&wish, &observed, &response);
        let order = random.permutation(5);
        let mut permuted = response.clone();
        permuted.map = response.map.select_columns(&order);
        permuted.muscles = order.iter().map(|&k| response.muscles[k].clone()).collect();
        let solution = solve(&wish, &observed, &permuted);
        for (name, value) in reference.activations.names.iter().zip(&reference.activations.values) {
            let other = solution.activations.get(name).unwrap();
            assert!((other - value).abs() < 1e-8, "{name}: {other} {value} {:?}", solution.status);
        }
        for factor in [1e-3, 1e3] {
            let original = wish.clone();
            let mut scaled = response.clone();
            scaled.map *= factor;
            let mut sites = observed.clone();
            for site in &mut sites.sites {
                site.position *= factor;
            }
            for marker in &mut wish.markers {
                let (Goal::Displacement(values) | Goal::Position(values)) = &mut marker.goal;
                for value in values.iter_mut().flatten() {
                    *value *= factor;
                }
                marker.sigma_mm *= factor;
            }
            for feature in &mut wish.features {
                let (FeatureGoal::Change(value) | FeatureGoal::Value(value)) = &mut feature.goal;
                *value *= factor;
                feature.sigma_mm *= factor;
            }
            wish.symmetry[0].sigma_mm *= factor;
            let solution = solve(&wish, &sites, &scaled);
            let difference = (activations(&solution) - activations(&reference)).amax();
            assert!(difference < 1e-8, "lengths x {factor}: {difference:e}");
            wish = original;
        }
    }
}

#[test]
fn limits_hold_and_their_multipliers_are_rates() {
    let mut random = Random(48);
    let response = Body::random(&mut random, 20, 6, 5, 0).response();
    let observed = observations(&mut random, 5);
    let a = DVector::from_vec(vec![1.8, 0.4, -0.7, 0.5, 0.6, 0.3]);
    let mut wish = target(&(&response.map * a), 1.0);
    wish.tied = vec![["muscle_3".into(), "muscle_4".into()]];
    wish.bounds = vec![bound(1, 0.25, 0.25), bound(0, 0.0, 0.9)];
    let solution = solve(&wish, &observed, &response);
    let values = &solution.activations.values;
    assert_eq!((values[0], values[1]), (0.9, 0.25));
    assert!((values[3] - values[4]).abs() < 1e-15);
    let held = solution.active_limits.iter().find(|limit| limit.name == "muscle_0 <= 0.9").unwrap();
    assert_eq!(held.unit, "1");
    let h = 1e-5;
    let mut at = |max: f64| {
        wish.bounds[1].max = max;
        solve(&wish, &observed, &response).objective
    };
    let rate = (at(0.9 - h) - at(0.9 + h)) / (2.0 * h);
    assert!((rate - held.multiplier).abs() < 1e-6 * rate, "{rate} {}", held.multiplier);
}

#[test]
fn degenerate_targets() {
    let mut random = Random(49);
    let response = Body::random(&mut random, 20, 4, 3, 0).response();
    let observed = observations(&mut random, 3);
    // Effort alone: nothing is observed.
    let none = Observations::default();
    let still = mapped(DMatrix::zeros(0, 4));
    let idle = solve(&Target { effort: 1.0, ..Target::default() }, &none, &still);
    assert_eq!((idle.status, idle.activations.values.len()), (Status::NoData, 0));
    // Met at rest, and met at full activation.
    for a in [0.0, 1.0] {
        let d = &response.map * DVector::from_element(4, a);
        let solution = solve(&target(&d, 1.0), &observed, &response);
        assert_eq!(solution.status, Status::Solved);
        assert!((activations(&solution) - DVector::from_element(4, a)).amax() < 1e-12);
    }
    // Every component missing.
    let mut missing = target(&DVector::zeros(9), 1.0);
    for marker in &mut missing.markers {
        marker.goal = Goal::Displacement([None; 3]);
    }
    missing.effort = 1.0;
    let solution = solve(&missing, &observed, &response);
    assert_eq!(solution.status, Status::NoData);
    assert!(solution.activations.values.is_empty());
    // A missing component counts nothing.
    let d = &response.map * DVector::from_element(4, 0.5);
    let mut partial = target(&d, 1.0);
    partial.markers[0].goal = Goal::Displacement([None, Some(d[1]), Some(d[2])]);
    let solution = solve(&partial, &observed, &response);
    assert!((activations(&solution) - DVector::from_element(4, 0.5)).amax() < 1e-9);
    // No muscle at all, and muscles without influence.
    let none = solve(&target(&DVector::from_element(9, 1.0), 1.0), &observed, &mapped(DMatrix::zeros(9, 0)));
    assert_eq!((none.status, none.objective), (Status::Solved, 4.5));
    let inert = solve(&target(&DVector::from_element(9, 1.0), 1.0), &observed, &mapped(DMatrix::zeros(9, 2)));
    assert_eq!((inert.status, inert.objective), (Status::Underdetermined, 4.5));
}

fn face() -> Face {
    let landmark = |name: &str, x: f64| Landmark {
        name: name.into(),
        site: Site::node(x.abs() as usize, Vec3::new(x, 0.0, 0.0)),
    };
    let muscle = |name: &str| Muscle {
        name: name.into(),
        max_force_n: 1.0,
        radius_mm: 1.0,
        area_mm2: None,
        insertion_mm: 0.0,
        fibres: Vec::new(),
    };
    Face {
        name: "test".into(),
        mesh: Mesh::default(),
        tissue: Tissue::default(),
        muscle_tissue: MuscleTissue::default(),
        supports: Vec::new(),
        jaw: None,
        muscles: vec![muscle("risorius_l"), muscle("risorius_r")],
        teeth: Vec::new(),
        mucosa: Vec::new(),
        upper_lip: Vec::new(),
        lower_lip: Vec::new(),
        skin: Vec::new(),
        landmarks: vec![
            landmark("cheilion_l", 25.0),
            landmark("cheilion_r", -26.0),
            landmark("stomion", 1.0),
        ],
    }
}

fn smile() -> Target {
    let marker = |name: &str, x: f64| Marker {
        name: name.into(),
        at: Place::Landmark(name.into()),
        goal: Goal::Displacement([Some(x), None, None]),
        sigma_mm: 0.1,
    };
    Target { markers: vec![marker("cheilion_l", 4.0), marker("cheilion_r", -4.0)], ..Target::default() }
}

#[test]
fn targets_are_refused_by_field_value_and_choices() {
    let off = |_: Vec3| Err(7.5);
    let refused = |change: &dyn Fn(&mut Target)| {
        let mut target = smile();
        change(&mut target);
        Observations::resolve(&target, &face(), off).unwrap_err()
    };
    let error = refused(&|t| t.markers[1].at = Place::Landmark("chelion_r".into()));
    let TargetError::UnknownLandmark { field, nearest, .. } = &error else { panic!("{error}") };
    assert_eq!((field.as_str(), nearest[0].as_str()), ("markers[1].landmark", "cheilion_r"));
    assert!(error.to_string().contains("`chelion_r`") && error.to_string().contains("`cheilion_r`"));
    let field_of = |error: &TargetError| error.to_string().split(": ").next().unwrap().to_string();
    type Change = dyn Fn(&mut Target);
    let cases: [(&str, &Change); 15] = [
        ("markers[0].sigma_mm", &|t| t.markers[0].sigma_mm = 0.0),
        ("markers[0].sigma_mm", &|t| t.markers[0].sigma_mm = f64::NAN),
        ("markers[1].displacement_mm", &|t| t.markers[1].goal = Goal::Displacement([Some(f64::NAN); 3])),
        ("markers[1]", &|t| t.markers[1].name = "cheilion_l".into()),
        ("markers[0].point_mm", &|t| t.markers[0].at = Place::Point(Vec3::zeros())),
        ("effort", &|t| t.effort = -1.0),
        ("bounds[0].muscle", &|t| t.bounds = vec![bound(0, 0.0, 1.0)]),
        ("bounds[0].max", &|t| t.bounds = vec![Bound { muscle: "risorius_l".into(), min: 0.0, max: 1.5 }]),
        ("bounds[0].min", &|t| {
            t.bounds = vec![Bound { muscle: "risorius_l".into(), min: f64::NAN, max: 1.0 }];
        }),
        ("bounds[0]", &|t| t.bounds = vec![Bound { muscle: "risorius_l".into(), min: 0.6, max: 0.5 }]),
        ("tied[0][1]", &|t| t.tied = vec![["risorius_l".into(), "risorus_r".into()]]),
        ("tied[0]", &|t| t.tied = vec![["risorius_l".into(), "risorius_l".into()]]),
        ("tied[0]", &|t| {
            t.tied = vec![["risorius_l".into(), "risorius_r".into()]];
            t.bounds = vec![Bound { muscle: "risorius_l".into(), min: 0.5, max: 0.5 }];
        }),
        ("symmetry[0]", &|t| {
            let place = Place::Landmark("stomion".into());
            t.symmetry = vec![MirroredPair { left: place.clone(), right: place, sigma_mm: 1.0 }];
        }),
        ("markers", &|t| t.markers.clear()),
    ];
    for (field, change) in cases {
        let error = refused(change);
        assert_eq!(field_of(&error), field, "{error}");
    }
    let resolved = Observations::resolve(&smile(), &face(), off).unwrap();
    assert_eq!((resolved.markers, resolved.sites.len()), (vec![0, 1], 2));
    // A response of other points, and one that is not finite.
    let observed = Observations::resolve(&smile(), &face(), off).unwrap();
    let mut response = mapped(DMatrix::zeros(5, 2));
    assert!(matches!(
        Problem::new(&smile(), &observed, &response).unwrap_err(),
        TargetError::ResponseShape { found: 5, expected: 6, .. }
    ));
    response = mapped(DMatrix::from_element(6, 2, f64::NAN));
    let error = Problem::new(&smile(), &observed, &response).unwrap_err();
    assert!(error.to_string().starts_with("response.map[0, 0]"), "{error}");
}

#[test]
fn doubts_are_voiced() {
    let observed = Observations::resolve(&smile(), &face(), |_| Err(0.0)).unwrap();
    let mut map = DMatrix::zeros(6, 2);
    (map[(0, 0)], map[(3, 1)]) = (5.0, -5.0);
    let response = mapped(map);
    let warnings = |target: &Target, response: &Response| solve(target, &observed, response).warnings;
    assert_eq!(warnings(&smile(), &response), []);
    let mut swapped = smile();
    for marker in &mut swapped.markers {
        let Goal::Displacement([Some(x), ..]) = &mut marker.goal else { unreachable!() };
        *x = -*x;
    }
    let doubts = warnings(&swapped, &response);
    assert!(matches!(&doubts[0], Warning::SwappedSides { residual_mm, swapped_mm, .. }
        if (*residual_mm - 4.0).abs() < 1e-9 && *swapped_mm < 1e-9));
    let mut far = smile();
    far.markers[0].goal = Goal::Displacement([Some(9.0), None, None]);
    let Some(Warning::Unreachable { marker, residual_mm, limits }) = warnings(&far, &response).pop() else {
        panic!()
    };
    assert_eq!((marker.as_str(), limits), ("cheilion_l", vec!["muscle_0 <= 1".to_string()]));
    assert!((residual_mm - 4.0).abs() < 1e-9);
    let mut zero = smile();
    zero.markers[0].goal = Goal::Displacement([Some(0.0); 3]);
    assert!(warnings(&zero, &response).contains(&Warning::ExactZero { marker: "cheilion_l".into() }));
    let mut alike = DMatrix::zeros(6, 4);
    (alike[(0, 0)], alike[(3, 1)], alike[(0, 3)]) = (5.0, -5.0, 2.5);
    let doubts = warnings(&smile(), &mapped(alike));
    assert_eq!(
        doubts,
        [
            Warning::NoInfluence { muscle: "muscle_2".into() },
            Warning::Indistinguishable { muscles: vec!["muscle_0".into(), "muscle_3".into()] },
            Warning::Underdetermined { components: 2, muscles: 4 },
        ]
    );
    assert!(doubts.iter().all(|w| !w.to_string().is_empty() && !w.remedy().is_empty()));
    let mut still = DMatrix::zeros(6, 4);
    (0..4).for_each(|k| still[(0, k)] = 1.0 + k as f64);
    assert!(warnings(&smile(), &mapped(still)).contains(&Warning::Immovable { marker: "cheilion_r".into() }));
}

#[test]
fn fewer_independent_observations_than_unknowns_are_underdetermined_unless_effort_or_ties_decide() {
    let observed = Observations::resolve(&smile(), &face(), |_| Err(0.0)).unwrap();
    let mut map = DMatrix::zeros(6, 4);
    for k in 0..4 {
        (map[(0, k)], map[(3, k)]) = (1.0 + k as f64, -4.0 + k as f64);
    }
    let response = mapped(map);
    let status = |change: &dyn Fn(&mut Target)| {
        let mut target = smile();
        change(&mut target);
        let solution = solve(&target, &observed, &response);
        assert_eq!(solution.activations.values.len(), 4, "the answer is given, as one of many");
        solution.status
    };
    assert_eq!(status(&|_| {}), Status::Underdetermined);
    assert_eq!(status(&|t| t.effort = 0.1), Status::Solved);
    assert_eq!(status(&|t| t.bounds = vec![bound(0, 0.2, 0.2), bound(1, 0.3, 0.3)]), Status::Solved);
    let tie = |a: usize, b: usize| [format!("muscle_{a}"), format!("muscle_{b}")];
    assert_eq!(status(&|t| t.tied = vec![tie(0, 1)]), Status::Underdetermined);
    assert_eq!(status(&|t| t.tied = vec![tie(0, 1), tie(2, 3)]), Status::Solved);
    // Two markers that say the same are one.
    let mut alike = DMatrix::zeros(6, 2);
    alike.set_row(0, &nalgebra::RowDVector::from_vec(vec![1.0, 2.0]));
    alike.set_row(3, &nalgebra::RowDVector::from_vec(vec![-1.0, -2.0]));
    assert_eq!(solve(&smile(), &observed, &mapped(alike)).status, Status::Underdetermined);
}
