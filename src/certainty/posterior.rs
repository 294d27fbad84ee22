//! The distribution of the unknowns that the data leave, within their limits.

use nalgebra::{Cholesky, DMatrix, DVector};
use rand_xoshiro::Xoshiro256PlusPlus;
use rand_xoshiro::rand_core::{RngCore, SeedableRng};

use super::misfit::Misfit;
use crate::inverse::ActivationBounds;

/// Precision of a normal distribution that is flat to about one per cent over [0, 1], about the middle: it stands for a
/// uniform one where the data say nothing.
const FLAT: f64 = 0.1;
/// Trajectories before the first that counts.
const WARM: usize = 100;
/// Standard deviations beyond which a row is no wall.
const FAR: f64 = 7.;
/// Share of a turn after a bounce in which the same wall is not met again.
const AT_ONCE: f64 = 1e-10;
/// Bounces of one trajectory before it is cut short.
const MOST_BOUNCES: usize = 20_000;

/// Samples of the normal distribution of the misfit, truncated to the bounds: all flat before the data.
///
/// Exact Hamiltonian Monte Carlo: in whitened coordinates a particle moves on an ellipse and bounces off the walls
/// (Pakman and Paninski, Exact Hamiltonian Monte Carlo for truncated multivariate Gaussians, J Comput Graph Stat 23:518,
/// 2014). The seed is fixed: the same program gives the same samples.
#[derive(Clone, Debug)]
pub(super) struct Posterior {
    /// (k x samples).
    samples: DMatrix<f64>,
}

impl Posterior {
    /// `count` samples of that of `misfit` within `bounds`, from the unknowns `start`, which satisfy them.
    pub(super) fn of(
        misfit: &Misfit,
        bounds: &ActivationBounds,
        start: &DVector<f64>,
        count: usize,
    ) -> Option<Self> {
        let k = start.len();
        if k == 0 {
            return None;
        }
        let middle = (&bounds.min + &bounds.max) / 2.;
        let precision = misfit.matrix.tr_mul(&misfit.matrix) + DMatrix::identity(k, k) * FLAT;
        let factor = Cholesky::new(precision)?;
        let mean = factor.solve(&(misfit.matrix.tr_mul(&misfit.centre) + middle * FLAT));
        let walls = Walls::of(bounds, &factor, &mean, start)?;
        let upper = factor.l().transpose();
        let mut place = &upper * (start - &mean);
        let mut normal = Normal::new();
        let mut samples = DMatrix::zeros(k, count);
        for n in 0..WARM + count {
            let speed = DVector::from_fn(k, |_, _| normal.next());
            place = walls.trajectory(place, speed);
            if n >= WARM {
                samples.set_column(n - WARM, &(&mean + upper.solve_upper_triangular(&place)?));
            }
        }
        Some(Self { samples })
    }

    /// Mean (k).
    pub(super) fn mean(&self) -> DVector<f64> {
        self.samples.column_mean()
    }

    /// Covariance (k x k).
    pub(super) fn covariance(&self) -> DMatrix<f64> {
        let mean = self.mean();
        let mut off = self.samples.clone();
        off.column_iter_mut().for_each(|mut column| column -= &mean);
        &off * off.transpose() / self.samples.ncols() as f64
    }
}

/// Half spaces `row z + offset >= 0` in whitened coordinates.
struct Walls {
    rows: DMatrix<f64>,
    offset: DVector<f64>,
    /// Products of the rows with each other.
    gram: DMatrix<f64>,
}

