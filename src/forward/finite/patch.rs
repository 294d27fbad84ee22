//! Material points that share one dilatation.

use nalgebra::Matrix3;

use super::corner::Corner;
use super::material::{PointFibre, PointMaterial};
use crate::units::Vec3;

/// A material point of a patch.
#[derive(Clone, Debug)]
pub struct PatchPoint {
    /// Volume at rest that it stands for, mm³.
    pub volume: f64,
    /// Gradients of the shape functions of the patch's nodes at rest, 1/mm; zero for nodes that do not move it.
    pub gradients: Vec<Vec3>,
    /// What it is made of.
    pub material: PointMaterial,
}

/// Forces (n, N) of the passive tissue of a patch, and those of each of its muscles by the muscle's number.
pub type PatchForces = (Vec<Vec3>, Vec<(usize, Vec<Vec3>)>);

/// Material points that share one dilatation: `theta = sum_q w_q J_q / V` (mean dilatation; Simo, Taylor and Pister 1985).
///
/// The energy is
/// `sum_q w_q [c_1 (I_q - 3) + c_2 (I_q - 3)^2 + sum_m a_m (s/2 ln^2 lambda_q + tau |F_q f|)] + V K/2 ln^2 theta`,
/// with `I = J^-2/3 F:F`, the fibre stretch `lambda = (theta/J)^1/3 |F f|`, the stiffening `s` and the contractile
/// stress `tau` of the point. It is infinite where `J <= 0`. The nodes of a cell that could fold between its points add an
/// energy of their own below 0.4 of the volume, infinite where one of them is inside out. At small strain it is the B-bar
/// element with law `reinforced` under the [active stress](super::super::active_stress_forces) `tau`.
///
/// A hexahedron, a wedge and some six linear tetrahedra are one patch, so that nearly incompressible tissue does not
/// lock; of a quadratic tetrahedron every point is one.
#[derive(Clone, Debug)]
pub struct Patch {
    nodes: Vec<usize>,
    points: Vec<PatchPoint>,
    /// Nodes of its cell, which stay upright.
    corners: Vec<Corner>,
    volume: f64,
    /// Volume-weighted mean bulk modulus, N/mm².
    bulk: f64,
}

/// First and second derivatives of the energy of a patch.
#[derive(Clone, Debug, Default)]
pub struct PatchDerivatives {
    /// By the position of each node, N.
    pub gradient: Vec<Vec3>,
    /// By the positions of nodes `i` and `j`, N/mm, at `i n + j`.
    pub hessian: Vec<Matrix3<f64>>,
}

/// A point as it is deformed.
struct Deformed {
    /// `F`.
    gradient: Matrix3<f64>,
    /// `F^-T`.
    normal: Matrix3<f64>,
    /// `det F`.
    volume_ratio: f64,
}

/// A fibre as it is deformed.
struct DeformedFibre {
    /// Unit direction of `F f`.
    direction: Vec3,
    /// `|F f|`.
    length: f64,
    /// Logarithm of the stretch `lambda`.
    strain: f64,
}

impl Patch {
    /// A patch of `points` whose gradients belong to `nodes` (0-based).
    pub fn new(nodes: Vec<usize>, points: Vec<PatchPoint>) -> Self {
        let volume: f64 = points.iter().map(|p| p.volume).sum();
        let bulk = points.iter().map(|p| p.volume * p.material.bulk).sum::<f64>() / volume;
        Self { nodes, points, corners: Vec::new(), volume, bulk }
    }

    /// Keeps it upright also where the shape functions of its nodes have `gradients` (a list of n, 1/mm), such as at the
    /// nodes of its cell, of which `stiffness` is volume times shear modulus, N mm.
    pub(super) fn keep_upright(&mut self, gradients: &[&[Vec3]], stiffness: f64) {
        let share = stiffness / gradients.len() as f64;
        self.corners = gradients.iter().map(|gradients| Corner::new(share, gradients)).collect();
    }

    /// Its nodes (0-based).
    pub fn nodes(&self) -> &[usize] {
        &self.nodes
    }

