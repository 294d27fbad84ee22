//! What parameters and activations do to the residuals of an expression.

use nalgebra::{Cholesky, DMatrix, DVector};

use super::search::Noise;
use super::{CalibrationError, Expression, Parameters, Quantity};
use crate::certainty::Discrepancy;
use crate::forward::ScaledModel;

/// The residuals of one expression at some parameters, and their exact derivatives.
///
/// ```text
/// u = K^-1 F a,    du/dtheta = K^-1 (dF/dtheta a - dK/dtheta u),    du/da_m = K^-1 (f_m - dK/da_m u)
/// ```
///
/// Shapes: `r` residuals, `p` parameters, `k` muscles that act, `d` observed components.
#[derive(Clone, Debug)]
pub struct Sensitivity {
    /// Displacement (3n), mm.
    pub displacement: Vec<f64>,
    /// Residuals (r) in the standard deviations of the observations.
    pub residual: DVector<f64>,
    /// Their derivatives (r x p) by the logarithms of the parameters.
    pub by_parameter: DMatrix<f64>,
    /// Their derivatives (r x k) by the activations, each in its standard deviation.
    pub by_activation: DMatrix<f64>,
    /// Numbers of the muscles (k) that act.
    pub acting: Vec<usize>,
    /// Their derivatives (r x d) by the observed displacements, 1/mm.
    by_observed: DMatrix<f64>,
    /// What each muscle that acts does (d x k), mm per unit activation at the stiffness held.
    map: DMatrix<f64>,
}

impl Sensitivity {
    /// That of `expression` at `theta` (p).
    ///
    /// # Errors
    /// [`CalibrationError::Forward`] where the face cannot be solved there.
    pub fn of(
        model: &ScaledModel,
        parameters: &Parameters,
        expression: &Expression,
        theta: &[f64],
    ) -> Result<Self, CalibrationError> {
        let Expression { activation, sigma, .. } = expression;
        let stiff = model.at(parameters.moduli(theta), activation)?;
        let force = parameters.forces(theta);
        let u = stiff
            .displacements(&[stiff.pull(force.iter().zip(activation).map(|(f, a)| f * a))])
            .swap_remove(0);
        let acting = expression.acting();
        let alone =
            |muscle: usize| stiff.pull((0..force.len()).map(|k| if k == muscle { force[k] } else { 0. }));
        let mut pushes = vec![stiff.tissue_force(&u), stiff.muscle_force(&u)];
        pushes.extend(acting.iter().map(|&muscle| alone(muscle)));
        pushes.extend(acting.iter().map(|&muscle| stiff.stiffening(muscle, activation[muscle], &u)));
        let seen = |field: &Vec<f64>| {
            let points = expression.sites.iter().flat_map(|site| site.displacement(field).data.0[0]);
            DVector::from_iterator(3 * expression.sites.len(), points)
        };
        let fields: Vec<DVector<f64>> = stiff.displacements(&pushes).iter().map(seen).collect();
        let observed = seen(&u);
        let (globals, muscles) = fields.split_at(2);
        let (map, softened) = muscles.split_at(acting.len());
        let by_parameter = parameters.list().iter().map(|parameter| match &parameter.quantity {
            Quantity::TissueModulus => -&globals[0],
            Quantity::MuscleModulus => -&globals[1],
            Quantity::MuscleStress => observed.clone(),
            Quantity::Strength(own) => {
                let of = acting.iter().zip(map).filter(|(muscle, _)| own.contains(muscle));
                of.fold(DVector::zeros(observed.len()), |sum, (&m, field)| sum + field * activation[m])
            }
        });
        let by_parameter: Vec<DVector<f64>> = by_parameter.collect();
        let by_activation: Vec<DVector<f64>> = (acting.iter().zip(map).zip(softened))
            .map(|((&muscle, pull), soft)| (pull - soft) * sigma[muscle])
            .collect();
        let d = observed.len();
        let terms = expression.residuals(observed);
        let residual = terms.value();
        let by_observed = terms.by_observed(d);
        Ok(Self {
            displacement: u,
            residual,
            by_parameter: &by_observed * DMatrix::from_columns(&by_parameter),
            by_activation: &by_observed * DMatrix::from_columns(&by_activation),
            map: DMatrix::from_columns(map),
            acting,
            by_observed,
        })
    }

    /// The factor of the covariance (r x r) of the residuals: the noise of the observations, that of the activations on the
    /// tangent, `M sigma_a^2 M'`, and how far the model is from the face; `None` where numbers leave their range.
    pub(super) fn noise(&self, expression: &Expression, discrepancy: &Discrepancy) -> Option<Noise> {
        let of = |&muscle: &usize| expression.activation[muscle].powi(2) + expression.sigma[muscle].powi(2);
        let squares = DVector::from_iterator(self.acting.len(), self.acting.iter().map(of));
        let model = discrepancy.covariance(&expression.points_mm, &self.map, &squares);
        let r = self.residual.len();
        let covariance = DMatrix::identity(r, r)
            + &self.by_activation * self.by_activation.transpose()
            + &self.by_observed * model * self.by_observed.transpose();
        Cholesky::new(covariance)
    }
}
