//! The left half of the face as a grid of columns and rows, from skull to skin.

use super::builder::Builder;
use super::parameters::Parameters;
use super::resolution::Resolution;
use crate::units::Vec3;

/// A miss below this is a hit, mm.
const FOUND_MM: f64 = 1e-9;

/// Depth (0 inner surface, 1 skin) of the lips behind which they turn away from each other.
const MEET: f64 = 0.75;

/// A place on the grid.
#[derive(Clone, Copy, Debug)]
pub(super) struct Place {
    /// Column, fractional.
    pub(super) column: f64,
    /// Row, fractional.
    pub(super) row: f64,
    /// Distance in the frontal plane between what was looked for and this place, mm.
    pub(super) miss: f64,
}

/// Positions on the left half, mid-line included; index `[column * rows + row]`.
#[derive(Clone, Debug)]
pub(super) struct Grid {
    /// Columns, first on the mid-line.
    pub(super) columns: usize,
    /// Rows, first at the bottom.
    pub(super) rows: usize,
    /// Column of the corner of the mouth: the slit ends there.
    pub(super) corner: usize,
    /// Row of the slit.
    pub(super) slit: usize,
    /// Cells through the thickness.
    pub(super) layers: usize,
    /// The featureless head, on which places are found by `(x, y)`.
    pub(super) base: Vec<Vec3>,
    /// The skin.
    pub(super) skin: Vec<Vec3>,
    /// The inner surface as the upper jaw, and as the lower jaw: they differ on the slit's row only.
    inner: [Vec<Vec3>; 2],
    /// Share of vestibule at each inner point: 1 behind lips and cheeks, 0 on bone.
    pub(super) vestibule: Vec<f64>,
    gap: f64,
    /// How far each inner point is turned up or down, away from the slit, of the upper and the lower lip.
    turned: [Vec<f64>; 2],
    /// Least and greatest `(x, y)` of each cell of `base`, cell `column * (rows - 1) + row`.
    boxes: Vec<[[f64; 2]; 2]>,
}

impl Grid {
    /// The grid of a face.
    pub(super) fn new(parameters: &Parameters, resolution: &Resolution) -> Self {
        let builder = Builder::new(parameters, resolution);
        let (columns, rows) = (builder.columns(), builder.labels.len());
        let mut grid = Self {
            columns,
            rows,
            corner: resolution.mouth_columns,
            slit: resolution.rows_below.iter().sum(),
            layers: resolution.layers,
            base: Vec::with_capacity(columns * rows),
            skin: Vec::with_capacity(columns * rows),
            inner: [Vec::with_capacity(columns * rows), Vec::with_capacity(columns * rows)],
            vestibule: Vec::with_capacity(columns * rows),
            gap: parameters.slit_gap_mm,
            turned: [Vec::with_capacity(columns * rows), Vec::with_capacity(columns * rows)],
            boxes: Vec::with_capacity(columns * rows),
        };
        for column in 0..columns {
            for row in 0..rows {
                let station = builder.station(column, row);
                grid.base.push(station.base);
                grid.skin.push(builder.skin(&station));
                let share = builder.vestibule_share(&station);
                grid.vestibule.push(share);
                for (half, inner) in grid.inner.iter_mut().enumerate() {
                    let upper = if row == grid.slit { half == 0 } else { row > grid.slit };
                    let turned = builder.turned(column, row, upper);
                    inner.push(builder.inner(&station, share, upper, turned));
                    grid.turned[half].push(turned);
                }
            }
        }
        for column in 0..columns.min(1) {
            for k in column * rows..(column + 1) * rows {
                for sheet in [&mut grid.base, &mut grid.skin] {
                    sheet[k].x = 0.0;
                }
                for sheet in &mut grid.inner {
                    sheet[k].x = 0.0;
                }
            }
        }
        for column in 0..columns - 1 {
            for row in 0..rows - 1 {
                let corners = corners(&grid.base, rows, column, row);
                grid.boxes.push(corners.iter().fold([[f64::MAX; 2], [f64::MIN; 2]], |[lo, hi], p| {
                    [[lo[0].min(p.x), lo[1].min(p.y)], [hi[0].max(p.x), hi[1].max(p.y)]]
                }));
            }
        }
        grid
    }

    /// Whether the node of the slit's row in `column` is doubled.
    pub(super) fn is_split(&self, column: usize, row: usize) -> bool {
        row == self.slit && column < self.corner
    }

    /// The point of `column`, `row` at `depth` (0 inner surface, 1 skin), on the upper or lower
    /// side of the slit.
    pub(super) fn point(&self, column: usize, row: usize, depth: f64, upper: bool) -> Vec3 {
        let k = column * self.rows + row;
        let upper = if row == self.slit { upper } else { row > self.slit };
        let inner = self.inner[usize::from(!upper)][k];
        let mut point = inner + depth * (self.skin[k] - inner);
        if self.is_split(column, row) {
            let t = column as f64 / self.corner as f64;
            let half = 0.5 * self.gap * (1.0 - t * t);
            point.y += if upper { half } else { -half };
        }
        point.y += self.turned[usize::from(!upper)][k] * (1.0 - depth / MEET).max(0.0).powi(2);
        point
    }

