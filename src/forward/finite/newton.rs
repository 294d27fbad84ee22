//! Newton's method on the potential.

use super::Potential;
use super::conjugate_gradients::{Descent, conjugate_gradients, dot};
use super::contact::Obstacles;
use super::hessian::Hessian;
use crate::contact::Curvature;
use crate::forward::{Cholesky, ForwardError};
use crate::units::Vec3;

/// Steps before a load is given up, and those in a row that surfaces cut to less than half.
const MOST_STEPS: usize = 100;
const MOST_CUT: usize = 40;
/// Unbalanced force of a body at rest, as a share of the forces that act on it.
const BALANCED: f64 = 1e-9;
/// Forces below this, N, are not told apart from those of rounding when they are balanced.
const LEAST_FORCE_N: f64 = 1e-3;
/// Share of the predicted decrease that a step must bring (Armijo).
const WORTH: f64 = 1e-4;
/// Shortest step, as a share of Newton's.
const SHORTEST: f64 = 1. / 1024.;
/// Longest step of a node along an axis, mm: what a longer one would meet on its way is not asked for.
const LONGEST_MM: f64 = 4.;
/// Residual of the exact Hessian's step, as a share of the gradient, at most; less where the gradient is small.
const INEXACT: f64 = 0.1;
/// How far a body is pushed where its balance is not stable, mm.
const PUSH_MM: f64 = 0.01;
/// Times that it is pushed.
const MOST_PUSHES: usize = 3;
/// Unbalanced force, as the share above, with which bones are moved on at once.
const NEAR: f64 = 1e-2;
/// Share of the way to the next touch that held dofs and teeth are moved at once.
const SAFE: f64 = 0.5;
/// First and greatest weight of the rest stiffness where the Hessian is indefinite.
const SHIFT: [f64; 2] = [0.02, 100.];

/// How much work the search for rest was.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct SettlingCost {
    /// Newton steps.
    pub steps: usize,
    /// Numeric factorisations, those that found a negative pivot included.
    pub factorisations: usize,
}

impl SettlingCost {
    /// Adds the work of another search.
    pub fn add(&mut self, other: Self) {
        self.steps += other.steps;
        self.factorisations += other.factorisations;
    }
}

/// Where the nodes and the teeth are.
#[derive(Clone, Debug)]
pub(super) struct Place {
    /// Nodes (n), mm.
    pub(super) x: Vec<Vec3>,
    pub(super) obstacles: Obstacles,
}

/// A body at rest: where its potential has a minimum, its Hessian there and the factor of it.
#[derive(Clone, Debug)]
pub struct Minimum {
    pub(super) place: Place,
    pub(super) hessian: Hessian,
    pub(super) is_stable: bool,
    pub(super) cost: SettlingCost,
}

impl Minimum {
    /// Whether the Hessian is positive definite.
    pub fn is_stable(&self) -> bool {
        self.is_stable
    }

    /// The nodes (n), mm.
    pub fn positions(&self) -> &[Vec3] {
        &self.place.x
    }

    /// The factor of the Hessian: the tangent stiffness.
    pub fn factor(&self) -> &Cholesky {
        self.hessian.factor()
    }

    /// What it took to find it.
    pub fn cost(&self) -> SettlingCost {
        self.cost
    }
}

/// The potential and its derivatives somewhere.
struct Here {
    /// Gradient on the free dofs, N.
    residual: Vec<f64>,
    /// What the residual is measured against, N.
    scale: f64,
}

/// Newton's method with exact tangents. What is factorised is the Hessian with the curvature of contact made positive,
/// `P`, and where the tissue itself is unstable `P + tau H_0`, `H_0` the Hessian at rest; the step of the exact Hessian comes
/// from it by conjugate gradients, once steps go their whole way. A step is shortened until the potential falls with it
/// (Armijo) with no point inside out and no surfaces that cross.
pub(super) struct Newton<'p> {
    potential: &'p Potential,
    /// Where the body rests without a load,
    origin: &'p [Vec3],
    /// and `H_0` there.
    metric: &'p Hessian,
    hessian: Hessian,
    shift: f64,
    is_stable: bool,
    cost: SettlingCost,
}

