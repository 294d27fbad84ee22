//! The tissue as its contacts feel it.

use nalgebra::{DMatrix, DVector};

use super::{ContactResponse, FixedStiffness, SparseColumn};
use crate::contact::Pair;

/// `K^-1` condensed to the nodes that may touch: `C = E' K^-1 E` (3k x 3k, mm/N) and `E' K^-1 F` (3k x m, mm),
/// with `E` the unit columns of `k` nodes. Any contact rows `G` on these nodes have
/// `V = G E' K^-1 F` and `S = G C G'` without another substitution: linearising the gaps again costs no solve.
#[derive(Clone, Debug)]
pub(super) struct Condensed {
    /// Where the three columns of a node start, by node.
    start: Vec<Option<usize>>,
    compliance: DMatrix<f64>,
    map: DMatrix<f64>,
}

impl Condensed {
    /// `stiff` condensed to `nodes` (0-based, distinct).
    pub(super) fn new(stiff: &FixedStiffness<'_>, nodes: &[usize]) -> Self {
        let loads = stiff.model().loads();
        let m = loads.len();
        let mut start = vec![None; stiff.model().n_dofs() / 3];
        let mut columns: Vec<SparseColumn> = loads.to_vec();
        for (k, &node) in nodes.iter().enumerate() {
            start[node] = Some(3 * k);
            columns.extend((0..3).map(|axis| vec![(3 * node + axis, 1.)]));
        }
        let gram = stiff.cholesky().gram(&columns);
        let d = 3 * nodes.len();
        Self {
            start,
            compliance: gram.view((m, m), (d, d)).into_owned(),
            map: gram.view((m, 0), (d, m)).into_owned(),
        }
    }

    /// The contact rows of `pairs`; nodes that were left out count as fixed.
    pub(super) fn contact(&self, pairs: &[Pair]) -> ContactResponse {
        let (c, m, d) = (pairs.len(), self.map.ncols(), self.compliance.nrows());
        let rows: Vec<SparseColumn> = pairs.iter().map(|pair| self.row(pair)).collect();
        let mut compliance = DMatrix::zeros(c, c);
        let mut pushed = DVector::zeros(d);
        for (j, row) in rows.iter().enumerate() {
            pushed.fill(0.);
            for &(dof, g) in row {
                pushed.axpy(g, &self.compliance.column(dof), 1.);
            }
            for (i, other) in rows.iter().enumerate().skip(j) {
                let opening = other.iter().map(|&(dof, g)| g * pushed[dof]).sum::<f64>();
                compliance[(i, j)] = opening;
                compliance[(j, i)] = opening;
            }
        }
        let approach =
            |i: usize, muscle: usize| rows[i].iter().map(|&(dof, g)| g * self.map[(dof, muscle)]).sum();
        ContactResponse {
            kinds: pairs.iter().map(|pair| pair.kind).collect(),
            gap: DVector::from_iterator(c, pairs.iter().map(|pair| pair.gap_mm)),
            approach: DMatrix::from_fn(c, m, approach),
            compliance,
            reach: DMatrix::zeros(0, c),
        }
    }

    fn row(&self, pair: &Pair) -> SparseColumn {
        let entries = pair.row.iter().filter_map(|(node, g)| Some((self.start[*node]?, g)));
        entries.flat_map(|(start, g)| (0..3).map(move |axis| (start + axis, g[axis]))).collect()
    }
}
