//! One finite element: integration points, strains, stiffness.

use nalgebra::{Matrix3, Matrix6, SMatrix, Vector6};

use super::ForwardError;
use super::quadrature::rule;
use crate::mesh::{CellKind, DilatationPatches, Mesh};
use crate::units::Vec3;

/// Strain-displacement matrix of one node (6 x 3).
type NodeStrain = SMatrix<f64, 6, 3>;

/// An integration point of an element.
#[derive(Clone, Debug)]
pub struct IntegrationPoint {
    /// Position, mm.
    pub position: Vec3,
    /// Volume that it stands for, mm³.
    pub volume: f64,
    gradient: Vec<Vec3>,
}

/// An element on its nodes' rest positions.
///
/// Hex8 and Wedge6 are B-bar elements (mean dilatation, Hughes 1980): the volumetric strain is its
/// mean over the element, `B_bar = B + 1/3 m (b_mean - b)` with `m = (1,1,1,0,0,0)'` and `b` the
/// divergence row, so that nearly incompressible tissue does not lock. The Tet4 of a patch are one B-bar element whose
/// integration points are the tetrahedra. A single Tet4 and Tet10 are plain.
#[derive(Clone, Debug)]
pub struct Element {
    n_nodes: usize,
    points: Vec<IntegrationPoint>,
    mean_gradient: Option<Vec<Vec3>>,
}

impl IntegrationPoint {
    /// The point `xi`, of `weight`, of an element of `kind` on `nodes` (mm), or `None` when the Jacobian is not positive
    /// there.
    pub(super) fn new(kind: CellKind, nodes: &[Vec3], xi: Vec3, weight: f64) -> Option<Self> {
        let (shape, local) = (kind.shape(xi), kind.shape_gradient(xi));
        let mut jacobian = Matrix3::zeros();
        let mut position = Vec3::zeros();
        for (i, p) in nodes.iter().enumerate() {
            jacobian += p * local[i].transpose();
            position += shape[i] * p;
        }
        let determinant = jacobian.determinant();
        if determinant.is_nan() || determinant <= 0. {
            return None;
        }
        let to_global = jacobian.try_inverse()?.transpose();
        let gradient = local[..nodes.len()].iter().map(|g| to_global * g).collect();
        Some(Self { position, volume: determinant * weight, gradient })
    }

    /// The points at the nodes of an element of `kind` on `nodes` (mm), its corners among them, where the Jacobian is
    /// positive. They stand for no volume.
    pub(super) fn at_nodes(kind: CellKind, nodes: &[Vec3]) -> Vec<Self> {
        kind.node_positions().iter().filter_map(|p| Self::new(kind, nodes, Vec3::from(*p), 0.)).collect()
    }

    /// Gradients of the shape functions of the element's nodes, 1/mm.
    pub(super) fn gradients(&self) -> &[Vec3] {
        &self.gradient
    }

    /// Displacement gradient `H_ij = du_i/dx_j` for nodal displacements `u` (mm).
    pub(super) fn displacement_gradient(&self, u: &[Vec3]) -> Matrix3<f64> {
        u.iter().zip(&self.gradient).map(|(u, g)| u * g.transpose()).sum()
    }
}

/// Stiffness of an element as 3 x 3 node blocks, N/mm.
pub type ElementStiffness = Vec<Matrix3<f64>>;

impl Element {
    /// The element of `kind` on `nodes` (mm), or `None` when the Jacobian is not positive at an
    /// integration point.
    pub fn new(kind: CellKind, nodes: &[Vec3]) -> Option<Self> {
        let at = |(xi, weight)| IntegrationPoint::new(kind, nodes, xi, weight);
        let points = rule(kind).into_iter().map(at).collect::<Option<Vec<_>>>()?;
        let plain = Self { n_nodes: nodes.len(), points, mean_gradient: None };
        Some(match kind {
            CellKind::Hex8 | CellKind::Wedge6 => plain.with_mean_dilatation(),
            CellKind::Tet4 | CellKind::Tet10 => plain,
        })
    }

