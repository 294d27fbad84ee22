//! What parameters and activations do to the residuals of an expression.

use nalgebra::{Cholesky, DMatrix, DVector};

use super::search::Noise;
use super::{CalibrationError, Expression, HeldContact, Parameters, Quantity};
use crate::certainty::Discrepancy;
use crate::contact::Pair;
use crate::forward::ScaledModel;

/// The residuals of one expression at some parameters, and their exact derivatives.
///
/// ```text
/// K u = F a + G' lambda,    0 <= lambda  _|_  g + G u >= 0
/// du/dtheta = P K^-1 (dF/dtheta a - dK/dtheta u),    du/da_m = P K^-1 (f_m - dK/da_m u)
/// ```
///
/// `P` holds the gaps of the contacts that press; it is the identity where none does.
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
    /// That of `expression` at `theta` (p) against the candidates of `contact`.
    ///
    /// # Errors
    /// [`CalibrationError::Forward`] and [`CalibrationError::Contact`] where the face cannot be solved there.
    pub fn of(
        model: &ScaledModel,
        parameters: &Parameters,
        expression: &Expression,
        theta: &[f64],
        contact: &HeldContact,
    ) -> Result<Self, CalibrationError> {
        let Expression { activation, sigma, .. } = expression;
        let moduli = parameters.moduli(theta);
        let scaled = model.at(moduli, &parameters.forces(theta)).with_pairs(contact.pairs.clone());
        let stiff = scaled.at(activation)?;
        let equilibrium = stiff
            .equilibrium_from(&contact.touching)
            .map_err(|error| CalibrationError::Contact { expression: expression.name.clone(), error })?;
        let u = equilibrium.displacement;
        let acting = expression.acting();
        let tissue = model.tissue_force(moduli, &u);
        let whole = scaled.stiffness().pattern().multiply(&scaled.stiffness_at(activation), &u);
        let muscle = whole.iter().zip(&tissue).map(|(whole, tissue)| whole - tissue).collect();
        let pull = |muscle: usize| {
            let mut force = vec![0.; scaled.n_dofs()];
            scaled.loads()[muscle].iter().for_each(|&(dof, f)| force[dof] += f);
            force
        };
        let mut pushes = vec![tissue, muscle];
        pushes.extend(acting.iter().map(|&muscle| pull(muscle)));
        pushes.extend(acting.iter().map(|&muscle| scaled.stiffening(muscle, activation[muscle], &u)));
        let mut fields = stiff.cholesky().displacements(&pushes);
        let pressing =
            contact.pairs.iter().zip(&equilibrium.contact_forces).filter(|(_, force)| **force > 0.);
        let pressing: Vec<Pair> = pressing.map(|(pair, _)| pair.clone()).collect();
        stiff.hold(&pressing, &mut fields);
        let seen = |field: &Vec<f64>| {
            let points = expression.sites.iter().flat_map(|site| site.displacement(field).data.0[0]);
            DVector::from_iterator(3 * expression.sites.len(), points)
        };
        let fields: Vec<DVector<f64>> = fields.iter().map(seen).collect();
        let observed = seen(&u);
        let (globals, muscles) = fields.split_at(2);
        let (map, softened) = muscles.split_at(acting.len());
        let pulled = |is_meant: &dyn Fn(usize) -> bool| {
            let of = acting.iter().zip(map).filter(|(muscle, _)| is_meant(**muscle));
            of.fold(DVector::zeros(observed.len()), |sum, (&m, field)| sum + field * activation[m])
        };
        let by_parameter = parameters.list().iter().map(|parameter| match &parameter.quantity {
            Quantity::TissueModulus => -&globals[0],
            Quantity::MuscleModulus => -&globals[1],
            Quantity::MuscleStress => pulled(&|_| true),
            Quantity::Strength(own) => pulled(&|muscle| own.contains(&muscle)),
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
