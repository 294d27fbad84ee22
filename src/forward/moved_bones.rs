//! What moved bones do to the tissue at one stiffness.

use super::{Cholesky, Model};
use crate::contact::Pair;
use crate::face::{JawRange, Pose};

/// The displacement that moved bones alone bring about, and how it goes on as the jaw opens.
///
/// With `u_b` the displacement of the nodes on bones, the free ones follow by `K_ff u_f = -K_fb u_b`.
#[derive(Clone, Debug)]
pub(super) struct MovedBones {
    /// Where the bones are.
    pub(super) pose: Pose,
    /// Displacement (3n) without activation and contact forces, mm.
    pub(super) lift: Vec<f64>,
    /// The jaw's opening as an unknown.
    pub(super) jaw: Option<JawColumn>,
}

/// The jaw's opening as an unknown, in shares of its range.
#[derive(Clone, Debug)]
pub(super) struct JawColumn {
    pub(super) range: JawRange,
    /// The share at which the column is taken, 0 to 1.
    pub(super) share: f64,
    /// Displacement (3n) per unit share, mm.
    pub(super) field: Vec<f64>,
}

impl MovedBones {
    /// The bones of `model` at `pose`, under the stiffness with these `values` and its factor.
    pub(super) fn new(model: &Model, values: &[f64], cholesky: &Cholesky, pose: Pose) -> Self {
        let lift = lifted(model, values, cholesky, model.face().bone_displacement(&pose));
        Self { pose, lift, jaw: None }
    }

    /// The same with the jaw, whose opening is the `share` of `range`, as an unknown.
    pub(super) fn opened(
        model: &Model,
        values: &[f64],
        cholesky: &Cholesky,
        range: JawRange,
        share: f64,
    ) -> Self {
        let face = model.face();
        let opening_mm = range.at(share);
        let pose = face.jaw.as_ref().map(|jaw| Pose::opened(jaw, opening_mm)).unwrap_or_default();
        let mut slope = face.bone_slope(opening_mm);
        slope.iter_mut().for_each(|v| *v *= range.width_mm());
        let field = lifted(model, values, cholesky, slope);
        Self { jaw: Some(JawColumn { range, share, field }), ..Self::new(model, values, cholesky, pose) }
    }

    /// Change of the gaps of `pairs` (c) by the pose without activation and contact forces, mm.
    pub(super) fn gap_changes(&self, model: &Model, pairs: &[Pair]) -> Vec<f64> {
        let teeth = model.face().tooth_changes(pairs, &self.pose);
        pairs.iter().zip(teeth).map(|(pair, tooth)| pair.change_mm(&self.lift) + tooth).collect()
    }
}

impl JawColumn {
    /// How the gaps of `pairs` (c) open per unit share, mm.
    pub(super) fn gap_slopes(&self, model: &Model, pairs: &[Pair]) -> Vec<f64> {
        let teeth = model.face().tooth_slopes(pairs, self.range.at(self.share));
        let slope = |(pair, tooth): (&Pair, f64)| pair.change_mm(&self.field) + self.range.width_mm() * tooth;
        pairs.iter().zip(teeth).map(slope).collect()
    }
}

/// The displacement (3n) of tissue whose bones move by `u_b` (3n, zero off the bones).
fn lifted(model: &Model, values: &[f64], cholesky: &Cholesky, u_b: Vec<f64>) -> Vec<f64> {
    let mut push = model.stiffness().pattern().multiply(values, &u_b);
    push.iter_mut().for_each(|f| *f = -*f);
    let mut u = cholesky.displacements(&[push]).swap_remove(0);
    for (u, held) in u.iter_mut().zip(u_b) {
        *u += held;
    }
    u
}
