//! Optimality where the gradient jumps.

use nalgebra::{DMatrix, DVector};

use super::program::Objective;

/// Halvings of the share that one side gives to another.
const HALVINGS: usize = 24;
/// Times that one side gives to another.
const MOST_EXCHANGES: usize = 40;
/// Difference of the slopes of two sides along a step, as a share of the steepest of them, that is none.
const EQUAL: f64 = 1e-6;

/// The objective on one side of a kink.
#[derive(Clone, Debug)]
pub(super) struct Side {
    /// Where (n),
    pub(super) at: DVector<f64>,
    /// and what it is about there.
    pub(super) model: Objective,
}

impl Side {
    /// The same residuals and slopes taken to be those at `x`.
    fn brought_to(&self, x: &DVector<f64>) -> Objective {
        let value = self.model.at(&self.at) - &self.model.matrix * x;
        Objective { value, ..self.model.clone() }
    }
}

/// The mixture of the model at `here` with those of `others`, near by, that promises least: its best step, which `best`
/// finds, goes downhill equally on all sides that have a share in it, and at least as steeply on the others.
///
/// A function that falls between smooth pieces has its optimum where they meet: there no gradient is zero, but a convex
/// combination of those of all sides is. Source: Goldstein (1977), Optimization of Lipschitz continuous functions;
/// Lemarechal (1975), An extension of Davidon methods to nondifferentiable problems. Shares are exchanged by pairs as in
/// Lacoste-Julien and Jaggi (2015), On the global linear convergence of Frank-Wolfe optimization variants.
///
/// # Errors
/// Those of `best`.
pub(super) fn mixed<'a, E>(
    here: &Side,
    others: impl Iterator<Item = &'a Side>,
    mut best: impl FnMut(&Objective) -> Result<DVector<f64>, E>,
) -> Result<Objective, E> {
    let x = &here.at;
    let sides: Vec<Objective> =
        std::iter::once(here.model.clone()).chain(others.map(|side| side.brought_to(x))).collect();
    let slopes: Vec<DVector<f64>> = sides.iter().map(|side| side.gradient(x)).collect();
    let mut shares = vec![0.; sides.len()];
    shares[0] = 1.;
    for _ in 0..MOST_EXCHANGES {
        let step = best(&mixture(&sides, &shares))? - x;
        let along: Vec<f64> = slopes.iter().map(|slope| slope.dot(&step)).collect();
        let by_slope = |a: &usize, b: &usize| along[*a].total_cmp(&along[*b]);
        let steepest = (0..sides.len()).filter(|&k| shares[k] > 0.).min_by(by_slope);
        let flattest = (0..sides.len()).max_by(by_slope);
        let (Some(from), Some(to)) = (steepest, flattest) else { break };
        let size = along.iter().fold(0., |most: f64, slope| most.max(slope.abs()));
        if from == to || along[to] - along[from] <= EQUAL * size {
            break;
        }
        let given = |given: f64| {
            let mut shares = shares.clone();
            shares[from] -= given;
            shares[to] += given;
            shares
        };
        let difference = &slopes[to] - &slopes[from];
        let mut rise = |shares: &[f64]| best(&mixture(&sides, shares)).map(|to| difference.dot(&(to - x)));
        let (mut low, mut high) = (0., shares[from]);
        if rise(&given(high))? >= 0. {
            low = high;
        }
        for _ in 0..HALVINGS {
            let middle = 0.5 * (low + high);
            if middle <= low || middle >= high {
                break;
            }
            if rise(&given(middle))? > 0. { low = middle } else { high = middle }
        }
        shares = given(0.5 * (low + high));
    }
    Ok(mixture(&sides, &shares))
}

