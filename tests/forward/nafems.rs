//! NAFEMS benchmarks of stress where it concentrates (The Standard NAFEMS Benchmarks, 1990): LE1 and LE10, on
//! quadratic tetrahedra.

use std::f64::consts::FRAC_PI_2;

use crate::common::{cell_displacements, grid, solve};
use modiolus::forward::Element;
use modiolus::forward::elasticity::isotropic;
use modiolus::mesh::{CellKind, Mesh};
use modiolus::units::Vec3;
use nalgebra::Vector6;

/// Young's modulus of both benchmarks, N/mm2; lengths are in m, which leaves the unit of stress as it is.
const YOUNG: f64 = 210e3;
const POISSON: f64 = 0.3;
/// Where the stress is asked for, but for its height.
const D: [f64; 2] = [2., 0.];

/// A quarter of the plate between the ellipses with half axes 2 and 1, and 3.25 and 2.75.
fn quarter([across, around, through]: [usize; 3], thickness: f64) -> Mesh {
    // Cells get smaller towards the hole and towards D.
    let grade = |t: f64| t * (0.4 + 0.6 * t);
    grid(CellKind::Tet10, [across, around, through], |p| {
        let (sin, cos) = (grade(p.y) * FRAC_PI_2).sin_cos();
        let t = grade(p.x);
        let (a, b) = (2. + 1.25 * t, 1. + 1.75 * t);
        Vec3::new(a * cos, b * sin, thickness * p.z)
    })
}

/// Distance of a point from the outer ellipse, in the units of its equation.
fn off_outer(p: Vec3) -> f64 {
    ((p.x / 3.25).powi(2) + (p.y / 2.75).powi(2) - 1.).abs()
}

/// Adds the consistent forces of `traction(unit normal)` on the outer faces whose nodes all satisfy `select`.
fn press(mesh: &Mesh, select: impl Fn(Vec3) -> bool, traction: impl Fn(Vec3) -> Vec3, force: &mut [f64]) {
    let kind = CellKind::Tet10;
    // Degree 4: weights and barycentric coordinates (Dunavant 1985).
    let rule =
        [(0.109_951_743_655_322, 0.091_576_213_509_771), (0.223_381_589_678_011, 0.445_948_490_915_965)];
    for cell in &mesh.cells {
        for face in kind.faces() {
            let corner = |k: usize| face[k % 3];
            let mid = |k: usize| {
                let ends = [corner(k), corner(k + 1)];
                let edge = kind.edges().iter().position(|e| e.contains(&ends[0]) && e.contains(&ends[1]));
                kind.mid_edge_nodes()[edge.unwrap()]
            };
            let nodes: Vec<usize> =
                (0..3).map(corner).chain((0..3).map(mid)).map(|local| cell.nodes()[local]).collect();
            if !nodes.iter().all(|&n| select(mesh.points[n])) {
                continue;
            }
            for (weight, l) in rule {
                for place in 0..3 {
                    let mut bary = [l; 3];
                    bary[place] = 1. - 2. * l;
                    let (shape, dr, ds) = quadratic_triangle(bary);
                    let along = |d: &[f64; 6]| -> Vec3 {
                        d.iter().zip(&nodes).map(|(d, &n)| *d * mesh.points[n]).sum()
                    };
                    let area = 0.5 * along(&dr).cross(&along(&ds));
                    let t = traction(area.normalize()) * area.norm() * weight;
                    for (n, &node) in shape.iter().zip(&nodes) {
                        for axis in 0..3 {
                            force[3 * node + axis] += n * t[axis];
                        }
                    }
                }
            }
        }
    }
}

/// Shape functions of the six-node triangle and their derivatives by the second and third coordinate.
fn quadratic_triangle(l: [f64; 3]) -> ([f64; 6], [f64; 6], [f64; 6]) {
    let corner = |k: usize| l[k] * (2. * l[k] - 1.);
    let slope = |k: usize| 4. * l[k] - 1.;
    let n = [corner(0), corner(1), corner(2), 4. * l[0] * l[1], 4. * l[1] * l[2], 4. * l[2] * l[0]];
    let dr = [-slope(0), slope(1), 0., 4. * (l[0] - l[1]), 4. * l[2], -4. * l[2]];
    let ds = [-slope(0), 0., slope(2), -4. * l[1], 4. * l[1], 4. * (l[0] - l[2])];
    (n, dr, ds)
}

