//! How far a model is from the face that it stands for.

use nalgebra::{DMatrix, DVector};

use crate::units::Vec3;

/// How far what a muscle does in another, as good a model is from what it does here: what a noise of the markers leaves
/// out.
///
/// Each muscle's column `F_m` of the map is taken to be `(1 + s) F_m + e`, where the strength `s` has the standard
/// deviation [`strength`](Self::strength), and the field `e` at a point has that of [`shape`](Self::shape) times the
/// movement `|F_m|` there, the same in every direction, with a correlation `exp(-d^2 / 2 l^2)` between points at the
/// distance `d`; muscles are independent. Errors so act where and as much as muscles act.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Discrepancy {
    /// Relative standard deviation of what a muscle does as a whole.
    pub strength: f64,
    /// Relative standard deviation of its movement from point to point, its length over the three directions.
    pub shape: f64,
    /// Length `l` over which the errors of points go together, mm.
    pub length_mm: f64,
}

impl Discrepancy {
    /// The model is the face: only for what was computed with itself.
    pub const NONE: Self = Self { strength: 0., shape: 0., length_mm: 15. };
    /// The face is known, its mesh is another one. Measured between the resolutions of the standard face; `docs/recovery.md`.
    pub const MESH: Self = Self { strength: 0.05, shape: 0.1, length_mm: 12. };
    /// The muscles are another anatomist's. Measured between two sets of muscles of one face; `docs/recovery.md`.
    pub const ANATOMY: Self = Self { strength: 0.4, shape: 0.6, length_mm: 15. };

    /// The names accepted at interfaces.
    pub const NAMES: [&'static str; 3] = ["none", "mesh", "anatomy"];

    /// The one called `name`, or `None`.
    pub fn parse(name: &str) -> Option<Self> {
        match name {
            "none" => Some(Self::NONE),
            "mesh" => Some(Self::MESH),
            "anatomy" => Some(Self::ANATOMY),
            _ => None,
        }
    }

    /// Covariance (d x d), mm^2, of the displacements of the points at rest at `points` (p), which activations whose
    /// expected squares are `squares` (m) move by the first `m` columns of `map` (d x n).
    pub fn covariance(&self, points: &[Vec3], map: &DMatrix<f64>, squares: &DVector<f64>) -> DMatrix<f64> {
        let d = map.nrows();
        let mut covariance = DMatrix::zeros(d, d);
        let near = DMatrix::from_fn(points.len(), points.len(), |p, q| {
            let apart = (points[p] - points[q]).norm() / self.length_mm;
            (-0.5 * apart * apart).exp()
        });
        for (column, &square) in map.column_iter().zip(squares.iter()).filter(|(_, square)| **square != 0.) {
            covariance.ger(self.strength.powi(2) * square, &column, &column, 1.);
            let size: Vec<f64> = (0..points.len()).map(|p| column.rows(3 * p, 3).norm()).collect();
            let share = self.shape.powi(2) * square / 3.;
            for p in 0..points.len() {
                for q in 0..points.len() {
                    let common = share * near[(p, q)] * size[p] * size[q];
                    (0..3).for_each(|k| covariance[(3 * p + k, 3 * q + k)] += common);
                }
            }
        }
        covariance
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Two points 10 mm apart, moved by 3 and 4 mm in different directions by one muscle whose expected square is 1/4.
    #[test]
    fn the_covariance_is_that_of_a_strength_and_of_a_field() {
        let map = DMatrix::from_column_slice(6, 1, &[3., 0., 0., 0., 4., 0.]);
        let points = [Vec3::zeros(), Vec3::new(0., 10., 0.)];
        let off = Discrepancy { strength: 0.2, shape: 0.6, length_mm: 10. };
        let found = off.covariance(&points, &map, &DVector::from_element(1, 0.25));
        // Of the field: (0.6 x 3)^2 / 4 over the three directions together.
        let field: f64 = (0..3).map(|k| found[(k, k)]).sum::<f64>() - 0.04 * 0.25 * 9.;
        assert!((field - 0.36 * 9. / 4.).abs() < 1e-12, "{field}");
        // Across: the strength alone between x here and y there, the field alone between x here and x there.
        assert!((found[(0, 4)] - 0.04 * 0.25 * 12.).abs() < 1e-12);
        assert!((found[(0, 3)] - 0.12 * 0.25 * 12. * (-0.5f64).exp()).abs() < 1e-12);
        assert!((&found - found.transpose()).amax() < 1e-15);
    }
}
