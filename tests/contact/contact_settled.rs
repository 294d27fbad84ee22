//! Contact on surfaces that are not planes: grooves, edges, and faces where their tissue went.
#![allow(clippy::unwrap_used, reason = "a test that cannot go on should say where")]

use std::collections::BTreeMap;

use crate::common::block_face::{block_face, jaw_block};
use crate::common::cuboid;
use modiolus::contact::{Pair, PairKind, Solid, teeth_planes};
use modiolus::face::standard::{Resolution, standard};
use modiolus::face::{ContactReach, ContactSearch, Landmark, Pose, RigidMotion, Teeth};
use modiolus::forward::{ContactResponse, Element, Model, contact_forces};
use modiolus::inverse::{
    ActivatedProblem, ContactFit, ContactMode, Goal, JawOpening, Marker, Observations, Place, Status, Target,
    Warning,
};
use modiolus::io::read_target;
use modiolus::mesh::{Locator, Surface};
use modiolus::units::Vec3;
use nalgebra::{DMatrix, DVector, Matrix3};

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
fn a_point_beyond_a_horseshoe_whose_notch_passes_through_it_is_outside() {
    // The notch between the arms ends 2 mm below their base; what it encloses there is turned inside out.
    let polygon = [[-5., -5.], [5., -5.], [5., 5.], [1., 5.], [0., -7.], [-1., 5.], [-5., 5.]];
    let solid = Solid::new(&prism(&polygon, [-3., 0.]));
    let beyond = solid.project(Vec3::new(0., -8., 0.)).unwrap();
    assert!(
        (beyond.distance_mm - 1.).abs() < 1e-9 && (beyond.normal + Vec3::y()).norm() < 1e-9,
        "{beyond:?}"
    );
    // On the middle of the notch the arms tie: away from both is up.
    let between = solid.project(Vec3::new(0., 2., 0.)).unwrap();
    let flank = 9. / (1. + 12f64.powi(2)).sqrt();
    assert!((between.distance_mm - flank).abs() < 1e-9 && between.normal.x.abs() < 1e-9, "{between:?}");
    assert!(between.normal.y > 0.99, "{between:?}");
    let inside = solid.project(Vec3::new(-4., 0., 0.)).unwrap();
    assert!((inside.distance_mm + 1.).abs() < 1e-9, "{inside:?}");
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
fn a_point_is_met_though_a_wall_beside_it_is_nearer() {
    // A spike of half angle 20 degrees, 0.9 mm from a wall; its sides, seen from above, are nearer than the wall
    // and bound nothing, so that only its tip holds the node.
    let slope = 20f64.to_radians().tan();
    let polygon =
        [[-5., -9.], [3., -9.], [3., -3. / slope], [0., 0.], [-0.9, -0.9 / slope], [-0.9, 5.], [-5., 5.]];
    let solid = Solid::new(&prism(&polygon, [-1., -5.]));
    let (held, to) = pressed(&solid, Vec3::new(0., 1., 0.2), Vec3::new(-0.1, -1.3, 0.));
    assert!((to - Vec3::new(-0.1, 0., 0.2)).norm() < 1e-9, "{to} {held:?}");
    assert!((held.iter().map(|(_, f)| f).sum::<f64>() - 0.3).abs() < 1e-9, "{held:?}");
}

#[test]
fn a_node_slides_round_a_cylinder_without_entering_it() {
    // A many-sided cylinder of radius 4; at each place the node is pushed in and along.
    let sides = 48;
    let corner = |k: i32| (std::f64::consts::TAU * f64::from(k) / f64::from(sides)).sin_cos();
    let polygon: Vec<[f64; 2]> = (0..sides).map(|k| [4. * corner(k).1, 4. * corner(k).0]).collect();
    let solid = Solid::new(&prism(&polygon, [0., 0.]));
    // Pressed on a side it slides along it, beyond its end too, where the next side falls away by `turn`. A radius
    // through the end leans by half of that, so that of the push (0.3 along, 0.5 in) no more than `slide` is along
    // the side. The plane that it came along may hold it for another step while it is no more than 0.01 mm above the
    // next one; then it must let go.
    let turn = std::f64::consts::TAU / f64::from(sides);
    let slide = 0.3 * (turn / 2.).cos() - 0.5 * (turn / 2.).sin();
    let farthest = 0.01 + slide * turn.sin();
    let mut seen = 0f64;
    for start in 0..20 {
        let begin = turn * (f64::from(start) / 20. - 0.5);
        let mut p = Vec3::new(4. * begin.cos(), 4. * begin.sin(), 0.);
        let mut gone = 0.;
        for step in 0..100 {
            let out = Vec3::new(p.x, p.y, 0.).normalize();
            let along = Vec3::new(-out.y, out.x, 0.);
            let to = pressed(&solid, p, 0.3 * along - 0.5 * out).1;
            gone += out.cross(&to).z.atan2(out.dot(&to));
            p = to;
            let distance = solid.project(p).unwrap().distance_mm;
            // The first step starts at the corners' radius, up to 0.01 mm above a side.
            assert!((-1e-9..farthest).contains(&distance), "{begin} step {step}: {p} {distance}");
            seen = seen.max(distance);
        }
        // A step on the circle would be 0.3 mm; at a corner that holds it the node would stay behind.
        assert!(gone > 100. * slide / 4.1, "it has gone round: {gone}");
    }
    println!("above the cylinder by at most {seen:.4} mm, of {farthest:.4}");
    assert!(seen > slide / 2. * turn.sin(), "it left planes behind: {seen}");
}

/// A ball whose facets turn by a degree about the pole that faces `-z`, and coarsely elsewhere.
fn ball(centre: Vec3, radius: f64) -> Surface {
    let around = 120;
    let polar: Vec<f64> =
        (1..=45).chain([60, 90, 120, 150]).map(|d: i32| f64::from(d).to_radians()).collect();
    let at = |theta: f64, k: usize| {
        let (sin, cos) = (std::f64::consts::TAU * k as f64 / around as f64).sin_cos();
        centre + radius * Vec3::new(theta.sin() * cos, theta.sin() * sin, -theta.cos())
    };
    let rings = polar.iter().flat_map(|&theta| (0..around).map(move |k| (theta, k)));
    let mut points: Vec<Vec3> = rings.map(|(theta, k)| at(theta, k)).collect();
    let (near, far) = (points.len(), points.len() + 1);
    points.extend([at(0., 0), at(std::f64::consts::PI, 0)]);
    let mut triangles = Vec::new();
    for k in 0..around {
        let next = (k + 1) % around;
        triangles.push([near, next, k]);
        for ring in 0..polar.len() - 1 {
            let (a, b) = (ring * around + k, ring * around + next);
            triangles.extend([[a, b, b + around], [a, b + around, a + around]]);
        }
        let last = (polar.len() - 1) * around;
        triangles.push([last + k, last + next, far]);
    }
    Surface { points, triangles }
}

#[test]
fn tissue_pushed_along_a_ball_rests_on_the_ball_whatever_the_start() {
    // The bone carries the block into a ball and 4 mm along it. What the ball does to the tissue is what its own
    // equilibrium lacks, K u - F a: it must push from the ball's centre, there alone where the ball is touched.
    let mut face = block_face([12, 8, 3]);
    face.supports[0].bone = "mandible".into();
    face.mucosa.clone_from(&face.skin);
    let (centre, radius) = (Vec3::new(2., -1., 12.5 + 20.), 20.);
    let surface = ball(centre, radius);
    face.teeth = vec![Teeth { upper: true, bone: "skull".into(), surface }];
    let search = ContactSearch::new(&face, ContactReach::default());
    let model = Model::new(&face, search.rest().to_vec()).unwrap();
    let a = [0.5, 0.2, 0.4];
    let pose = Pose::rest().with("mandible", RigidMotion::translation(Vec3::new(3.5, 2., 2.)));
    let stiff = model.at_pose(&a, &pose).unwrap();
    let starts = [None, Some(vec![0.; 3 * face.mesh.n_nodes()])];
    let found = starts.map(|start| stiff.settle(&face, &search, &a, start.as_deref()).unwrap());
    for settled in &found {
        assert!(settled.settled);
        let u = &settled.equilibrium.displacement;
        let mut push = model.stiffness().pattern().multiply(&model.stiffness_at(&a), u);
        for (load, value) in model.loads().iter().zip(&a) {
            load.iter().for_each(|(dof, f)| push[*dof] -= value * f);
        }
        let of = |v: &[f64], n: usize| Vec3::new(v[3 * n], v[3 * n + 1], v[3 * n + 2]);
        let total: f64 = face.skin.iter().map(|&n| of(&push, n).norm()).sum();
        let (mut deepest, mut stray, mut oblique, mut touched) = (0f64, 0., 0., 0);
        for &n in &face.skin {
            let arm = face.mesh.points[n] + of(u, n) - centre;
            let (force, distance) = (of(&push, n), arm.norm() - radius);
            deepest = deepest.max(-distance);
            stray += if distance > 5e-2 { force.norm() } else { 0. };
            oblique += (force - force.dot(&arm) / arm.norm_squared() * arm).norm();
            touched += usize::from(force.dot(&arm) > 1e-6 * total * arm.norm());
        }
        let free =
            (0..face.mesh.n_nodes()).filter(|&n| !face.skin.contains(&n) && face.mesh.points[n].z > 0.);
        let balance = free.map(|n| of(&push, n).norm()).fold(0., f64::max);
        println!(
            "{} rounds, {touched} nodes with {total:.3} N, overlap {deepest:.4} mm, stray {:.4}, oblique {:.4}",
            settled.rounds,
            stray / total,
            oblique / total
        );
        assert!(touched > 5 && balance < 1e-9 * total, "{touched} {balance:e}");
        // A facet lies at most R (1 - cos 1.5 deg) = 0.007 mm inside the ball.
        assert!(deepest <= 1e-2 + 7e-3 && stray <= 1e-2 * total, "{deepest} {stray}");
        // Facets are turned by at most 1 degree, and 0.01 mm of overlap hides sqrt(2 R 0.01) = 0.63 mm along the
        // ball, another 1.8 degrees.
        assert!(oblique <= 2.8f64.to_radians() * total, "{oblique} of {total}");
    }
    // Each linearised again about itself, both come to the same rest.
    let [one, other] = found.map(|settled| {
        let again =
            |u: Vec<f64>, _| stiff.settle(&face, &search, &a, Some(&u)).unwrap().equilibrium.displacement;
        DVector::from_vec((0..6).fold(settled.equilibrium.displacement, again))
    });
    let apart = (one - other).amax();
    println!("both starts, linearised again 6 times: {apart:.2e} mm apart");
    assert!(apart < 1e-2, "{apart}");
}

#[test]
fn strong_muscles_settle_on_the_surfaces_of_the_deformed_face() {
    let face = standard(&Resolution::COARSE);
    let search = ContactSearch::new(&face, ContactReach::default());
    let model = Model::new(&face, search.rest().to_vec()).unwrap();
    for muscles in [
        "zygomaticus_major",
        "levator_labii_superioris",
        "depressor_labii_inferioris",
        "risorius",
        "mentalis",
    ] {
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
fn pursed_lips_slide_past_the_rim_of_the_other_lip_and_are_held_there() {
    let face = standard(&Resolution::STANDARD);
    let search = ContactSearch::new(&face, ContactReach::default());
    let model = Model::new(&face, search.rest().to_vec()).unwrap();
    let a: Vec<f64> =
        model.muscles().iter().map(|n| if n == "orbicularis_oris_peripheralis" { 0.3 } else { 0. }).collect();
    let settled = model.at(&a).unwrap().settle(&face, &search, &a, None).unwrap();
    println!("{} rounds, overlap {:.4} mm", settled.rounds, settled.penetration_mm);
    assert!(settled.settled, "{} rounds, overlap {} mm", settled.rounds, settled.penetration_mm);
    // No point of integration is inside out; linear elasticity folds some cells at their corners.
    let u = &settled.equilibrium.displacement;
    for (index, cell) in face.mesh.cells.iter().enumerate() {
        let rest: Vec<_> = face.mesh.cell_points(index).collect();
        let element = Element::new(cell.kind(), &rest).unwrap();
        let moved: Vec<_> =
            cell.nodes().iter().map(|&n| Vec3::new(u[3 * n], u[3 * n + 1], u[3 * n + 2])).collect();
        for q in 0..element.points().len() {
            let ratio = (Matrix3::identity() + element.displacement_gradient(q, &moved)).determinant();
            assert!(ratio > 0., "cell {index}: {ratio}");
        }
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

#[test]
fn an_answer_that_leaves_tissue_in_the_teeth_is_not_called_solved() {
    // The front of the block lies between two teeth that are 3 mm apart and far larger. The jaw, hung 425 mm above,
    // drives one at least 435 sin(5 / 437) = 4.97 mm towards the other: wherever the tissue between them goes, it is
    // 0.98 mm deep in a tooth.
    let mut face = jaw_block([6, 4, 2]);
    let front = |n: &usize| face.mesh.points[*n].y < -5. && face.mesh.points[*n].x.abs() < 25.;
    face.mucosa = face.skin.iter().copied().filter(front).collect();
    let box_of = |back: f64, front: f64| cuboid(Vec3::new(-200., -200., back), Vec3::new(200., 200., front));
    face.teeth[0].surface = box_of(-300., 10.5);
    face.teeth[1].surface = box_of(13.5, 60.);
    if let Some(jaw) = &mut face.jaw {
        jaw.condyles.iter_mut().for_each(|condyle| condyle.y += 400.);
    }
    let search = ContactSearch::new(&face, ContactReach { teeth_mm: 1., lips_mm: 1. });
    let model = Model::new(&face, search.rest().to_vec()).unwrap();
    let still = |l: &Landmark| Marker {
        name: l.name.clone(),
        at: Place::Landmark(l.name.clone()),
        goal: Goal::Displacement([Some(0.); 3]),
        sigma_mm: 1.,
    };
    let target = Target {
        markers: face.landmarks.iter().map(still).collect(),
        jaw_opening: Some(JawOpening::Held(5.)),
        effort: 1e-3,
        ..Target::default()
    };
    let observations = Observations::resolve(&target, &face, |_| Err(0.)).unwrap();
    let mode = ContactMode::Reactions;
    let fit = ContactFit {
        face: &face,
        search: Some(&search),
        model: &model,
        target: &target,
        observations: &observations,
        mode,
    };
    let problem = ActivatedProblem::new(&model, &target, &observations, mode);
    let first = problem.solve_at_fixed_stiffness(0.5).unwrap();
    let pose = Pose::opened(face.jaw.as_ref().unwrap(), 5.);
    for fitted in [fit.fixed(0.5, first).unwrap(), fit.activated(&[0.; 3], |_| ()).unwrap()] {
        println!("{:?} {:?} {:?}", fitted.solution.status, fitted.overlap_mm, fitted.solution.warnings);
        assert_ne!(fitted.solution.status, Status::Solved);
        let Some(u) = &fitted.displacement else { continue };
        let overlap = search.at(&face, u, &pose).overlap_mm();
        assert!(overlap > 0.9, "{overlap}");
        let told = fitted.solution.warnings.iter().find_map(|warning| match warning {
            Warning::Unsettled { overlap_mm } => Some(*overlap_mm),
            _ => None,
        });
        assert_eq!(told, Some(overlap));
    }
}

#[test]
fn a_symmetric_face_moves_symmetrically() {
    let face = standard(&Resolution::COARSE);
    let bits = |p: Vec3| [p.x, p.y, p.z].map(|c| (c + 0.).to_bits());
    let nodes: BTreeMap<_, usize> = face.mesh.points.iter().enumerate().map(|(k, p)| (bits(*p), k)).collect();
    let search = ContactSearch::new(&face, ContactReach::default());
    let model = Model::new(&face, search.rest().to_vec()).unwrap();
    let activated = |list: &[(&str, f64)]| -> Vec<f64> {
        let of = |name: &String| list.iter().find(|(stem, _)| name.starts_with(stem)).map_or(0., |(_, a)| *a);
        model.muscles().iter().map(of).collect()
    };
    // Lips that press each other slide to one side as soon as anything tells the sides apart.
    let rings = activated(&[("orbicularis_oris_marginalis", 0.5), ("orbicularis_oris_peripheralis", 0.3)]);
    let smile = activated(&[("zygomaticus_major", 1.), ("risorius", 1.)]);
    for (what, a, opening_mm) in
        [("lips", &rings, 0.), ("smile", &smile, 0.), ("smile with open jaw", &smile, 5.)]
    {
        let pose = Pose::opened(face.jaw.as_ref().unwrap(), opening_mm);
        let stiff = model.at_pose(a, &pose).unwrap();
        let settled = stiff.settle(&face, &search, a, None).unwrap();
        let u = &settled.equilibrium.displacement;
        let (mut apart, mut moved) = (0f64, 0f64);
        for (k, p) in face.mesh.points.iter().enumerate() {
            let other = nodes[&bits(Vec3::new(-p.x, p.y, p.z))];
            let at = |n: usize| Vec3::new(u[3 * n], u[3 * n + 1], u[3 * n + 2]);
            apart = apart.max((at(k) - Vec3::new(-at(other).x, at(other).y, at(other).z)).amax());
            moved = moved.max(at(k).amax());
        }
        let pressing = settled.equilibrium.contact_forces.iter().filter(|f| **f > 0.).count();
        println!("{what}: {apart:.1e} of {moved:.1} mm, {pressing} contacts press");
        assert!(moved > 5. && pressing > 20, "{what}: {moved} {pressing}");
        assert!(apart <= 1e-9, "{what}: {apart:e}");
    }
}