/// Stress at `point`: in each cell that has it as a corner the strain of the four integration points is carried
/// there by the linear field through them, and the cells are averaged.
fn stress_at(mesh: &Mesh, u: &[f64], point: Vec3) -> Vector6<f64> {
    let law = isotropic(YOUNG, POISSON);
    // Barycentric coordinate of each integration point towards its own corner.
    let b = (5. + 3. * 5f64.sqrt()) / 20.;
    let (mut sum, mut cells) = (Vector6::zeros(), 0);
    for (index, cell) in mesh.cells.iter().enumerate() {
        let Some(corner) = cell.nodes()[..4].iter().position(|&n| (mesh.points[n] - point).norm() < 1e-9)
        else {
            continue;
        };
        let element = Element::new(cell.kind(), &mesh.cell_points(index).collect::<Vec<_>>()).unwrap();
        let moved = cell_displacements(mesh, index, u);
        let mean: Vector6<f64> = (0..4).map(|q| element.strain(q, &moved)).sum::<Vector6<f64>>() / 4.;
        let near = element.strain(corner, &moved);
        sum += law * (mean + (near - mean) * 0.75 / (b - 0.25));
        cells += 1;
    }
    sum / f64::from(cells)
}

fn held(mesh: &Mesh, axis: usize, select: impl Fn(Vec3) -> bool) -> Vec<(usize, f64)> {
    (0..mesh.n_nodes()).filter(|&n| select(mesh.points[n])).map(|n| (3 * n + axis, 0.)).collect()
}

/// LE10: thick plate, 1 N/mm2 down on its upper face; `sigma_yy` at D on that face.
fn thick_plate(cells: [usize; 3]) -> f64 {
    let mesh = quarter(cells, 0.6);
    let mut force = vec![0.; 3 * mesh.n_nodes()];
    press(&mesh, |p| (p.z - 0.6).abs() < 1e-9, |normal| -normal, &mut force);
    let outer = |p: Vec3| off_outer(p) < 1e-6;
    let mut fixed = held(&mesh, 0, |p| p.x.abs() < 1e-9 || outer(p));
    fixed.extend(held(&mesh, 1, |p| p.y.abs() < 1e-9 || outer(p)));
    fixed.extend(held(&mesh, 2, |p| outer(p) && (p.z - 0.3).abs() < 1e-9));
    let u = solve(&mesh, |_, _| isotropic(YOUNG, POISSON), &fixed, &force);
    stress_at(&mesh, &u, Vec3::new(D[0], D[1], 0.6))[1]
}

/// LE1: membrane 0.1 thick, 10 N/mm2 outward on its outer edge; `sigma_yy` at D.
fn membrane(cells: [usize; 3]) -> f64 {
    let mesh = quarter(cells, 0.05);
    let mut force = vec![0.; 3 * mesh.n_nodes()];
    press(&mesh, |p| off_outer(p) < 1e-6, |normal| 10. * normal, &mut force);
    let mut fixed = held(&mesh, 0, |p| p.x.abs() < 1e-9);
    fixed.extend(held(&mesh, 1, |p| p.y.abs() < 1e-9));
    fixed.extend(held(&mesh, 2, |p| p.z.abs() < 1e-9));
    let u = solve(&mesh, |_, _| isotropic(YOUNG, POISSON), &fixed, &force);
    let at = |z: f64| stress_at(&mesh, &u, Vec3::new(D[0], D[1], z))[1];
    0.5 * (at(0.) + at(0.05))
}

#[test]
fn le10_thick_plate() {
    for cells in [[6, 10, 4], [10, 16, 6]] {
        let stress = thick_plate(cells);
        println!("LE10 {cells:?}: {stress:.3} MPa ({:+.2} %)", 100. * (stress / -5.38 - 1.));
        assert!((stress / -5.38 - 1.).abs() < 0.01, "{cells:?}: {stress}");
    }
}

#[test]
fn le1_elliptic_membrane() {
    for cells in [[8, 12, 1], [14, 24, 1]] {
        let stress = membrane(cells);
        println!("LE1 {cells:?}: {stress:.2} MPa ({:+.2} %)", 100. * (stress / 92.7 - 1.));
        assert!((stress / 92.7 - 1.).abs() < 0.01, "{cells:?}: {stress}");
    }
}
