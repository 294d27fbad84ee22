//! Bones that move: rigid motions, closed forms, reciprocity, the jaw, and the derivative by its opening.
#![allow(clippy::unwrap_used, reason = "a test that cannot go on should say where")]

use std::collections::BTreeMap;

use crate::common::block_face::{block_face, jaw_block, jaw_pairs};
use crate::common::grid;
use crate::common::piece::{jacobian_on_piece, observed_at};
use modiolus::contact::Solid;
use modiolus::face::standard::{Resolution, standard};
use modiolus::face::{ContactReach, Face, JawRange, MuscleLaw, Pose, RigidMotion, Support, Tissue};
use modiolus::forward::{FixedStiffness, Model};
use modiolus::mesh::{CellKind, Quality, Site};
use modiolus::units::Vec3;
use nalgebra::DVector;

const CELLS: [usize; 3] = [10, 8, 4];

fn node(u: &[f64], n: usize) -> Vec3 {
    Vec3::new(u[3 * n], u[3 * n + 1], u[3 * n + 2])
}

/// Every bone of `face` moved alike.
fn whole(face: &Face, motion: RigidMotion) -> Pose {
    face.bones().iter().fold(Pose::rest(), |pose, bone| pose.with(bone, motion))
}

#[test]
fn a_translation_of_every_bone_carries_the_face_without_strain_or_change_of_gaps() {
    let face = standard(&Resolution::COARSE);
    let pairs = face.contact_pairs(ContactReach::default());
    let model = Model::new(&face, pairs).unwrap();
    let t = Vec3::new(1.5, -0.7, 2.);
    let stiff =
        model.at_pose(&vec![0.3; face.muscles.len()], &whole(&face, RigidMotion::translation(t))).unwrap();
    let u = stiff.displacement(&vec![0.; face.muscles.len()], &[]);
    let worst = (0..face.mesh.n_nodes()).map(|n| (node(&u, n) - t).norm()).fold(0., f64::max);
    assert!(worst < 1e-9, "{worst:e}");
    let sites: Vec<Site> = face.landmarks.iter().map(|l| l.site.clone()).collect();
    let response = stiff.response(&sites);
    assert!(response.offset.as_slice().chunks(3).all(|o| (Vec3::from_column_slice(o) - t).norm() < 1e-9));
    let gaps = &response.contact.unwrap().gap;
    let kept = model.pairs().iter().zip(gaps.iter()).map(|(p, g)| (p.gap_mm - g).abs()).fold(0., f64::max);
    assert!(kept < 1e-9, "teeth and tissue move together: {kept:e}");
}

#[test]
fn a_rotation_of_every_bone_is_rigid_to_second_order() {
    let face = block_face(CELLS);
    let model = Model::new(&face, Vec::new()).unwrap();
    let error = |degrees: f64| {
        let turn = RigidMotion::rotation(Vec3::new(3., 1., -40.), Vec3::new(1., 0.3, 0.2), degrees).unwrap();
        let u = model.at_pose(&[0.; 3], &whole(&face, turn)).unwrap().displacement(&[0.; 3], &[]);
        let off = |n: usize| (node(&u, n) - turn.displacement(face.mesh.points[n])).norm();
        (0..face.mesh.n_nodes()).map(off).fold(0., f64::max)
    };
    let (two, one) = (error(2.), error(1.));
    assert!(one < 0.01 && one > 1e-6, "{one}");
    assert!((1.9..2.1).contains(&(two / one).log2()), "{two} {one}");
}

/// A block 20 x 20 x 30 mm between two bones, of tissue that does not contract across a pull.
fn bar() -> Face {
    let mesh = grid(CellKind::Hex8, [3, 3, 5], |p| Vec3::new(20. * p.x, 20. * p.y, 30. * p.z));
    let at = |z: f64| (0..mesh.n_nodes()).filter(|&n| (mesh.points[n].z - z).abs() < 1e-9).collect();
    let bone = |bone: &str, z| Support { bone: bone.into(), part_of: None, nodes: at(z) };
    let supports = vec![bone("skull", 0.), bone("mandible", 30.)];
    let tissue = Tissue { poisson: 0., ..Tissue::default() };
    Face {
        mesh,
        supports,
        tissue,
        muscles: Vec::new(),
        skin: Vec::new(),
        landmarks: Vec::new(),
        ..block_face(CELLS)
    }
}

