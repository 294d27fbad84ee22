//! Manufactured solutions: the error falls at the rates that the elements' order promises.

use crate::common::block_face::pulled_block;
use crate::common::{cell_displacements, grid, solve};
use modiolus::forward::Model;
use modiolus::forward::elasticity::{isotropic, reinforced};
use modiolus::mesh::{CellKind, Mesh};
use modiolus::units::Vec3;
use nalgebra::{Matrix3, Matrix6, Vector6};

/// Displacement `u_k = A_k sin(w_k . x + b_k)`: every derivative is known in closed form.
#[derive(Clone, Copy)]
struct Waves {
    amplitude: Vec3,
    wave: [Vec3; 3],
    phase: Vec3,
}

impl Waves {
    /// A general field.
    fn general() -> Self {
        Self {
            amplitude: Vec3::new(0.1, -0.08, 0.12),
            wave: [Vec3::new(1.9, 1.1, -0.7), Vec3::new(-1.2, 1.6, 0.9), Vec3::new(0.8, -1.3, 1.7)],
            phase: Vec3::new(0.3, 0.9, -0.4),
        }
    }

    /// A field without divergence, since `u_k` does not vary along `k`: what nearly incompressible
    /// tissue does.
    fn solenoidal() -> Self {
        let mut waves = Self::general();
        for k in 0..3 {
            waves.wave[k][k] = 0.;
        }
        waves
    }

    fn displacement(&self, x: Vec3) -> Vec3 {
        Vec3::from_fn(|k, _| self.amplitude[k] * (self.wave[k].dot(&x) + self.phase[k]).sin())
    }

    fn strain(&self, x: Vec3) -> Vector6<f64> {
        let gradient = Matrix3::from_fn(|k, l| {
            self.amplitude[k] * self.wave[k][l] * (self.wave[k].dot(&x) + self.phase[k]).cos()
        });
        let shear = |k: usize, l: usize| gradient[(k, l)] + gradient[(l, k)];
        Vector6::new(
            gradient[(0, 0)],
            gradient[(1, 1)],
            gradient[(2, 2)],
            shear(0, 1),
            shear(1, 2),
            shear(2, 0),
        )
    }

    /// Body force `-div(C epsilon)` for a constant law.
    fn body_force(&self, law: &Matrix6<f64>, x: Vec3) -> Vec3 {
        const VOIGT: [[usize; 3]; 3] = [[0, 3, 5], [3, 1, 4], [5, 4, 2]];
        let mut force = Vec3::zeros();
        for j in 0..3 {
            // Derivative of the strain along j.
            let second = |k: usize, l: usize| {
                let w = self.wave[k];
                -self.amplitude[k] * w[l] * w[j] * (w.dot(&x) + self.phase[k]).sin()
            };
            let shear = |k: usize, l: usize| second(k, l) + second(l, k);
            let d =
                Vector6::new(second(0, 0), second(1, 1), second(2, 2), shear(0, 1), shear(1, 2), shear(2, 0));
            let stress = law * d;
            for i in 0..3 {
                force[i] -= stress[VOIGT[i][j]];
            }
        }
        force
    }
}

/// A rule far finer than the elements' own: 3-point Gauss in each collapsed direction.
fn fine_rule(kind: CellKind) -> Vec<(Vec3, f64)> {
    let g = 0.6f64.sqrt();
    let line = [(-g, 5. / 9.), (0., 8. / 9.), (g, 5. / 9.)];
    let mut rule = Vec::new();
    for (a, wa) in line {
        for (b, wb) in line {
            for (c, wc) in line {
                let w = wa * wb * wc;
                let half = |x: f64| (1. + x) / 2.;
                rule.push(match kind {
                    CellKind::Hex8 => (Vec3::new(a, b, c), w),
                    // Triangle as a collapsed square, Jacobian (1 - s) / 4.
                    CellKind::Wedge6 => {
                        let s = half(b);
                        (Vec3::new(half(a) * (1. - s), s, c), w * (1. - s) / 4.)
                    }
                    // Tetrahedron as a collapsed cube, Jacobian (1 - s)(1 - t)^2 / 8.
                    _ => {
                        let (s, t) = (half(b), half(c));
                        let r = half(a) * (1. - s) * (1. - t);
                        (Vec3::new(r, s * (1. - t), t), w * (1. - s) * (1. - t).powi(2) / 8.)
                    }
                });
            }
        }
    }
    rule
}

