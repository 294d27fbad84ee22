//! The activation map: reciprocity, mirror symmetry, and the same answer by different routes.

use crate::common::block_face::{block_face, front_pairs};
use modiolus::forward::Model;
use modiolus::mesh::Site;
use modiolus::units::Vec3;
use nalgebra::DMatrix;

fn sites(face: &modiolus::face::Face) -> Vec<Site> {
    let mut sites: Vec<Site> = face.landmarks.iter().map(|l| l.site.clone()).collect();
    sites.push(Site { position: Vec3::zeros(), weights: vec![(10, 0.25), (40, 0.5), (77, 0.25)] });
    sites
}

#[test]
fn the_response_is_the_full_map_seen_at_the_sites() {
    let face = block_face([12, 8, 4]);
    let model = Model::new(&face, front_pairs(&face, 0.5)).unwrap();
    let fixed = model.at(&[0.5; 3]).unwrap();
    let sites = sites(&face);
    let response = fixed.response(&sites);
    let contact = response.contact.unwrap();
    // Full solves with backward substitution, an independent route to P K^-1 F and G K^-1 [F G'].
    let map = fixed.map();
    let scale = response.map.amax();
    for (muscle, u) in map.iter().enumerate() {
        for (s, site) in sites.iter().enumerate() {
            let seen = site.displacement(u);
            for axis in 0..3 {
                assert!((response.map[(3 * s + axis, muscle)] - seen[axis]).abs() < 1e-10 * scale);
            }
        }
        for (c, pair) in model.pairs().iter().enumerate() {
            let seen: f64 =
                pair.row.iter().map(|(n, g)| g.dot(&Vec3::new(u[3 * n], u[3 * n + 1], u[3 * n + 2]))).sum();
            assert!((contact.approach[(c, muscle)] - seen).abs() < 1e-10 * scale);
        }
    }
    for c in [0, 7, 20] {
        let mut forces = vec![0.; contact.gap.len()];
        forces[c] = 1.;
        let u = fixed.displacement(&[0.; 3], &forces);
        let column: DMatrix<f64> =
            DMatrix::from_iterator(contact.gap.len(), 1, model.pairs().iter().map(|p| -u[3 * p.node + 2]));
        assert!((contact.compliance.column(c) - column.column(0)).amax() < 1e-10 * contact.compliance.amax());
        for (s, site) in sites.iter().enumerate() {
            let seen = site.displacement(&u);
            assert!(
                (contact.reach.fixed_view::<3, 1>(3 * s, c) - seen).amax()
                    < 1e-10 * contact.compliance.amax()
            );
        }
    }
}

#[test]
fn displacements_and_forces_are_reciprocal() {
    // P K^-1 F by solving for F, and (F' K^-1 P')' by solving for P'.
    let face = block_face([12, 8, 4]);
    let model = Model::new(&face, Vec::new()).unwrap();
    let fixed = model.at(&[0.5; 3]).unwrap();
    let map = fixed.map();
    let sites = sites(&face);
    let unit_forces: Vec<Vec<f64>> = sites
        .iter()
        .flat_map(|site| {
            (0..3).map(|axis| {
                let mut force = vec![0.; model.n_dofs()];
                site.weights.iter().for_each(|&(n, w)| force[3 * n + axis] += w);
                force
            })
        })
        .collect();
    for (row, u) in fixed.cholesky().displacements(&unit_forces).iter().enumerate() {
        for (muscle, load) in model.loads().iter().enumerate() {
            let backward: f64 = load.iter().map(|&(dof, f)| f * u[dof]).sum();
            let forward = sites[row / 3].displacement(&map[muscle])[row % 3];
            assert!(
                (backward - forward).abs() < 1e-10 * map[muscle].iter().fold(0f64, |a, b| a.max(b.abs()))
            );
        }
    }
}

#[test]
fn a_symmetric_face_has_a_mirrored_map() {
    let face = block_face([12, 8, 4]);
    let model = Model::new(&face, Vec::new()).unwrap();
    let map = model.at(&[0.3, 0.3, 0.8]).unwrap().map();
    let mirror = |node: usize| {
        let p = face.mesh.points[node].component_mul(&Vec3::new(-1., 1., 1.));
        face.mesh.points.iter().position(|q| (q - p).norm() < 1e-9).unwrap()
    };
    let scale = map[0].iter().fold(0f64, |a, b| a.max(b.abs()));
    assert!(scale > 0.1, "the muscle moves something: {scale} mm");
    for node in 0..face.mesh.n_nodes() {
        let other = mirror(node);
        for axis in 0..3 {
            let sign = if axis == 0 { -1. } else { 1. };
            assert!((map[0][3 * node + axis] - sign * map[1][3 * other + axis]).abs() < 1e-10 * scale);
            assert!((map[2][3 * node + axis] - sign * map[2][3 * other + axis]).abs() < 1e-10 * scale);
        }
    }
}

#[test]
fn muscle_loads_and_reactions_balance() {
    let face = block_face([12, 8, 4]);
    let model = Model::new(&face, Vec::new()).unwrap();
    let activation = [0.7, 0.2, 0.4];
    let u = model.at(&activation).unwrap().displacement(&activation, &[]);
    let values = model.stiffness_at(&activation);
    let mut residual = model.stiffness().pattern().multiply(&values, &u);
    for (load, a) in model.loads().iter().zip(activation) {
        load.iter().for_each(|&(dof, f)| residual[dof] -= a * f);
    }
    let supported: std::collections::HashSet<usize> = face.supports[0].nodes.iter().copied().collect();
    let mut reaction = Vec3::zeros();
    for node in 0..face.mesh.n_nodes() {
        let r = Vec3::new(residual[3 * node], residual[3 * node + 1], residual[3 * node + 2]);
        if supported.contains(&node) {
            reaction += r;
        } else {
            assert!(r.norm() < 1e-10, "free node {node} is not in equilibrium: {r}");
        }
    }
    // Fibres are tissue to tissue: their forces sum to zero, and so do the reactions.
    assert!(reaction.norm() < 1e-9, "{reaction}");
}

#[test]
fn stiffness_parts_add_up_to_the_reassembled_stiffness() {
    let face = block_face([6, 4, 2]);
    let model = Model::new(&face, Vec::new()).unwrap();
    let u: Vec<f64> = (0..model.n_dofs()).map(|i| ((i * 37 % 101) as f64 / 101.) - 0.5).collect();
    let pattern = model.stiffness().pattern();
    let whole = pattern.multiply(&model.stiffness_at(&[0.2, 0.9, 0.4]), &u);
    let mut sum = pattern.multiply(&model.stiffness_at(&[0.; 3]), &u);
    for (muscle, a) in [0.2, 0.9, 0.4].into_iter().enumerate() {
        let force = model.stiffening(muscle, a, &u);
        assert!(force.iter().zip(&u).map(|(f, u)| f * u).sum::<f64>() >= 0., "K_m is not negative");
        sum.iter_mut().zip(force).for_each(|(s, f)| *s += a * f);
    }
    assert!(whole.iter().zip(&sum).all(|(a, b)| (a - b).abs() < 1e-12));
}
