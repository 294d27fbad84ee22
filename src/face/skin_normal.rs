//! The direction of the skin, inside the tissue too.

use crate::contact::Facets;
use crate::mesh::Mesh;
use crate::units::Vec3;

/// A smooth field of unit skin normals: the mean of the normals at the skin's nodes, weighted by the inverse
/// fourth power of the distance, so that no choice of a nearest node breaks the mirror symmetry.
#[derive(Clone, Debug)]
pub struct SkinNormal {
    nodes: Vec<(Vec3, Vec3)>,
}

impl SkinNormal {
    /// The field of the nodes `skin` (0-based) of `mesh`.
    pub fn new(mesh: &Mesh, skin: &[usize]) -> Self {
        let normals = Facets::of(mesh).within(skin).node_normals(mesh);
        Self { nodes: normals.into_iter().map(|(node, n)| (mesh.points[node], n)).collect() }
    }

    /// The unit normal at `p`, mm; zero without a skin.
    pub fn at(&self, p: Vec3) -> Vec3 {
        let weighted = |(x, n): &(Vec3, Vec3)| n / ((p - x).norm_squared().powi(2) + 1e-6);
        self.nodes.iter().map(weighted).sum::<Vec3>().try_normalize(0.).unwrap_or_else(Vec3::zeros)
    }
}
