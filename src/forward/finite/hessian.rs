//! The second derivatives of the potential, and their factor.

use std::collections::BTreeSet;
use std::sync::Arc;

use nalgebra::Matrix3;

use super::FiniteBody;
use crate::contact::Curvature;
use crate::forward::{Cholesky, ForwardError, Pattern, SymbolicFactor};
use crate::units::Vec3;

/// The second derivative by nodes `i >= j`, N/mm.
pub(super) type ContactBlock = (usize, usize, Matrix3<f64>);

/// The Hessian `H` of the potential on the nodes of a face, N/mm, and the Cholesky factor of its free part.
///
/// Its pattern is that of the tissue, and of the nodes that contact has joined so far.
#[derive(Clone, Debug)]
pub(super) struct Hessian {
    pub(super) pattern: Pattern,
    /// Of the tissue, on the pattern.
    pub(super) tissue: Vec<f64>,
    /// Of contact: as they are, and the nearest positive semidefinite ones.
    pub(super) contact: Option<[Vec<ContactBlock>; 2]>,
    /// What was factorised last.
    pub(super) values: Vec<f64>,
    factor: Cholesky,
    /// Pairs of nodes `(i, j)`, `i > j`, that contact has joined.
    joined: BTreeSet<(usize, usize)>,
}

impl Hessian {
    /// Zero, on the pattern of `body` and the `joined` pairs of nodes, with the supports `fixed` (3n).
    pub(super) fn new(
        body: &FiniteBody,
        fixed: &[bool],
        joined: BTreeSet<(usize, usize)>,
    ) -> Result<Self, ForwardError> {
        let pairs: Vec<[usize; 2]> = joined.iter().map(|&(i, j)| [i, j]).collect();
        let groups = body.patches().iter().map(|patch| patch.nodes()).chain(pairs.iter().map(|p| &p[..]));
        let pattern = Pattern::new(fixed.len() / 3, groups);
        let symbolic = Arc::new(SymbolicFactor::new(&pattern, fixed)?);
        let values = vec![0.; pattern.n_values()];
        let factor = Cholesky::unfactorised(symbolic);
        Ok(Self { pattern, tissue: values.clone(), contact: None, values, factor, joined })
    }

    /// Makes room for `blocks` between nodes that are not yet joined.
    pub(super) fn join(
        &mut self,
        body: &FiniteBody,
        fixed: &[bool],
        blocks: &[ContactBlock],
    ) -> Result<(), ForwardError> {
        let is_new = |&(i, j, _): &ContactBlock| (!self.pattern.joins(i, j)).then_some((i.max(j), i.min(j)));
        let new: BTreeSet<(usize, usize)> = blocks.iter().filter_map(is_new).collect();
        if !new.is_empty() {
            *self = Self::new(body, fixed, self.joined.union(&new).copied().collect())?;
        }
        Ok(())
    }

    /// The Hessian with the curvature of contact as it is, or made positive.
    pub(super) fn with(&self, curvature: Curvature) -> Vec<f64> {
        let mut values = self.tissue.clone();
        if let Some([exact, projected]) = &self.contact {
            let blocks = match curvature {
                Curvature::Exact => exact,
                Curvature::Projected => projected,
            };
            blocks.iter().for_each(|(i, j, block)| self.pattern.add_block(*i, *j, block, &mut values));
        }
        values
    }

    /// Factorises `H + tau shift`, with `shift` on the same pattern. False when that is not positive definite.
    pub(super) fn factorise(&mut self, curvature: Curvature, shift: Option<(f64, &[f64])>) -> bool {
        self.values = self.with(curvature);
        if let Some((tau, shift)) = shift {
            self.values.iter_mut().zip(shift).for_each(|(h, k)| *h += tau * k);
        }
        self.factor.renew(&self.values).is_ok()
    }

    /// The Hessian of the tissue of `body` at `x` (n, mm) without activation, on this pattern; `known` has it on that of
    /// the tissue alone.
    pub(super) fn of_tissue(&self, body: &FiniteBody, x: &[Vec3], known: &Self) -> Vec<f64> {
        if self.joined.is_empty() {
            return known.tissue.clone();
        }
        let mut values = vec![0.; self.pattern.n_values()];
        body.derivatives(x, &vec![0.; body.n_muscles()], &self.pattern, &mut values);
        values
    }

    /// The factor of the last [`factorise`](Self::factorise) that was true.
    pub(super) fn factor(&self) -> &Cholesky {
        &self.factor
    }
}