impl<'p> Newton<'p> {
    /// With the memory of `hessian`.
    pub(super) fn new(
        potential: &'p Potential,
        origin: &'p [Vec3],
        metric: &'p Hessian,
        hessian: Hessian,
    ) -> Self {
        let cost = SettlingCost::default();
        Self { potential, origin, metric, hessian, shift: 0., is_stable: true, cost }
    }

    /// The place of rest near `start` under the activations `a` (m), with the held dofs and the teeth as they are in
    /// `bones`; `None` when there is none to be found.
    ///
    /// # Errors
    /// [`ForwardError`] when the matrices cannot be set up.
    pub(super) fn rest(
        &mut self,
        start: &Place,
        bones: &Place,
        a: &[f64],
    ) -> Result<Option<Place>, ForwardError> {
        let (mut place, mut to_go) = (start.clone(), if self.is_there(start, bones) { 0. } else { 1. });
        let Some(pull) = self.pull(&place.x, a) else { return Ok(None) };
        let (mut is_whole, mut cut, mut pushes) = (true, 0, 0);
        for _ in 0..MOST_STEPS {
            let Some(here) = self.derivatives(&place, a, pull)? else { return Ok(None) };
            let size = norm(&here.residual);
            if to_go == 0. && size <= BALANCED * here.scale {
                self.cost.factorisations += 1;
                self.is_stable = self.hessian.factorise(Curvature::Exact, None);
                if self.is_stable {
                    return Ok(Some(place));
                }
                if !self.factorise() {
                    return Ok(None);
                }
                match self.pushed(&place, &here, a).filter(|_| pushes < MOST_PUSHES) {
                    Some(next) => place = next,
                    None => return Ok(Some(place)),
                }
                pushes += 1;
                continue;
            }
            if !self.factorise() {
                return Ok(None);
            }
            if to_go > 0. && size <= NEAR * here.scale {
                (place, to_go) = self.following(&place, bones);
                self.cost.steps += 1;
                continue;
            }
            let tolerance = f64::min(INEXACT, (size / here.scale).sqrt());
            let exact = if is_whole { self.exact_step(&here, tolerance) } else { None };
            let along = |step: Vec<f64>| self.line_search(&place, &step, &here, a);
            let projected = || {
                let mut step = here.residual.clone();
                self.hessian.factor().solve_in_place(&mut step);
                step
            };
            let Some((next, share)) = exact.and_then(along).or_else(|| along(projected())) else {
                if self.shift >= SHIFT[1] {
                    return Ok(None);
                }
                self.shift = (8. * self.shift).max(SHIFT[0]);
                continue;
            };
            is_whole = share > 0.9;
            cut = if share < 0.5 { cut + 1 } else { 0 };
            if cut == MOST_CUT {
                return Ok(None);
            }
            self.shift = if is_whole { 0.1 * self.shift } else { self.shift };
            if self.shift < 0.1 * SHIFT[0] {
                self.shift = 0.;
            }
            place = next;
            if to_go > 0. {
                (place, to_go) = self.following(&place, bones);
            }
            self.cost.steps += 1;
        }
        Ok(None)
    }

    /// The minimum at `place`, whose Hessian was factorised last.
    pub(super) fn minimum(self, place: Place) -> Minimum {
        Minimum { place, hessian: self.hessian, is_stable: self.is_stable, cost: self.cost }
    }

    /// The step of the exact Hessian; `None` where the factor's own is as good.
    fn exact_step(&self, here: &Here, tolerance: f64) -> Option<Vec<f64>> {
        let touches = self.hessian.contact.as_ref().is_some_and(|[exact, _]| !exact.is_empty());
        if !touches && self.shift == 0. {
            return None;
        }
        let exact = self.hessian.with(Curvature::Exact);
        match conjugate_gradients(&self.hessian, &exact, &here.residual, tolerance) {
            Descent::Solution(step) => Some(step),
            Descent::Curved { step, direction } => {
                let longest = direction.iter().fold(0., |most: f64, d| most.max(d.abs()));
                let downhill = dot(&direction, &here.residual).signum();
                let far = downhill * PUSH_MM / longest;
                let step = step.unwrap_or_else(|| vec![0.; direction.len()]);
                Some(step.iter().zip(&direction).map(|(s, d)| s + far * d).collect())
            }
        }
    }

