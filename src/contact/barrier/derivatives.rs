//! The potential's derivatives by mesh nodes.

use nalgebra::Matrix3;
use rayon::prelude::*;

use super::local::Local;
use super::term::{Term, Terms};
use super::{CollisionSurface, Curvature};
use crate::units::Vec3;

/// Terms whose derivatives are held at once.
const BATCH: usize = 8192;

/// The contact potential and its derivatives by the positions of mesh nodes.
#[derive(Clone, Debug, PartialEq)]
pub struct ContactDerivatives {
    /// N mm.
    pub energy: f64,
    /// (3n, node-major xyz), N. Contact loads the nodes by its negative.
    pub gradient: Vec<f64>,
    /// Second derivatives by nodes `(i, j)`, `i >= j`, N/mm: each pair once, ascending; those of diagonal pairs are whole.
    pub blocks: Vec<(usize, usize, Matrix3<f64>)>,
}

impl Terms<'_> {
    /// The sum of `terms`, in their order whatever the number of threads.
    pub(super) fn derivatives(&self, terms: &[Term], curvature: Curvature) -> ContactDerivatives {
        let mut sum = Sum::new(self.surface.n_nodes());
        for batch in terms.chunks(BATCH) {
            let locals: Vec<Local> =
                batch.par_iter().map(|term| term.derivatives(self.barrier, self.x, curvature)).collect();
            batch.iter().zip(&locals).for_each(|(term, local)| sum.add(self.surface, term, local));
        }
        sum.finish()
    }
}

/// Sums by nodes.
struct Sum {
    energy: f64,
    gradient: Vec<f64>,
    /// Blocks of the row of each node, in the order in which they first came.
    rows: Vec<Vec<(u32, Matrix3<f64>)>>,
}

impl Sum {
    fn new(n_nodes: usize) -> Self {
        Self { energy: 0., gradient: vec![0.; 3 * n_nodes], rows: vec![Vec::new(); n_nodes] }
    }

    fn add(&mut self, surface: &CollisionSurface, term: &Term, local: &Local) {
        self.energy += local.energy;
        let corners = &term.vertices[..term.n];
        for (i, &v) in corners.iter().enumerate() {
            for &(row, w) in surface.carriers(v as usize) {
                let force: Vec3 = w * local.gradient[i];
                (0..3).for_each(|k| self.gradient[3 * row + k] += force[k]);
                for (j, &other) in corners.iter().enumerate() {
                    for &(column, share) in surface.carriers(other as usize) {
                        if column <= row {
                            let block = local.hessian.fixed_view::<3, 3>(3 * i, 3 * j);
                            *self.block(row, column) += w * share * block;
                        }
                    }
                }
            }
        }
    }

    fn block(&mut self, row: usize, column: usize) -> &mut Matrix3<f64> {
        let blocks = &mut self.rows[row];
        let place = blocks.iter().position(|(c, _)| *c as usize == column).unwrap_or(blocks.len());
        if place == blocks.len() {
            blocks.push((column as u32, Matrix3::zeros()));
        }
        &mut blocks[place].1
    }

    fn finish(self) -> ContactDerivatives {
        let mut blocks = Vec::new();
        for (row, mut columns) in self.rows.into_iter().enumerate() {
            columns.sort_unstable_by_key(|(column, _)| *column);
            blocks.extend(columns.into_iter().map(|(column, block)| (row, column as usize, block)));
        }
        ContactDerivatives { energy: self.energy, gradient: self.gradient, blocks }
    }
}