/// `sum_k share_k (1/2 |r_k|^2 + slope_k'x)` with the residuals of all sides that have a share.
fn mixture(sides: &[Objective], shares: &[f64]) -> Objective {
    let mixed: Vec<(&Objective, f64)> = sides
        .iter()
        .zip(shares)
        .filter(|(_, share)| **share > 0.)
        .map(|(side, share)| (side, share.sqrt()))
        .collect();
    let rows = mixed.iter().map(|(side, _)| side.matrix.nrows()).sum();
    let mut matrix = DMatrix::zeros(rows, sides[0].matrix.ncols());
    let mut value = DVector::zeros(rows);
    let mut slope = DVector::zeros(matrix.ncols());
    let mut first = 0;
    for (side, weight) in mixed {
        let rows = side.matrix.nrows();
        matrix.rows_mut(first, rows).copy_from(&(weight * &side.matrix));
        value.rows_mut(first, rows).copy_from(&(weight * &side.value));
        slope.axpy(weight * weight, &side.slope, 1.);
        first += rows;
    }
    Objective { matrix, value, slope }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// `1/2 (x^2 + (y - 1)^2) + pull x`, as residuals linearised at `x`: two pieces with `pull` of either sign are the
    /// sides of a kink along `x = 0`, whose optimum is (0, 1).
    fn side(pull: f64, at: [f64; 2]) -> Side {
        Side { at: DVector::from_column_slice(&at), model: model([pull, -1.]) }
    }

    /// `1/2 |x + value|^2`.
    fn model(value: [f64; 2]) -> Objective {
        let value = DVector::from_column_slice(&value);
        Objective { matrix: DMatrix::identity(2, 2), value, slope: DVector::zeros(2) }
    }

    /// The best point within `radius`.
    fn within(radius: f64, centre: DVector<f64>) -> impl Fn(&Objective) -> Result<DVector<f64>, ()> {
        move |model| {
            let normal = model.matrix.tr_mul(&model.matrix);
            let free = normal.lu().solve(&-model.gradient(&DVector::zeros(2))).ok_or(())?;
            Ok(free.zip_map(&centre, |x, c| x.clamp(c - radius, c + radius)))
        }
    }

    #[test]
    fn at_a_kink_no_slope_is_left_though_each_side_has_one() {
        let here = side(0.3, [1e-6, 1.]);
        let best = within(1e-3, here.at.clone());
        let model = mixed(&here, [side(-0.1, [-1e-6, 1.])].iter(), &best).unwrap();
        assert!(here.model.gradient(&here.at).amax() > 0.2);
        assert!(model.gradient(&here.at).amax() < 1e-6, "{}", model.gradient(&here.at));
    }

    #[test]
    fn where_four_pieces_meet_no_slope_is_left_though_no_two_of_them_suffice() {
        // `1/2 (x^2 + y^2) + 0.3 |x| + 0.2 |y| + 0.05 x`: two kinks that cross at its optimum.
        let piece = |pulls: [f64; 2], at: [f64; 2]| Side {
            at: DVector::from_column_slice(&at),
            model: model([pulls[0] + 0.05, pulls[1]]),
        };
        let here = piece([0.3, 0.2], [1e-6, 1e-6]);
        let others = [
            piece([-0.3, 0.2], [-1e-6, 1e-6]),
            piece([0.3, -0.2], [1e-6, -1e-6]),
            piece([-0.3, -0.2], [-1e-6, -1e-6]),
        ];
        let best = within(1e-3, here.at.clone());
        let model = mixed(&here, others.iter(), &best).unwrap();
        assert!(model.gradient(&here.at).amax() < 1e-5, "{}", model.gradient(&here.at));
        let two = mixed(&here, others[..1].iter(), &best).unwrap();
        assert!(two.gradient(&here.at).amax() > 0.1);
    }

    #[test]
    fn along_a_kink_the_step_goes_downhill_on_both_sides() {
        let here = side(0.3, [0., 0.5]);
        let best = within(1e-3, here.at.clone());
        let model = mixed(&here, [side(-0.1, [0., 0.5])].iter(), &best).unwrap();
        let step = best(&model).unwrap() - &here.at;
        assert!(step[0].abs() < 1e-6 && (step[1] - 1e-3).abs() < 1e-9, "{step}");
    }

    #[test]
    fn sides_with_the_same_slope_are_no_kink() {
        let here = side(0.3, [0.2, 1.]);
        let best = within(1e-3, here.at.clone());
        let model = mixed(&here, [side(0.4, [0.2, 1.])].iter(), &best).unwrap();
        // Both go down the same way; the lesser slope promises less.
        assert!((model.gradient(&here.at)[0] - 0.5).abs() < 1e-12);
    }
}
