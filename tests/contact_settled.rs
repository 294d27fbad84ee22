//! Contact on surfaces that are not planes: grooves, edges, and faces where their tissue went.
#![allow(clippy::unwrap_used, reason = "a test that cannot go on should say where")]

mod common;

use std::collections::BTreeMap;

use modiolus::contact::{Pair, PairKind, Solid, teeth_planes};
use modiolus::face::standard::{Resolution, standard};
use modiolus::face::{ContactReach, ContactSearch, Pose};
use modiolus::forward::{ContactResponse, Model, contact_forces};
use modiolus::inverse::{ActivatedProblem, ContactFit, ContactMode, Observations, Status};
use modiolus::io::read_target;
use modiolus::mesh::{Locator, Surface};
use modiolus::units::Vec3;
use nalgebra::{DMatrix, DVector};

/// The prism between `z = -10` and `z = 10` over a polygon whose vertices run anticlockwise, with `hub` inside it.
fn prism(polygon: &[[f64; 2]], hub: [f64; 2]) -> Surface {
    let n = polygon.len();
    let at = |z: f64| polygon.iter().chain([&hub]).map(move |&[x, y]| Vec3::new(x, y, z));
    let points: Vec<Vec3> = at(-10.).chain(at(10.)).collect();
    let (low, high) = (n, 2 * n + 1);
    let mut triangles = Vec::new();
    for k in 0..n {
        let (a, b) = (k, (k + 1) % n);
        let (c, d) = (a + n + 1, b + n + 1);
        triangles.extend([[a, b, d], [a, d, c], [b, a, low], [c, d, high]]);
    }
    Surface { points, triangles }
}

/// Forces on the planes of a node on springs (1 N/mm), at `p`, under the load `push` (N), and where it goes.
fn pressed(solid: &Solid, p: Vec3, push: Vec3) -> (Vec<(Vec3, f64)>, Vec3) {
    let pairs = teeth_planes(PairKind::UpperTeeth, 0, solid, &[p], &[0], &BTreeMap::new(), [5., 1.5]);
    let c = pairs.len();
    let contact = ContactResponse {
        kinds: vec![PairKind::UpperTeeth; c],
        gap: DVector::from_iterator(c, pairs.iter().map(|q| q.gap_mm - q.rest_overlap_mm)),
        approach: DMatrix::from_iterator(c, 1, pairs.iter().map(|q| q.normal().dot(&push))),
        compliance: DMatrix::from_fn(c, c, |i, j| pairs[i].normal().dot(&pairs[j].normal())),
        reach: DMatrix::zeros(0, c),
    };
    let forces = contact_forces(&contact, &DVector::from_element(1, 1.)).unwrap();
    let held: Vec<(Vec3, f64)> = pairs.iter().map(Pair::normal).zip(forces.iter().copied()).collect();
    let to = p + push + held.iter().map(|(n, f)| *f * n).sum::<Vec3>();
    (held, to)
}

#[test]
fn a_groove_holds_a_node_by_both_flanks() {
    // Flanks of slope 1 and 2 that meet at the origin.
    let (left, right) = (Vec3::new(2., 1., 0.).normalize(), Vec3::new(-1., 1., 0.).normalize());
    let polygon = [[-4., -9.], [9., -9.], [8., 8.], [0., 0.], [-4., 8.]];
    let solid = Solid::new(&prism(&polygon, [0., -5.]));
    for start in [Vec3::new(0.05, 0.6, 0.), Vec3::new(-0.1, 0.4, 0.3)] {
        let push = Vec3::new(0.2, -2., 0.);
        let (held, to) = pressed(&solid, start, push);
        let force =
            |normal: Vec3| held.iter().filter(|(n, _)| n.dot(&normal) > 0.999).map(|(_, f)| f).sum::<f64>();
        // In the groove the node rests at the bottom: l left + r right = to - start - push.
        let needed = Vec3::new(0., 0., start.z) - start - push;
        let flanks = nalgebra::Matrix2::new(left.x, right.x, left.y, right.y);
        let split = flanks.try_inverse().unwrap() * nalgebra::Vector2::new(needed.x, needed.y);
        assert!(split.min() > 0.1, "both flanks are needed: {split}");
        assert!(
            (force(left) - split.x).abs() < 1e-9 && (force(right) - split.y).abs() < 1e-9,
            "{held:?} {split}"
        );
        assert!((to - Vec3::new(0., 0., start.z)).norm() < 1e-9, "{to}");
    }
}

#[test]
fn an_edge_holds_a_node_by_a_force_between_its_sides_and_lets_it_slide_off_otherwise() {
    // A ridge at the origin with sides that fall by 45 degrees.
    let polygon = [[-5., -5.], [-5., -9.], [5., -9.], [5., -5.], [0., 0.]];
    let solid = Solid::new(&prism(&polygon, [0., -6.]));
    let sides = [Vec3::new(-1., 1., 0.).normalize(), Vec3::new(1., 1., 0.).normalize()];
    // Force within the cone of the two normals: the node stays on the edge.
    let (held, to) = pressed(&solid, Vec3::new(0., 0.01, 0.), Vec3::new(0.3, -1., 0.));
    assert!(to.norm() < 1e-9, "{to} {held:?}");
    assert!(sides.iter().all(|s| held.iter().any(|(n, f)| n.dot(s) > 0.999 && *f > 0.1)), "{held:?}");
    // Force along one side: it slides down the other, which the far side's plane must not stop.
    let (_, to) = pressed(&solid, Vec3::new(0.2, -0.2, 0.), Vec3::new(1., -1.5, 0.));
    assert!((to - Vec3::new(1.45, -1.45, 0.)).norm() < 1e-9, "{to}");
}