    /// Its material points.
    pub fn points(&self) -> &[PatchPoint] {
        &self.points
    }

    /// The muscles with a fibre in it, ascending.
    pub fn muscles(&self) -> Vec<usize> {
        let mut muscles: Vec<usize> =
            self.points.iter().filter_map(|p| p.material.fibre.map(|f| f.muscle)).collect();
        muscles.sort_unstable();
        muscles.dedup();
        muscles
    }

    /// `F` at each point with the nodes at `x` (n, mm).
    pub fn deformation_gradients<'a>(&'a self, x: &'a [Vec3]) -> impl Iterator<Item = Matrix3<f64>> + 'a {
        self.points.iter().map(|p| deformation_gradient(p, x))
    }

    /// Whether no point and no corner is inside out with the nodes at `x` (n, mm).
    pub fn is_upright(&self, x: &[Vec3]) -> bool {
        self.deformation_gradients(x).all(|f| f.determinant() > 0.)
            && self.corners.iter().all(|corner| corner.volume_ratio(x) > 0.)
    }

    /// The energy, N mm, with the nodes at `x` (n, mm) under the activations `a` (m); `None` where a point is inside
    /// out.
    pub fn energy(&self, x: &[Vec3], a: &[f64]) -> Option<f64> {
        let mut gradients = Vec::with_capacity(self.points.len());
        let mut dilated = 0.;
        for point in &self.points {
            let gradient = deformation_gradient(point, x);
            let volume_ratio = gradient.determinant();
            if volume_ratio.is_nan() || volume_ratio <= 0. {
                return None;
            }
            dilated += point.volume * volume_ratio;
            gradients.push((gradient, volume_ratio));
        }
        let dilatation = dilated / self.volume;
        let mut energy = 0.5 * self.volume * self.bulk * dilatation.ln().powi(2);
        for corner in &self.corners {
            energy += corner.energy(x)?;
        }
        for (point, (gradient, volume_ratio)) in self.points.iter().zip(gradients) {
            let invariant = gradient.norm_squared() / volume_ratio.powf(2. / 3.);
            energy += point.volume * point.material.isochoric(invariant)[0];
            if let Some(own) = &point.material.fibre {
                let DeformedFibre { length, strain, .. } =
                    deformed_fibre(own, &gradient, volume_ratio, dilatation);
                let stiffened = 0.5 * own.stiffening * strain * strain;
                energy += point.volume * a[own.muscle] * (stiffened + own.tension * length);
            }
        }
        Some(energy)
    }

    /// The forces `d Pi/dx_i` (n, N) of the tissue at rest of its muscles and, beside them, of each of its
    /// [muscles](Self::muscles) at full activation, with the nodes at `x` (n, mm); `None` where a point is inside out.
    pub fn forces(&self, x: &[Vec3]) -> Option<PatchForces> {
        let deformed = self.deformed(x)?;
        let (dilatation, mean) = self.dilatation(&deformed);
        let pressure = self.bulk * dilatation.ln() / dilatation;
        let mut passive: Vec<Vec3> = mean.iter().map(|g| self.volume * pressure * g).collect();
        self.corners.iter().try_for_each(|corner| corner.add_forces(x, &mut passive))?;
        let mut active: Vec<(usize, Vec<Vec3>)> =
            self.muscles().into_iter().map(|m| (m, vec![Vec3::zeros(); mean.len()])).collect();
        for (point, here) in self.points.iter().zip(&deformed) {
            let (scale, invariant) = isochoric_invariant(here);
            let slope = point.material.isochoric(invariant)[1];
            let stress =
                2. * point.volume * slope * scale * (here.gradient - invariant / (3. * scale) * here.normal);
            for (force, g) in passive.iter_mut().zip(&point.gradients) {
                *force += stress * g;
            }
            let Some(own) = &point.material.fibre else { continue };
            let Some((_, forces)) = active.iter_mut().find(|(m, _)| *m == own.muscle) else { continue };
            let fibre = deformed_fibre(own, &here.gradient, here.volume_ratio, dilatation);
            let stiff = own.stiffening * fibre.strain;
            let pressure = point.volume * stiff / (3. * dilatation);
            for ((force, g), mean) in forces.iter_mut().zip(&point.gradients).zip(&mean) {
                let along = own.direction.dot(g);
                let stretch = along / fibre.length * fibre.direction - here.normal * g / 3.;
                *force += point.volume * (stiff * stretch + own.tension * along * fibre.direction)
                    + pressure * mean;
            }
        }
        Some((passive, active))
    }

