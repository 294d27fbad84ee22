//! Patch tests: constant strain is reproduced to round-off whatever the shape of the elements.

use crate::common::{cell_displacements, elements, five_tetrahedra, grid, solve};
use modiolus::forward::Element;
use modiolus::forward::elasticity::{isotropic, reinforced};
use modiolus::mesh::{Cell, CellKind, Mesh};
use modiolus::units::Vec3;
use nalgebra::{DMatrix, Matrix3, Matrix6, Vector6};

/// The seven-element cube of MacNeal and Harder (1985), fig. 5: a distorted inner hex and its six
/// neighbours.
fn patch() -> Mesh {
    let inner = [
        [0.249, 0.342, 0.192],
        [0.826, 0.288, 0.288],
        [0.850, 0.649, 0.263],
        [0.273, 0.750, 0.230],
        [0.320, 0.186, 0.643],
        [0.677, 0.305, 0.683],
        [0.788, 0.693, 0.644],
        [0.165, 0.745, 0.702],
    ];
    let outer = CellKind::Hex8.node_positions().iter().map(|p| (Vec3::from(*p) + Vec3::repeat(1.)) / 2.);
    let points = inner.iter().map(|p| Vec3::from(*p)).chain(outer).collect();
    let mut cells = vec![Cell::new(CellKind::Hex8, &[0, 1, 2, 3, 4, 5, 6, 7])];
    for face in CellKind::Hex8.faces() {
        // Inner face seen from the inner cell's outside, then the outer face above it.
        let nodes: Vec<usize> = face.iter().copied().chain(face.iter().map(|n| n + 8)).collect();
        cells.push(Cell::new(CellKind::Hex8, &nodes));
    }
    Mesh::new(points, cells)
}

/// MacNeal and Harder's displacement field.
fn field(p: Vec3) -> Vec3 {
    1e-3 * Vec3::new(2. * p.x + p.y + p.z, p.x + 2. * p.y + p.z, p.x + p.y + 2. * p.z) / 2.
}

/// Stresses at every integration point when the outer nodes follow [`field`].
fn stresses(law: Matrix6<f64>) -> Vec<Vector6<f64>> {
    let mesh = patch();
    let prescribed: Vec<_> = (8..16)
        .flat_map(|n| (0..3).map(move |axis| (3 * n + axis, n)))
        .map(|(dof, n)| (dof, field(mesh.points[n])[dof % 3]))
        .collect();
    let u = solve(&mesh, |_, _| law, &prescribed, &vec![0.; 48]);
    (0..7)
        .flat_map(|c| {
            let element = Element::new(CellKind::Hex8, &mesh.cell_points(c).collect::<Vec<_>>()).unwrap();
            let local = cell_displacements(&mesh, c, &u);
            (0..8).map(move |q| law * element.strain(q, &local)).collect::<Vec<_>>()
        })
        .collect()
}

#[test]
fn macneal_harder_cube_has_uniform_stress() {
    for (stress, count) in stresses(isotropic(1e6, 0.25)).iter().zip(0..) {
        let expected = Vector6::new(2000., 2000., 2000., 400., 400., 400.);
        assert!((stress - expected).amax() < 1e-11 * 2000., "point {count}: {stress}");
    }
}

#[test]
fn macneal_harder_cube_has_uniform_stress_when_nearly_incompressible() {
    let (young, poisson) = (1e6, 0.4999);
    // Normal strains 1e-3 and shears 1e-3: sigma = 3 K eps, tau = mu gamma.
    let sigma = young / (1. - 2. * poisson) * 1e-3;
    let tau = young / (2. * (1. + poisson)) * 1e-3;
    for stress in stresses(isotropic(young, poisson)) {
        let expected = Vector6::new(sigma, sigma, sigma, tau, tau, tau);
        assert!((stress - expected).amax() < 1e-11 * sigma, "{stress}");
    }
}

#[test]
fn a_rotated_transversely_isotropic_patch_has_uniform_stress() {
    let f = Vec3::new(2., -1., 3.).normalize();
    let (young, poisson, extra) = (6.2, 0.49, 103.8);
    // The stress from the tensors themselves, without Voigt notation.
    let strain: Matrix3<f64> = 1e-3 * Matrix3::new(1., 0.5, 0.5, 0.5, 1., 0.5, 0.5, 0.5, 1.);
    let lambda = young * poisson / ((1. + poisson) * (1. - 2. * poisson));
    let mu = young / (2. * (1. + poisson));
    let tensor: Matrix3<f64> = Matrix3::identity() * lambda * strain.trace()
        + 2. * mu * strain
        + extra * f.dot(&(strain * f)) * f * f.transpose();
    let expected = Vector6::new(
        tensor[(0, 0)],
        tensor[(1, 1)],
        tensor[(2, 2)],
        tensor[(0, 1)],
        tensor[(1, 2)],
        tensor[(2, 0)],
    );
    for stress in stresses(reinforced(young, poisson, extra, f)) {
        assert!((stress - expected).amax() < 1e-11 * expected.amax(), "{stress} {expected}");
    }
}

