//! Forward contact against closed forms: a confined block, Hertz, and the balance of forces on a face.
#![allow(clippy::unwrap_used, reason = "a test that cannot go on should say where")]

use std::collections::BTreeMap;

use crate::common::block_face::{block_face, front_pairs};
use crate::common::{
    add_quad_traction, contact_column as column, contact_response as response, cuboid, factor, grid,
    half_space, isotropic,
};
use modiolus::contact::{Facets, Pair, PairKind, Patch, Solid, teeth_pairs};
use modiolus::face::standard::{Resolution, standard};
use modiolus::face::{ContactReach, ContactSearch, Face, Pose, RigidMotion, Teeth};
use modiolus::forward::{Model, SparseColumn, contact_forces};
use modiolus::mesh::CellKind;
use modiolus::units::Vec3;
use nalgebra::DVector;

#[test]
fn a_confined_block_meets_a_wall_as_its_closed_form_says() {
    let (side, height, young, poisson) = (6., 4., 0.015, 0.49);
    let modulus = young * (1. - poisson) / ((1. + poisson) * (1. - 2. * poisson));
    let n = 4;
    // Distorted inside, where the uniform stress must still be met.
    let mesh = grid(CellKind::Hex8, [n, n, n], |p| {
        let inside = |x: f64| (std::f64::consts::PI * x).sin();
        let bump = 0.3 * inside(p.x) * inside(p.y) * inside(p.z);
        Vec3::new(side * p.x + bump, side * p.y - 0.7 * bump, height * p.z + 0.5 * bump)
    });
    let cholesky = factor(&mesh, isotropic(young, poisson), |p, axis| match axis {
        2 => p.z == 0.,
        _ => p[axis] == 0. || p[axis] == side,
    });
    let front = |p: Vec3| (p.z - height).abs() < 1e-12;
    let nodes: Vec<usize> = (0..mesh.n_nodes()).filter(|&k| front(mesh.points[k])).collect();
    let mut unit = vec![0.; 3 * mesh.n_nodes()];
    for cell in &mesh.cells {
        let c = cell.nodes();
        if front(mesh.points[c[4]]) {
            add_quad_traction(&mesh, [c[4], c[5], c[6], c[7]], |_, outward| outward, &mut unit);
        }
    }
    let load: SparseColumn = unit.iter().copied().enumerate().filter(|(_, v)| *v != 0.).collect();
    let mut states = [0; 2];
    for gap in [0., 0.01, 0.08] {
        let wall =
            Solid::new(&cuboid(Vec3::new(-20., -20., height + gap), Vec3::new(20. + side, 20. + side, 40.)));
        let pairs = teeth_pairs(PairKind::UpperTeeth, 0, &wall, &mesh.points, &nodes, &BTreeMap::new(), 1.);
        assert_eq!(pairs.len(), nodes.len());
        let contact = response(&cholesky, &load, &pairs);
        for pressure in [0., 1e-4, 1e-3, 5e-3, 2e-2] {
            let forces = contact_forces(&contact, &DVector::from_element(1, pressure)).unwrap();
            let mut force: Vec<f64> = unit.iter().map(|f| pressure * f).collect();
            for (pair, lambda) in pairs.iter().zip(forces.iter()) {
                column(pair).iter().for_each(|(dof, g)| force[*dof] += lambda * g);
            }
            let u = cholesky.displacements(&[force]).swap_remove(0);
            let expected = (pressure * height / modulus).min(gap);
            let pushed_back = (pressure - modulus * gap / height).max(0.);
            states[usize::from(pushed_back > 0.)] += 1;
            for (pair, lambda) in pairs.iter().zip(forces.iter()) {
                let moved = u[3 * pair.node + 2];
                assert!((moved - expected).abs() < 1e-6 * height, "{gap} {pressure}: {moved} {expected}");
                assert!((moved - expected).abs() < 1e-6 * expected.max(1e-3), "{moved} {expected}");
                // The consistent force of a uniform pressure on the node's share of the front.
                let share = pushed_back * unit[3 * pair.node + 2];
                assert!((lambda - share).abs() <= 1e-6 * pressure * side, "{lambda} {share}");
            }
            // As pressures on the areas of the nodes it is uniform, corners included.
            let areas = Facets::of(&mesh).within(&nodes).node_areas(&mesh);
            for (pair, lambda) in pairs.iter().zip(forces.iter()) {
                let found = lambda / areas[&pair.node];
                assert!((found - pushed_back).abs() <= 1e-6 * pressure, "{found} {pushed_back}");
            }
            let total = forces.sum();
            assert!((total - pushed_back * side * side).abs() <= 1e-6 * pressure * side * side, "{total}");
        }
    }
    assert!(states[0] > 2 && states[1] > 5, "open and closed states were both met: {states:?}");
}

