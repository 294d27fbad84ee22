//! Tissue that is pulled to where it belongs: the regulariser of the match.

use std::sync::Arc;

use nalgebra::Matrix3;

use crate::forward::finite::{FiniteBody, PointMaterial};
use crate::forward::{Cholesky, ForwardError, Pattern, SymbolicFactor};
use crate::mesh::Mesh;
use crate::units::Vec3;

/// Modulus of the tissue, N/mm², and its Poisson ratio. Only the ratio to the stiffness of the springs counts; nearly
/// incompressible tissue could not become that of a fuller face.
const YOUNG: f64 = 0.015;
const POISSON: f64 = 0.3;
/// Ratio `c_2/c_1` of the Yeoh law: what is sheared far is sheared no farther, so that cells keep their shape.
const STIFFENING: f64 = 1.;
/// Share of the predicted decrease that a step must bring (Armijo), and the shortest step as a share of Newton's.
const WORTH: f64 = 1e-4;
const SHORTEST: f64 = 1. / 256.;
/// Longest step of a node, mm.
const LONGEST_MM: f64 = 5.;
/// First and greatest weight of the rest stiffness where the Hessian is indefinite.
const SHIFT: [f64; 2] = [0.05, 100.];

/// Stiffness across a sliding spring as a share of that along its normal.
const ACROSS: f64 = 0.05;

/// A spring between a point of the tissue and a place:
/// `1/2 (k_n (n.r)² + k_t |r - (n.r) n|²)`, `r` from the place to the point.
#[derive(Clone, Debug)]
pub(super) struct Spring {
    /// Nodes and weights of the point.
    pub(super) carriers: Vec<(usize, f64)>,
    /// The place, mm.
    pub(super) target: Vec3,
    /// Unit normal `n`.
    pub(super) normal: Vec3,
    /// Stiffness `k_n` along the normal and `k_t` across it, N/mm.
    pub(super) along: f64,
    pub(super) across: f64,
}

impl Spring {
    /// One of the stiffness `along` (N/mm) its normal and a share of that across: what it holds slides, but not at once.
    pub(super) fn sliding(carriers: Vec<(usize, f64)>, target: Vec3, normal: Vec3, along: f64) -> Self {
        Self { carriers, target, normal, along, across: ACROSS * along }
    }

    fn stiffness(&self) -> Matrix3<f64> {
        let n = self.normal;
        self.across * Matrix3::identity() + (self.along - self.across) * (n * n.transpose())
    }

    fn stretch(&self, x: &[Vec3]) -> Vec3 {
        self.carriers.iter().map(|&(node, w)| w * x[node]).sum::<Vec3>() - self.target
    }

    fn energy(&self, x: &[Vec3]) -> f64 {
        let r = self.stretch(x);
        0.5 * r.dot(&(self.stiffness() * r))
    }
}

/// The tissue without muscles, at rest where the match begins: `W(x) + springs`, minimised over all nodes.
///
/// `W` is the passive potential at finite strain of the corners of cells, infinite where one is folded flat, so that no
/// cell ever is turned inside out.
/// Springs that stiffen while correspondences are found anew make it the non-rigid match of Amberg, Romdhani and Vetter
/// (CVPR 2007) with tissue in place of its smoothness term; that a mesh of elements is carried along is the mesh-matching of
/// Couteau, Payan and Lavallee (J. Biomech. 33 (2000) 1005).
pub(super) struct Tissue {
    body: FiniteBody,
    pattern: Pattern,
    symbolic: Arc<SymbolicFactor>,
    factor: Option<Cholesky>,
    /// Second derivatives at rest.
    rest: Vec<f64>,
}

