//! What keeps cells upright between their material points.

use nalgebra::Matrix3;

use crate::units::Vec3;

/// Share of its volume to which tissue may be squeezed at a node of its cell before the cell pushes back.
const FREE: f64 = 0.4;

/// A node of a cell, seen from within.
///
/// Points of integration do not see that a cell is folded at one of its corners: tissue there would be inside out, which
/// none can be. Its energy is `-V mu (s - 1)^2 ln s` with `s = J / J_0` below `J_0` = 0.4, zero above and infinite where
/// `J <= 0`; `J` is the ratio of volumes at the node, `V` its share of the cell and `mu` the shear modulus there. Twice
/// continuously differentiable, and nothing where tissue is squeezed less: there the element is what it was.
#[derive(Clone, Debug)]
pub(super) struct Corner {
    /// `V mu`, N mm.
    stiffness: f64,
    /// Gradients of the shape functions at rest, 1/mm, of the nodes of the patch (0-based) that move it.
    gradients: Vec<(usize, Vec3)>,
}

impl Corner {
    /// With the gradients of the shape functions of all nodes (n, 1/mm) there.
    pub(super) fn new(stiffness: f64, gradients: &[Vec3]) -> Self {
        let moving = gradients.iter().copied().enumerate().filter(|(_, g)| *g != Vec3::zeros());
        Self { stiffness, gradients: moving.collect() }
    }

    /// The ratio of volumes with the nodes of the patch at `x` (n, mm).
    pub(super) fn volume_ratio(&self, x: &[Vec3]) -> f64 {
        self.gradient(x).determinant()
    }

    /// The energy, N mm; `None` where it is inside out.
    pub(super) fn energy(&self, x: &[Vec3]) -> Option<f64> {
        let ratio = self.volume_ratio(x);
        (ratio > 0.).then(|| self.stiffness * barrier(ratio)[0])
    }

    /// Adds the forces `d energy / dx_i` to `forces` (n, N); `None` where it is inside out.
    pub(super) fn add_forces(&self, x: &[Vec3], forces: &mut [Vec3]) -> Option<()> {
        let here = self.gradient(x);
        let ratio = here.determinant();
        if ratio.is_nan() || ratio <= 0. {
            return None;
        }
        let [_, slope, _] = barrier(ratio);
        if slope != 0. {
            let area = cofactor(&here);
            self.gradients.iter().for_each(|(i, g)| forces[*i] += self.stiffness * slope * (area * g));
        }
        Some(())
    }

    /// Adds its second derivatives to `hessian` (n x n blocks, N/mm), those of `i >= j`; not inside out.
    pub(super) fn add_hessian(&self, x: &[Vec3], hessian: &mut [Matrix3<f64>]) {
        let here = self.gradient(x);
        let [_, slope, curve] = barrier(here.determinant()).map(|b| self.stiffness * b);
        if slope == 0. {
            return;
        }
        let (n, area) = (x.len(), cofactor(&here));
        for (j, b) in &self.gradients {
            for (i, a) in self.gradients.iter().filter(|(i, _)| i >= j) {
                // d2J / dx_i dx_j u = u x F (a x b).
                let turned = (here * a.cross(b)).cross_matrix();
                hessian[i * n + j] += curve * (area * a) * (area * b).transpose() - slope * turned;
            }
        }
    }

    fn gradient(&self, x: &[Vec3]) -> Matrix3<f64> {
        self.gradients.iter().map(|(i, g)| x[*i] * g.transpose()).sum()
    }
}

/// `-(s - 1)^2 ln s` with `s = J / J_0`, and its derivatives by `J`.
fn barrier(ratio: f64) -> [f64; 3] {
    let s = ratio / FREE;
    if s >= 1. {
        return [0.; 3];
    }
    let (t, ln) = (s - 1., s.ln());
    [
        -t * t * ln,
        -(2. * t * ln + t * t / s) / FREE,
        (-2. * ln - 4. * t / s + t * t / (s * s)) / (FREE * FREE),
    ]
}

/// `det F F^-T`, also where `F` is singular.
fn cofactor(f: &Matrix3<f64>) -> Matrix3<f64> {
    let [a, b, c] = [f.column(0), f.column(1), f.column(2)].map(|c| Vec3::new(c[0], c[1], c[2]));
    Matrix3::from_columns(&[b.cross(&c), c.cross(&a), a.cross(&b)])
}
