//! How a face at finite strain goes on from where it rests.

use nalgebra::{DMatrix, DVector};

use super::contact::Obstacles;
use super::{FiniteModel, FiniteState};
use crate::face::{JawRange, Teeth};
use crate::forward::Response;
use crate::mesh::Site;
use crate::units::Vec3;

/// The tangent of a face at rest: the displacement field that each unknown brings about, contact included.
#[derive(Clone, Debug)]
pub struct Tangent {
    /// `du/da_m = -H^-1 grad Pi_m` (m x 3n), mm per unit activation, and after them the field of the jaw's opening, mm
    /// per unit share of its range, where that is an unknown.
    fields: Vec<Vec<f64>>,
    muscles: Vec<String>,
    jaw: Option<JawRange>,
}

impl Tangent {
    /// The displacement field (3n, mm per unit) of each unknown: the muscles, then the jaw's opening where it is one.
    pub fn fields(&self) -> &[Vec<f64>] {
        &self.fields
    }

    /// What the unknowns do to `sites`, linearised about `state`, whose unknowns are `x`:
    /// `P u' = P u + P du/dx (x' - x)`. Contact is in the tangent; there is no contact row.
    pub fn response(&self, state: &FiniteState, x: &DVector<f64>, sites: &[Site]) -> Response {
        let seen =
            |u: &[f64]| sites.iter().flat_map(|s| <[f64; 3]>::from(s.displacement(u))).collect::<Vec<_>>();
        let columns: Vec<f64> = self.fields.iter().flat_map(|field| seen(field)).collect();
        let map = DMatrix::from_vec(3 * sites.len(), self.fields.len(), columns);
        let offset = DVector::from_vec(seen(state.displacement())) - &map * x;
        Response { muscles: self.muscles.clone(), jaw: self.jaw, map, offset, contact: None }
    }

    /// Where the nodes at `positions` (n, mm) go as the unknowns change by `step`, to first order.
    pub(super) fn predict(&self, positions: &[Vec3], step: &DVector<f64>) -> Vec<Vec3> {
        let mut x = positions.to_vec();
        for (field, step) in self.fields.iter().zip(step).filter(|(_, step)| **step != 0.) {
            for (x, u) in x.iter_mut().zip(field.as_chunks::<3>().0) {
                *x += *step * Vec3::from(*u);
            }
        }
        x
    }
}

impl FiniteModel {
    /// The tangent at `state`; `jaw` is the range of an opening that is unknown, and the share of it at `state`.
    pub fn tangent(&self, state: &FiniteState, jaw: Option<(JawRange, f64)>) -> Option<Tangent> {
        let (_, muscles) = self.potential().body().forces(state.positions())?;
        let dense = |forces: Vec<Vec3>| forces.into_iter().flat_map(|f| [-f.x, -f.y, -f.z]).collect();
        let loads: Vec<Vec<f64>> = muscles.into_iter().map(dense).collect();
        let mut fields = state.factor().displacements(&loads);
        if let Some((range, share)) = jaw {
            let (face, opening_mm) = (self.face(), range.at(share));
            fields.push(self.follow(state, |bone, p| face.jaw_slope(bone, opening_mm, p) * range.width_mm()));
        }
        let muscles = self.face().muscles.iter().map(|m| m.name.clone()).collect();
        Some(Tangent { fields, muscles, jaw: jaw.map(|(range, _)| range) })
    }

    /// The displacement field (3n, mm per unit) as the point of each bone that rests at `p` moves by `way(bone, p)` from where it is
    /// at `state`: teeth move on with their bones, and the tissue follows in balance to first order, contact included.
    pub fn follow(&self, state: &FiniteState, way: impl Fn(&str, Vec3) -> Vec3) -> Vec<f64> {
        let face = self.face();
        let of = |teeth: &Teeth| teeth.surface.points.iter().map(|p| way(&teeth.bone, *p)).collect();
        let teeth = Obstacles::new(face.teeth.iter().map(of).collect());
        self.potential().follow(state.hessian(), state.place(), &face.bone_field(&way), &teeth)
    }
}