    /// Grid coordinates `(column, row)`, fractional, of the place whose featureless head point has
    /// this `(x, y)`, `x >= 0`; off the map, the nearest within its border cells.
    pub(super) fn locate(&self, x: f64, y: f64) -> Place {
        let mut best = Place { column: 0.0, row: 0.0, miss: f64::INFINITY };
        // Cells whose box holds the place come first: nearly always one of them has it.
        for holding in [true, false] {
            for (cell, [lo, hi]) in self.boxes.iter().enumerate() {
                let (dx, dy) = ((lo[0] - x).max(x - hi[0]).max(0.0), (lo[1] - y).max(y - hi[1]).max(0.0));
                if holding != (dx == 0.0 && dy == 0.0) || dx.hypot(dy) >= best.miss {
                    continue;
                }
                let (column, row) = (cell / (self.rows - 1), cell % (self.rows - 1));
                let corners = corners(&self.base, self.rows, column, row);
                let (s, t) = unbilinear(&corners, x, y);
                let (s, t) = (s.clamp(0.0, 1.0), t.clamp(0.0, 1.0));
                let p = bilinear(&corners, s, t);
                let miss = (p.x - x).hypot(p.y - y);
                if miss < best.miss {
                    best = Place { column: column as f64 + s, row: row as f64 + t, miss };
                }
            }
            if best.miss < FOUND_MM {
                break;
            }
        }
        best
    }

    /// The four columns and rows around `place` with their bilinear weights.
    pub(super) fn around(&self, place: Place) -> [(usize, usize, f64); 4] {
        let column = (place.column.floor() as usize).min(self.columns - 2);
        let row = (place.row.floor() as usize).min(self.rows - 2);
        let (s, t) = (place.column - column as f64, place.row - row as f64);
        [
            (column, row, (1.0 - s) * (1.0 - t)),
            (column + 1, row, s * (1.0 - t)),
            (column + 1, row + 1, s * t),
            (column, row + 1, (1.0 - s) * t),
        ]
    }

    /// The tissue point at `place` and `depth` (0 inner surface, 1 skin): the trilinear map of the
    /// cell there, so the point is inside the mesh by construction.
    pub(super) fn tissue(&self, place: Place, depth: f64) -> Vec3 {
        let around = self.around(place);
        let upper = around[0].1 >= self.slit;
        around.iter().map(|&(column, row, weight)| weight * self.point(column, row, depth, upper)).sum()
    }
}

/// Corners of a cell of `sheet`, counter-clockwise.
fn corners(sheet: &[Vec3], rows: usize, column: usize, row: usize) -> [Vec3; 4] {
    let at = |i: usize, j: usize| sheet[(column + i) * rows + row + j];
    [at(0, 0), at(1, 0), at(1, 1), at(0, 1)]
}

/// The bilinear patch over `corners` (counter-clockwise) at `(s, t)`.
fn bilinear(corners: &[Vec3; 4], s: f64, t: f64) -> Vec3 {
    (1.0 - s) * (1.0 - t) * corners[0]
        + s * (1.0 - t) * corners[1]
        + s * t * corners[2]
        + (1.0 - s) * t * corners[3]
}

/// Where the patch has this `(x, y)`, by Newton from its middle.
fn unbilinear(corners: &[Vec3; 4], x: f64, y: f64) -> (f64, f64) {
    let (mut s, mut t) = (0.5, 0.5);
    for _ in 0..12 {
        let p = bilinear(corners, s, t);
        let ds = (1.0 - t) * (corners[1] - corners[0]) + t * (corners[2] - corners[3]);
        let dt = (1.0 - s) * (corners[3] - corners[0]) + s * (corners[2] - corners[1]);
        let det = ds.x * dt.y - ds.y * dt.x;
        if det.abs() < 1e-12 {
            break;
        }
        let (ex, ey) = (x - p.x, y - p.y);
        s += ((ex * dt.y - ey * dt.x) / det).clamp(-1.0, 1.0);
        t += ((ds.x * ey - ds.y * ex) / det).clamp(-1.0, 1.0);
    }
    (s, t)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::face::standard::relief::Relief;

    fn grid() -> Grid {
        Grid::new(&Parameters::default(), &Resolution::COARSE)
    }

    #[test]
    fn places_are_found_again() {
        let grid = grid();
        for (x, y) in [(0.0, 21.4), (7.3, 11.0), (25.35, -1.6), (40.0, 20.0), (56.0, -2.0), (30.0, -35.0)] {
            let place = grid.locate(x, y);
            assert!(place.miss < 1e-9, "{x} {y}: {place:?}");
            let p: Vec3 = grid
                .around(place)
                .iter()
                .map(|&(column, row, weight)| weight * grid.base[column * grid.rows + row])
                .sum();
            assert!((p.x - x).hypot(p.y - y) < 1e-9);
        }
    }

    #[test]
    fn rows_follow_the_slit_and_the_borders() {
        let grid = grid();
        let relief = Relief::new(&Parameters::default());
        for column in 0..=grid.corner {
            let p = grid.base[column * grid.rows + grid.slit];
            assert!((p.y - relief.slit(p.x)).abs() < 0.05, "{p:?}");
        }
        let border = grid.base[grid.slit + Resolution::COARSE.rows_above[0]];
        assert!((border.y - 10.1).abs() < 0.2, "{border:?}");
    }
}
