//! The four cell kinds: topology and shape functions.

use crate::units::Vec3;

/// Most nodes that any cell kind has.
pub const MAX_NODES: usize = 10;

/// A cell kind, with the node order of VTK (wedges as Gmsh and Abaqus write them: the normal of
/// nodes 0, 1, 2 points towards nodes 3, 4, 5).
///
/// Reference domains: Hex8 `[-1, 1]³`; Wedge6 triangle `r, s >= 0, r + s <= 1` times `t` in
/// `[-1, 1]`; Tet4 and Tet10 `r, s, t >= 0, r + s + t <= 1`.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash, PartialOrd, Ord)]
pub enum CellKind {
    /// Trilinear hexahedron.
    Hex8,
    /// Linear wedge.
    Wedge6,
    /// Linear tetrahedron.
    Tet4,
    /// Quadratic tetrahedron; mid-edge nodes in the order 01, 12, 20, 03, 13, 23.
    Tet10,
}

const HEX_CORNERS: [[f64; 3]; 8] = [
    [-1., -1., -1.],
    [1., -1., -1.],
    [1., 1., -1.],
    [-1., 1., -1.],
    [-1., -1., 1.],
    [1., -1., 1.],
    [1., 1., 1.],
    [-1., 1., 1.],
];
const WEDGE_NODES: [[f64; 3]; 6] =
    [[0., 0., -1.], [1., 0., -1.], [0., 1., -1.], [0., 0., 1.], [1., 0., 1.], [0., 1., 1.]];
const TET_NODES: [[f64; 3]; 10] = [
    [0., 0., 0.],
    [1., 0., 0.],
    [0., 1., 0.],
    [0., 0., 1.],
    [0.5, 0., 0.],
    [0.5, 0.5, 0.],
    [0., 0.5, 0.],
    [0., 0., 0.5],
    [0.5, 0., 0.5],
    [0., 0.5, 0.5],
];
const TET_EDGES: [[usize; 2]; 6] = [[0, 1], [1, 2], [2, 0], [0, 3], [1, 3], [2, 3]];

impl CellKind {
    /// Every kind.
    pub const ALL: [Self; 4] = [Self::Hex8, Self::Wedge6, Self::Tet4, Self::Tet10];

    /// Number of nodes.
    pub fn n_nodes(self) -> usize {
        self.node_positions().len()
    }

    /// Number of corner nodes; they come first.
    pub fn n_corners(self) -> usize {
        match self {
            Self::Tet10 => 4,
            other => other.n_nodes(),
        }
    }