    /// A place beside the balanced `place` where the potential is less, along a direction of negative curvature.
    fn pushed(&self, place: &Place, here: &Here, a: &[f64]) -> Option<Place> {
        let exact = self.hessian.with(Curvature::Exact);
        // Any load that has a part in every direction.
        let load: Vec<f64> =
            (1..=here.residual.len()).map(|k| (k as f64 * 0.618_033_988_75).fract() - 0.5).collect();
        let Descent::Curved { direction, .. } = conjugate_gradients(&self.hessian, &exact, &load, 1e-10)
        else {
            return None;
        };
        let longest = direction.iter().fold(0., |most: f64, d| most.max(d.abs()));
        [1., -1.].into_iter().find_map(|sign| {
            let push: Vec<f64> = direction.iter().map(|d| sign * PUSH_MM / longest * d).collect();
            self.line_search(place, &push, here, a).map(|(next, _)| next)
        })
    }

    /// `start` with held dofs and teeth brought towards where they are in `bones`, as far as nothing crosses or turns
    /// inside out, the other dofs following as the stiffness that was factorised last has it, contact included; and the
    /// share of the way that is left.
    fn following(&self, start: &Place, bones: &Place) -> (Place, f64) {
        let mut lift = vec![0.; 3 * start.x.len()];
        for (dof, _) in self.potential.held().iter().enumerate().filter(|(_, held)| **held) {
            lift[dof] = bones.x[dof / 3][dof % 3] - start.x[dof / 3][dof % 3];
        }
        let teeth = start.obstacles.iter().zip(bones.obstacles.iter());
        let teeth = teeth.map(|(from, to)| from.iter().zip(to).map(|(p, q)| q - p).collect()).collect();
        let follow = self.potential.follow(&self.hessian, start, &lift, &Obstacles::new(teeth));
        let along = |share: f64| {
            let moved = follow.as_chunks::<3>().0;
            let x = start.x.iter().zip(moved).map(|(x, u)| x + share * Vec3::from(*u));
            let lists = start.obstacles.iter().zip(bones.obstacles.iter());
            let teeth = lists.map(|(from, to)| from.iter().zip(to).map(|(p, q)| p.lerp(q, share)).collect());
            Place { x: x.collect(), obstacles: Obstacles::new(teeth.collect()) }
        };
        let longest = follow.iter().fold(0., |most: f64, u| most.max(u.abs()));
        let most = (LONGEST_MM / longest).min(1.);
        let farthest =
            if most == 1. { Place { obstacles: bones.obstacles.clone(), ..along(1.) } } else { along(most) };
        let limit = self.potential.way(start, &farthest).limit;
        let is_upright = |place: &Place| self.potential.body().is_upright(&place.x);
        if limit == 1. && is_upright(&farthest) {
            return (farthest, 1. - most);
        }
        let mut share = SAFE * limit * most;
        let mut there = along(share);
        while share > 0. && !is_upright(&there) {
            share *= 0.5;
            there = along(share);
        }
        (there, 1. - share)
    }

    /// Whether held dofs and teeth are at `place` where they are in `bones`.
    fn is_there(&self, place: &Place, bones: &Place) -> bool {
        let mut held = self.potential.held().iter().enumerate().filter(|(_, held)| **held);
        held.all(|(dof, _)| place.x[dof / 3][dof % 3] == bones.x[dof / 3][dof % 3])
            && place.obstacles == bones.obstacles
    }

    /// The forces of the muscles at `x`, as one number, N; `None` where a point is inside out.
    fn pull(&self, x: &[Vec3], a: &[f64]) -> Option<f64> {
        let (_, muscles) = self.potential.body().forces(x)?;
        let size = |forces: &Vec<Vec3>| forces.iter().map(Vec3::norm_squared).sum::<f64>().sqrt();
        Some(muscles.iter().zip(a).map(|(forces, a)| a * size(forces)).sum())
    }