#[test]
fn a_bar_between_two_bones_stretches_evenly_and_pulls_with_e_a_over_l() {
    let face = bar();
    let model = Model::new(&face, Vec::new()).unwrap();
    let pose = Pose::rest().with("mandible", RigidMotion::translation(Vec3::new(0., 0., 1.2)));
    let u = model.at_pose(&[], &pose).unwrap().displacement(&[], &[]);
    for (n, p) in face.mesh.points.iter().enumerate() {
        assert!((node(&u, n) - Vec3::new(0., 0., 1.2 * p.z / 30.)).norm() < 1e-10, "{p:?}");
    }
    let force = model.stiffness().pattern().multiply(&model.stiffness_at(&[]), &u);
    let pull: f64 = face.supports[1].nodes.iter().map(|n| force[3 * n + 2]).sum();
    // 15 kPa = 0.015 N/mm2 over 400 mm2, strain 0.04.
    assert!((pull - 0.015 * 400. * 0.04).abs() < 1e-10, "{pull}");
}

#[test]
fn what_a_bone_does_to_the_tissue_is_what_the_tissue_does_to_the_bone() {
    // Betti: f . u(u_b) = -R(f) . u_b, with R(f) the force that holds the bones still under f.
    let face = jaw_block(CELLS);
    let model = Model::new(&face, Vec::new()).unwrap();
    let a = [0.7, 0.2, 0.9];
    let pose = Pose::opened(face.jaw.as_ref().unwrap(), 3.);
    let moved = model.at_pose(&a, &pose).unwrap().displacement(&[0.; 3], &[]);
    let held = model.at(&a).unwrap().displacement(&[1., 0., 0.], &[]);
    let mut reaction = model.stiffness().pattern().multiply(&model.stiffness_at(&a), &held);
    let mut work = 0.;
    for &(dof, f) in &model.loads()[0] {
        reaction[dof] -= f;
        work += f * moved[dof];
    }
    let u_b = face.bone_displacement(&pose);
    let by_bone: f64 = -reaction.iter().zip(&u_b).map(|(r, u)| r * u).sum::<f64>();
    // The load on the bones themselves does work on them without the tissue.
    let own: f64 = model.loads()[0].iter().map(|&(dof, f)| f * u_b[dof]).sum();
    assert!(by_bone.abs() > 1e-3);
    assert!((work - own - by_bone + own).abs() < 1e-10 * by_bone.abs().max(1.), "{work} {own} {by_bone}");
}

#[test]
fn the_jaw_opens_by_ten_millimetres_without_tearing_the_standard_face() {
    let face = standard(&Resolution::STANDARD);
    let model = Model::new(&face, Vec::new()).unwrap();
    let jaw = face.jaw.as_ref().unwrap();
    let u = model.at_pose(&vec![0.; face.muscles.len()], &Pose::opened(jaw, 10.)).unwrap();
    let u = u.displacement(&vec![0.; face.muscles.len()], &[]);
    let mut moved = face.mesh.clone();
    (0..moved.n_nodes()).for_each(|n| moved.points[n] += node(&u, n));
    let quality = |c: usize| Quality::new(&moved.cells[c], &moved.points).scaled_jacobian;
    let mut worst: Vec<(f64, usize)> = (0..moved.cells.len()).map(|c| (quality(c), c)).collect();
    worst.sort_by(|a, b| a.0.total_cmp(&b.0));
    let lip = |name: &str| face.landmark(name).unwrap().site.displacement(&u).y;
    assert!(lip("stomion_inferius") < -8. && lip("stomion_superius") > -2., "the mouth opens");
    assert!(worst[0].0 > 0.1, "{:?} at {:?}", worst[0], face.mesh.cell_points(worst[0].1).next());
}

/// Where the tissue is at rest under `a` with the jaw at a share of its range.
fn at_rest(
    model: &Model,
    range: JawRange,
    sites: &[Site],
    x: &[f64],
) -> (DVector<f64>, DVector<f64>, Vec<f64>) {
    let stiff = stiff(model, range, x);
    let response = stiff.response(sites);
    let found = stiff.equilibrium(response.contact.as_ref()).unwrap();
    let seen = sites.iter().flat_map(|s| {
        let u = s.displacement(&found.displacement);
        [u.x, u.y, u.z]
    });
    (DVector::from_iterator(3 * sites.len(), seen), found.contact_forces, found.displacement)
}

