//! Elastic blocks that press on something.
#![allow(clippy::unwrap_used, reason = "a test that cannot go on should say where")]

use std::sync::Arc;

use modiolus::contact::Pair;
use modiolus::forward::{Cholesky, ContactResponse, Element, SparseColumn, Stiffness, SymbolicFactor};
use modiolus::mesh::{CellKind, Mesh};
use modiolus::units::Vec3;
use nalgebra::{DMatrix, DVector, Matrix6};

use super::grid;

/// Isotropic stiffness, Voigt with engineering shears.
pub fn isotropic(young: f64, poisson: f64) -> Matrix6<f64> {
    let mu = young / (2. * (1. + poisson));
    let lambda = 2. * mu * poisson / (1. - 2. * poisson);
    let mut c = Matrix6::zeros();
    for i in 0..3 {
        c[(i, i)] = 2. * mu;
        c[(i + 3, i + 3)] = mu;
        for j in 0..3 {
            c[(i, j)] += lambda;
        }
    }
    c
}

/// The factor of a mesh of one `law`, with the dofs `is_fixed(point, axis)` held.
pub fn factor(mesh: &Mesh, law: Matrix6<f64>, is_fixed: impl Fn(Vec3, usize) -> bool) -> Cholesky {
    let mut stiffness = Stiffness::new(mesh.n_nodes(), mesh.cells.iter().map(|c| c.nodes()), 0);
    for (index, cell) in mesh.cells.iter().enumerate() {
        let element = Element::new(cell.kind(), &mesh.cell_points(index).collect::<Vec<_>>()).unwrap();
        stiffness.add_base(cell.nodes(), &element.stiffness(|_| law));
    }
    let values = stiffness.at(&[]);
    stiffness.finish();
    let fixed: Vec<bool> =
        (0..3 * mesh.n_nodes()).map(|dof| is_fixed(mesh.points[dof / 3], dof % 3)).collect();
    let symbolic = Arc::new(SymbolicFactor::new(stiffness.pattern(), &fixed).unwrap());
    Cholesky::new(symbolic, &values).unwrap()
}

/// A contact row as a column of `G'`.
pub fn contact_column(pair: &Pair) -> SparseColumn {
    pair.row.iter().flat_map(|(n, g)| (0..3).map(move |axis| (3 * n + axis, g[axis]))).collect()
}

/// The contact rows of `pairs` under one load, whose factor is the only activation.
pub fn contact_response(cholesky: &Cholesky, load: &SparseColumn, pairs: &[Pair]) -> ContactResponse {
    let c = pairs.len();
    let columns: Vec<SparseColumn> =
        std::iter::once(load.clone()).chain(pairs.iter().map(contact_column)).collect();
    let gram = cholesky.gram(&columns);
    ContactResponse {
        kinds: pairs.iter().map(|p| p.kind).collect(),
        gap: DVector::from_iterator(c, pairs.iter().map(|p| p.gap_mm)),
        approach: gram.view((1, 0), (c, 1)).into_owned(),
        compliance: gram.view((1, 1), (c, c)).into_owned(),
        reach: DMatrix::zeros(0, c),
    }
}

/// A quarter of a half space of one `law`, with `cells` cells along the contact radius of 1 mm, then growing ones to
/// beyond 32 mm: its corner the origin, its free face `z = 0`.
pub fn half_space(law: Matrix6<f64>, cells: usize) -> (Mesh, Cholesky) {
    let mut axis = vec![0.];
    let mut step = 1. / cells as f64;
    while axis[axis.len() - 1] < 32. {
        let last = axis[axis.len() - 1];
        if last > 1.2 {
            step *= 1.4;
        }
        axis.push(last + step);
    }
    let n = axis.len() - 1;
    let along = |x: f64| axis[(x * n as f64).round() as usize];
    let mesh = grid(CellKind::Hex8, [n; 3], |p| Vec3::new(along(p.x), along(p.y), -along(1. - p.z)));
    let cholesky = factor(&mesh, law, |p, k| match k {
        2 => p.z == -axis[n],
        _ => p[k] == 0. || p[k] == axis[n],
    });
    (mesh, cholesky)
}
