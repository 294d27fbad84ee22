//! Soft-tissue depth between the featureless head and the skull.

use super::curve::Curve;

/// Half widths of the table's columns, mm.
const X: [f64; 7] = [0.0, 12.0, 25.0, 35.0, 45.0, 55.0, 70.0];
/// Heights of the rows, and depths, mm. Skin depth is this plus the relief: upper lip 12 at the
/// subnasale, pogonion 11.5 to 13.4, mid-cheek 20 to 26, zygoma 6 to 10, gonial 10 to 16.
const DEPTH: [(f64, [f64; 7]); 11] = [
    (-52.0, [8.0, 8.0, 8.0, 8.0, 8.0, 9.0, 9.0]),
    (-42.0, [9.0, 9.0, 9.0, 9.0, 9.0, 10.0, 10.0]),
    (-30.0, [11.0, 10.5, 10.5, 11.0, 12.0, 12.0, 12.0]),
    (-18.0, [9.5, 10.0, 11.0, 13.5, 16.0, 16.0, 14.0]),
    (-8.0, [9.0, 10.0, 12.0, 16.5, 20.0, 20.0, 16.0]),
    (8.0, [9.0, 10.0, 13.0, 17.5, 21.0, 21.0, 17.0]),
    (21.0, [9.0, 11.0, 15.0, 17.0, 18.0, 17.0, 15.0]),
    (30.0, [8.5, 10.5, 14.0, 15.0, 14.0, 13.0, 13.0]),
    (42.0, [8.0, 9.0, 11.0, 11.0, 9.5, 9.0, 11.0]),
    (52.0, [7.0, 7.5, 8.5, 8.5, 8.5, 9.0, 10.0]),
    (60.0, [7.0, 7.0, 7.5, 7.5, 8.0, 9.0, 10.0]),
];

/// Depth of the skull under the featureless head.
#[derive(Clone, Debug)]
pub(super) struct Thickness {
    rows: Vec<(f64, Curve)>,
}

impl Thickness {
    /// The table above, interpolated by monotone cubics.
    pub(super) fn new() -> Self {
        let row = |depths: [f64; 7]| {
            let knots: Vec<_> = X.into_iter().zip(depths).collect();
            Curve::monotone(&knots)
        };
        Self { rows: DEPTH.map(|(y, depths)| (y, row(depths))).into() }
    }

    /// Depth at half width `x` and height `y`, mm.
    pub(super) fn at(&self, x: f64, y: f64) -> f64 {
        let knots: Vec<_> = self.rows.iter().map(|(height, row)| (*height, row.at(x))).collect();
        Curve::monotone(&knots).at(y)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_table_is_kept_at_its_knots_and_never_overshot() {
        let thickness = Thickness::new();
        for (y, depths) in DEPTH {
            for (x, depth) in X.into_iter().zip(depths) {
                assert!((thickness.at(x, y) - depth).abs() < 1e-12);
            }
        }
        for k in 0..2000 {
            let (x, y) = (f64::from(k % 71), f64::from(k / 71) * 4.0 - 52.0);
            assert!((6.999..21.001).contains(&thickness.at(x, y)), "{x} {y}");
        }
    }
}