/// Calls `visit(position, weight, shape, gradients)` at the fine rule's points of a cell.
fn integrate(mesh: &Mesh, cell: usize, mut visit: impl FnMut(Vec3, f64, &[f64], &[Vec3])) {
    let kind = mesh.cells[cell].kind();
    let nodes: Vec<Vec3> = mesh.cell_points(cell).collect();
    for (xi, weight) in fine_rule(kind) {
        let (shape, local) = (kind.shape(xi), kind.shape_gradient(xi));
        let mut jacobian = Matrix3::zeros();
        let mut x = Vec3::zeros();
        for (i, p) in nodes.iter().enumerate() {
            jacobian += p * local[i].transpose();
            x += shape[i] * p;
        }
        let to_global = jacobian.try_inverse().unwrap().transpose();
        let gradients = local.map(|g| to_global * g);
        visit(x, weight * jacobian.determinant(), &shape, &gradients);
    }
}

/// L2 errors of displacement and strain.
fn errors(kind: CellKind, n: usize, law: Matrix6<f64>, waves: Waves) -> (f64, f64) {
    let smooth = |p: Vec3| {
        let bump = |a: f64, b: f64| (std::f64::consts::PI * a).sin() * (std::f64::consts::PI * b).sin();
        p + 0.06 * Vec3::new(bump(p.x, p.y + 0.3), bump(p.y, p.z + 0.2), bump(p.z, p.x + 0.1))
    };
    let mesh = grid(kind, [n; 3], smooth);
    let mut on_boundary = vec![false; mesh.n_nodes()];
    let reference = grid(kind, [n; 3], |p| p);
    for (flag, p) in on_boundary.iter_mut().zip(&reference.points) {
        *flag = p.iter().any(|x| x.abs() < 1e-12 || (x - 1.).abs() < 1e-12);
    }
    let prescribed: Vec<(usize, f64)> = (0..3 * mesh.n_nodes())
        .filter(|dof| on_boundary[dof / 3])
        .map(|dof| (dof, waves.displacement(mesh.points[dof / 3])[dof % 3]))
        .collect();
    let mut force = vec![0.; 3 * mesh.n_nodes()];
    for (index, cell) in mesh.cells.iter().enumerate() {
        integrate(&mesh, index, |x, weight, shape, _| {
            let b = waves.body_force(&law, x) * weight;
            for (&node, s) in cell.nodes().iter().zip(shape) {
                for axis in 0..3 {
                    force[3 * node + axis] += s * b[axis];
                }
            }
        });
    }
    let u = solve(&mesh, |_, _| law, &prescribed, &force);
    let (mut displacement, mut strain) = (0., 0.);
    for index in 0..mesh.cells.len() {
        let local = cell_displacements(&mesh, index, &u);
        integrate(&mesh, index, |x, weight, shape, gradients| {
            let uh: Vec3 = local.iter().zip(shape).map(|(u, s)| *s * u).sum();
            let g: Matrix3<f64> = local.iter().zip(gradients).map(|(u, d)| u * d.transpose()).sum();
            let shear = |k: usize, l: usize| g[(k, l)] + g[(l, k)];
            let eh = Vector6::new(g[(0, 0)], g[(1, 1)], g[(2, 2)], shear(0, 1), shear(1, 2), shear(2, 0));
            displacement += weight * (uh - waves.displacement(x)).norm_squared();
            strain += weight * (eh - waves.strain(x)).norm_squared();
        });
    }
    (displacement.sqrt(), strain.sqrt())
}