impl Walls {
    fn of(
        bounds: &ActivationBounds,
        factor: &Cholesky<f64, nalgebra::Dyn>,
        mean: &DVector<f64>,
        start: &DVector<f64>,
    ) -> Option<Self> {
        let k = mean.len();
        let all =
            DMatrix::from_fn(2 * k, k, |i, j| if i < k { f64::from(i == j) } else { -f64::from(i - k == j) });
        let values = bounds.min.iter().map(|lo| -lo).chain(bounds.max.iter().copied());
        let offset = DVector::from_iterator(2 * k, values);
        // L^-1 A' = (A L^-T)'.
        let white = factor.l().solve_lower_triangular(&all.transpose())?.transpose();
        let at_mean = &all * mean + &offset;
        let at_start = &all * start + &offset;
        let near: Vec<usize> = (0..2 * k)
            .filter(|&i| at_mean[i] < FAR * white.row(i).norm().max(1e-300) || at_start[i] < ROOM)
            .collect();
        let rows = white.select_rows(&near);
        // The start is inside by a hair at least.
        let offset =
            DVector::from_fn(near.len(), |i, _| at_mean[near[i]] + (ROOM - at_start[near[i]]).max(0.));
        let gram = &rows * rows.transpose();
        Some(Self { rows, offset, gram })
    }

    /// A quarter of a turn from `place` with `speed`.
    fn trajectory(&self, mut place: DVector<f64>, mut speed: DVector<f64>) -> DVector<f64> {
        let mut left = std::f64::consts::FRAC_PI_2;
        let (mut at, mut rate) = (&self.rows * &place, &self.rows * &speed);
        let mut last = None;
        for _ in 0..MOST_BOUNCES {
            let hit = self.first(&at, &rate, left, last);
            let time = hit.map_or(left, |(time, _)| time);
            let (sin, cos) = time.sin_cos();
            let turn = |x: &mut DVector<f64>, v: &mut DVector<f64>| {
                for (x, v) in x.iter_mut().zip(v.iter_mut()) {
                    (*x, *v) = (*x * cos + *v * sin, *v * cos - *x * sin);
                }
            };
            turn(&mut place, &mut speed);
            turn(&mut at, &mut rate);
            let Some((_, wall)) = hit else { break };
            left -= time;
            let back = 2. * rate[wall] / self.gram[(wall, wall)];
            speed.axpy(-back, &self.rows.row(wall).transpose(), 1.);
            rate.axpy(-back, &self.gram.column(wall), 1.);
            last = Some(wall);
        }
        place
    }

    /// When and which wall is met first within `left`, where `row z` is `at` and changes at `rate`.
    fn first(
        &self,
        at: &DVector<f64>,
        rate: &DVector<f64>,
        left: f64,
        last: Option<usize>,
    ) -> Option<(f64, usize)> {
        let mut first = None;
        let mut soonest = left;
        for wall in 0..self.offset.len() {
            let (p, v, g) = (at[wall], rate[wall], self.offset[wall]);
            let reach = p.hypot(v);
            if reach <= g.abs() {
                continue;
            }
            // p cos t + v sin t = reach cos(t - phase) = -g.
            let (phase, half) = (v.atan2(p), (-g / reach).acos());
            let turn = std::f64::consts::TAU;
            let least = if last == Some(wall) { AT_ONCE } else { 0. };
            for time in [phase - half, phase + half] {
                let time = time.rem_euclid(turn);
                // It is met from inside, going down.
                let down = v * time.cos() - p * time.sin() < 0.;
                if down && time > least && time < soonest {
                    (soonest, first) = (time, Some((time, wall)));
                }
            }
        }
        first
    }
}

/// What the start is inside by, at least.
const ROOM: f64 = 1e-9;

/// Normal deviates, by the polar method of Marsaglia and Bray (1964).
struct Normal {
    bits: Xoshiro256PlusPlus,
    spare: Option<f64>,
}

impl Normal {
    fn new() -> Self {
        Self { bits: Xoshiro256PlusPlus::seed_from_u64(0), spare: None }
    }

    /// Uniform in [-1, 1).
    fn uniform(&mut self) -> f64 {
        let unit = (self.bits.next_u64() >> 11) as f64 / (1u64 << 53) as f64;
        2. * unit - 1.
    }

    fn next(&mut self) -> f64 {
        if let Some(spare) = self.spare.take() {
            return spare;
        }
        loop {
            let (u, v) = (self.uniform(), self.uniform());
            let s = u * u + v * v;
            if s > 0. && s < 1. {
                let factor = (-2. * s.ln() / s).sqrt();
                self.spare = Some(v * factor);
                return u * factor;
            }
        }
    }
}
