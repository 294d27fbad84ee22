//! Linear elastic laws as 6 x 6 matrices.
//!
//! Voigt order xx, yy, zz, xy, yz, zx with engineering shear strains: `sigma = C epsilon`.

use nalgebra::{Matrix6, Vector6};

use crate::units::Vec3;

/// Isotropic law `C_iso(E, nu)`, in the unit of `young`.
pub fn isotropic(young: f64, poisson: f64) -> Matrix6<f64> {
    let mu = young / (2. * (1. + poisson));
    let lambda = young * poisson / ((1. + poisson) * (1. - 2. * poisson));
    let mut c = Matrix6::zeros();
    for i in 0..3 {
        for j in 0..3 {
            c[(i, j)] = lambda;
        }
        c[(i, i)] += 2. * mu;
        c[(i + 3, i + 3)] = mu;
    }
    c
}

/// `f (x) f` as a stress vector: its product with a strain is the stretch along `f`.
///
/// `f` is a unit vector.
pub fn fibre_dyad(f: Vec3) -> Vector6<f64> {
    Vector6::new(f.x * f.x, f.y * f.y, f.z * f.z, f.x * f.y, f.y * f.z, f.z * f.x)
}

/// Law `reinforced`: `C = C_iso(E, nu) + extra (f(x)f)(x)(f(x)f)` (DESIGN 3).
///
/// Pulled along `f` it has exactly the modulus `young + extra`; it stays positive definite and
/// quasi-incompressible for every `extra >= 0`. The modulus across the fibre drifts upward with
/// `extra`: from 6.2 to at most 8.1 kPa for muscle.
pub fn reinforced(young: f64, poisson: f64, extra: f64, f: Vec3) -> Matrix6<f64> {
    let d = fibre_dyad(f);
    isotropic(young, poisson) + extra * d * d.transpose()
}