    /// The element of `patch` of `mesh` and its nodes (0-based): of a single cell that on its nodes; of several one on the
    /// nodes of all, whose integration points are those of the cells in their order, with one mean dilatation.
    ///
    /// # Errors
    /// [`ForwardError::InvertedCell`].
    pub fn of_patch(
        mesh: &Mesh,
        patches: &DilatationPatches,
        patch: usize,
    ) -> Result<(Self, Vec<usize>), ForwardError> {
        let of_cell = |&cell: &usize| {
            Self::new(mesh.cells[cell].kind(), &mesh.cell_points(cell).collect::<Vec<_>>())
                .ok_or(ForwardError::InvertedCell { cell: mesh.cell_id(cell) })
        };
        let (cells, nodes) = (&patches.cells()[patch], patches.nodes(mesh, patch));
        if let [only] = &cells[..] {
            return Ok((of_cell(only)?, nodes));
        }
        let mut points = Vec::new();
        for cell in cells {
            for point in of_cell(cell)?.points {
                let mut gradient = vec![Vec3::zeros(); nodes.len()];
                for (node, g) in mesh.cells[*cell].nodes().iter().zip(&point.gradient) {
                    gradient[nodes.partition_point(|n| n < node)] = *g;
                }
                points.push(IntegrationPoint { gradient, ..point });
            }
        }
        let plain = Self { n_nodes: nodes.len(), points, mean_gradient: None };
        Ok((plain.with_mean_dilatation(), nodes))
    }

    fn with_mean_dilatation(mut self) -> Self {
        let volume = self.volume();
        let mean = |i: usize| self.points.iter().map(|p| p.gradient[i] * p.volume).sum::<Vec3>() / volume;
        self.mean_gradient = Some((0..self.n_nodes).map(mean).collect());
        self
    }

    /// Whether its points share one dilatation.
    pub(super) fn shares_dilatation(&self) -> bool {
        self.mean_gradient.is_some()
    }

    /// The same element without the mean dilatation, which locks near incompressibility.
    #[must_use]
    pub fn fully_integrated(mut self) -> Self {
        self.mean_gradient = None;
        self
    }

    /// The integration points.
    pub fn points(&self) -> &[IntegrationPoint] {
        &self.points
    }

    /// Volume, mm³.
    pub fn volume(&self) -> f64 {
        self.points.iter().map(|p| p.volume).sum()
    }

    fn node_strain(&self, q: usize, node: usize) -> NodeStrain {
        let g = self.points[q].gradient[node];
        let mut b =
            NodeStrain::new(g.x, 0., 0., 0., g.y, 0., 0., 0., g.z, g.y, g.x, 0., 0., g.z, g.y, g.z, 0., g.x);
        if let Some(mean) = &self.mean_gradient {
            let shift = (mean[node] - g) / 3.;
            for row in 0..3 {
                for axis in 0..3 {
                    b[(row, axis)] += shift[axis];
                }
            }
        }
        b
    }

    /// Strain (Voigt, engineering shear) at integration point `q` for nodal displacements `u` (mm).
    pub fn strain(&self, q: usize, u: &[Vec3]) -> Vector6<f64> {
        u.iter().enumerate().map(|(i, ui)| self.node_strain(q, i) * ui).sum()
    }

    /// Displacement gradient `H_ij = du_i/dx_j` at integration point `q` for nodal displacements `u` (mm).
    pub fn displacement_gradient(&self, q: usize, u: &[Vec3]) -> Matrix3<f64> {
        self.points[q].displacement_gradient(u)
    }

    /// Stiffness `sum_q v_q B_bar' C_q B_bar` in N/mm as blocks `(i, j)` at `i * n + j`;
    /// `law(q)` is `C` in N/mm² at integration point `q`.
    pub fn stiffness(&self, law: impl Fn(usize) -> Matrix6<f64>) -> ElementStiffness {
        let n = self.n_nodes;
        let mut k = vec![Matrix3::zeros(); n * n];
        for (q, point) in self.points.iter().enumerate() {
            let c = law(q) * point.volume;
            let strains: Vec<NodeStrain> = (0..n).map(|i| self.node_strain(q, i)).collect();
            for j in 0..n {
                let stress = c * strains[j];
                for i in j..n {
                    k[i * n + j] += strains[i].tr_mul(&stress);
                }
            }
        }
        for j in 0..n {
            for i in 0..j {
                k[i * n + j] = k[j * n + i].transpose();
            }
        }
        k
    }

    /// Nodal forces `v_q B_bar' sigma` (N) that a stress (N/mm²) at integration point `q` exerts.
    pub fn stress_force(&self, q: usize, stress: &Vector6<f64>) -> Vec<Vec3> {
        let scaled = stress * self.points[q].volume;
        (0..self.n_nodes).map(|i| self.node_strain(q, i).tr_mul(&scaled)).collect()
    }
}
