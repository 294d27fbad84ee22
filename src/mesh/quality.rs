//! How well shaped cells are.

use nalgebra::Matrix3;

use super::{Cell, CellKind};
use crate::units::Vec3;

/// Shape measures of one cell.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Quality {
    /// Least determinant of the three unit edge vectors at a corner, over the ideal cell's: 1 for a
    /// cube, an equilateral right wedge and a regular tetrahedron, 0 where a corner is flat, negative
    /// where it is turned inside out.
    pub scaled_jacobian: f64,
    /// Least determinant of `dx/dxi` at the quadrature points, which is what an element sees, mm³.
    pub min_jacobian: f64,
    /// Greatest determinant at the quadrature points, mm³.
    pub max_jacobian: f64,
    /// Least determinant at the nodes, where a folded cell shows first, mm³.
    pub node_jacobian: f64,
    /// Volume by quadrature, mm³.
    pub volume: f64,
    /// Least over greatest stretch from the reference cell at its middle: 1 for a cube, 0.01 for a plate a hundred
    /// times as wide as it is thick, whose corners are as square as the cube's.
    pub thickness_ratio: f64,
}

impl Quality {
    /// The shape of cell `cell` among the nodes `points` (n x 3, mm).
    ///
    /// # Panics
    /// If the cell has a node that `points` has not.
    pub fn new(cell: &Cell, points: &[Vec3]) -> Self {
        let kind = cell.kind();
        let mut x = [Vec3::zeros(); super::MAX_NODES];
        for (xi, &node) in x.iter_mut().zip(cell.nodes()) {
            *xi = points[node];
        }
        let x = &x[..kind.n_nodes()];
        let at_nodes = kind.node_positions().iter().map(|p| jacobian(kind, x, Vec3::from(*p)).determinant());
        let (mut min, mut max, mut volume) = (f64::INFINITY, f64::NEG_INFINITY, 0.0);
        for (xi, weight) in quadrature(kind) {
            let det = jacobian(kind, x, xi).determinant();
            (min, max) = (min.min(det), max.max(det));
            volume += weight * det;
        }
        let stretch = jacobian(kind, x, kind.centre()).singular_values();
        Self {
            thickness_ratio: stretch.min() / stretch.max(),
            scaled_jacobian: scaled_jacobian(kind, x),
            min_jacobian: min,
            max_jacobian: max,
            node_jacobian: at_nodes.fold(f64::INFINITY, f64::min),
            volume,
        }
    }

    /// Whether the cell is turned inside out at a node or a quadrature point.
    pub fn is_inverted(&self) -> bool {
        self.min_jacobian.min(self.node_jacobian) <= 0.
    }

    /// `min_jacobian / max_jacobian`: 1 for a parallelepiped, near 0 for a distorted cell.
    pub fn jacobian_ratio(&self) -> f64 {
        self.min_jacobian / self.max_jacobian
    }
}

/// `dx/dxi` at `xi` of a cell of `kind` with its nodes at `x`; column k is the derivative by `xi_k`.
pub(super) fn jacobian(kind: CellKind, x: &[Vec3], xi: Vec3) -> Matrix3<f64> {
    let gradient = kind.shape_gradient(xi);
    x.iter().zip(&gradient).map(|(x, g)| x * g.transpose()).sum()
}

/// At each corner the three neighbouring corners, right-handed.
pub(crate) fn corner_neighbours(kind: CellKind) -> &'static [[usize; 4]] {
    match kind {
        CellKind::Hex8 => &[
            [0, 1, 3, 4],
            [1, 2, 0, 5],
            [2, 3, 1, 6],
            [3, 0, 2, 7],
            [4, 7, 5, 0],
            [5, 4, 6, 1],
            [6, 5, 7, 2],
            [7, 6, 4, 3],
        ],
        CellKind::Wedge6 => {
            &[[0, 1, 2, 3], [1, 2, 0, 4], [2, 0, 1, 5], [3, 5, 4, 0], [4, 3, 5, 1], [5, 4, 3, 2]]
        }
        CellKind::Tet4 | CellKind::Tet10 => &[[0, 1, 2, 3], [1, 2, 0, 3], [2, 0, 1, 3], [3, 2, 1, 0]],
    }
}

