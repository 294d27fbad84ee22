//! Triangles to samples, the nearest winning.

use rayon::prelude::*;

use super::Projected;

/// Steps of a pixel at which corners are held: edges are then exact integers, and two triangles that share
/// one never both take a sample, nor both leave it.
const STEPS: f64 = 256.;
/// Corners farther off than this many pixels are refused: their edges would overflow.
const FARTHEST: f64 = 1e6;
/// Rows to a piece of parallel work.
const BAND: usize = 16;

/// What one sample sees.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Hit {
    /// Position of the triangle in the list.
    pub triangle: u32,
    /// Weights of its corners, which sum to one.
    pub weights: [f32; 3],
    /// Height towards the viewer, mm.
    pub depth: f32,
}

/// The samples of one set of triangles, row by row from the upper left.
#[derive(Clone, Debug)]
pub struct Layer {
    /// Samples to a row.
    pub width: usize,
    /// Rows.
    pub height: usize,
    /// What each sample sees.
    pub hits: Vec<Option<Hit>>,
}

impl Layer {
    /// The nearest of `triangles` at the middle of each of `width` x `height` samples; of equally near ones
    /// the first. Both sides of a triangle are drawn. The same whatever the number of threads.
    pub fn new(width: usize, height: usize, triangles: &[[Projected; 3]]) -> Self {
        let edges: Vec<Option<Fixed>> = triangles.iter().map(Fixed::new).collect();
        let mut hits = vec![None; width * height];
        hits.par_chunks_mut((BAND * width).max(1)).enumerate().for_each(|(band, hits)| {
            let first = band * BAND;
            let rows = first..first + hits.len() / width;
            for (index, fixed) in edges.iter().enumerate() {
                if let Some(fixed) = fixed {
                    fixed.draw(index as u32, &triangles[index], width, rows.clone(), hits);
                }
            }
        });
        Self { width, height, hits }
    }
}

/// A triangle with its corners on the grid of steps, counter-clockwise in (x, y).
struct Fixed {
    corners: [[i64; 2]; 3],
    /// Which corner of the given triangle each is.
    order: [usize; 3],
    area: i64,
}

impl Fixed {
    fn new(triangle: &[Projected; 3]) -> Option<Self> {
        let far = |p: &Projected| !(p.x.abs() < FARTHEST && p.y.abs() < FARTHEST && p.depth.is_finite());
        if triangle.iter().any(far) {
            return None;
        }
        let mut corners = triangle.map(|p| [p.x, p.y].map(|c| (c * STEPS).round() as i64));
        let mut order = [0, 1, 2];
        let mut area = cross(corners[0], corners[1], corners[2]);
        if area < 0 {
            corners.swap(1, 2);
            order.swap(1, 2);
            area = -area;
        }
        (area > 0).then_some(Self { corners, order, area })
    }

    fn draw(
        &self,
        index: u32,
        triangle: &[Projected; 3],
        width: usize,
        rows: std::ops::Range<usize>,
        hits: &mut [Option<Hit>],
    ) {
        let step = STEPS as i64;
        let half = step / 2;
        let span = |axis: usize, below: usize| {
            let along = self.corners.map(|c| c[axis]);
            let lo = along.iter().min().map_or(0, |lo| (lo - half).div_euclid(step));
            let hi = along.iter().max().map_or(0, |hi| (hi - half).div_euclid(step) + 1);
            lo.clamp(0, below as i64) as usize..(hi + 1).clamp(0, below as i64) as usize
        };
        let (across, down) = (span(0, width), span(1, rows.end));
        // A sample on an edge belongs to the triangle to whose left or upper side the edge is.
        let owed = |k: usize| {
            let (a, b) = (self.corners[k], self.corners[(k + 1) % 3]);
            let (dx, dy) = (b[0] - a[0], b[1] - a[1]);
            i64::from(!(dy < 0 || (dy == 0 && dx > 0)))
        };
        let owed = [owed(0), owed(1), owed(2)];
        let reciprocal = 1. / self.area as f64;
        for row in down.start.max(rows.start)..down.end {
            for column in across.clone() {
                let p = [column as i64 * step + half, row as i64 * step + half];
                let edge = |k: usize| cross(self.corners[k], self.corners[(k + 1) % 3], p);
                let sides = [edge(0), edge(1), edge(2)];
                if (0..3).any(|k| sides[k] < owed[k]) {
                    continue;
                }
                let mut weights = [0.; 3];
                for k in 0..3 {
                    // The edge across from a corner gives the corner's weight.
                    weights[self.order[k]] = sides[(k + 1) % 3] as f64 * reciprocal;
                }
                let depth = (0..3).map(|k| weights[k] * triangle[k].depth).sum::<f64>() as f32;
                let hit = &mut hits[(row - rows.start) * width + column];
                if hit.is_none_or(|nearest: Hit| depth > nearest.depth) {
                    *hit = Some(Hit { triangle: index, weights: weights.map(|w| w as f32), depth });
                }
            }
        }
    }
}