    /// Gradient and Hessian with the nodes at `x` (n, mm) under the activations `a` (m); `None` where a point is
    /// inside out.
    pub fn derivatives(&self, x: &[Vec3], a: &[f64]) -> Option<PatchDerivatives> {
        let deformed = self.deformed(x)?;
        let (dilatation, mean) = self.dilatation(&deformed);
        let n = self.nodes.len();
        let mut gradient = vec![Vec3::zeros(); n];
        let mut hessian = vec![Matrix3::zeros(); n * n];
        for corner in &self.corners {
            corner.add_forces(x, &mut gradient)?;
            corner.add_hessian(x, &mut hessian);
        }
        // d Pi/d theta and d^2 Pi/d theta^2 over the patch's volume, and d^2 Pi/d theta dx.
        let log = dilatation.ln();
        let mut pressure = self.bulk * log / dilatation;
        let mut curvature = self.volume * self.bulk * (1. - log) / (dilatation * dilatation);
        let mut coupling = vec![Vec3::zeros(); n];
        for (point, here) in self.points.iter().zip(&deformed) {
            let Some(own) = &point.material.fibre else { continue };
            let stiff = point.volume * a[own.muscle] * own.stiffening;
            let strain = deformed_fibre(own, &here.gradient, here.volume_ratio, dilatation).strain;
            pressure += stiff * strain / (3. * dilatation * self.volume);
            curvature += stiff * (1. / 9. - strain / 3.) / (dilatation * dilatation);
        }
        for (point, here) in self.points.iter().zip(&deformed) {
            let w = point.volume;
            let (scale, invariant) = isochoric_invariant(here);
            let [_, c, cc] = point.material.isochoric(invariant);
            let (c, cc) = (w * c, w * cc);
            let fibre = point.material.fibre.as_ref().map(|own| {
                let activation = w * a[own.muscle];
                let fibre = deformed_fibre(own, &here.gradient, here.volume_ratio, dilatation);
                (own, fibre, activation * own.stiffening, activation * own.tension)
            });
            let swelling = w * pressure * here.volume_ratio;
            // F g, F^-T g and the slopes of the invariant and of the fibre strain, by node.
            let per_node: Vec<NodeSlopes> = point
                .gradients
                .iter()
                .map(|g| {
                    let (moved, normal) = (here.gradient * g, here.normal * g);
                    let invariant_slope = 2. * scale * moved - (2. / 3.) * invariant * normal;
                    let (along, strain_slope) = fibre.as_ref().map_or((0., Vec3::zeros()), |(own, f, ..)| {
                        let along = own.direction.dot(g);
                        (along, along / f.length * f.direction - normal / 3.)
                    });
                    NodeSlopes { moved, normal, invariant_slope, along, strain_slope }
                })
                .collect();
            let [mut stiff, mut stiff_strain, mut tension] = [0.; 3];
            let (mut fibre_block, mut direction) = (Matrix3::zeros(), Vec3::zeros());
            if let Some((_, f, s, t)) = &fibre {
                (stiff, stiff_strain, tension, direction) = (*s, s * f.strain, *t, f.direction);
                let (dyad, length) = (f.direction * f.direction.transpose(), f.length);
                // Per product of the nodes' gradients along the fibre.
                fibre_block = stiff_strain / (length * length) * (Matrix3::identity() - 2. * dyad)
                    + tension / length * (Matrix3::identity() - dyad);
            }
            for (i, at) in per_node.iter().enumerate() {
                gradient[i] += c * at.invariant_slope
                    + swelling * at.normal
                    + stiff_strain * at.strain_slope
                    + tension * at.along * direction;
                coupling[i] += stiff / (3. * dilatation) * at.strain_slope;
            }
            let spread = 2. * c * scale;
            let both = c * (4. / 9.) * invariant + swelling;
            let crossed = c * (2. / 3.) * invariant - swelling + stiff_strain / 3.;
            let moved = -(4. / 3.) * c * scale;
            for (j, b) in per_node.iter().enumerate() {
                for (i, at) in per_node.iter().enumerate().skip(j) {
                    let mut block = outer(&at.normal, &(both * b.normal + moved * b.moved))
                        + outer(&(moved * at.moved), &b.normal)
                        + outer(&(crossed * b.normal), &at.normal);
                    let diagonal = spread * point.gradients[i].dot(&point.gradients[j]);
                    for k in 0..3 {
                        block[(k, k)] += diagonal;
                    }
                    if cc != 0. {
                        block += outer(&at.invariant_slope, &(cc * b.invariant_slope));
                    }
                    if fibre.is_some() {
                        block += outer(&at.strain_slope, &(stiff * b.strain_slope))
                            + at.along * b.along * fibre_block;
                    }
                    hessian[i * n + j] += block;
                }
            }
        }
        for j in 0..n {
            for i in j..n {
                hessian[i * n + j] +=
                    outer(&coupling[i], &mean[j]) + outer(&mean[i], &(coupling[j] + curvature * mean[j]));
                if i > j {
                    hessian[j * n + i] = hessian[i * n + j].transpose();
                }
            }
        }
        Some(PatchDerivatives { gradient, hessian })
    }