fn scaled_jacobian(kind: CellKind, x: &[Vec3]) -> f64 {
    let ideal = match kind {
        CellKind::Hex8 => 1.0,
        CellKind::Wedge6 => 0.75_f64.sqrt(),
        CellKind::Tet4 | CellKind::Tet10 => 0.5_f64.sqrt(),
    };
    let at_corner = |[o, a, b, c]: &[usize; 4]| {
        let [a, b, c] = [x[*a] - x[*o], x[*b] - x[*o], x[*c] - x[*o]];
        let lengths = a.norm() * b.norm() * c.norm();
        if lengths > 0.0 { a.dot(&b.cross(&c)) / (lengths * ideal) } else { 0.0 }
    };
    corner_neighbours(kind).iter().map(at_corner).fold(f64::INFINITY, f64::min)
}

/// Quadrature that is exact for the volume of every kind but a curved Tet10.
fn quadrature(kind: CellKind) -> Vec<(Vec3, f64)> {
    let g = 1. / 3_f64.sqrt();
    match kind {
        CellKind::Hex8 => kind.node_positions().iter().map(|p| (g * Vec3::from(*p), 1.)).collect(),
        CellKind::Wedge6 => {
            let triangle = [[1. / 6., 1. / 6.], [2. / 3., 1. / 6.], [1. / 6., 2. / 3.]];
            let at = |[r, s]: [f64; 2]| [-g, g].map(|t| (Vec3::new(r, s, t), 1. / 6.));
            triangle.into_iter().flat_map(at).collect()
        }
        CellKind::Tet4 => vec![(kind.centre(), 1. / 6.)],
        CellKind::Tet10 => {
            let (a, b) = ((5. - 5_f64.sqrt()) / 20., (5. + 3. * 5_f64.sqrt()) / 20.);
            [[a, a, a], [b, a, a], [a, b, a], [a, a, b]].map(|p| (Vec3::from(p), 1. / 24.)).to_vec()
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::mesh::Mesh;
    use crate::mesh::testing::single;

    fn of(mesh: &Mesh) -> Quality {
        Quality::new(&mesh.cells[0], &mesh.points)
    }

    #[test]
    fn the_ideal_cell_of_each_kind_has_one() {
        let h = 0.75_f64.sqrt();
        let triangle = [[0., 0.], [1., 0.], [0.5, h]];
        let mut wedge = single(CellKind::Wedge6);
        for k in 0..6 {
            let [x, y] = triangle[k % 3];
            wedge.points[k] = Vec3::new(x, y, (k / 3) as f64);
        }
        let apex = Vec3::new(0.5, h / 3., (2_f64 / 3.).sqrt());
        let mut tet = single(CellKind::Tet4);
        for (k, [x, y]) in triangle.into_iter().enumerate() {
            tet.points[k] = Vec3::new(x, y, 0.);
        }
        tet.points[3] = apex;
        for mesh in [single(CellKind::Hex8), wedge, tet] {
            assert!((of(&mesh).scaled_jacobian - 1.).abs() < 1e-14, "{:?}", mesh.cells[0].kind());
        }
    }

    #[test]
    fn volumes_are_those_of_the_reference_domains() {
        for (kind, volume) in [
            (CellKind::Hex8, 8.),
            (CellKind::Wedge6, 1.),
            (CellKind::Tet4, 1. / 6.),
            (CellKind::Tet10, 1. / 6.),
        ] {
            assert!((of(&single(kind)).volume - 1000. * volume).abs() < 1e-9, "{kind:?}");
        }
    }

    #[test]
    fn a_pushed_in_corner_shows_in_every_measure() {
        let mut mesh = single(CellKind::Hex8);
        mesh.points[6] = Vec3::new(-2., -2., -2.);
        let quality = of(&mesh);
        assert!(quality.scaled_jacobian < 0. && quality.node_jacobian < 0. && quality.is_inverted());
        assert!(quality.jacobian_ratio() < 0.1);
    }

    #[test]
    fn mirrored_cells_are_inverted_at_every_corner() {
        for kind in CellKind::ALL {
            let mut mesh = single(kind);
            mesh.points.iter_mut().for_each(|p| p.x = -p.x);
            let quality = of(&mesh);
            assert!(quality.max_jacobian < 0. && quality.scaled_jacobian < 0., "{kind:?}");
        }
    }
}
