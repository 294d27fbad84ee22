//! The linear model at one fixed stiffness.

use nalgebra::{DMatrix, DVector};
use rayon::prelude::*;

use super::contact_forces::contact_forces_near;
use super::moved_bones::MovedBones;
use super::{Cholesky, ContactError, ContactResponse, Model, Response, SparseColumn, Touching};
use crate::contact::Pair;
use crate::face::Pose;
use crate::mesh::Site;

/// The forward model at a fixed stiffness `K(abar)`: linear in activations and contact forces.
#[derive(Clone, Debug)]
pub struct FixedStiffness<'m> {
    model: &'m Model,
    activation: Vec<f64>,
    cholesky: Cholesky,
    /// `None` with every bone at rest.
    bones: Option<MovedBones>,
}

/// Where the tissue comes to rest under its muscles, its stiffness being that of their activations.
#[derive(Clone, Debug)]
pub struct Equilibrium {
    /// Displacement (3n), mm.
    pub displacement: Vec<f64>,
    /// Contact forces (c), N.
    pub contact_forces: DVector<f64>,
}

impl<'m> FixedStiffness<'m> {
    pub(super) fn new(
        model: &'m Model,
        activation: &[f64],
        cholesky: Cholesky,
        bones: Option<MovedBones>,
    ) -> Self {
        Self { model, activation: activation.to_vec(), cholesky, bones }
    }

    /// Where the bones are.
    pub fn pose(&self) -> Pose {
        self.bones.as_ref().map(|b| b.pose.clone()).unwrap_or_default()
    }

    /// The activations `abar` (m) of this stiffness, and after them the share of the jaw's opening where that
    /// is an unknown: where the [`response`](Self::response) stands.
    pub fn unknowns(&self) -> DVector<f64> {
        let share = self.bones.as_ref().and_then(|b| b.jaw.as_ref()).map(|jaw| jaw.share);
        DVector::from_iterator(
            self.activation.len() + usize::from(share.is_some()),
            self.activation.iter().copied().chain(share),
        )
    }

