//! Newton's method on the potential.

use super::Potential;
use super::contact::Obstacles;
use super::hessian::Hessian;
use crate::forward::{Cholesky, ForwardError};
use crate::units::Vec3;

/// Steps before a load is given up.
const MOST_STEPS: usize = 60;
/// Unbalanced force of a body at rest, as a share of the forces that act on it.
const BALANCED: f64 = 1e-9;
/// Forces below this, N, are not told apart from those of rounding when they are balanced.
const LEAST_FORCE_N: f64 = 1e-3;
/// Share of the predicted decrease that a step must bring (Armijo).
const WORTH: f64 = 1e-4;
/// Shortest step, as a share of Newton's.
const SHORTEST: f64 = 1. / 1024.;
/// Steps in which the negative curvature of contact is taken away.
const MADE_POSITIVE: f64 = 0.25;
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
    /// Share of the negative curvature of contact that had to be taken away to factorise the Hessian: 0 at a minimum
    /// that every small push finds stable.
    pub(super) made_positive: f64,
    pub(super) cost: SettlingCost,
}

impl Minimum {
    /// Whether the Hessian is positive definite.
    pub fn is_stable(&self) -> bool {
        self.made_positive == 0.
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
    /// Gradient (n), N,
    gradient: Vec<Vec3>,
    /// and on the free dofs.
    residual: Vec<f64>,
    /// What the residual is measured against, N.
    scale: f64,
}

/// Newton's method with exact tangents: a step is shortened until the potential falls with it (Armijo) with no point
/// inside out and no surfaces that cross, and where the Hessian is indefinite it is taken on `H + tau H_0`, `H_0` the
/// Hessian at rest.
pub(super) struct Newton<'p> {
    potential: &'p Potential,
    /// Where the body rests without a load,
    origin: &'p [Vec3],
    /// and `H_0` there.
    metric: &'p Hessian,
    hessian: Hessian,
    shift: f64,
    made_positive: f64,
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
        Self {
            potential,
            origin,
            metric,
            hessian,
            shift: 0.,
            made_positive: 0.,
            cost: SettlingCost::default(),
        }
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
        let (mut place, mut to_go) = self.following(start, bones);
        let Some(pull) = self.pull(&place.x, a) else { return Ok(None) };
        for _ in 0..MOST_STEPS {
            let Some(here) = self.derivatives(&place, a, pull)? else { return Ok(None) };
            let size = norm(&here.residual);
            let is_balanced = to_go == 0. && size <= BALANCED * here.scale;
            if is_balanced {
                // Whether the place is stable is asked without the help that the way there took.
                self.made_positive = 0.;
            }
            if !self.factorise() {
                return Ok(None);
            }
            if is_balanced {
                return Ok(Some(place));
            }
            let mut step = here.residual;
            self.hessian.factor().solve_in_place(&mut step);
            let free = self.hessian.factor().symbolic().free();
            let slope: f64 =
                -step.iter().zip(free).map(|(s, &dof)| s * here.gradient[dof / 3][dof % 3]).sum::<f64>();
            let Some((next, share)) = self.line_search(&place, &step, slope, a) else {
                if self.shift >= SHIFT[1] {
                    return Ok(None);
                }
                self.shift = (8. * self.shift).max(SHIFT[0]);
                continue;
            };
            self.shift = if share > 0.9 { 0.1 * self.shift } else { self.shift };
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
        Minimum { place, hessian: self.hessian, made_positive: self.made_positive, cost: self.cost }
    }

