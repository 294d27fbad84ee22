//! Quadrature rules of the cell kinds.

use crate::mesh::CellKind;
use crate::units::Vec3;

/// A point of a rule: reference coordinates and weight.
pub(crate) type RulePoint = (Vec3, f64);

/// The rule that integrates the stiffness of `kind`: 2x2x2 Gauss (Hex8), 3-point triangle times
/// 2-point Gauss (Wedge6), one point (Tet4) and four points of degree 2 (Tet10).
///
/// Weights sum to the volume of the reference domain.
pub(crate) fn rule(kind: CellKind) -> Vec<RulePoint> {
    let g = 1. / 3f64.sqrt();
    match kind {
        CellKind::Hex8 => {
            let ends = [-g, g];
            let mut points = Vec::with_capacity(8);
            for z in ends {
                for y in ends {
                    for x in ends {
                        points.push((Vec3::new(x, y, z), 1.));
                    }
                }
            }
            points
        }
        CellKind::Wedge6 => {
            let triangle = [[1. / 6., 1. / 6.], [2. / 3., 1. / 6.], [1. / 6., 2. / 3.]];
            [-g, g].into_iter().flat_map(|z| triangle.map(|[r, s]| (Vec3::new(r, s, z), 1. / 6.))).collect()
        }
        CellKind::Tet4 => vec![(Vec3::repeat(0.25), 1. / 6.)],
        CellKind::Tet10 => {
            let (a, b) = ((5. - 5f64.sqrt()) / 20., (5. + 3. * 5f64.sqrt()) / 20.);
            [[a, a, a], [b, a, a], [a, b, a], [a, a, b]].map(|p| (Vec3::from(p), 1. / 24.)).to_vec()
        }
    }
}