impl Tissue {
    /// That of `mesh`, which is at rest; `joined` are groups of nodes that springs hold together.
    pub(super) fn new(mesh: &Mesh, joined: &[Vec<usize>]) -> Result<Self, ForwardError> {
        let material = PointMaterial {
            shear: YOUNG / (2. * (1. + POISSON)),
            strain_stiffening: STIFFENING,
            bulk: YOUNG / (3. * (1. - 2. * POISSON)),
            fibre: None,
        };
        let body = FiniteBody::of_corners(mesh, material);
        let patches = body.patches().iter().map(|patch| patch.nodes());
        let pattern = Pattern::new(mesh.n_nodes(), patches.chain(joined.iter().map(Vec::as_slice)));
        let symbolic = Arc::new(SymbolicFactor::new(&pattern, &vec![false; 3 * mesh.n_nodes()])?);
        let mut rest = vec![0.; pattern.n_values()];
        body.derivatives(&mesh.points, &[], &pattern, &mut rest);
        Ok(Self { body, pattern, symbolic, factor: None, rest })
    }

    fn energy(&self, x: &[Vec3], springs: &[Spring]) -> Option<f64> {
        let tissue = self.body.energy(x, &[])?;
        let energy = tissue + springs.iter().map(|spring| spring.energy(x)).sum::<f64>();
        energy.is_finite().then_some(energy)
    }

    /// Takes up to `steps` Newton steps from `x` (n, mm) towards the minimum; returns the longest that a node took in the
    /// last one, mm.
    ///
    /// # Errors
    /// [`ForwardError::NotPositiveDefinite`] where no step leads down.
    pub(super) fn relax(
        &mut self,
        x: &mut Vec<Vec3>,
        springs: &[Spring],
        steps: usize,
    ) -> Result<f64, ForwardError> {
        let mut longest = 0.;
        for _ in 0..steps {
            let Some(energy) = self.energy(x, springs) else { return Err(ForwardError::NotPositiveDefinite) };
            let mut values = vec![0.; self.pattern.n_values()];
            let Some(mut gradient) = self.body.derivatives(x, &[], &self.pattern, &mut values) else {
                return Err(ForwardError::NotPositiveDefinite);
            };
            for spring in springs {
                let k = spring.stiffness();
                let force = k * spring.stretch(x);
                for (a, &(i, wi)) in spring.carriers.iter().enumerate() {
                    gradient[i] += wi * force;
                    for &(j, wj) in &spring.carriers[..=a] {
                        self.pattern.add_block(i, j, &(wi * wj * k), &mut values);
                    }
                }
            }
            self.factorise(&values)?;
            let Some(factor) = &self.factor else { return Err(ForwardError::NotPositiveDefinite) };
            let mut step: Vec<f64> = gradient.iter().flat_map(|g| [-g.x, -g.y, -g.z]).collect();
            factor.solve_in_place(&mut step);
            let slope: f64 =
                step.as_chunks::<3>().0.iter().zip(&gradient).map(|(s, g)| Vec3::from(*s).dot(g)).sum();
            let farthest = step.as_chunks::<3>().0.iter().map(|s| Vec3::from(*s).norm()).fold(0., f64::max);
            let mut share = (LONGEST_MM / farthest).min(1.);
            let noise = 1e-13 * energy.abs();
            loop {
                let next: Vec<Vec3> =
                    x.iter().zip(step.as_chunks::<3>().0).map(|(x, s)| x + share * Vec3::from(*s)).collect();
                if self.energy(&next, springs).is_some_and(|e| e <= energy + WORTH * share * slope + noise) {
                    *x = next;
                    break;
                }
                share *= 0.5;
                if share < SHORTEST {
                    // As low as rounding lets it be.
                    return Ok(0.);
                }
            }
            longest = share * farthest;
            if longest < 1e-4 {
                break;
            }
        }
        Ok(longest)
    }

    fn factorise(&mut self, values: &[f64]) -> Result<(), ForwardError> {
        let mut shift = 0.;
        loop {
            let shifted: Vec<f64> = values.iter().zip(&self.rest).map(|(h, k)| h + shift * k).collect();
            let done = match &mut self.factor {
                Some(factor) => factor.renew(&shifted),
                None => {
                    Cholesky::new(self.symbolic.clone(), &shifted).map(|factor| self.factor = Some(factor))
                }
            };
            match done {
                Ok(()) => return Ok(()),
                Err(error) if shift >= SHIFT[1] => return Err(error),
                Err(_) => shift = (4. * shift).max(SHIFT[0]),
            }
        }
    }
}