#[test]
fn a_sphere_on_a_half_space_follows_hertz() {
    let (radius, young, poisson) = (10., 0.015, 0.3);
    // At the deepest press the contact radius is 1 mm: 8 cells of 1/8 mm.
    let depth = 0.1;
    let (mesh, cholesky) = half_space(isotropic(young, poisson), 8);
    let size = mesh.points.iter().fold(0f64, |far, p| far.max(p.x));
    let pairs: Vec<Pair> = (0..mesh.n_nodes())
        .filter(|&k| mesh.points[k].z == 0. && mesh.points[k].norm() < 1.6)
        .map(|node| Pair {
            kind: PairKind::UpperTeeth,
            node,
            row: vec![(node, -Vec3::z())],
            tooth: None,
            gap_mm: mesh.points[node].norm_squared() / (2. * radius),
            rest_overlap_mm: 0.,
        })
        .collect();
    // The sphere comes down instead of a load pulling up.
    let mut contact = response(&cholesky, &Vec::new(), &pairs);
    contact.approach.fill(-1.);
    let plane_modulus = young / (1. - poisson * poisson);
    let forces = contact_forces(&contact, &DVector::from_element(1, depth)).unwrap();
    let total = 4. * forces.sum();
    let hertz = 4. / 3. * plane_modulus * f64::sqrt(radius) * depth.powf(1.5);
    let edge = pairs.iter().zip(forces.iter()).filter(|(_, f)| **f > 0.);
    let edge = edge.map(|(p, _)| mesh.points[p.node].norm()).fold(0., f64::max);
    let gaps = &contact.gap + &contact.approach * depth + &contact.compliance * &forces;
    let broken = (0..gaps.len()).map(|i| (-gaps[i]).max(gaps[i].min(forces[i]))).fold(0., f64::max);
    println!(
        "Hertz: {} nodes, S/a {size:.1}, force {total:.6} N for {hertz:.6} ({:+.2} %), radius {edge:.3}",
        mesh.n_nodes(),
        100. * (total / hertz - 1.)
    );
    assert!(size >= 30.);
    assert!((total / hertz - 1.).abs() < 0.05, "{total} for {hertz}");
    assert!((edge - 1.).abs() <= 0.125 + 1e-12, "contact radius {edge}");
    assert!(broken < 1e-9, "{broken:e}");
    // Half the depth: the power 3/2 within what the coarser contact patch allows.
    let half = 4. * contact_forces(&contact, &DVector::from_element(1, depth / 2.)).unwrap().sum();
    let power = (total / half).log2();
    assert!((power - 1.5).abs() < 0.05, "{power}");
}

fn coarse() -> (Face, Vec<Pair>) {
    let face = standard(&Resolution::COARSE);
    let pairs = face.contact_pairs(ContactReach::default());
    (face, pairs)
}