    /// `start` with held dofs and teeth brought towards where they are in `bones`, as far as nothing crosses or turns
    /// inside out, the other dofs following as the stiffness at rest has it; and the share of the way that is left.
    fn following(&self, start: &Place, bones: &Place) -> (Place, f64) {
        let mut lift = vec![0.; 3 * start.x.len()];
        for (dof, _) in self.potential.held().iter().enumerate().filter(|(_, held)| **held) {
            lift[dof] = bones.x[dof / 3][dof % 3] - start.x[dof / 3][dof % 3];
        }
        let teeth = || start.obstacles.iter().flatten().zip(bones.obstacles.iter().flatten());
        if lift.iter().all(|u| *u == 0.) && teeth().all(|(from, to)| from == to) {
            return (start.clone(), 0.);
        }
        let mut push = self.metric.pattern.multiply(&self.metric.values, &lift);
        push.iter_mut().for_each(|f| *f = -*f);
        let follow = self.metric.factor().displacements(&[push]).swap_remove(0);
        let along = |share: f64| {
            let moved = follow.as_chunks::<3>().0.iter().zip(lift.as_chunks::<3>().0);
            let x =
                start.x.iter().zip(moved).map(|(x, (u, l))| x + share * (Vec3::from(*u) + Vec3::from(*l)));
            let lists = start.obstacles.iter().zip(bones.obstacles.iter());
            let teeth = lists.map(|(from, to)| from.iter().zip(to).map(|(p, q)| p.lerp(q, share)).collect());
            Place { x: x.collect(), obstacles: Obstacles::new(teeth.collect()) }
        };
        let whole = Place { obstacles: bones.obstacles.clone(), ..along(1.) };
        let limit = self.potential.way(start, &whole).limit;
        let is_upright = |place: &Place| self.potential.body().is_upright(&place.x);
        if limit == 1. && is_upright(&whole) {
            return (whole, 0.);
        }
        let mut share = SAFE * limit;
        let mut there = along(share);
        while !is_upright(&there) {
            share *= 0.5;
            there = along(share);
        }
        (there, 1. - share)
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
        Ok(Some(Here { gradient, residual, scale: reactions.max(pull).max(LEAST_FORCE_N) }))
    }

    /// Factorises the Hessian: with as little of the negative curvature of contact taken away as leaves it positive
    /// definite, and with a share of the Hessian at rest where the tissue itself is unstable.
    fn factorise(&mut self) -> bool {
        let mut made_positive =
            if self.hessian.contact.is_some() { self.made_positive - MADE_POSITIVE } else { 0. };
        made_positive = f64::max(made_positive, 0.);
        loop {
            self.cost.factorisations += 1;
            let is_positive = if self.shift > 0. {
                let rest = self.hessian.of_tissue(self.potential.body(), self.origin, self.metric);
                self.hessian.factorise(made_positive, Some((self.shift, &rest)))
            } else {
                self.hessian.factorise(made_positive, None)
            };
            if is_positive {
                self.made_positive = made_positive;
                return true;
            }
            if self.hessian.contact.is_some() && made_positive < 1. {
                made_positive = f64::min(made_positive + MADE_POSITIVE, 1.);
            } else if self.shift < SHIFT[1] {
                self.shift = (4. * self.shift).max(SHIFT[0]);
            } else {
                return false;
            }
        }
    }

    /// Where the step `-step` (free dofs) leads from `place`, shortened until nothing crosses and the potential falls
    /// as it should, and by how much it was shortened.
    fn line_search(&self, place: &Place, step: &[f64], slope: f64, a: &[f64]) -> Option<(Place, f64)> {
        let free = self.hessian.factor().symbolic().free();
        let along = |share: f64| {
            let mut next = place.clone();
            for (&dof, step) in free.iter().zip(step) {
                next.x[dof / 3][dof % 3] -= share * step;
            }
            next
        };
        let way = self.potential.way(place, &along(1.));
        let energy = self.potential.energy(place, &way, a)?;
        // What rounding of the sum hides.
        let noise = 1e-13 * energy.abs();
        let mut share = way.limit;
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
        if found.is_none() || !hessian.factorise(0., None) {
            return Err(ForwardError::NotPositiveDefinite);
        }
        Ok(hessian)
    }
}

fn norm(v: &[f64]) -> f64 {
    v.iter().map(|x| x * x).sum::<f64>().sqrt()
}
