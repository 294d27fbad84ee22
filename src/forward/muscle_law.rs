//! The stiffness of muscle as its fibres contract.

use nalgebra::{Matrix3, Matrix6, Vector6};

use super::elasticity::fibre_dyad;
use crate::face::{MuscleLaw, MuscleTissue};
use crate::units::{N_PER_MM2_PER_KPA, Vec3};

/// Number of tensors that span the transversely isotropic laws.
pub const N_TENSORS: usize = 5;

/// Position of `A(x)A` among the [`tensors`].
const FIBRE: usize = 4;

/// The five tensors (6 x 6, Voigt) that span every law that is isotropic about the unit fibre `f`, with
/// `A = f(x)f` (Spencer 1984):
/// `C = lambda I(x)I + 2 mu_t (1 - S) + 2 mu_l S + alpha (I(x)A + A(x)I) + beta A(x)A`, where
/// `S epsilon = A epsilon + epsilon A`.
///
/// In this order their coefficients are `lambda`, `mu_t`, `mu_l`, `alpha`, `beta`.
pub fn tensors(f: Vec3) -> [Matrix6<f64>; N_TENSORS] {
    let unit = Vector6::new(1., 1., 1., 0., 0., 0.);
    let dyad = fibre_dyad(f);
    let double = Matrix6::from_diagonal(&Vector6::new(2., 2., 2., 1., 1., 1.));
    let along = 2. * axial(f * f.transpose());
    [
        unit * unit.transpose(),
        double - along,
        along,
        unit * dyad.transpose() + dyad * unit.transpose(),
        dyad * dyad.transpose(),
    ]
}

/// `epsilon -> A epsilon + epsilon A` from engineering strains to stresses.
fn axial(a: Matrix3<f64>) -> Matrix6<f64> {
    const VOIGT: [(usize, usize); 6] = [(0, 0), (1, 1), (2, 2), (0, 1), (1, 2), (2, 0)];
    Matrix6::from_fn(|row, column| {
        let (i, j) = VOIGT[column];
        let mut strain = Matrix3::zeros();
        // A normal strain of one, or an engineering shear of one: half of it on either side.
        strain[(i, j)] += 0.5;
        strain[(j, i)] += 0.5;
        let stress = a * strain + strain * a;
        stress[VOIGT[row]]
    })
}

impl MuscleTissue {
    /// Coefficients `c_k(a)` at activation `a`, N/mm².
    ///
    /// Law `reinforced`: `C_iso(rest, nu)` plus `a (active - rest)` on `A(x)A`. Law `orthotropic`: the
    /// engineering constants `E_f(a)`, `E_t`, `G_ft = E_t / 2(1 + nu)`, `nu_ft = nu` and, so that the
    /// volume hardly changes whichever way it is pulled, `nu_tt = nu (2 - E_t / E_f)`.
    pub fn coefficients(&self, a: f64) -> [f64; N_TENSORS] {
        let (lambda, mu) = self.lame();
        let extra = a * self.extra();
        match self.law {
            MuscleLaw::Reinforced => [lambda, mu, mu, 0., extra],
            MuscleLaw::Orthotropic => spread(&self.normal_stiffness(a), mu),
        }
    }

    /// `dc_k/da` at activation `a`, N/mm².
    pub fn coefficient_slopes(&self, a: f64) -> [f64; N_TENSORS] {
        match self.law {
            MuscleLaw::Reinforced => [0., 0., 0., 0., self.extra()],
            MuscleLaw::Orthotropic => {
                // C = S^-1 with S = S_0 + S_1 / E_f, hence C' = C S_1 C E_f' / E_f^2.
                let c = self.normal_stiffness(a);
                let along = self.along(a);
                spread(&(c * self.softening() * c * (self.extra() / (along * along))), 0.)
            }
        }
    }

    /// The tensors whose coefficients change with activation, by position.
    pub(super) fn active_tensors(&self) -> &'static [usize] {
        match self.law {
            MuscleLaw::Reinforced => &[FIBRE],
            // mu_l is kept: shear along the fibre does not stiffen.
            MuscleLaw::Orthotropic => &[0, 1, 3, FIBRE],
        }
    }

    /// `C(a)` (N/mm², 6 x 6, Voigt) of muscle with the unit fibre `f`.
    pub fn stiffness(&self, a: f64, f: Vec3) -> Matrix6<f64> {
        self.coefficients(a).into_iter().zip(tensors(f)).map(|(c, tensor)| c * tensor).sum()
    }

    fn lame(&self) -> (f64, f64) {
        let (young, nu) = (self.rest_kpa * N_PER_MM2_PER_KPA, self.poisson);
        (young * nu / ((1. + nu) * (1. - 2. * nu)), young / (2. * (1. + nu)))
    }

    fn extra(&self) -> f64 {
        (self.active_kpa - self.rest_kpa) * N_PER_MM2_PER_KPA
    }

    fn along(&self, a: f64) -> f64 {
        self.rest_kpa * N_PER_MM2_PER_KPA + a * self.extra()
    }

    /// `dS/d(1/E_f)` of the compliance of normal strains, fibre first.
    fn softening(&self) -> Matrix3<f64> {
        let nu = self.poisson;
        Matrix3::new(1., -nu, -nu, -nu, 0., nu, -nu, nu, 0.)
    }

    /// Stiffness of normal strains, fibre first, of law `orthotropic`.
    fn normal_stiffness(&self, a: f64) -> Matrix3<f64> {
        let (across, nu) = (1. / (self.rest_kpa * N_PER_MM2_PER_KPA), self.poisson);
        let rest = Matrix3::new(0., 0., 0., 0., across, -2. * nu * across, 0., -2. * nu * across, across);
        let compliance = rest + self.softening() / self.along(a);
        compliance.try_inverse().unwrap_or_else(|| Matrix3::repeat(f64::NAN))
    }
}

/// Coefficients on the tensors of a law with the normal block `c` (fibre first) and the shear modulus
/// `mu_l` along the fibre.
fn spread(c: &Matrix3<f64>, mu_l: f64) -> [f64; N_TENSORS] {
    let lambda = c[(1, 2)];
    let mu_t = 0.5 * (c[(1, 1)] - c[(1, 2)]);
    let alpha = c[(0, 1)] - lambda;
    let beta = c[(0, 0)] - lambda - 2. * alpha - 4. * mu_l + 2. * mu_t;
    [lambda, mu_t, mu_l, alpha, beta]
}