#[test]
fn patches_of_tetrahedra_have_uniform_strain_whatever_their_shape() {
    let bump = |p: Vec3| p + 0.05 * Vec3::new((9. * p.y).sin(), (7. * p.z).sin(), (8. * p.x).sin());
    for mesh in [grid(CellKind::Tet4, [3, 4, 3], bump), five_tetrahedra([4, 3, 3], bump)] {
        // The shape of the block is a map of the cube, whose sides are told by their faces.
        let mut sides = vec![0; mesh.n_nodes()];
        let facets = modiolus::mesh::boundary_facets(&mesh);
        facets.iter().flat_map(|f| f.corners()).for_each(|&n| sides[n] += 1);
        let inner = sides.iter().filter(|n| **n == 0).count();
        assert!(inner >= 12, "{inner} free nodes");
        for poisson in [0.3, 0.49, 0.4999] {
            let law = isotropic(1e6, poisson);
            let prescribed: Vec<_> = (0..3 * mesh.n_nodes())
                .filter(|dof| sides[dof / 3] > 0)
                .map(|dof| (dof, field(mesh.points[dof / 3])[dof % 3]))
                .collect();
            let u = solve(&mesh, |_, _| law, &prescribed, &vec![0.; 3 * mesh.n_nodes()]);
            for (node, p) in mesh.points.iter().enumerate() {
                let found = Vec3::new(u[3 * node], u[3 * node + 1], u[3 * node + 2]);
                assert!((found - field(*p)).norm() < 1e-13, "nu {poisson}, node {node}: {found:?}");
            }
            let expected = Vector6::new(1., 1., 1., 1., 1., 1.) * 1e-3;
            for (element, nodes) in elements(&mesh) {
                let local: Vec<Vec3> =
                    nodes.iter().map(|&n| Vec3::new(u[3 * n], u[3 * n + 1], u[3 * n + 2])).collect();
                for q in 0..element.points().len() {
                    assert!((element.strain(q, &local) - expected).amax() < 1e-12);
                }
            }
        }
    }
}

#[test]
fn a_free_element_and_a_free_body_have_exactly_six_rigid_modes() {
    let law = reinforced(6.2, 0.49, 103.8, Vec3::new(1., 2., -1.).normalize());
    let warp = |p: Vec3| 3. * p + 0.3 * Vec3::new(p.y * p.z, p.x * p.z, p.x * p.y);
    for kind in CellKind::ALL {
        let nodes: Vec<Vec3> = kind.node_positions().iter().map(|p| warp(Vec3::from(*p))).collect();
        let k = Element::new(kind, &nodes).unwrap().stiffness(|_| law);
        let n = kind.n_nodes();
        let dense = DMatrix::from_fn(3 * n, 3 * n, |r, c| k[(r / 3) * n + c / 3][(r % 3, c % 3)]);
        assert_six_zeros(&dense, &format!("{kind:?}"));

        let dense = assembled(&grid(kind, [2, 1, 1], warp), law);
        assert_six_zeros(&dense, &format!("body of {kind:?}"));
    }
    assert_six_zeros(&assembled(&five_tetrahedra([3, 2, 2], warp), law), "body of patches of many shapes");
}

/// The stiffness of a free body.
fn assembled(mesh: &Mesh, law: Matrix6<f64>) -> DMatrix<f64> {
    let mut dense = DMatrix::zeros(3 * mesh.n_nodes(), 3 * mesh.n_nodes());
    for (element, nodes) in elements(mesh) {
        let k = element.stiffness(|_| law);
        for (a, &i) in nodes.iter().enumerate() {
            for (b, &j) in nodes.iter().enumerate() {
                let mut block = dense.view_mut((3 * i, 3 * j), (3, 3));
                block += k[a * nodes.len() + b];
            }
        }
    }
    dense
}

fn assert_six_zeros(k: &DMatrix<f64>, what: &str) {
    let mut values: Vec<f64> = k.symmetric_eigenvalues().iter().copied().collect();
    values.sort_by(f64::total_cmp);
    let largest = values[values.len() - 1];
    assert!(values[..6].iter().all(|v| v.abs() < 1e-9 * largest), "{what}: {:?}", &values[..7]);
    assert!(values[6] > 1e-6 * largest, "{what} has a seventh zero: {:?}", &values[..8]);
}