#[test]
fn pressed_lips_push_each_other_equally_and_supports_carry_the_rest() {
    let (face, pairs) = coarse();
    let model = Model::new(&face, pairs).unwrap();
    let names = model.muscles();
    let a: Vec<f64> = names
        .iter()
        .map(|n| {
            if n.starts_with("orbicularis_oris") {
                0.8
            } else if n.starts_with("mentalis") {
                0.6
            } else {
                0.
            }
        })
        .collect();
    let stiff = model.at(&a).unwrap();
    let contact = stiff.response(&[]).contact.unwrap();
    let rest = stiff.equilibrium(Some(&contact)).unwrap();
    let (u, forces) = (&rest.displacement, &rest.contact_forces);

    let gaps: Vec<f64> = model.pairs().iter().map(|p| p.gap_mm + p.change_mm(u)).collect();
    let broken = gaps.iter().zip(forces.iter()).map(|(g, f)| (-g).max(-f).max(g.min(*f))).fold(0., f64::max);
    assert!(broken < 1e-9, "0 <= force _|_ gap >= 0, from the displacement field: {broken:e}");

    let points = &face.mesh.points;
    let (mut pressed, mut lips, mut lip_moment) = (0., Vec3::zeros(), Vec3::zeros());
    let mut teeth = Vec3::zeros();
    for (pair, &lambda) in model.pairs().iter().zip(forces.iter()) {
        for (node, g) in &pair.row {
            if pair.kind == PairKind::Lips {
                lips += lambda * g;
                lip_moment += lambda * points[*node].cross(g);
            } else {
                teeth += lambda * g;
            }
        }
        pressed += if pair.kind == PairKind::Lips { lambda } else { 0. };
    }
    let load = face.contact_load(model.pairs(), forces.as_slice());
    let gathered = load.force_n.iter().sum::<Vec3>();
    assert!((gathered - lips - teeth).norm() < 1e-9 && (load.of(PairKind::Lips) - pressed).abs() < 1e-9);
    let both = load.total_n.values().sum::<f64>();
    assert!((both - forces.sum()).abs() < 1e-9 && load.pressure_kpa.iter().all(|p| p.is_finite()));
    println!("lips press with {pressed:.3} N, teeth push {teeth:?}");
    assert!(pressed > 0.05 && teeth.norm() > 0.05, "{pressed} {teeth:?}");
    assert!(lips.norm() < 1e-12 * pressed && lip_moment.norm() < 1e-9 * pressed, "{lips:?} {lip_moment:?}");

    // Everything that is not held by the tissue's own equilibrium is a reaction of the bones.
    let mut out_of_balance = model.stiffness().pattern().multiply(&model.stiffness_at(&a), u);
    for (load, value) in model.loads().iter().zip(&a) {
        load.iter().for_each(|(dof, f)| out_of_balance[*dof] -= value * f);
    }
    for (pair, &lambda) in model.pairs().iter().zip(forces.iter()) {
        column(pair).iter().for_each(|(dof, g)| out_of_balance[*dof] -= lambda * g);
    }
    let free = model.symbolic().free();
    let worst = free.iter().map(|&dof| out_of_balance[dof].abs()).fold(0., f64::max);
    assert!(worst < 1e-9, "free nodes are in equilibrium: {worst:e}");
    let mut reaction = Vec3::zeros();
    out_of_balance.iter().enumerate().for_each(|(dof, f)| reaction[dof % 3] += f);
    let mut muscles = Vec3::zeros();
    for (load, value) in model.loads().iter().zip(&a) {
        load.iter().for_each(|(dof, f)| muscles[dof % 3] += value * f);
    }
    assert!((reaction + muscles + teeth).norm() < 1e-9, "{reaction:?} {muscles:?} {teeth:?}");
}

#[test]
fn gaps_linearised_where_the_tissue_went_settle_on_the_true_surfaces() {
    let (face, pairs) = coarse();
    let search = ContactSearch::new(&face, ContactReach::default());
    let same = search.at(&face, &vec![0.; 3 * face.mesh.n_nodes()], &Pose::rest());
    assert_eq!(same.overlap_mm(), 0.);
    assert!(pairs.iter().all(|p| same.pairs.iter().any(|q| p.row == q.row && p.gap_mm == q.gap_mm)));

    let model = Model::new(&face, pairs.clone()).unwrap();
    let a: Vec<f64> = model
        .muscles()
        .iter()
        .map(|n| if n.starts_with("zygomaticus") || n.starts_with("risorius") { 0.7 } else { 0. })
        .collect();
    let stiff = model.at(&a).unwrap();
    let settled = stiff.settle(&face, &search, &a, None).unwrap();
    println!("{} rounds, overlap {:.4} mm", settled.rounds, settled.penetration_mm);
    assert!(settled.settled && settled.rounds > 1);
    let (u, forces) = (&settled.equilibrium.displacement, &settled.equilibrium.contact_forces);
    assert!(forces.sum() > 0.01, "{}", forces.sum());
    // The candidates found where the tissue now is: their gaps there are distances, not extrapolations.
    let there = search.at(&face, u, &Pose::rest());
    let overlap = there.overlap_mm();
    assert!(overlap <= 1e-2 && overlap == settled.penetration_mm, "{overlap}");
    let distances = there.distances();
    for (pair, force) in settled.pairs.iter().zip(forces.iter()).filter(|(_, f)| **f > 1e-6) {
        let gap = distances[&(pair.kind, pair.node)];
        assert!(gap.abs() < 2e-2, "node {} presses with {force} N at {gap} mm", pair.node);
    }
}