    fn deformed(&self, x: &[Vec3]) -> Option<Vec<Deformed>> {
        let at = |point: &PatchPoint| {
            let gradient = deformation_gradient(point, x);
            let volume_ratio = gradient.determinant();
            if volume_ratio.is_nan() || volume_ratio <= 0. {
                return None;
            }
            Some(Deformed { gradient, normal: gradient.try_inverse()?.transpose(), volume_ratio })
        };
        self.points.iter().map(at).collect()
    }

    /// `theta` and its derivative by the position of each node, 1/mm.
    fn dilatation(&self, deformed: &[Deformed]) -> (f64, Vec<Vec3>) {
        let mut dilatation = 0.;
        let mut mean = vec![Vec3::zeros(); self.nodes.len()];
        for (point, here) in self.points.iter().zip(deformed) {
            let swollen = point.volume * here.volume_ratio / self.volume;
            dilatation += swollen;
            for (mean, g) in mean.iter_mut().zip(&point.gradients) {
                *mean += swollen * (here.normal * g);
            }
        }
        (dilatation, mean)
    }
}

/// What the derivatives at a point are made of, for one node with the gradient `g`.
struct NodeSlopes {
    /// `F g`.
    moved: Vec3,
    /// `F^-T g`.
    normal: Vec3,
    /// Derivative of the invariant `I`.
    invariant_slope: Vec3,
    /// `f . g`.
    along: f64,
    /// Derivative of the logarithmic fibre stretch at fixed dilatation.
    strain_slope: Vec3,
}

fn deformation_gradient(point: &PatchPoint, x: &[Vec3]) -> Matrix3<f64> {
    let mut gradient = Matrix3::zeros();
    for (x, g) in x.iter().zip(&point.gradients) {
        gradient += outer(x, g);
    }
    gradient
}

/// `J^-2/3` and `I = J^-2/3 F:F`.
fn isochoric_invariant(here: &Deformed) -> (f64, f64) {
    let scale = here.volume_ratio.powf(-2. / 3.);
    (scale, scale * here.gradient.norm_squared())
}

fn deformed_fibre(
    own: &PointFibre,
    gradient: &Matrix3<f64>,
    volume_ratio: f64,
    dilatation: f64,
) -> DeformedFibre {
    let along = gradient * own.direction;
    let length = along.norm();
    let strain = length.ln() + (dilatation.ln() - volume_ratio.ln()) / 3.;
    DeformedFibre { direction: along / length, length, strain }
}

fn outer(a: &Vec3, b: &Vec3) -> Matrix3<f64> {
    a * b.transpose()
}
