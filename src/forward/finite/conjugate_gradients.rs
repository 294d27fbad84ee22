//! Conjugate gradients on the Hessian, from a factor of one that is like it and positive definite.

use super::hessian::Hessian;

/// Products with the Hessian before a step is taken as it is.
const MOST_PRODUCTS: usize = 60;
/// How much longer than the step of the factor alone a step may be, in the norm of the factorised matrix.
const LONGER: f64 = 5.;

/// Where conjugate gradients lead.
pub(super) enum Descent {
    /// To the solution, as nearly as was asked for.
    Solution(Vec<f64>),
    /// To a direction of no positive curvature, and what was found until then.
    Curved {
        /// A step that goes that way as far as it may; none when the very first one has no positive curvature.
        step: Option<Vec<f64>>,
        /// The direction, of length 1 in the norm of the factorised matrix.
        direction: Vec<f64>,
    },
}

/// Solves `H s = r` on the free dofs to `|H s - r| <= tolerance |r|`, `H` having the `values` on the pattern of `hessian`,
/// with its factor as the preconditioner.
///
/// Every step that comes of it goes downhill where `r` is the gradient, whatever `H` is: source: Steihaug (1983), The
/// conjugate gradient method and trust regions in large scale optimization.
pub(super) fn conjugate_gradients(hessian: &Hessian, values: &[f64], r: &[f64], tolerance: f64) -> Descent {
    let factor = hessian.factor();
    let free = factor.symbolic().free();
    let mut full = vec![0.; factor.symbolic().n_dofs()];
    let mut product = |v: &[f64]| -> Vec<f64> {
        free.iter().zip(v).for_each(|(&dof, v)| full[dof] = *v);
        let out = hessian.pattern.multiply(values, &full);
        free.iter().map(|&dof| out[dof]).collect()
    };
    let conditioned = |r: &[f64]| {
        let mut y = r.to_vec();
        factor.solve_in_place(&mut y);
        y
    };
    let mut left = r.to_vec();
    let mut step = vec![0.; r.len()];
    let mut direction = conditioned(&left);
    let mut rho = dot(&left, &direction);
    let done = tolerance * dot(r, r).sqrt();
    let limit = LONGER * LONGER * rho;
    // Squared norm of the step, of the direction, and their product, in the norm of the factorised matrix.
    let (mut own, mut along, mut shared) = (0., rho, 0.);
    for count in 0..MOST_PRODUCTS {
        let pushed = product(&direction);
        let curvature = dot(&direction, &pushed);
        let share = rho / curvature;
        if curvature <= 0. || own + 2. * share * shared + share * share * along >= limit {
            let share = (-shared + (shared * shared + along * (limit - own)).sqrt()) / along;
            let step = (count > 0).then(|| step.iter().zip(&direction).map(|(s, d)| s + share * d).collect());
            direction.iter_mut().for_each(|d| *d /= along.sqrt());
            return Descent::Curved { step, direction };
        }
        step.iter_mut().zip(&direction).for_each(|(s, d)| *s += share * d);
        left.iter_mut().zip(&pushed).for_each(|(r, p)| *r -= share * p);
        if dot(&left, &left).sqrt() <= done {
            break;
        }
        own += 2. * share * shared + share * share * along;
        let next = conditioned(&left);
        let before = rho;
        rho = dot(&left, &next);
        let beta = rho / before;
        shared = beta * (shared + share * along);
        along = rho + beta * beta * along;
        direction.iter_mut().zip(next).for_each(|(d, y)| *d = y + beta * *d);
    }
    Descent::Solution(step)
}

pub(super) fn dot(a: &[f64], b: &[f64]) -> f64 {
    a.iter().zip(b).map(|(a, b)| a * b).sum()
}