#[test]
fn the_pressure_of_a_uniform_push_is_its_force_over_its_area() {
    // 6 x 4 rectangles of 10 x 10 mm in front: a node owns the quarters of those about it.
    let mut face = block_face([6, 4, 2]);
    face.mucosa.clone_from(&face.skin);
    let share = |p: Vec3| {
        let half = |at_rim: bool| if at_rim { 0.5 } else { 1. };
        100. * half(p.x.abs() > 29.) * half(p.y.abs() > 19.)
    };
    // 3 kPa = 0.003 N/mm2, as two pushes that are not along the normal of the surface; one node is spared.
    let spared = face.skin[7];
    let (mut pairs, mut forces) = (Vec::new(), Vec::new());
    for pair in front_pairs(&face, 0.).iter().flat_map(|pair| {
        let lean = |x: f64| Pair { row: vec![(pair.node, Vec3::new(x, 0., -0.8))], ..pair.clone() };
        [lean(0.6), lean(-0.6)]
    }) {
        forces.push(0.003 * share(face.mesh.points[pair.node]) / 1.6);
        pairs.push(pair);
    }
    let off_the_mucosa = face.supports[0].nodes[3];
    pairs.push(Pair { node: off_the_mucosa, row: vec![(off_the_mucosa, Vec3::z())], ..pairs[0].clone() });
    forces.push(1.);
    let load = face.contact_load(&pairs, &forces);
    let touched: Vec<usize> = front_pairs(&face, 0.).iter().map(|pair| pair.node).collect();
    assert!(!touched.contains(&spared) && touched.len() > 10);
    for (node, pressure) in load.pressure_kpa.iter().enumerate() {
        let wanted = if touched.contains(&node) { 3. } else { 0. };
        assert!((pressure - wanted).abs() < 1e-12, "{}: {pressure} kPa", face.mesh.points[node]);
    }
}

/// A block whose back moves, before the wall `z >= 12 mm + gap_mm` that stays.
fn before_wall(gap_mm: f64) -> Face {
    let mut face = block_face([6, 4, 2]);
    face.supports[0].bone = "mandible".into();
    face.mucosa.clone_from(&face.skin);
    let surface = cuboid(Vec3::new(-60., -50., 12. + gap_mm), Vec3::new(60., 50., 40.));
    face.teeth = vec![Teeth { upper: true, bone: "skull".into(), surface }];
    face
}

#[test]
fn an_overlap_at_rest_counts_as_touching_from_there_on() {
    let distances = |gap_mm: f64, forward_mm: f64| {
        let face = before_wall(gap_mm);
        let u: Vec<f64> = face.mesh.points.iter().flat_map(|_| [0., 0., forward_mm]).collect();
        let there = ContactSearch::new(&face, ContactReach::default()).at(&face, &u, &Pose::rest());
        assert_eq!(there.distances().len(), face.skin.len());
        there.distances().into_values().collect::<Vec<_>>()
    };
    for (gap, forward, wanted) in [
        (-0.4, 0., 0.),
        (-0.4, 0.3, -0.3),
        (-0.4, -0.3, 0.3),
        (-0.4, -0.9, 0.9),
        (0.4, 0.3, 0.1),
        (0.4, 0.5, -0.1),
    ] {
        let found = distances(gap, forward);
        assert!(found.iter().all(|d| (d - wanted).abs() < 1e-12), "{gap} {forward}: {found:?}");
    }
    // Pushed into a wall that it overlaps the tissue does what it does before a wall that it just touches.
    let pressed = |gap_mm: f64| {
        let face = before_wall(gap_mm);
        let search = ContactSearch::new(&face, ContactReach::default());
        let model = Model::new(&face, search.rest().to_vec()).unwrap();
        let pose = Pose::rest().with("mandible", RigidMotion::translation(Vec3::new(0.7, 0., 1.)));
        let a = [0.8, 0., 0.5];
        let settled = model.at_pose(&a, &pose).unwrap().settle(&face, &search, &a, None).unwrap();
        assert!(settled.settled, "{gap_mm}");
        (DVector::from_vec(settled.equilibrium.displacement), settled.equilibrium.contact_forces.sum())
    };
    let (touching, overlapping) = (pressed(0.), pressed(-0.4));
    assert!(touching.1 > 0.1, "{} N", touching.1);
    assert!((touching.0 - overlapping.0).amax() < 1e-9, "the same displacement");
    assert!((touching.1 / overlapping.1 - 1.).abs() < 1e-9, "{} {}", touching.1, overlapping.1);
}

/// Deepest, mm, that a point lies beyond a patch of tissue surface, in what the tissue is fixed to; nothing beside it.
fn beyond(patch: &Patch, normals: &BTreeMap<usize, Vec3>, p: Vec3) -> f64 {
    let (site, distance) = patch.project(p).unwrap();
    let outward: Vec3 = site.weights.iter().map(|(node, w)| *w * normals[node]).sum();
    let depth = (p - site.position).dot(&outward.normalize());
    if depth > 0.8 * distance { depth } else { 0. }
}

