//! Barrier contact on the standard face: lips, cheeks and teeth.

use std::collections::HashMap;

use modiolus::contact::{Barrier, BarrierContact, BarrierError, Body, CollisionSurface, Curvature, Facets};
use modiolus::face::Face;
use modiolus::face::standard::{Resolution, standard};
use modiolus::units::Vec3;

const BARRIER: Barrier = Barrier { reach_mm: 0.3, stiffness: 0.02 };

/// The facets of the face none of whose nodes is fixed to a bone, against its teeth.
fn surface(face: &Face) -> CollisionSurface {
    let mut free = vec![true; face.mesh.n_nodes()];
    face.supports.iter().flat_map(|s| &s.nodes).for_each(|&node| free[node] = false);
    let free: Vec<usize> = (0..free.len()).filter(|&node| free[node]).collect();
    let teeth: Vec<_> = face.teeth.iter().map(|t| &t.surface).collect();
    CollisionSurface::new(&face.mesh, &Facets::of(&face.mesh).within(&free), &teeth, 1)
}

fn teeth(face: &Face) -> Vec<Vec<Vec3>> {
    face.teeth.iter().map(|t| t.surface.points.clone()).collect()
}

/// Lips that are drawn back and together, the same on both sides, so far that they cross and enter the teeth.
fn drawn(face: &Face) -> Vec<Vec3> {
    let pull = |p: &Vec3| {
        let near = (-(p.x * p.x + p.y * p.y) / 900.).exp();
        near * Vec3::new(-0.04 * p.x, -0.06 * p.y, -1.5)
    };
    face.mesh.points.iter().map(|p| p + pull(p)).collect()
}

/// Nodes and vertices of the face after `steps` steps towards drawn lips, each of nine tenths of what the limit allows.
fn pressed(face: &Face, contact: &BarrierContact, steps: usize) -> (Vec<Vec3>, Vec<Vec3>) {
    let teeth = teeth(face);
    let wished = drawn(face);
    let to = contact.surface().positions(&wished, &teeth);
    let mut nodes = face.mesh.points.clone();
    let mut x = contact.surface().positions(&nodes, &teeth);
    for _ in 0..steps {
        let limit = contact.step_limit(&x, &to, &contact.candidates(&x, &to));
        assert!(limit > 0. && limit < 1., "{limit}");
        nodes = nodes.iter().zip(&wished).map(|(p, q)| p.lerp(q, 0.9 * limit)).collect();
        x = contact.surface().positions(&nodes, &teeth);
    }
    (nodes, x)
}

#[test]
fn the_standard_face_rests_free_of_contact_and_never_crosses_itself_or_its_teeth() {
    let face = standard(&Resolution::COARSE);
    let surface = surface(&face);
    let rest = surface.positions(&face.mesh.points, &teeth(&face));
    let contact = BarrierContact::new(surface.clone(), &rest, BARRIER).unwrap();
    assert!(contact.reaches_mm()[..surface.n_tissue_vertices()].iter().all(|r| *r > 0.005));
    let candidates = contact.candidates(&rest, &rest);
    assert_eq!(contact.energy(&rest, &candidates), 0.);
    assert!(contact.contact_points(&rest, &candidates).is_empty());

    let (_, x) = pressed(&face, &contact, 3);
    let candidates = contact.candidates(&x, &x);
    assert!(contact.least_distance_mm(&x, &candidates) > 0.);
    let points = contact.contact_points(&x, &candidates);
    let met = |body| points.iter().filter(|p| p.bodies[0] == body || p.bodies[1] == body).count();
    assert!(met(Body::Tissue) > 20, "{} {}", met(Body::Tissue), points.len());
    // Whether surfaces cross is asked of those who start there.
    assert!(BarrierContact::new(surface.clone(), &x, BARRIER).is_ok());
    // Without limit they do.
    let far = surface.positions(&drawn(&face), &teeth(&face));
    let Err(BarrierError::Intersecting { crossings }) = BarrierContact::new(surface, &far, BARRIER) else {
        panic!("nothing crosses");
    };
    assert!(crossings.len() > 20, "{}", crossings.len());
}

#[test]
fn a_symmetric_face_has_symmetric_contact() {
    let face = standard(&Resolution::COARSE);
    let surface = surface(&face);
    let rest = surface.positions(&face.mesh.points, &teeth(&face));
    let contact = BarrierContact::new(surface, &rest, BARRIER).unwrap();
    let (nodes, x) = pressed(&face, &contact, 1);
    let key = |p: &Vec3, side: f64| [side * p.x, p.y, p.z].map(|c| (c * 1e6).round() as i64);
    let at: HashMap<_, usize> = nodes.iter().enumerate().map(|(k, p)| (key(p, 1.), k)).collect();
    let mirror: Vec<usize> = nodes.iter().map(|p| at[&key(p, -1.)]).collect();
    let d = contact.derivatives(&x, &contact.candidates(&x, &x), Curvature::Projected);
    let scale = d.gradient.iter().fold(0., |m: f64, g| m.max(g.abs()));
    assert!(scale > 1e-3, "{scale}");
    let blocks: HashMap<[usize; 2], _> = d.blocks.iter().map(|(i, j, b)| ([*i, *j], *b)).collect();
    let stiffest = d.blocks.iter().map(|b| b.2.amax()).fold(0., f64::max);
    for (k, &other) in mirror.iter().enumerate() {
        for axis in 0..3 {
            let sign = if axis == 0 { -1. } else { 1. };
            let (g, h) = (d.gradient[3 * k + axis], d.gradient[3 * other + axis]);
            assert!((g - sign * h).abs() < 1e-11 * scale, "{k} {axis}: {g} {h} of {scale}");
        }
    }
    for (&[i, j], block) in &blocks {
        let (k, l) = (mirror[i], mirror[j]);
        let image = if k >= l { blocks[&[k, l]] } else { blocks[&[l, k]].transpose() };
        for a in 0..3 {
            for b in 0..3 {
                let sign = if (a == 0) == (b == 0) { 1. } else { -1. };
                let difference = (block[(a, b)] - sign * image[(a, b)]).abs();
                assert!(difference < 1e-11 * stiffest, "{i} {j}: {difference} of {stiffest}");
            }
        }
    }
}