    /// Reference coordinates of the nodes.
    pub fn node_positions(self) -> &'static [[f64; 3]] {
        match self {
            Self::Hex8 => &HEX_CORNERS,
            Self::Wedge6 => &WEDGE_NODES,
            Self::Tet4 => &TET_NODES[..4],
            Self::Tet10 => &TET_NODES,
        }
    }

    /// Corner-node edges (local indices).
    pub fn edges(self) -> &'static [[usize; 2]] {
        match self {
            Self::Hex8 => &[
                [0, 1],
                [1, 2],
                [2, 3],
                [3, 0],
                [4, 5],
                [5, 6],
                [6, 7],
                [7, 4],
                [0, 4],
                [1, 5],
                [2, 6],
                [3, 7],
            ],
            Self::Wedge6 => &[[0, 1], [1, 2], [2, 0], [3, 4], [4, 5], [5, 3], [0, 3], [1, 4], [2, 5]],
            Self::Tet4 | Self::Tet10 => &TET_EDGES,
        }
    }

    /// Faces by their corner nodes (local indices), counter-clockwise seen from outside.
    pub fn faces(self) -> &'static [&'static [usize]] {
        match self {
            Self::Hex8 => {
                &[&[0, 3, 2, 1], &[4, 5, 6, 7], &[0, 1, 5, 4], &[1, 2, 6, 5], &[2, 3, 7, 6], &[3, 0, 4, 7]]
            }
            Self::Wedge6 => &[&[0, 2, 1], &[3, 4, 5], &[0, 1, 4, 3], &[1, 2, 5, 4], &[2, 0, 3, 5]],
            Self::Tet4 | Self::Tet10 => &[&[0, 2, 1], &[0, 1, 3], &[1, 2, 3], &[2, 0, 3]],
        }
    }

    /// Mid-edge node (local index) on each of [`edges`](Self::edges), for quadratic kinds.
    pub fn mid_edge_nodes(self) -> &'static [usize] {
        match self {
            Self::Tet10 => &[4, 5, 6, 7, 8, 9],
            _ => &[],
        }
    }

    /// Shape functions `N_i(xi)`; entries past [`n_nodes`](Self::n_nodes) are zero.
    pub fn shape(self, xi: Vec3) -> [f64; MAX_NODES] {
        let mut n = [0.0; MAX_NODES];
        match self {
            Self::Hex8 => {
                for (ni, c) in n.iter_mut().zip(&HEX_CORNERS) {
                    *ni = 0.125 * (1. + c[0] * xi.x) * (1. + c[1] * xi.y) * (1. + c[2] * xi.z);
                }
            }
            Self::Wedge6 => {
                let l = [1. - xi.x - xi.y, xi.x, xi.y];
                for k in 0..3 {
                    n[k] = 0.5 * l[k] * (1. - xi.z);
                    n[k + 3] = 0.5 * l[k] * (1. + xi.z);
                }
            }
            Self::Tet4 => n[..4].copy_from_slice(&barycentric(xi)),
            Self::Tet10 => {
                let l = barycentric(xi);
                for k in 0..4 {
                    n[k] = l[k] * (2. * l[k] - 1.);
                }
                for (k, e) in TET_EDGES.iter().enumerate() {
                    n[4 + k] = 4. * l[e[0]] * l[e[1]];
                }
            }
        }
        n
    }

    /// Gradients of the shape functions with respect to the reference coordinates.
    pub fn shape_gradient(self, xi: Vec3) -> [Vec3; MAX_NODES] {
        let mut g = [Vec3::zeros(); MAX_NODES];
        match self {
            Self::Hex8 => {
                for (gi, c) in g.iter_mut().zip(&HEX_CORNERS) {
                    let f = [1. + c[0] * xi.x, 1. + c[1] * xi.y, 1. + c[2] * xi.z];
                    *gi = 0.125 * Vec3::new(c[0] * f[1] * f[2], c[1] * f[0] * f[2], c[2] * f[0] * f[1]);
                }
            }
            Self::Wedge6 => {
                let l = [1. - xi.x - xi.y, xi.x, xi.y];
                let dl = [[-1., -1.], [1., 0.], [0., 1.]];
                for k in 0..3 {
                    let (lo, hi) = (0.5 * (1. - xi.z), 0.5 * (1. + xi.z));
                    g[k] = Vec3::new(dl[k][0] * lo, dl[k][1] * lo, -0.5 * l[k]);
                    g[k + 3] = Vec3::new(dl[k][0] * hi, dl[k][1] * hi, 0.5 * l[k]);
                }
            }
            Self::Tet4 => g[..4].copy_from_slice(&barycentric_gradient()),
            Self::Tet10 => {
                let (l, dl) = (barycentric(xi), barycentric_gradient());
                for k in 0..4 {
                    g[k] = dl[k] * (4. * l[k] - 1.);
                }
                for (k, e) in TET_EDGES.iter().enumerate() {
                    g[4 + k] = 4. * (dl[e[0]] * l[e[1]] + dl[e[1]] * l[e[0]]);
                }
            }
        }
        g
    }

    /// Reference coordinates of the cell's centre.
    pub fn centre(self) -> Vec3 {
        match self {
            Self::Hex8 => Vec3::zeros(),
            Self::Wedge6 => Vec3::new(1. / 3., 1. / 3., 0.),
            Self::Tet4 | Self::Tet10 => Vec3::repeat(0.25),
        }
    }

    /// How far `xi` lies outside the reference domain (0 inside), in reference coordinates.
    pub fn outside(self, xi: Vec3) -> f64 {
        self.signed_outside(xi).max(0.)
    }

    /// [`outside`](Self::outside), going on below zero inside: minus the distance to the nearest side.
    pub fn signed_outside(self, xi: Vec3) -> f64 {
        match self {
            Self::Hex8 => xi.abs().max() - 1.,
            Self::Wedge6 => {
                [xi.x + xi.y - 1., -xi.x, -xi.y, xi.z.abs() - 1.].into_iter().fold(f64::MIN, f64::max)
            }
            Self::Tet4 | Self::Tet10 => {
                [xi.sum() - 1., -xi.x, -xi.y, -xi.z].into_iter().fold(f64::MIN, f64::max)
            }
        }
    }
}