#[test]
fn the_buccinator_presses_the_cheeks_on_teeth_and_gum() {
    let (face, pairs) = coarse();
    let points = &face.mesh.points;
    let corner = face.landmark("cheilion_l").unwrap().site.position;
    // Behind the corners of the mouth, as far as the mucosa reaches: farther back the tissue is fixed to bone.
    let back = face.mucosa.iter().map(|&n| points[n].z).fold(0., f64::min);
    let is_cheek = |p: Vec3| p.x.abs() > corner.x && (back..corner.z).contains(&p.z);
    let arches: Vec<Solid> = face.teeth.iter().map(|t| Solid::new(&t.surface)).collect();
    let nearest = |p: Vec3| {
        let to = arches.iter().map(|arch| arch.project(p).unwrap());
        to.min_by(|a, b| a.distance_mm.total_cmp(&b.distance_mm)).unwrap()
    };

    let search = ContactSearch::new(&face, ContactReach::default());
    let model = Model::new(&face, pairs).unwrap();
    let a: Vec<f64> =
        model.muscles().iter().map(|n| f64::from(u8::from(n.starts_with("buccinator")))).collect();
    let settled = model.at(&a).unwrap().settle(&face, &search, &a, None).unwrap();
    assert!(settled.settled && settled.penetration_mm <= 1e-2);
    let (u, forces) = (&settled.equilibrium.displacement, &settled.equilibrium.contact_forces);
    let moved = |n: usize| points[n] + Vec3::new(u[3 * n], u[3 * n + 1], u[3 * n + 2]);

    // T/R: what the curved fibres load the cheek with, towards the arches.
    let mut inward = 0.;
    for muscle in face.muscles.iter().filter(|m| m.name.starts_with("buccinator")) {
        let tension = muscle.max_force_n / muscle.fibres.len() as f64;
        for p in muscle.fibres.iter().flat_map(|f| f.points.windows(3)).filter(|p| is_cheek(p[1])) {
            let turned = (p[2] - p[1]).normalize() - (p[1] - p[0]).normalize();
            inward -= tension * turned.dot(&nearest(p[1]).normal);
        }
    }
    let (mut side, mut by_arch, mut nodes) = ([0.; 2], BTreeMap::new(), Vec::new());
    for (pair, &force) in settled.pairs.iter().zip(forces.iter()) {
        let at = points[pair.node];
        if force > 0. && pair.kind != PairKind::Lips && is_cheek(at) {
            // Outward, with its cheek: no node has slipped behind the arch.
            assert!(pair.normal().dot(&(moved(pair.node) - Vec3::new(0., at.y, -40.))) > 0., "{pair:?}");
            side[usize::from(at.x < 0.)] += force;
            *by_arch.entry(pair.kind).or_insert(0.) += force;
            nodes.push(pair.node);
        }
    }
    nodes.sort_unstable();
    nodes.dedup();
    println!("cheeks: T/R {inward:.3} N inward, {:.3} N on the arches: {by_arch:.3?}", side[0] + side[1]);
    println!("{} of their nodes press", nodes.len());
    assert!(nodes.len() >= 10 && by_arch.len() == 2, "{by_arch:?}");
    assert!((side[0] - side[1]).abs() < 0.02 * side[0], "{side:?}");
    // The tissue, which hangs from skull and mandible, carries the rest of the line load, and all of it until the
    // gaps are closed; without these more of it is left for the arches.
    let stiff = model.at(&a).unwrap();
    let mut closed = stiff.response(&[]).contact.unwrap();
    closed.gap.fill(0.);
    let at_once = contact_forces(&closed, &DVector::from_vec(a)).unwrap();
    let pressing = model.pairs().iter().zip(at_once.iter());
    let cheeks = pressing.filter(|(p, _)| p.kind != PairKind::Lips && is_cheek(points[p.node]));
    let [share, most] = [side[0] + side[1], cheeks.map(|(_, f)| f).sum()].map(|n: f64| n / inward);
    println!("shares of T/R: {share:.3}, {most:.3} without gaps");
    assert!(0.05 < share && share < most && most < 1., "{share} {most}");

    let (facets, normals) = (Facets::of(&face.mesh), Facets::of(&face.mesh).node_normals(&face.mesh));
    for support in &face.supports {
        let bone = Patch::new(&facets.within(&support.nodes), &face.mesh);
        for &node in &face.mucosa {
            let depth = beyond(&bone, &normals, moved(node));
            assert!(depth < 0.05, "{}: {depth} at {:?}", support.bone, points[node]);
        }
    }
    for &node in &face.mucosa {
        let p = moved(node);
        assert!((-19. ..18.).contains(&p.y) && p.z > -52., "beyond the rim of an arch: {p:?}");
    }
}