    /// The model that this is the stiffness of.
    pub fn model(&self) -> &'m Model {
        self.model
    }

    /// The factor of `K(abar)`.
    pub fn cholesky(&self) -> &Cholesky {
        &self.cholesky
    }

    /// The activation map: displacement (3n, mm) per unit activation of each of the `m` muscles,
    /// `K^-1 F`, from one factorisation with blocked right-hand sides.
    pub fn map(&self) -> Vec<Vec<f64>> {
        let forces: Vec<_> = self.model.loads().iter().map(|load| self.dense(load)).collect();
        self.cholesky.displacements(&forces)
    }

    /// Displacement (3n, mm) `u = K^-1 (F a + G' lambda)` under activations `a` (m) and contact
    /// forces `lambda` (c, N; empty when there are none), on top of what the moved bones do.
    pub fn displacement(&self, activation: &[f64], contact_forces: &[f64]) -> Vec<f64> {
        self.displacement_with(self.model.pairs(), activation, contact_forces)
    }

    /// [`displacement`](Self::displacement) with contact forces on other `pairs` than the model's.
    pub fn displacement_with(&self, pairs: &[Pair], activation: &[f64], contact_forces: &[f64]) -> Vec<f64> {
        let mut force = vec![0.; self.model.n_dofs()];
        for (load, a) in self.model.loads().iter().zip(activation) {
            add(&mut force, load, *a);
        }
        for (pair, lambda) in pairs.iter().zip(contact_forces) {
            for (node, push) in &pair.row {
                for axis in 0..3 {
                    force[3 * node + axis] += lambda * push[axis];
                }
            }
        }
        let mut u = self.cholesky.displacements(&[force]).swap_remove(0);
        if let Some(bones) = &self.bones {
            u.iter_mut().zip(&bones.lift).for_each(|(u, lift)| *u += lift);
        }
        u
    }

    /// The response of `sites` and contacts, every block from one Gram matrix `C' K^-1 C` with
    /// `C = [F P' G']`: only the observed rows are ever formed.
    pub fn response(&self, sites: &[Site]) -> Response {
        self.response_with(sites, self.model.pairs())
    }

    /// The [`response`](Self::response) of other contact `pairs` than the model's.
    pub fn response_with(&self, sites: &[Site], pairs: &[Pair]) -> Response {
        let loads = self.model.loads();
        let (m, d, c) = (loads.len(), 3 * sites.len(), pairs.len());
        let mut columns: Vec<SparseColumn> = loads.to_vec();
        for site in sites {
            columns.extend((0..3).map(|axis| site.weights.iter().map(|&(n, w)| (3 * n + axis, w)).collect()));
        }
        for pair in pairs {
            let entries = pair.row.iter().flat_map(|(n, g)| (0..3).map(move |axis| (3 * n + axis, g[axis])));
            columns.push(entries.collect());
        }
        let gram = self.cholesky.gram(&columns);
        let contact = (c > 0).then(|| ContactResponse {
            kinds: pairs.iter().map(|p| p.kind).collect(),
            gap: DVector::from_iterator(c, pairs.iter().map(|p| p.gap_mm)),
            approach: gram.view((m + d, 0), (c, m)).into_owned(),
            compliance: gram.view((m + d, m + d), (c, c)).into_owned(),
            reach: gram.view((m, m + d), (d, c)).into_owned(),
        });
        let mut response = Response {
            muscles: self.model.muscles().to_vec(),
            jaw: None,
            map: gram.view((m, 0), (d, m)).into_owned(),
            offset: DVector::zeros(d),
            contact,
        };
        if let Some(bones) = &self.bones {
            self.add_bones(bones, sites, pairs, &mut response);
        }
        response
    }

    /// What bones at `pose`, in place of where they are, do without activation and contact forces: displacements (d) of
    /// `sites` and changes of the gaps of the model's pairs (c), mm. No factorisation.
    pub fn moved_by(&self, pose: &Pose, sites: &[Site]) -> (DVector<f64>, DVector<f64>) {
        let bones = self.bones_at(pose);
        let gaps = DVector::from_vec(bones.gap_changes(self.model, self.model.pairs()));
        (observed(sites, &bones.lift), gaps)
    }

    /// Displacement (3n), mm, with bones at `pose`, in place of where they are, without activation and contact forces.
    pub fn lifted_by(&self, pose: &Pose) -> Vec<f64> {
        self.bones_at(pose).lift
    }

    fn bones_at(&self, pose: &Pose) -> MovedBones {
        let values = self.model.stiffness_at(&self.activation);
        MovedBones::new(self.model, &values, &self.cholesky, pose.clone())
    }

    /// Change of the gaps of `pairs` (c) by the moved bones without activation and contact forces, mm.
    pub(super) fn gap_changes(&self, pairs: &[Pair]) -> DVector<f64> {
        match &self.bones {
            Some(bones) => DVector::from_vec(bones.gap_changes(self.model, pairs)),
            None => DVector::zeros(pairs.len()),
        }
    }

    /// What the moved bones do to the observed points and the gaps, and the column of the jaw's opening where
    /// that is an unknown.
    fn add_bones(&self, bones: &MovedBones, sites: &[Site], pairs: &[Pair], response: &mut Response) {
        response.offset = observed(sites, &bones.lift);
        if let Some(contact) = &mut response.contact {
            contact.gap += DVector::from_vec(bones.gap_changes(self.model, pairs));
        }
        let Some(jaw) = &bones.jaw else { return };
        response.jaw = Some(jaw.range);
        let append = |matrix: &mut DMatrix<f64>, offset: &mut DVector<f64>, column: DVector<f64>| {
            offset.axpy(-jaw.share, &column, 1.);
            let last = matrix.ncols();
            let whole = std::mem::replace(matrix, DMatrix::zeros(0, 0));
            *matrix = whole.insert_column(last, 0.);
            matrix.set_column(last, &column);
        };
        append(&mut response.map, &mut response.offset, observed(sites, &jaw.field));
        if let Some(contact) = &mut response.contact {
            let slopes = DVector::from_vec(jaw.gap_slopes(self.model, pairs));
            append(&mut contact.approach, &mut contact.gap, slopes);
        }
    }

    /// Displacement and contact forces at the activations `abar` that this stiffness belongs to and at its
    /// pose: `K(abar) u = F abar + G' lambda`, `0 <= lambda  _|_  g0 + G u >= 0`.
    ///
    /// # Errors
    /// [`ContactError`] when no contact forces keep the gaps open.
    pub fn equilibrium(&self, contact: Option<&ContactResponse>) -> Result<Equilibrium, ContactError> {
        self.equilibrium_near(contact, &[])
    }

    /// The [`equilibrium`](Self::equilibrium), its contact forces sought from the contacts `touching` of a nearby
    /// one; from the gaps when there are none.
    pub(crate) fn equilibrium_near(
        &self,
        contact: Option<&ContactResponse>,
        touching: &[usize],
    ) -> Result<Equilibrium, ContactError> {
        let contact_forces = match contact {
            Some(contact) => {
                let near = Touching::new(&contact.compliance, touching.iter().copied());
                let near = (!touching.is_empty()).then_some(&near);
                contact_forces_near(contact, &self.unknowns(), near)?.0
            }
            None => DVector::zeros(0),
        };
        let displacement = self.displacement(&self.activation, contact_forces.as_slice());
        Ok(Equilibrium { displacement, contact_forces })
    }

    /// The [`equilibrium`](Self::equilibrium) against the model's pairs, its contact forces sought from the pairs `touching`.
    ///
    /// # Errors
    /// As [`equilibrium`](Self::equilibrium).
    pub fn equilibrium_from(&self, touching: &[usize]) -> Result<Equilibrium, ContactError> {
        self.equilibrium_near(self.response(&[]).contact.as_ref(), touching)
    }

    /// The `response` of `sites` at this stiffness, linearised about `abar` and the displacement `u`
    /// (3n, mm) that it causes:
    /// `K(abar) u' = F a' - sum_m (a'_m - abar_m) dK/da_m u + G' lambda'`.
    ///
    /// `u` includes what the moved bones do, so that the force which they need is seen to change with `K`. The
    /// map is the exact Jacobian `du/da_m = K(abar)^-1 (f_m - dK/da_m u)` at fixed contact forces:
    /// the fixed-stiffness map less `K^-1 dK/da_m u`, one more solve a muscle.
    pub fn tangent(&self, sites: &[Site], response: &Response, displacement: &[f64]) -> Response {
        let stretched: Vec<Vec<f64>> = (0..self.model.muscles().len())
            .into_par_iter()
            .map(|muscle| self.model.stiffening(muscle, self.activation[muscle], displacement))
            .collect();
        let mut tangent = response.clone();
        for (part, softened) in self.cholesky.displacements(&stretched).iter().enumerate() {
            let a = self.activation[part];
            for (s, site) in sites.iter().enumerate() {
                let u = site.displacement(softened);
                for axis in 0..3 {
                    tangent.map[(3 * s + axis, part)] -= u[axis];
                    tangent.offset[3 * s + axis] += a * u[axis];
                }
            }
            if let Some(contact) = &mut tangent.contact {
                for (c, pair) in self.model.pairs().iter().enumerate() {
                    let change = pair.change_mm(softened);
                    contact.approach[(c, part)] -= change;
                    contact.gap[c] += a * change;
                }
            }
        }
        tangent
    }

    /// Holds the gaps of the `touching` pairs in each of the `fields` (3n, mm): `T - K^-1 G' S^-1 G T`, with
    /// `S = G K^-1 G'`.
    pub fn hold(&self, touching: &[Pair], fields: &mut [Vec<f64>]) {
        let Some(contact) = self.response_with(&[], touching).contact else { return };
        let held = Touching::new(&contact.compliance, 0..touching.len());
        let push = |field: &Vec<f64>| {
            let gap =
                DVector::from_iterator(touching.len(), touching.iter().map(|pair| pair.change_mm(field)));
            let mut force = vec![0.; field.len()];
            for (pair, lambda) in touching.iter().zip(&held.forces(&gap)) {
                for (node, g) in &pair.row {
                    (0..3).for_each(|axis| force[3 * node + axis] += lambda * g[axis]);
                }
            }
            force
        };
        let pushes: Vec<Vec<f64>> = fields.par_iter().map(push).collect();
        for (field, back) in fields.iter_mut().zip(self.cholesky.displacements(&pushes)) {
            field.iter_mut().zip(back).for_each(|(t, b)| *t += b);
        }
    }

    fn dense(&self, column: &SparseColumn) -> Vec<f64> {
        let mut full = vec![0.; self.model.n_dofs()];
        add(&mut full, column, 1.);
        full
    }
}

/// Displacements (3p) of `sites` in the field `u` (3n), mm.
fn observed(sites: &[Site], u: &[f64]) -> DVector<f64> {
    let seen = sites.iter().flat_map(|site| {
        let u = site.displacement(u);
        [u.x, u.y, u.z]
    });
    DVector::from_iterator(3 * sites.len(), seen)
}

fn add(full: &mut [f64], column: &SparseColumn, factor: f64) {
    for &(dof, value) in column {
        full[dof] += factor * value;
    }
}
