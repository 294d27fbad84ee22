//! First and second derivatives of one term.

use nalgebra::allocator::Allocator;
use nalgebra::{Const, DefaultAllocator, DimDiff, DimSub, Matrix3, OMatrix, SMatrix, SVector, U1};

use super::Barrier;
use super::separation::Separation;
use super::term::Term;
use crate::units::Vec3;

/// Second derivative by the corners of two simplices, corner-major xyz.
pub(super) type Hessian = SMatrix<f64, 12, 12>;

/// Which second derivative.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Curvature {
    /// As it is; indefinite.
    Exact,
    /// The nearest positive semidefinite one of every term, for descent directions.
    Projected,
}

/// One term and its derivatives.
pub(super) struct Local {
    pub(super) energy: f64,
    /// By corner, N.
    pub(super) gradient: [Vec3; 4],
    /// N/mm.
    pub(super) hessian: Hessian,
}

impl Term {
    /// The gradient by corner, N.
    pub(super) fn gradient(&self, barrier: &Barrier, x: &[Vec3]) -> [Vec3; 4] {
        let distance = self.separation.distance();
        let [b, slope, _] = barrier.at(distance, self.reach_mm).map(|b| b * self.weight);
        let direction = self.separation.offset / distance;
        let gradient = self.separation.shares.map(|a| slope * a * direction);
        let Some(mollifier) = self.mollifier else { return gradient };
        let (m, slope) = mollifier.slope(&Self::places(self.vertices, x));
        std::array::from_fn(|i| m * gradient[i] + b * slope[i])
    }

    /// The derivatives by corner.
    pub(super) fn derivatives(&self, barrier: &Barrier, x: &[Vec3], curvature: Curvature) -> Local {
        let barrier = barrier.at(self.separation.distance(), self.reach_mm).map(|b| b * self.weight);
        let Some(mollifier) = self.mollifier else {
            let (gradient, hessian) = of_distance(&self.separation, barrier, curvature);
            return Local { energy: barrier[0], gradient, hessian };
        };
        let (gradient, hessian) = of_distance(&self.separation, barrier, Curvature::Exact);
        let m = mollifier.derivatives(&Self::places(self.vertices, x));
        let b = SVector::<f64, 12>::from_fn(|k, _| gradient[k / 3][k % 3]);
        let mixed = m.gradient * b.transpose();
        let exact = m.value * hessian + mixed + mixed.transpose() + barrier[0] * m.hessian;
        let total = m.value * b + barrier[0] * m.gradient;
        Local {
            energy: m.value * barrier[0],
            gradient: std::array::from_fn(|i| Vec3::new(total[3 * i], total[3 * i + 1], total[3 * i + 2])),
            hessian: match curvature {
                Curvature::Exact => exact,
                Curvature::Projected => positive_part(exact),
            },
        }
    }
}

