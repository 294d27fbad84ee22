//! Optimality where the gradient jumps.

use nalgebra::{DMatrix, DVector};

use super::program::Residuals;

/// Halvings of the share of either side.
const HALVINGS: usize = 24;

/// Residuals linearised on one side of a kink.
#[derive(Clone, Debug)]
pub(super) struct Side {
    /// Where (n),
    pub(super) at: DVector<f64>,
    /// and what they are about it.
    pub(super) residuals: Residuals,
}

impl Side {
    /// The same residuals and slopes taken to be those at `x`.
    fn brought_to(&self, x: &DVector<f64>) -> Residuals {
        let value = self.residuals.at(&self.at) - &self.residuals.matrix * x;
        Residuals { matrix: self.residuals.matrix.clone(), value }
    }
}

/// The mixture of the model at `here` with those of `others`, near by, that promises least: of the mixtures of any two
/// the one whose best step, which `best` finds, goes downhill equally on both sides.
///
/// A function that falls between two smooth pieces has its optimum at their border, where no gradient is zero but a
/// convex combination of those of both sides is. Source: Goldstein (1977), Optimization of Lipschitz continuous
/// functions; Lemarechal (1975), An extension of Davidon methods to nondifferentiable problems.
///
/// # Errors
/// Those of `best`.
pub(super) fn mixed<'a, E>(
    here: &Side,
    others: impl Iterator<Item = &'a Side>,
    mut best: impl FnMut(&Residuals) -> Result<DVector<f64>, E>,
) -> Result<Residuals, E> {
    let x = &here.at;
    let mut model = here.residuals.clone();
    for other in others {
        let other = other.brought_to(x);
        let slope = gradient(&other, x) - gradient(&model, x);
        let mut rise = |model: &Residuals| best(model).map(|to| slope.dot(&(to - x)));
        if rise(&model)? <= 0. {
            continue;
        }
        if rise(&other)? >= 0. {
            model = other;
            continue;
        }
        let (mut low, mut high) = (0., 1.);
        for _ in 0..HALVINGS {
            let middle = 0.5 * (low + high);
            if rise(&mixture(&model, &other, middle))? > 0. { low = middle } else { high = middle }
        }
        model = mixture(&model, &other, 0.5 * (low + high));
    }
    Ok(model)
}

/// Gradient (n) of `1/2 |r|^2` at `x`.
fn gradient(residuals: &Residuals, x: &DVector<f64>) -> DVector<f64> {
    residuals.matrix.tr_mul(&residuals.at(x))
}

/// `(1 - share) 1/2 |r_a|^2 + share 1/2 |r_b|^2` as the residuals of both.
fn mixture(a: &Residuals, b: &Residuals, share: f64) -> Residuals {
    let (of_a, of_b) = ((1. - share).sqrt(), share.sqrt());
    let (rows, n) = a.matrix.shape();
    let mut matrix = DMatrix::zeros(rows + b.matrix.nrows(), n);
    matrix.rows_mut(0, rows).copy_from(&(of_a * &a.matrix));
    matrix.rows_mut(rows, b.matrix.nrows()).copy_from(&(of_b * &b.matrix));
    let mut value = DVector::zeros(matrix.nrows());
    value.rows_mut(0, rows).copy_from(&(of_a * &a.value));
    value.rows_mut(rows, b.value.len()).copy_from(&(of_b * &b.value));
    Residuals { matrix, value }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// `1/2 (x^2 + (y - 1)^2) + pull x`, as residuals linearised at `x`: two pieces with `pull` of either sign are the
    /// sides of a kink along `x = 0`, whose optimum is (0, 1).
    fn side(pull: f64, at: [f64; 2]) -> Side {
        let residuals =
            Residuals { matrix: DMatrix::identity(2, 2), value: DVector::from_column_slice(&[pull, -1.]) };
        Side { at: DVector::from_column_slice(&at), residuals }
    }

    /// The best point within `radius`.
    fn within(radius: f64, centre: DVector<f64>) -> impl Fn(&Residuals) -> Result<DVector<f64>, ()> {
        move |model| {
            let normal = model.matrix.tr_mul(&model.matrix);
            let free = normal.lu().solve(&(-model.matrix.tr_mul(&model.value))).ok_or(())?;
            Ok(free.zip_map(&centre, |x, c| x.clamp(c - radius, c + radius)))
        }
    }

    #[test]
    fn at_a_kink_no_slope_is_left_though_each_side_has_one() {
        let here = side(0.3, [1e-6, 1.]);
        let best = within(1e-3, here.at.clone());
        let model = mixed(&here, [side(-0.1, [-1e-6, 1.])].iter(), &best).unwrap();
        assert!(gradient(&here.residuals, &here.at).amax() > 0.2);
        assert!(gradient(&model, &here.at).amax() < 1e-6, "{}", gradient(&model, &here.at));
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
        assert!((gradient(&model, &here.at)[0] - 0.5).abs() < 1e-12);
    }
}
