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