/// Gradient and second derivative of `b(d)`, given `[b, b', b'']`.
///
/// With `n = r / d`, tangents `E = dr/dbeta`, `G = (E'E)^-1`, slopes `c = da/dbeta` and `p = -b'`
///
/// ```text
/// H_ij = b'' a_i a_j n n' + p (a_i E G c_j n' + n c_i' G E' a_j + d c_i' G c_j n n') - p/d a_i a_j (I - n n' - E G E')
/// ```
///
/// In a frame of `n`, of `E` and of what is normal to both this is one small matrix on the span of `a n`, `c_k n` and
/// `a e_l`, and `-p/d` on the rest, which does not meet it: so the small one is projected, of order five at most.
fn of_distance(
    separation: &Separation,
    [_, slope, curve]: [f64; 3],
    curvature: Curvature,
) -> ([Vec3; 4], Hessian) {
    let Separation { offset, shares, slopes, tangents, n_free } = separation;
    let d = offset.norm();
    let n = offset / d;
    let p = -slope;
    let gradient = shares.map(|a| slope * a * n);

    let frame = Matrix3::from_columns(&frame(n, &tangents[..*n_free]));
    let inverse = inverse_gram(&tangents[..*n_free]);
    let basis = orthonormal(shares, &slopes[..*n_free]);
    let length = shares.iter().map(|a| a * a).sum::<f64>().sqrt();
    let dot = |a: &[f64; 4], b: &[f64; 4]| (0..4).map(|i| a[i] * b[i]).sum::<f64>();

    // Rows 0..3: the basis along n; rows 3..5: the unit shares along the tangents.
    let mut small = SMatrix::<f64, 5, 5>::zeros();
    small[(0, 0)] = curve * length * length;
    for k in 0..*n_free {
        for l in 0..*n_free {
            for i in 0..=*n_free {
                let along = dot(&basis[i], &slopes[k]);
                for j in 0..=*n_free {
                    small[(i, j)] += p * d * inverse[k][l] * along * dot(&basis[j], &slopes[l]);
                }
                for e in 0..*n_free {
                    let cross = p * length * along * inverse[k][l] * tangents[l].dot(&frame.column(1 + e));
                    small[(i, 3 + e)] += cross;
                    small[(3 + e, i)] += cross;
                }
            }
        }
    }
    let mut rest = -p / d;
    if curvature == Curvature::Projected {
        small = positive_part(small);
        rest = rest.max(0.);
    }

    let unit = shares.map(|a| a / length);
    let mut hessian = Hessian::zeros();
    for i in 0..4 {
        for j in 0..=i {
            let mut in_frame = Matrix3::zeros();
            for k in 0..=*n_free {
                for l in 0..=*n_free {
                    in_frame[(0, 0)] += small[(k, l)] * basis[k][i] * basis[l][j];
                }
                for e in 0..*n_free {
                    in_frame[(0, 1 + e)] += small[(k, 3 + e)] * basis[k][i] * unit[j];
                    in_frame[(1 + e, 0)] += small[(3 + e, k)] * unit[i] * basis[k][j];
                }
            }
            for e in 0..2 {
                if e >= *n_free {
                    in_frame[(1 + e, 1 + e)] = rest * shares[i] * shares[j];
                    continue;
                }
                for f in 0..*n_free {
                    in_frame[(1 + e, 1 + f)] = small[(3 + e, 3 + f)] * unit[i] * unit[j];
                }
            }
            let block = frame * in_frame * frame.transpose();
            hessian.fixed_view_mut::<3, 3>(3 * i, 3 * j).copy_from(&block);
            hessian.fixed_view_mut::<3, 3>(3 * j, 3 * i).copy_from(&block.transpose());
        }
    }
    (gradient, hessian)
}

/// `n`, then the tangents made orthonormal, then what completes the frame.
fn frame(n: Vec3, tangents: &[Vec3]) -> [Vec3; 3] {
    let first = match tangents.first() {
        Some(t) => *t,
        None => {
            let least = n.iamin();
            n.cross(&Vec3::from_fn(|k, _| if k == least { 1. } else { 0. }))
        }
    };
    let first = first.normalize();
    [n, first, n.cross(&first)]
}

/// `(E'E)^-1`.
fn inverse_gram(tangents: &[Vec3]) -> [[f64; 2]; 2] {
    match tangents {
        [e, f] => {
            let (ee, ef, ff) = (e.norm_squared(), e.dot(f), f.norm_squared());
            let determinant = e.cross(f).norm_squared();
            [[ff / determinant, -ef / determinant], [-ef / determinant, ee / determinant]]
        }
        [e] => [[1. / e.norm_squared(), 0.], [0.; 2]],
        _ => [[0.; 2]; 2],
    }
}

/// `shares` and `slopes` made orthonormal in turn (Gram and Schmidt).
fn orthonormal(shares: &[f64; 4], slopes: &[[f64; 4]]) -> [[f64; 4]; 3] {
    let mut basis = [[0.; 4]; 3];
    for (k, vector) in std::iter::once(shares).chain(slopes).enumerate() {
        let mut left = *vector;
        for known in &basis[..k] {
            let along: f64 = (0..4).map(|i| known[i] * left[i]).sum();
            (0..4).for_each(|i| left[i] -= along * known[i]);
        }
        let norm = left.iter().map(|v| v * v).sum::<f64>().sqrt();
        basis[k] = left.map(|v| v / norm);
    }
    basis
}

