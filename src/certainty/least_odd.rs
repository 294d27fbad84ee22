//! The least difference between the sides that the data demand.

use nalgebra::{DMatrix, DVector};

use super::misfit::Misfit;
use crate::inverse::ActivationBounds;
use crate::qp::{self, Answer};

/// Weights of the misfit between which the one is sought that just keeps it.
const WEIGHTS: [f64; 2] = [1e-8, 1e8];
/// Halvings of their ratio.
const HALVINGS: usize = 40;

/// The free unknowns (k) within `bounds` and a misfit of `most` with the least `|O y + o|`, the odd parts of the pairs
/// being `odd` (rows x k) and `offset` (rows); `None` where no program converges.
pub(super) fn least_odd(
    misfit: &Misfit,
    most: f64,
    bounds: &ActivationBounds,
    odd: &DMatrix<f64>,
    offset: &DVector<f64>,
) -> Option<DVector<f64>> {
    let k = bounds.min.len();
    let squares = misfit.matrix.tr_mul(&misfit.matrix);
    let pull = misfit.matrix.tr_mul(&misfit.centre);
    let with = |weight: f64| {
        // Divided by the larger weight, so that both ends are well scaled.
        let (of_odd, of_misfit) = if weight > 1. { (1. / weight, 1.) } else { (1., weight) };
        let problem = qp::Problem {
            hessian: odd.tr_mul(odd) * of_odd + &squares * of_misfit,
            linear: odd.tr_mul(offset) * of_odd - &pull * of_misfit,
            constant: 0.,
            equality: DMatrix::zeros(0, k),
            equality_value: DVector::zeros(0),
            inequality: DMatrix::zeros(0, k),
            inequality_limit: DVector::zeros(0),
            lower: bounds.min.clone(),
            upper: bounds.max.clone(),
        };
        match qp::solve(&problem).ok()? {
            Answer::Solved(solution) | Answer::NotConverged(Some(solution)) => Some(solution.point.x),
            _ => None,
        }
    };
    let [mut low, mut high] = WEIGHTS;
    let even = with(low)?;
    if misfit.at(&even) <= most {
        return Some(even);
    }
    let mut found = with(high)?;
    for _ in 0..HALVINGS {
        let weight = (low * high).sqrt();
        let y = with(weight)?;
        if misfit.at(&y) <= most {
            (found, high) = (y, weight);
        } else {
            low = weight;
        }
    }
    Some(found)
}