fn barycentric(xi: Vec3) -> [f64; 4] {
    [1. - xi.sum(), xi.x, xi.y, xi.z]
}

fn barycentric_gradient() -> [Vec3; 4] {
    [Vec3::repeat(-1.), Vec3::x(), Vec3::y(), Vec3::z()]
}

/// A cell: its kind and its nodes.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Cell {
    kind: CellKind,
    nodes: [usize; MAX_NODES],
}

impl Cell {
    /// A cell of `kind` on `nodes`.
    ///
    /// # Panics
    /// If the number of nodes is not the kind's.
    pub fn new(kind: CellKind, nodes: &[usize]) -> Self {
        assert_eq!(nodes.len(), kind.n_nodes(), "{kind:?} takes {} nodes", kind.n_nodes());
        let mut all = [0; MAX_NODES];
        all[..nodes.len()].copy_from_slice(nodes);
        Self { kind, nodes: all }
    }

    /// The cell's kind.
    pub fn kind(&self) -> CellKind {
        self.kind
    }

    /// The nodes, 0-based, in the kind's order.
    pub fn nodes(&self) -> &[usize] {
        &self.nodes[..self.kind.n_nodes()]
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn shape_functions_are_one_at_their_node_and_sum_to_one() {
        for kind in CellKind::ALL {
            for (i, p) in kind.node_positions().iter().enumerate() {
                let n = kind.shape(Vec3::from(*p));
                for (j, nj) in n[..kind.n_nodes()].iter().enumerate() {
                    assert!((nj - f64::from(u8::from(i == j))).abs() < 1e-14, "{kind:?} {i} {j}");
                }
            }
            let xi = Vec3::new(0.21, 0.13, 0.34);
            assert!((kind.shape(xi).iter().sum::<f64>() - 1.).abs() < 1e-14);
            assert!(kind.shape_gradient(xi).iter().sum::<Vec3>().norm() < 1e-14);
        }
    }

    #[test]
    fn gradients_are_the_derivatives_of_the_shape_functions() {
        let (xi, h) = (Vec3::new(0.21, 0.13, 0.34), 1e-6);
        for kind in CellKind::ALL {
            let g = kind.shape_gradient(xi);
            for axis in 0..3 {
                let mut step = Vec3::zeros();
                step[axis] = h;
                let (hi, lo) = (kind.shape(xi + step), kind.shape(xi - step));
                for i in 0..kind.n_nodes() {
                    assert!((g[i][axis] - (hi[i] - lo[i]) / (2. * h)).abs() < 1e-9, "{kind:?}");
                }
            }
        }
    }

    #[test]
    fn faces_point_outward() {
        for kind in CellKind::ALL {
            let p = kind.node_positions();
            for face in kind.faces() {
                let at = |k: usize| Vec3::from(p[face[k]]);
                let normal = (at(1) - at(0)).cross(&(at(2) - at(0)));
                assert!(normal.dot(&(at(0) - kind.centre())) > 0., "{kind:?} {face:?}");
            }
        }
    }
}