fn stiff<'m>(model: &'m Model, range: JawRange, x: &[f64]) -> FixedStiffness<'m> {
    model.at_opening(&x[..x.len() - 1], range, x[x.len() - 1]).unwrap()
}

#[test]
fn the_jacobian_by_activations_and_opening_is_the_derivative() {
    let range = JawRange { min_mm: 1., max_mm: 9. };
    for law in [MuscleLaw::Reinforced, MuscleLaw::Orthotropic] {
        for contact in [false, true] {
            let mut face = jaw_block(CELLS);
            face.muscle_tissue.law = law;
            let pairs = if contact { jaw_pairs(&face, 0.01) } else { Vec::new() };
            let model = Model::new(&face, pairs).unwrap();
            // One site on a moved node: it must be seen to move with the bone.
            let held = face.supports[1].nodes[3];
            let mut sites: Vec<Site> = face.landmarks.iter().map(|l| l.site.clone()).collect();
            sites.push(Site::node(held, face.mesh.points[held]));
            let x = [0.6, 0.35, 0.5, 0.4];
            let (observed, forces, u) = at_rest(&model, range, &sites, &x);
            let here = stiff(&model, range, &x);
            let tangent = here.tangent(&sites, &here.response(&sites), &u);
            assert_eq!(contact, forces.iter().any(|f| *f > 0.), "contact presses when it is on");
            let jacobian = jacobian_on_piece(&tangent, &forces);
            // The tangent meets the state it was taken at.
            assert!((observed_at(&tangent, &x, &forces) - &observed).amax() < 1e-10);
            let h = 1e-4;
            for k in 0..4 {
                let moved = |step: f64| {
                    let mut y = x;
                    y[k] += step;
                    at_rest(&model, range, &sites, &y)
                };
                let (hi, lo) = (moved(h), moved(-h));
                let same = |f: &DVector<f64>| (0..f.len()).all(|i| (f[i] > 0.) == (forces[i] > 0.));
                assert!(same(&hi.1) && same(&lo.1), "the difference stays on one piece");
                let difference = (hi.0 - lo.0) / (2. * h);
                let error = (jacobian.column(k) - difference).amax() / jacobian.amax();
                assert!(error < 1e-6, "{law:?} contact {contact} unknown {k}: {error:e}");
            }
        }
    }
}

#[test]
fn pairs_found_at_a_pose_give_the_distance_to_the_teeth_where_they_are() {
    let face = standard(&Resolution::COARSE);
    let reach = ContactReach::default();
    let jaw = face.jaw.as_ref().unwrap();
    let pose = Pose::opened(jaw, 6.);
    let u = face.bone_displacement(&pose);
    let pairs = face.contact_pairs_at(reach, &u, &pose).pairs;
    let teeth = face.teeth_at(&pose);
    let solids: Vec<Solid> = teeth.iter().map(|t| Solid::new(&t.surface)).collect();
    let by_teeth = face.tooth_changes(&pairs, &pose);
    // A node has a plane for each flank that it is near; one of them is the closest point's.
    let mut met: BTreeMap<(usize, usize), bool> = BTreeMap::new();
    for (pair, tooth) in pairs.iter().zip(by_teeth) {
        let Some(at) = pair.tooth else { continue };
        let x = face.mesh.points[pair.node] + node(&u, pair.node);
        let found = solids[at.surface].project(x).unwrap();
        // Inside, the way out may be another one than the nearest.
        let gap = pair.gap_mm + pair.change_mm(&u) + tooth - pair.rest_overlap_mm;
        *met.entry((at.surface, pair.node)).or_default() |= (gap - found.distance_mm).abs() < 1e-9;
    }
    let strayed: Vec<_> = met.iter().filter(|(_, met)| !**met).collect();
    assert!(strayed.is_empty(), "{strayed:?}");
    let seen = met.keys().filter(|(surface, _)| teeth[*surface].bone == "mandible").count();
    assert!(seen > 20, "{seen}");
}
