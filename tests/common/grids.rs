//! Structured meshes and a plain elastic solve.

use std::collections::HashMap;
use std::sync::Arc;

use modiolus::forward::{Cholesky, Element, Stiffness, SymbolicFactor};
use modiolus::mesh::{Cell, CellKind, DilatationPatches, Mesh};
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

/// A grid of tetrahedra that is not that of its hexes: five of each, in two ways by turns, with shifted inner nodes.
pub fn five_tetrahedra(n: [usize; 3], map: impl Fn(Vec3) -> Vec3) -> Mesh {
    const EVEN: [[usize; 4]; 5] = [[0, 1, 3, 4], [2, 3, 1, 6], [5, 4, 6, 1], [7, 6, 4, 3], [1, 3, 4, 6]];
    const ODD: [[usize; 4]; 5] = [[1, 2, 0, 5], [3, 0, 2, 7], [4, 7, 5, 0], [6, 5, 7, 2], [0, 2, 7, 5]];
    let mut mesh = grid(CellKind::Hex8, n, |p| p);
    let place = |cell: &Cell| {
        let corner = mesh.points[cell.nodes()[0]];
        (0..3).map(|k| (corner[k] * n[k] as f64).round() as usize).sum::<usize>()
    };
    let cut = |cell: &Cell| {
        let split = if place(cell) % 2 == 0 { EVEN } else { ODD };
        split.map(|t| Cell::new(CellKind::Tet4, &t.map(|k| cell.nodes()[k])))
    };
    mesh = Mesh::new(mesh.points.clone(), mesh.cells.iter().flat_map(cut).collect());
    for (k, p) in mesh.points.iter_mut().enumerate() {
        for axis in 0..3 {
            if p[axis] > 1e-9 && p[axis] < 1. - 1e-9 {
                p[axis] += 0.15 / n[axis] as f64 * ((7 * k + 3 * axis) as f64).sin();
            }
        }
        *p = map(*p);
    }
    mesh
}

/// Every element of `mesh` with its nodes: of tetrahedra one a patch.
pub fn elements(mesh: &Mesh) -> Vec<(Element, Vec<usize>)> {
    let patches = DilatationPatches::new(mesh);
    (0..patches.len()).map(|patch| Element::of_patch(mesh, &patches, patch).unwrap()).collect()
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
    let elements = elements(mesh);
    let joined = elements.iter().map(|(_, nodes)| nodes.as_slice());
    let mut stiffness = Stiffness::new(mesh.n_nodes(), joined, 0);
    for ((element, nodes), cells) in elements.iter().zip(DilatationPatches::new(mesh).cells()) {
        let element = shape(element.clone());
        let cell = |q: usize| if cells.len() > 1 { cells[q] } else { cells[0] };
        stiffness.add_base(nodes, &element.stiffness(|q| law(cell(q), element.points()[q].position)));
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

/// Adds the consistent nodal forces of a traction `p(x)` on the faces of tetrahedra whose nodes `select` takes; the rule
/// of mid-edges.
pub fn add_traction_on_tetrahedra(
    mesh: &Mesh,
    select: impl Fn(Vec3) -> bool,
    traction: impl Fn(Vec3) -> Vec3,
    force: &mut [f64],
) {
    for cell in &mesh.cells {
        for face in cell.kind().faces() {
            let nodes = [face[0], face[1], face[2]].map(|k| cell.nodes()[k]);
            let x = nodes.map(|n| mesh.points[n]);
            if !x.iter().all(|p| select(*p)) {
                continue;
            }
            let area = (x[1] - x[0]).cross(&(x[2] - x[0])).norm() / 2.;
            for k in 0..3 {
                let next = (k + 1) % 3;
                let half = traction((x[k] + x[next]) / 2.) * (area / 6.);
                for node in [nodes[k], nodes[next]] {
                    (0..3).for_each(|axis| force[3 * node + axis] += half[axis]);
                }
            }
        }
    }
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