/// The nearest positive semidefinite matrix.
fn positive_part<const N: usize>(matrix: SMatrix<f64, N, N>) -> SMatrix<f64, N, N>
where
    Const<N>: DimSub<U1>,
    DefaultAllocator: Allocator<Const<N>, Const<N>, Buffer<f64> = nalgebra::ArrayStorage<f64, N, N>>
        + Allocator<Const<N>>
        + Allocator<DimDiff<Const<N>, U1>>,
{
    let eigen = OMatrix::<f64, Const<N>, Const<N>>::symmetric_eigen(matrix);
    let mut scaled = eigen.eigenvectors;
    for (mut column, value) in scaled.column_iter_mut().zip(eigen.eigenvalues.iter()) {
        column *= value.max(0.);
    }
    scaled * eigen.eigenvectors.transpose()
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::contact::barrier::mollifier::Mollifier;
    use crate::contact::barrier::testing::Random;

    const BARRIER: Barrier = Barrier { reach_mm: 4., stiffness: 0.3 };

    /// The term of the corners `x`: of two edges, or of a vertex and `n - 1` corners.
    fn term(x: &[Vec3], n_first: usize, n: usize, rest: Option<[Vec3; 4]>) -> Term {
        let vertices = [0, 1, 2, 3];
        let corners = Term::places(vertices, x);
        let separation = match n_first {
            2 => Separation::of_edges(&corners),
            _ => Separation::of_vertex(&corners, n),
        };
        let mollifier = rest.and_then(|rest| Mollifier::new(&rest, &corners));
        Term { vertices, n, n_first, weight: 0.7, reach_mm: 4., separation, mollifier }
    }

    fn moved(x: &[Vec3], k: usize, by: f64) -> Vec<Vec3> {
        let mut x = x.to_vec();
        x[k / 3][k % 3] += by;
        x
    }

    /// Gradient and second derivative by central differences, each of what comes before it; the projected second
    /// derivative has no negative eigenvalue and differs by the negative part alone.
    fn check(x: &[Vec3], n_first: usize, n: usize, rest: Option<[Vec3; 4]>) {
        let h = 1e-6;
        let here = term(x, n_first, n, rest).derivatives(&BARRIER, x, Curvature::Exact);
        assert_eq!(term(x, n_first, n, rest).gradient(&BARRIER, x), here.gradient);
        let scale = here.hessian.norm();
        for k in 0..12 {
            let [hi, lo] = [h, -h].map(|h| {
                let x = moved(x, k, h);
                let term = term(&x, n_first, n, rest);
                (term.energy(&BARRIER, &x), term.gradient(&BARRIER, &x))
            });
            let slope = (hi.0 - lo.0) / (2. * h);
            assert!((slope - here.gradient[k / 3][k % 3]).abs() < 1e-7 * (1. + slope.abs()), "{k}: {slope}");
            for j in 0..12 {
                let slope = (hi.1[j / 3][j % 3] - lo.1[j / 3][j % 3]) / (2. * h);
                assert!(
                    (slope - here.hessian[(j, k)]).abs() < 1e-6 * scale,
                    "{j} {k}: {slope} {}",
                    here.hessian[(j, k)]
                );
            }
        }
        let projected = term(x, n_first, n, rest).derivatives(&BARRIER, x, Curvature::Projected).hessian;
        let least = projected.symmetric_eigenvalues().min();
        assert!(least > -1e-12 * scale, "{least}");
        let expected = positive_part(here.hessian);
        assert!((projected - expected).norm() < 1e-11 * scale, "{}", (projected - expected).norm() / scale);
    }

    #[test]
    fn a_vertex_has_the_derivatives_of_its_energy_against_every_feature() {
        let mut random = Random(3);
        for _ in 0..20 {
            let x: [Vec3; 4] = std::array::from_fn(|_| random.point());
            (2..=4).for_each(|n| check(&x, 1, n, None));
        }
    }

    #[test]
    fn edges_have_the_derivatives_of_their_energy_in_every_region() {
        let mut random = Random(4);
        let mut regions = [0; 3];
        for _ in 0..80 {
            let x: [Vec3; 4] = std::array::from_fn(|_| random.point());
            regions[Separation::of_edges(&x).n_free] += 1;
            check(&x, 2, 4, None);
        }
        assert!(regions.iter().all(|n| *n > 3), "{regions:?}");
    }

    #[test]
    fn edges_that_are_nearly_parallel_have_the_derivatives_of_their_smoothed_energy() {
        let mut random = Random(5);
        for angle in [0.02, 0.01, 0.003] {
            let x = [
                Vec3::zeros(),
                Vec3::new(2., 0., 0.),
                Vec3::new(0.3, 0.4, -angle) + 1e-3 * random.point(),
                Vec3::new(2.3, 0.4, angle) + 1e-3 * random.point(),
            ];
            assert!(term(&x, 2, 4, Some(x)).mollifier.is_some());
            check(&x, 2, 4, Some(x));
        }
    }

    #[test]
    fn parallel_edges_push_each_other_not_at_all() {
        let x = [Vec3::zeros(), Vec3::x(), Vec3::new(0.2, 0.1, 0.), Vec3::new(1.2, 0.1, 0.)];
        let local = term(&x, 2, 4, Some(x)).derivatives(&BARRIER, &x, Curvature::Exact);
        assert_eq!(local.energy, 0.);
        assert!(local.gradient.iter().all(|g| g.norm() == 0.));
    }
}