fn cross(a: [i64; 2], b: [i64; 2], c: [i64; 2]) -> i64 {
    (b[0] - a[0]) * (c[1] - a[1]) - (b[1] - a[1]) * (c[0] - a[0])
}

#[cfg(test)]
mod tests {
    use super::*;

    fn at(x: f64, y: f64, depth: f64) -> Projected {
        Projected { x, y, depth }
    }

    fn count(layer: &Layer) -> usize {
        layer.hits.iter().flatten().count()
    }

    #[test]
    fn a_triangle_covers_the_samples_whose_middles_are_inside() {
        let half = [at(0., 0., 0.), at(10., 0., 0.), at(0., 10., 0.)];
        let layer = Layer::new(12, 12, &[half]);
        for row in 0..12 {
            for column in 0..12 {
                let inside = column + row < 9;
                let on_the_edge = column + row == 9;
                let hit = layer.hits[12 * row + column].is_some();
                assert!(on_the_edge || hit == inside, "{column} {row}");
            }
        }
        let turned = [half[0], half[2], half[1]];
        assert_eq!(count(&Layer::new(12, 12, &[turned])), count(&layer), "both sides are drawn");
    }

    #[test]
    fn a_fan_takes_every_sample_of_its_outline_once() {
        // Corners on sample middles and edges through them are the hard cases.
        let rim = [at(0.5, 0.5, 0.), at(20.5, 0.5, 0.), at(20.5, 20.5, 0.), at(0.5, 20.5, 0.)];
        for hub in [at(10.5, 10.5, 0.), at(3.25, 17.1, 0.), at(0.5, 10.5, 0.)] {
            let fan: Vec<[Projected; 3]> = (0..4).map(|k| [rim[k], rim[(k + 1) % 4], hub]).collect();
            let apart: usize = fan.iter().map(|t| count(&Layer::new(24, 24, &[*t]))).sum();
            assert_eq!(apart, 400, "{hub:?}");
            assert_eq!(count(&Layer::new(24, 24, &fan)), 400, "{hub:?}");
        }
    }

    #[test]
    fn the_nearer_hides_the_farther_in_either_order() {
        let square = |depth: f64| [at(0., 0., depth), at(30., 0., depth), at(0., 30., depth)];
        for (order, nearest) in [([1., 2.], 1), ([2., 1.], 0), ([2., 2.], 0)] {
            let layer = Layer::new(8, 8, &order.map(square));
            assert!(layer.hits.iter().flatten().all(|h| h.triangle == nearest && h.depth == 2.));
        }
    }

    #[test]
    fn weights_give_back_the_sample() {
        let t = [at(1., 2., 3.), at(19., 4., -2.), at(6., 17., 8.)];
        let layer = Layer::new(20, 20, &[t]);
        assert!(count(&layer) > 50);
        for (k, hit) in layer.hits.iter().enumerate().filter_map(|(k, h)| h.map(|h| (k, h))) {
            let x: f64 = (0..3).map(|c| f64::from(hit.weights[c]) * t[c].x).sum();
            let y: f64 = (0..3).map(|c| f64::from(hit.weights[c]) * t[c].y).sum();
            assert!((x - (k % 20) as f64 - 0.5).abs() < 0.02 && (y - (k / 20) as f64 - 0.5).abs() < 0.02);
        }
    }

    #[test]
    fn what_cannot_be_drawn_is_left_out() {
        let nan = [at(f64::NAN, 0., 0.), at(5., 0., 0.), at(0., 5., 0.)];
        let far = [at(1e12, 0., 0.), at(5., 0., 0.), at(0., 5., 0.)];
        let flat = [at(0., 0., 0.), at(5., 5., 0.), at(9., 9., 0.)];
        assert_eq!(count(&Layer::new(8, 8, &[nan, far, flat])), 0);
    }
}