    /// Derivatives at `place`, the Hessian kept; `None` where a point is inside out.
    fn derivatives(&mut self, place: &Place, a: &[f64], pull: f64) -> Result<Option<Here>, ForwardError> {
        let Some(gradient) = self.potential.derivatives(place, a, &mut self.hessian)? else {
            return Ok(None);
        };
        let reactions = gradient.iter().map(Vec3::norm_squared).sum::<f64>().sqrt();
        let free = self.hessian.factor().symbolic().free();
        let residual = free.iter().map(|&dof| gradient[dof / 3][dof % 3]).collect();
        Ok(Some(Here { residual, scale: reactions.max(pull).max(LEAST_FORCE_N) }))
    }

    /// Factorises the Hessian with the curvature of contact made positive, and with a share of the Hessian at rest where
    /// the tissue itself is unstable.
    fn factorise(&mut self) -> bool {
        loop {
            self.cost.factorisations += 1;
            let is_positive = if self.shift > 0. {
                let rest = self.hessian.of_tissue(self.potential.body(), self.origin, self.metric);
                self.hessian.factorise(Curvature::Projected, Some((self.shift, &rest)))
            } else {
                self.hessian.factorise(Curvature::Projected, None)
            };
            if is_positive {
                return true;
            }
            if self.shift >= SHIFT[1] {
                return false;
            }
            self.shift = (4. * self.shift).max(SHIFT[0]);
        }
    }

    /// Where the step `-step` (free dofs) leads from `place`, shortened until nothing crosses and the potential falls
    /// as it should, and by how much it was shortened.
    fn line_search(&self, place: &Place, step: &[f64], here: &Here, a: &[f64]) -> Option<(Place, f64)> {
        let free = self.hessian.factor().symbolic().free();
        let along = |share: f64| {
            let mut next = place.clone();
            for (&dof, step) in free.iter().zip(step) {
                next.x[dof / 3][dof % 3] -= share * step;
            }
            next
        };
        let slope = -step.iter().zip(&here.residual).map(|(s, r)| s * r).sum::<f64>();
        let longest = step.iter().fold(0., |most: f64, s| most.max(s.abs()));
        let whole = (LONGEST_MM / longest).min(1.);
        let way = self.potential.way(place, &along(whole));
        let energy = self.potential.energy(place, &way, a)?;
        // What rounding of the sum hides.
        let noise = 1e-13 * energy.abs();
        let mut share = whole * way.limit;
        while share >= SHORTEST {
            let next = along(share);
            if let Some(there) = self.potential.energy(&next, &way, a)
                && there <= energy + WORTH * share * slope + noise
            {
                return Some((next, share));
            }
            share *= 0.5;
        }
        None
    }
}

impl Potential {
    /// The body at rest near `start` (n, mm) under the activations `a` (m), its held dofs where they are in `held`
    /// (n, mm), all at once; `None` when no minimum is found. `origin` (n, mm) is where the body is without a load.
    /// Of a body without contact.
    ///
    /// # Errors
    /// [`ForwardError`] when the matrices cannot be set up.
    pub fn minimum(
        &self,
        origin: &[Vec3],
        start: &[Vec3],
        held: &[Vec3],
        a: &[f64],
    ) -> Result<Option<Minimum>, ForwardError> {
        let metric = self.tissue_at(origin, &vec![0.; a.len()])?;
        let mut newton = Newton::new(self, origin, &metric, metric.clone());
        let [start, held] = [start, held].map(|x| Place { x: x.to_vec(), obstacles: Obstacles::default() });
        let found = newton.rest(&start, &held, a)?;
        Ok(found.map(|place| newton.minimum(place)))
    }

    /// The Hessian of the tissue at `x` (n, mm), factorised.
    ///
    /// # Errors
    /// [`ForwardError::NotPositiveDefinite`] where that is no stable place.
    pub(super) fn tissue_at(&self, x: &[Vec3], a: &[f64]) -> Result<Hessian, ForwardError> {
        let mut hessian = Hessian::new(self.body(), self.held(), Default::default())?;
        let Hessian { pattern, tissue, .. } = &mut hessian;
        let found = self.body().derivatives(x, a, pattern, tissue);
        if found.is_none() || !hessian.factorise(Curvature::Exact, None) {
            return Err(ForwardError::NotPositiveDefinite);
        }
        Ok(hessian)
    }
}

fn norm(v: &[f64]) -> f64 {
    dot(v, v).sqrt()
}
