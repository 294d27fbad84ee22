//! Structured meshes and a plain elastic solve.

use std::collections::HashMap;
use std::sync::Arc;

use modiolus::forward::{Cholesky, Element, Stiffness, SymbolicFactor};
use modiolus::mesh::{Cell, CellKind, Mesh};
use modiolus::units::Vec3;
use nalgebra::Matrix6;

/// Grid of `nx x ny x nz` cells of `kind` on the unit cube, mapped by `map`.
pub fn grid(kind: CellKind, [nx, ny, nz]: [usize; 3], map: impl Fn(Vec3) -> Vec3) -> Mesh {
    let id = |i: usize, j: usize, k: usize| (i * (ny + 1) + j) * (nz + 1) + k;
    let mut points = Vec::new();
    for i in 0..=nx {
        for j in 0..=ny {
            for k in 0..=nz {
                points.push(Vec3::new(i as f64 / nx as f64, j as f64 / ny as f64, k as f64 / nz as f64));
            }
        }
    }
    let mut cells = Vec::new();
    let mut middle: HashMap<[usize; 2], usize> = HashMap::new();
    for i in 0..nx {
        for j in 0..ny {
            for k in 0..nz {
                let h = [
                    id(i, j, k),
                    id(i + 1, j, k),
                    id(i + 1, j + 1, k),
                    id(i, j + 1, k),
                    id(i, j, k + 1),
                    id(i + 1, j, k + 1),
                    id(i + 1, j + 1, k + 1),
                    id(i, j + 1, k + 1),
                ];
                match kind {
                    CellKind::Hex8 => cells.push(Cell::new(kind, &h)),
                    CellKind::Wedge6 => {
                        for t in [[0, 1, 2, 4, 5, 6], [0, 2, 3, 4, 6, 7]] {
                            cells.push(Cell::new(kind, &t.map(|q| h[q])));
                        }
                    }
                    CellKind::Tet4 | CellKind::Tet10 => {
                        // Six tetrahedra about the diagonal 0-6: conforming from cell to cell.
                        for t in [
                            [0, 1, 2, 6],
                            [0, 2, 3, 6],
                            [0, 3, 7, 6],
                            [0, 7, 4, 6],
                            [0, 4, 5, 6],
                            [0, 5, 1, 6],
                        ] {
                            let mut nodes = t.map(|q| h[q]).to_vec();
                            if kind == CellKind::Tet10 {
                                for e in kind.edges() {
                                    let mut ends = [nodes[e[0]], nodes[e[1]]];
                                    ends.sort_unstable();
                                    let mid = (points[ends[0]] + points[ends[1]]) / 2.;
                                    nodes.push(*middle.entry(ends).or_insert_with(|| {
                                        points.push(mid);
                                        points.len() - 1
                                    }));
                                }
                            }
                            cells.push(Cell::new(kind, &nodes));
                        }
                    }
                }
            }
        }
    }
    Mesh::new(points.into_iter().map(map).collect(), cells)
}

/// Solves `K u = f` with `law(cell, position)` in N/mm², `prescribed` dofs and nodal `force`;
/// `shape` may change each element (to drop its mean dilatation).
pub fn solve_with(
    mesh: &Mesh,
    shape: impl Fn(Element) -> Element,
    law: impl Fn(usize, Vec3) -> Matrix6<f64>,
    prescribed: &[(usize, f64)],
    force: &[f64],
) -> Vec<f64> {
    let mut stiffness = Stiffness::new(mesh.n_nodes(), &mesh.cells, 0);
    for (index, cell) in mesh.cells.iter().enumerate() {
        let element = shape(Element::new(cell.kind(), &mesh.cell_points(index).collect::<Vec<_>>()).unwrap());
        stiffness.add_base(cell.nodes(), &element.stiffness(|q| law(index, element.points()[q].position)));
    }
    let values = stiffness.at(&[]);
    stiffness.finish();
    let mut fixed = vec![false; 3 * mesh.n_nodes()];
    let mut lift = vec![0.; 3 * mesh.n_nodes()];
    for &(dof, value) in prescribed {
        fixed[dof] = true;
        lift[dof] = value;
    }
    let from_lift = stiffness.pattern().multiply(&values, &lift);
    let rhs: Vec<f64> = force.iter().zip(from_lift).map(|(f, k)| f - k).collect();
    let symbolic = Arc::new(SymbolicFactor::new(stiffness.pattern(), &fixed).unwrap());
    let free = Cholesky::new(symbolic, &values).unwrap().displacements(&[rhs]).swap_remove(0);
    free.iter().zip(lift).map(|(u, l)| u + l).collect()
}

/// [`solve_with`] the elements as they are.
pub fn solve(
    mesh: &Mesh,
    law: impl Fn(usize, Vec3) -> Matrix6<f64>,
    prescribed: &[(usize, f64)],
    force: &[f64],
) -> Vec<f64> {
    solve_with(mesh, |e| e, law, prescribed, force)
}

/// Nodal displacements of a cell.
pub fn cell_displacements(mesh: &Mesh, cell: usize, u: &[f64]) -> Vec<Vec3> {
    mesh.cells[cell].nodes().iter().map(|&n| Vec3::new(u[3 * n], u[3 * n + 1], u[3 * n + 2])).collect()
}

/// Adds the consistent nodal forces of a traction `p(x, unit normal)` on a bilinear quad.
pub fn add_quad_traction(
    mesh: &Mesh,
    quad: [usize; 4],
    traction: impl Fn(Vec3, Vec3) -> Vec3,
    force: &mut [f64],
) {
    let g = 1. / 3f64.sqrt();
    let corners = [[-1., -1.], [1., -1.], [1., 1.], [-1., 1.]];
    for [r, s] in [[-g, -g], [g, -g], [g, g], [-g, g]] {
        let n = corners.map(|[a, b]| 0.25 * (1. + a * r) * (1. + b * s));
        let (mut x, mut dr, mut ds) = (Vec3::zeros(), Vec3::zeros(), Vec3::zeros());
        for (k, [a, b]) in corners.into_iter().enumerate() {
            let p = mesh.points[quad[k]];
            x += n[k] * p;
            dr += 0.25 * a * (1. + b * s) * p;
            ds += 0.25 * b * (1. + a * r) * p;
        }
        let area = dr.cross(&ds);
        let t = traction(x, area.normalize()) * area.norm();
        for k in 0..4 {
            for axis in 0..3 {
                force[3 * quad[k] + axis] += n[k] * t[axis];
            }
        }
    }
}
