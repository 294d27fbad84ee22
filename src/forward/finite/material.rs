//! What the tissue at a point is made of, and the energy of its fibres.

use crate::units::Vec3;

/// Muscle at a point, a share of the tissue there.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct PointFibre {
    /// Number of the muscle.
    pub muscle: usize,
    /// Unit direction of its fibres at rest.
    pub direction: Vec3,
    /// What full activation adds to the modulus along the fibre, N/mm²: the muscle's share of the tissue times `E_x`.
    pub stiffening: f64,
    /// Contractile stress at full activation, N/mm² of the tissue's cross-section at rest.
    pub tension: f64,
}

/// Tissue at a point.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct PointMaterial {
    /// Initial shear modulus `mu`, N/mm².
    pub shear: f64,
    /// Ratio `c_2/c_1` of the Yeoh law: 0 is neo-Hookean.
    pub strain_stiffening: f64,
    /// Bulk modulus `K`, N/mm².
    pub bulk: f64,
    /// The muscle there, if any.
    pub fibre: Option<PointFibre>,
}

impl PointMaterial {
    /// Isochoric energy `c_1 (I - 3) + c_2 (I - 3)^2`, `c_1 = mu/2`, with its first and second derivatives by
    /// `I = J^-2/3 F:F` (Yeoh 1993).
    pub(super) fn isochoric(&self, invariant: f64) -> [f64; 3] {
        let c1 = 0.5 * self.shear;
        let (c2, x) = (c1 * self.strain_stiffening, invariant - 3.);
        [c1 * x + c2 * x * x, c1 + 2. * c2 * x, 2. * c2]
    }
}