fn assert_rates(kind: CellKind, n: usize, law: Matrix6<f64>, waves: Waves, least: (f64, f64)) {
    let (coarse, fine) = (errors(kind, n, law, waves), errors(kind, 2 * n, law, waves));
    let rates = ((coarse.0 / fine.0).log2(), (coarse.1 / fine.1).log2());
    println!("{kind:?} {n}->{}: rates {:.2} {:.2}, errors {fine:?}", 2 * n, rates.0, rates.1);
    assert!(rates.0 >= least.0 && rates.1 >= least.1, "{kind:?}: {rates:?} < {least:?}");
}

#[test]
fn linear_elements_converge_at_order_two_and_one() {
    for kind in [CellKind::Hex8, CellKind::Wedge6] {
        assert_rates(kind, 8, isotropic(15., 0.3), Waves::general(), (1.85, 0.95));
    }
}

#[test]
fn quadratic_tetrahedra_converge_at_order_three_and_two() {
    assert_rates(CellKind::Tet10, 4, isotropic(15., 0.3), Waves::general(), (2.8, 1.85));
}

#[test]
fn linear_tetrahedra_converge_at_order_two_and_one() {
    assert_rates(CellKind::Tet4, 8, isotropic(15., 0.3), Waves::general(), (1.75, 0.9));
}

#[test]
fn patches_of_tetrahedra_keep_their_order_when_nearly_incompressible_and_fibrous() {
    let fibre = Vec3::new(2., -1., 3.).normalize();
    for law in [isotropic(15., 0.49), isotropic(15., 0.4999), reinforced(6.2, 0.49, 103.8, fibre)] {
        assert_rates(CellKind::Tet4, 8, law, Waves::solenoidal(), (1.75, 0.9));
    }
}

#[test]
fn b_bar_hexes_keep_their_order_when_nearly_incompressible_and_fibrous() {
    let fibre = Vec3::new(2., -1., 3.).normalize();
    for law in [isotropic(15., 0.49), reinforced(6.2, 0.49, 103.8, fibre)] {
        assert_rates(CellKind::Hex8, 8, law, Waves::solenoidal(), (1.8, 0.95));
    }
}

/// The movement (mm) of the points 5 mm off the middle, the right one mirrored, of a block of `n x n x n/2` hexahedra, or those cut
/// into tetrahedra, under a pair of muscles that stiffen.
fn pulled(kind: CellKind, n: usize) -> [Vec3; 2] {
    let face = pulled_block(kind, [n, n, n / 2]);
    let u = Model::new(&face, Vec::new()).unwrap().at(&[0.5; 2]).unwrap().displacement(&[0.5; 2], &[]);
    let [left, right] = [0, 1].map(|k| face.landmarks[k].site.displacement(&u));
    [left, Vec3::new(-right.x, right.y, right.z)]
}

#[test]
fn a_face_of_tetrahedra_moves_as_one_of_hexahedra_does_when_both_are_refined() {
    let [coarse, fine] = [8, 32].map(|n| {
        let [[hex, mirrored], [left, right]] = [CellKind::Hex8, CellKind::Tet4].map(|kind| pulled(kind, n));
        println!("{n}: hexahedra {hex:.4?}, tetrahedra {left:.4?} {right:.4?}");
        assert!((hex - mirrored).norm() < 1e-9 * hex.norm());
        (hex, (left + right) / 2., (left - right).norm() / hex.norm())
    });
    // A hexahedron cut along one diagonal has no mirror; cells as wide as a muscle is thick do not know where it is.
    let apart = |(hex, tets, _): (Vec3, Vec3, f64)| (hex - tets).norm() / hex.norm();
    let off = (coarse.0 - fine.0).norm() / fine.0.norm();
    assert!(apart(coarse) < 0.5 * off, "{} against {off}", apart(coarse));
    assert!(apart(fine) < 0.05 && fine.2 < 0.5 * coarse.2, "{}, {} {}", apart(fine), fine.2, coarse.2);
}
