//! A material point of a mesh.

use super::Cell;
use crate::units::Vec3;

/// A material point: its rest position and the interpolation weights of the nodes that carry it.
///
/// The displacement there is `sum_k w_k u_k`.
#[derive(Clone, Debug, PartialEq)]
pub struct Site {
    /// Rest position, mm.
    pub position: Vec3,
    /// Nodes (0-based) and their weights, which sum to one.
    pub weights: Vec<(usize, f64)>,
}

impl Site {
    /// The node `node` at `position` itself.
    pub fn node(node: usize, position: Vec3) -> Self {
        Self { position, weights: vec![(node, 1.0)] }
    }

    /// The point with reference coordinates `xi` of `cell`, whose nodes lie at `points` (n x 3, mm):
    /// `position = sum_i N_i(xi) x_i`; nodes whose weight is round-off are left out.
    ///
    /// # Panics
    /// If the cell has a node that `points` has not.
    pub fn in_cell(cell: &Cell, xi: Vec3, points: &[Vec3]) -> Self {
        let shape = cell.kind().shape(xi);
        let all = || cell.nodes().iter().copied().zip(shape);
        let position = all().map(|(node, w)| w * points[node]).sum();
        let mut weights: Vec<(usize, f64)> = all().filter(|(_, w)| w.abs() > 1e-12).collect();
        weights.sort_unstable_by_key(|&(node, _)| node);
        Self { position, weights }
    }

    /// What the `values` of the nodes (n) are there.
    pub fn value(&self, values: &[f64]) -> f64 {
        self.weights.iter().map(|&(node, weight)| weight * values[node]).sum()
    }

    /// Displacement at the site, mm, from the full field `u` (3n, node-major xyz).
    pub fn displacement(&self, u: &[f64]) -> Vec3 {
        self.weights
            .iter()
            .map(|&(node, w)| w * Vec3::new(u[3 * node], u[3 * node + 1], u[3 * node + 2]))
            .sum()
    }
}
