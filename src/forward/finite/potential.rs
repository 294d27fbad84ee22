//! What the face rests at a minimum of.

use super::contact::{FaceContact, Obstacles};
use super::hessian::Hessian;
use super::{FiniteBody, Place};
use crate::contact::{Candidates, Curvature};
use crate::forward::ForwardError;
use crate::units::Vec3;

/// The potential `Pi(u; a)` of a body with some dofs held, under dead loads and in contact.
#[derive(Clone, Debug)]
pub struct Potential {
    body: FiniteBody,
    /// Which dofs (3n) are held.
    held: Vec<bool>,
    /// Forces on the nodes (n) that stay the same however they move, N.
    dead_load: Vec<Vec3>,
    contact: Option<FaceContact>,
}

/// Where a step leads, with the contacts that it may bring about.
pub(super) struct Way {
    candidates: Option<Candidates>,
    /// The share of the step over which no surfaces cross.
    pub(super) limit: f64,
}

impl Potential {
    /// The potential of `body`, the dofs `held` (3n) being prescribed, under the forces `dead_load` (n, N).
    pub fn new(body: FiniteBody, held: Vec<bool>, dead_load: Vec<Vec3>) -> Self {
        Self { body, held, dead_load, contact: None }
    }

    /// The same with `contact`.
    #[must_use]
    pub fn with_contact(self, contact: FaceContact) -> Self {
        Self { contact: Some(contact), ..self }
    }

    /// The tissue.
    pub fn body(&self) -> &FiniteBody {
        &self.body
    }

    /// Which dofs (3n) are held.
    pub fn held(&self) -> &[bool] {
        &self.held
    }

    /// What may touch, if contact is on.
    pub fn contact(&self) -> Option<&FaceContact> {
        self.contact.as_ref()
    }

    /// The way from one place to another.
    pub(super) fn way(&self, from: &Place, to: &Place) -> Way {
        let Some(contact) = &self.contact else { return Way { candidates: None, limit: 1. } };
        let [from, to] = [from, to].map(|place| contact.positions(&place.x, &place.obstacles));
        let candidates = contact.barrier.candidates(&from, &to);
        let limit = contact.barrier.step_limit(&from, &to, &candidates);
        Way { candidates: Some(candidates), limit }
    }

    /// `Pi`, N mm, at `place` on the `way` under the activations `a` (m); `None` where a point is inside out or
    /// surfaces touch.
    pub(super) fn energy(&self, place: &Place, way: &Way, a: &[f64]) -> Option<f64> {
        let work: f64 = place.x.iter().zip(&self.dead_load).map(|(x, f)| x.dot(f)).sum();
        let mut energy = self.body.energy(&place.x, a)? - work;
        if let (Some(contact), Some(candidates)) = (&self.contact, &way.candidates) {
            energy += contact.barrier.energy(&contact.positions(&place.x, &place.obstacles), candidates);
        }
        energy.is_finite().then_some(energy)
    }

    /// The gradient (n, N) at `place`, the second derivatives being left in `hessian`, whose pattern grows by the nodes
    /// that contact joins; `None` where a point is inside out.
    pub(super) fn derivatives(
        &self,
        place: &Place,
        a: &[f64],
        hessian: &mut Hessian,
    ) -> Result<Option<Vec<Vec3>>, ForwardError> {
        let touched = self.contact.as_ref().map(|contact| {
            let at = contact.positions(&place.x, &place.obstacles);
            let candidates = contact.barrier.candidates(&at, &at);
            [Curvature::Exact, Curvature::Projected]
                .map(|curvature| contact.barrier.derivatives(&at, &candidates, curvature))
        });
        if let Some([exact, _]) = &touched {
            hessian.join(&self.body, &self.held, &exact.blocks)?;
        }
        hessian.tissue.fill(0.);
        let Hessian { pattern, tissue, .. } = hessian;
        let Some(mut gradient) = self.body.derivatives(&place.x, a, pattern, tissue) else { return Ok(None) };
        gradient.iter_mut().zip(&self.dead_load).for_each(|(g, f)| *g -= f);
        hessian.contact = touched.map(|touched| {
            let pushes = touched[0].gradient.as_chunks::<3>().0;
            gradient.iter_mut().zip(pushes).for_each(|(g, push)| *g += Vec3::from(*push));
            touched.map(|derivatives| derivatives.blocks)
        });
        Ok(Some(gradient))
    }

    /// The field (3n, mm) of all dofs as those that are held move by `lift` (3n, mm) and the teeth by `teeth` (mm) from
    /// `place`, balance being kept to first order by the stiffness that `hessian` factorised last.
    pub(super) fn follow(
        &self,
        hessian: &Hessian,
        place: &Place,
        lift: &[f64],
        teeth: &Obstacles,
    ) -> Vec<f64> {
        let mut push = hessian.pattern.multiply(&hessian.values, lift);
        if let Some(change) = self.contact_change(place, teeth) {
            push.iter_mut().zip(change).for_each(|(f, c)| *f += c);
        }
        push.iter_mut().for_each(|f| *f = -*f);
        let mut field = hessian.factor().displacements(&[push]).swap_remove(0);
        field.iter_mut().zip(lift).for_each(|(u, lift)| *u += lift);
        field
    }

    /// Force (n, N) by which contact changes on the nodes as the teeth move by `step` from `place`.
    fn contact_change(&self, place: &Place, step: &Obstacles) -> Option<Vec<f64>> {
        /// Farthest that a tooth is moved to see the change, mm: a small share of any gap.
        const NUDGE_MM: f64 = 1e-5;
        let contact = self.contact.as_ref()?;
        let farthest = step.iter().flatten().map(Vec3::norm).fold(0., f64::max);
        if farthest == 0. {
            return None;
        }
        let nudge = NUDGE_MM / farthest;
        let nudged = |share: f64| {
            let along = place.obstacles.iter().zip(step.iter());
            let moved = along.map(|(at, step)| at.iter().zip(step).map(|(p, s)| p + share * s).collect());
            let at = contact.positions(&place.x, &Obstacles::new(moved.collect()));
            let candidates = contact.barrier.candidates(&at, &at);
            contact.barrier.derivatives(&at, &candidates, Curvature::Exact).gradient
        };
        let (ahead, behind) = (nudged(nudge), nudged(-nudge));
        Some(ahead.iter().zip(behind).map(|(a, b)| (a - b) / (2. * nudge)).collect())
    }
}