#[test]
fn a_node_slides_round_a_cylinder_without_entering_it() {
    // A many-sided cylinder of radius 4; at each place the node is pushed in and along.
    let sides = 48;
    let corner = |k: i32| (std::f64::consts::TAU * f64::from(k) / f64::from(sides)).sin_cos();
    let polygon: Vec<[f64; 2]> = (0..sides).map(|k| [4. * corner(k).1, 4. * corner(k).0]).collect();
    let solid = Solid::new(&prism(&polygon, [0., 0.]));
    let mut p = Vec3::new(4.0, 0.05, 0.);
    for _ in 0..40 {
        let out = Vec3::new(p.x, p.y, 0.).normalize();
        let along = Vec3::new(-out.y, out.x, 0.);
        p = pressed(&solid, p, 0.3 * along - 0.5 * out).1;
        let distance = solid.project(p).unwrap().distance_mm;
        // It leaves the plane that it slid along by no more than that plane turns to the next, and
        // the 0.01 mm that the plane of a triangle behind it may hold it off.
        let turn = 0.3 * (std::f64::consts::TAU / f64::from(sides)).sin();
        assert!((-1e-9..turn + 1e-2).contains(&distance), "{p} {distance}");
    }
    assert!(p.y < 0. || p.x < 0., "it has gone round: {p}");
}

#[test]
fn strong_muscles_settle_on_the_surfaces_of_the_deformed_face() {
    let face = standard(&Resolution::COARSE);
    let search = ContactSearch::new(&face, ContactReach::default());
    let model = Model::new(&face, search.rest().to_vec()).unwrap();
    for muscles in ["levator_labii_superioris", "depressor_labii_inferioris", "risorius", "mentalis"] {
        let a: Vec<f64> =
            model.muscles().iter().map(|n| f64::from(u8::from(n.starts_with(muscles)))).collect();
        let settled = model.at(&a).unwrap().settle(&face, &search, &a, None).unwrap();
        let u = &settled.equilibrium.displacement;
        println!("{muscles}: {} rounds, overlap {:.4} mm", settled.rounds, settled.penetration_mm);
        assert!(settled.settled && settled.linear_penetration_mm < 1e-9, "{muscles}");
        assert!(
            face.contact_pairs_at(ContactReach::default(), u, &Pose::rest()).overlap_mm() <= 1e-2,
            "{muscles}"
        );
        // From the answer itself it stays there.
        let again = model.at(&a).unwrap().settle(&face, &search, &a, Some(u)).unwrap();
        assert!(again.settled, "{muscles}");
    }
}

#[test]
fn a_fit_satisfies_contact_where_its_answer_leads() {
    let face = standard(&Resolution::COARSE);
    let search = ContactSearch::new(&face, ContactReach::default());
    let model = Model::new(&face, search.rest().to_vec()).unwrap();
    let path = std::path::Path::new(env!("CARGO_MANIFEST_DIR")).join("targets/symmetric_smile.toml");
    let target = read_target(&path).unwrap().expand_patterns(model.muscles()).unwrap().target;
    let locator = Locator::new(&face.mesh);
    let locate = |p| locator.locate(p).map(|found| found.site).ok_or(f64::INFINITY);
    let observations = Observations::resolve(&target, &face, locate).unwrap();
    let mode = ContactMode::Reactions;
    let first = ActivatedProblem::new(&model, &target, &observations, mode).at_fixed_stiffness(0.5).unwrap();
    let first = first.solve(mode).unwrap();
    let displaced = model.at(&vec![0.5; model.muscles().len()]).unwrap();
    let u = displaced.displacement(&first.activations.values, first.contact_forces.as_slice());
    let before = search.at(&face, &u, &Pose::rest()).overlap_mm();
    let fit = ContactFit {
        face: &face,
        search: Some(&search),
        model: &model,
        target: &target,
        observations: &observations,
        mode,
    };
    let start = first.activations.values.clone();
    let fitted = fit.fixed(0.5, first).unwrap();
    let after = search.at(&face, &fitted.displacement.unwrap(), &Pose::rest()).overlap_mm();
    println!(
        "overlap {before:.3} mm at rest planes, {after:.4} mm after {} linearisations",
        fitted.linearisations
    );
    assert!(before > 0.1, "the target needs it: {before}");
    assert_eq!(fitted.solution.status, Status::Solved);
    assert!(after <= 1e-2 && fitted.overlap_mm == Some(after) && fitted.linearisations > 1, "{after}");
    assert!(fitted.solution.certificate.passes());
    // So does the answer with muscles that stiffen, from the same start.
    let fitted = fit.activated(&start, |_| ()).unwrap();
    let after = search.at(&face, &fitted.displacement.unwrap(), &Pose::rest()).overlap_mm();
    println!(
        "{after:.4} mm after {} linearisations, {} programs",
        fitted.linearisations,
        fitted.history.len()
    );
    assert_eq!(fitted.solution.status, Status::Solved);
    assert!(after <= 1e-2 && fitted.solution.certificate.passes(), "{after}");
}
