//! Embedded fibres against the continuum that a dense bundle of them makes.

use crate::common::grid;
use modiolus::face::Fibre;
use modiolus::forward::elasticity::isotropic;
use modiolus::forward::{active_stress_forces, fibre_forces};
use modiolus::mesh::{CellKind, Locator, Mesh};
use modiolus::units::Vec3;

/// Total tension, N, over the 8 x 8 mm cross-section of a bent block.
const TENSION_N: f64 = 3.2;

/// A block bent into an arc: `x` runs along it, radii 16 to 24 mm.
fn bend(p: Vec3) -> Vec3 {
    let (sin, cos) = (1.2 * p.x - 0.6).sin_cos();
    let r = 16. + 8. * p.y;
    Vec3::new(r * sin, r * cos, 8. * p.z)
}

/// Nodal forces of `n x n` arc fibres, each at the centre of its share of the cross-section.
fn bundle_forces(mesh: &Mesh, n: usize) -> Vec<f64> {
    let locator = Locator::new(mesh);
    let mut forces = vec![0.; 3 * mesh.n_nodes()];
    for row in 0..n {
        for column in 0..n {
            let at = |k: usize| (k as f64 + 0.5) / n as f64;
            let points =
                (0..=400).map(|s| bend(Vec3::new(f64::from(s) / 400., at(row), at(column)))).collect();
            let fibre = Fibre { points, closed: false };
            for (point, force) in
                fibre.points.iter().zip(fibre_forces(&fibre, TENSION_N / (n * n) as f64, 0.))
            {
                for (node, weight) in locator.locate(*point).unwrap().site.weights {
                    for axis in 0..3 {
                        forces[3 * node + axis] += weight * force[axis];
                    }
                }
            }
        }
    }
    forces
}

#[test]
fn a_dense_bundle_tends_to_active_stress() {
    let mesh = grid(CellKind::Hex8, [96, 2, 2], bend);
    let along = |x: Vec3| Some((TENSION_N / 64., Vec3::new(x.y, -x.x, 0.).normalize()));
    let continuum = active_stress_forces(&mesh, along).unwrap();
    let fixed: Vec<(usize, f64)> = (0..3 * mesh.n_nodes())
        .filter(|dof| {
            let p = mesh.points[dof / 3];
            (p.x.atan2(p.y) + 0.6).abs() < 1e-9
        })
        .map(|dof| (dof, 0.))
        .collect();
    let displacement =
        |force: &[f64]| crate::common::solve(&mesh, |_, _| isotropic(0.015, 0.49), &fixed, force);
    let reference = displacement(&continuum);
    let size = reference.iter().map(|u| u * u).sum::<f64>().sqrt();
    let difference: Vec<f64> = [1, 3, 9]
        .into_iter()
        .map(|n| {
            let u = displacement(&bundle_forces(&mesh, n));
            u.iter().zip(&reference).map(|(a, b)| (a - b).powi(2)).sum::<f64>().sqrt() / size
        })
        .collect();
    println!("bundles of 1, 9, 81 fibres against active stress: {difference:?}");
    // Odd bundles never align with the cells. The rate is per fibre: nine times as many each time.
    for pair in difference.windows(2) {
        assert!((pair[0] / pair[1]).ln() / 9f64.ln() > 0.8, "{difference:?}");
    }
    assert!(difference[2] < 0.02, "{difference:?}");
}
