//! The muscles of the standard face.

use super::curve::Curve;
use super::grid::Grid;
use super::parameters::Parameters;
use crate::face::{Fibre, Muscle};
use crate::units::Vec3;

/// Spacing of fibre points, mm.
const SPACING_MM: f64 = 1.0;
/// Fewest fibres in a bundle, and their spacing across it in wider ones, mm.
const LEAST_FIBRES: usize = 5;
const FIBRE_SPACING_MM: f64 = 2.0;

/// A muscle of the left side, or the left half of a ring.
struct Row {
    name: &'static str,
    kind: Kind,
    /// Physiological cross-section, mm2.
    area: f64,
    radius: f64,
    insertion: f64,
    /// From origin to insertion (a ring: from the upper to the lower mid-line): `x`, `y` on the
    /// head seen from the front, depth from bone (0) to skin (1), half width of the bundle; mm.
    path: &'static [[f64; 4]],
}

#[derive(PartialEq)]
enum Kind {
    Paired,
    Ring,
}
use Kind::{Paired, Ring};

/// Courses after the anatomy of the public face model and textbooks, where the muscles of the modiolus run on
/// past it into the lips and give up their tension there; cross-sections from widths
/// and thicknesses there. Radii are half the thickness or what the coarse grid needs to see them.
const TABLE: &[Row] = &[
    Row {
        name: "zygomaticus_major",
        kind: Paired,
        area: 20.0,
        radius: 1.6,
        insertion: 14.0,
        path: &[
            [50.0, 42.0, 0.02, 4.2],
            [44.0, 30.0, 0.4, 4.2],
            [37.0, 16.0, 0.55, 4.0],
            [31.5, 6.3, 0.56, 3.6],
            [25.2, 0.6, 0.52, 3.2],
        ],
    },
    Row {
        name: "zygomaticus_minor",
        kind: Paired,
        area: 8.0,
        radius: 1.3,
        insertion: 14.0,
        path: &[
            [37.5, 47.0, 0.02, 2.5],
            [31.0, 34.0, 0.4, 2.8],
            [24.5, 22.0, 0.6, 3.2],
            [16.6, 9.4, 0.66, 3.6],
        ],
    },
    Row {
        name: "levator_labii_superioris",
        kind: Paired,
        area: 24.0,
        radius: 1.7,
        insertion: 14.0,
        path: &[
            [26.5, 51.0, 0.02, 6.0],
            [24.5, 40.0, 0.35, 5.6],
            [19.5, 24.0, 0.52, 5.4],
            [8.8, 8.2, 0.62, 6.2],
        ],
    },
    Row {
        name: "levator_labii_superioris_alaeque_nasi",
        kind: Paired,
        area: 10.0,
        radius: 1.3,
        insertion: 16.0,
        path: &[
            [14.0, 54.0, 0.05, 2.5],
            [16.5, 44.0, 0.3, 2.5],
            [18.6, 31.0, 0.45, 2.5],
            [18.2, 14.5, 0.62, 2.5],
        ],
    },
    Row {
        name: "levator_anguli_oris",
        kind: Paired,
        area: 16.0,
        radius: 1.4,
        insertion: 14.0,
        path: &[
            [25.0, 34.0, 0.02, 4.0],
            [27.5, 23.0, 0.2, 4.0],
            [29.0, 10.5, 0.35, 3.4],
            [27.2, -3.2, 0.46, 3.0],
        ],
    },
    Row {
        name: "risorius",
        kind: Paired,
        area: 6.0,
        radius: 1.3,
        insertion: 14.0,
        path: &[
            [58.0, -1.0, 0.75, 3.0],
            [48.0, -1.5, 0.75, 3.0],
            [38.0, -1.2, 0.7, 3.0],
            [25.0, -1.4, 0.55, 2.6],
        ],
    },
    Row {
        name: "buccinator",
        kind: Paired,
        area: 45.0,
        radius: 1.5,
        insertion: 14.0,
        path: &[
            [56.0, -1.0, 0.05, 10.0],
            [48.0, -1.0, 0.2, 10.0],
            [39.5, -1.2, 0.32, 8.5],
            [32.5, -1.4, 0.42, 6.0],
            [24.0, -1.5, 0.46, 4.6],
        ],
    },
    Row {
        name: "depressor_anguli_oris",
        kind: Paired,
        area: 24.0,
        radius: 1.4,
        insertion: 14.0,
        path: &[
            [28.5, -37.0, 0.05, 5.5],
            [30.0, -27.0, 0.45, 5.0],
            [30.0, -13.0, 0.66, 4.0],
            [27.0, 0.8, 0.6, 3.0],
        ],
    },
    Row {
        name: "depressor_labii_inferioris",
        kind: Paired,
        area: 24.0,
        radius: 1.4,
        insertion: 12.0,
        path: &[
            [21.0, -37.0, 0.05, 6.0],
            [18.5, -28.0, 0.4, 5.6],
            [13.0, -18.5, 0.52, 5.6],
            [8.2, -8.6, 0.62, 5.8],
        ],
    },
    Row {
        name: "mentalis",
        kind: Paired,
        area: 30.0,
        radius: 1.8,
        insertion: 8.0,
        path: &[[5.0, -19.0, 0.04, 2.8], [6.0, -25.0, 0.35, 3.2], [6.5, -32.0, 0.88, 3.6]],
    },
    Row {
        name: "orbicularis_oris_peripheralis",
        kind: Ring,
        area: 35.0,
        radius: 2.4,
        insertion: 0.0,
        path: &[
            [0.0, 12.5, 0.5, 4.5],
            [15.0, 11.2, 0.5, 4.5],
            [25.4, 6.2, 0.48, 3.8],
            [29.6, -1.2, 0.48, 2.4],
            [25.4, -7.2, 0.48, 3.8],
            [14.5, -9.6, 0.5, 4.6],
            [0.0, -9.8, 0.5, 4.6],
        ],
    },
    Row {
        name: "orbicularis_oris_marginalis",
        kind: Ring,
        area: 12.0,
        radius: 1.45,
        insertion: 0.0,
        path: &[
            [0.0, 5.2, 0.66, 2.0],
            [10.0, 5.6, 0.66, 2.0],
            [19.0, 4.0, 0.61, 1.6],
            [25.2, 2.0, 0.55, 1.0],
            [28.6, -1.6, 0.50, 0.7],
            [25.2, -5.2, 0.55, 1.0],
            [19.5, -6.2, 0.61, 1.6],
            [10.0, -6.8, 0.66, 2.0],
            [0.0, -6.8, 0.66, 2.0],
        ],
    },
    Row {
        name: "incisivus_superior",
        kind: Paired,
        area: 5.0,
        radius: 1.2,
        insertion: 10.0,
        path: &[[9.5, 16.0, 0.04, 1.5], [19.0, 11.0, 0.22, 1.5], [28.0, 2.0, 0.42, 1.3]],
    },
    Row {
        name: "incisivus_inferior",
        kind: Paired,
        area: 5.0,
        radius: 1.2,
        insertion: 10.0,
        path: &[[9.0, -17.5, 0.04, 1.5], [18.5, -12.0, 0.22, 1.5], [28.0, -3.6, 0.42, 1.3]],
    },
    Row {
        name: "platysma",
        kind: Paired,
        area: 25.0,
        radius: 1.3,
        insertion: 14.0,
        path: &[
            [43.0, -31.0, 0.86, 9.0],
            [40.0, -24.0, 0.84, 8.0],
            [34.5, -11.5, 0.72, 5.0],
            [28.5, -1.8, 0.6, 3.2],
        ],
    },
];

/// Every muscle, left before right, at `stress` N/mm2 of cross-section.
pub(super) fn muscles(grid: &Grid, parameters: &Parameters) -> Vec<Muscle> {
    let stress = parameters.muscle_stress_n_mm2;
    let mut muscles = Vec::new();
    for row in TABLE {
        let bundle = bundle(grid, row, parameters);
        let muscle = |name: String, fibres: Vec<Fibre>| Muscle {
            name,
            max_force_n: stress * row.area,
            radius_mm: row.radius,
            area_mm2: Some(row.area),
            insertion_mm: row.insertion,
            fibres,
        };
        let open = |points: Vec<Vec3>| Fibre { points, closed: false };
        if row.kind == Ring && parameters.orbicularis_quadrants {
            for (half, upper) in [("upper", true), ("lower", false)] {
                let left: Vec<_> = bundle.iter().map(|course| quadrant(course, upper)).collect();
                let right = left.iter().map(|points| open(points.iter().map(mirror).collect())).collect();
                muscles.push(muscle(format!("{}_{half}_l", row.name), left.into_iter().map(open).collect()));
                muscles.push(muscle(format!("{}_{half}_r", row.name), right));
            }
        } else if row.kind == Ring {
            let fibres = bundle.into_iter().map(|half| Fibre { points: ring(half), closed: true });
            muscles.push(muscle(row.name.into(), fibres.collect()));
        } else {
            let right = bundle.iter().map(|points| points.iter().map(mirror).collect());
            let right: Vec<Fibre> = right.map(open).collect();
            muscles.push(muscle(format!("{}_l", row.name), bundle.into_iter().map(open).collect()));
            muscles.push(muscle(format!("{}_r", row.name), right));
        }
    }
    muscles
}

/// The mirror image in the mid-sagittal plane.
fn mirror(p: &Vec3) -> Vec3 {
    Vec3::new(if p.x == 0.0 { 0.0 } else { -p.x }, p.y, p.z)
}

/// The upper or lower part of a ring's left half, from the mid-line to its widest point and back: both
/// parts end there, so that the four quadrants together are the ring.
fn quadrant(half: &[Vec3], upper: bool) -> Vec<Vec3> {
    let widest = (0..half.len()).max_by(|&a, &b| half[a].x.total_cmp(&half[b].x)).unwrap_or(0);
    let mut points = if upper { half[..=widest].to_vec() } else { half[widest..].to_vec() };
    let middle = if upper { 0 } else { points.len() - 1 };
    points[middle].x = 0.0;
    points
}

/// The closed ring whose left half runs from mid-line to mid-line.
fn ring(mut half: Vec<Vec3>) -> Vec<Vec3> {
    let last = half.len() - 1;
    (half[0].x, half[last].x) = (0.0, 0.0);
    let right: Vec<Vec3> = half[1..last].iter().rev().map(mirror).collect();
    half.extend(right);
    half
}

/// Fibres of the left side, side by side across the bundle.
fn bundle(grid: &Grid, row: &Row, parameters: &Parameters) -> Vec<Vec<Vec3>> {
    let widest = row.path.iter().fold(0.0, |w: f64, p| w.max(2.0 * p[3]));
    let fibres = LEAST_FIBRES.max(1 + (widest / FIBRE_SPACING_MM).round() as usize);
    let course = Course::new(row, parameters);
    (0..fibres)
        .map(|k| {
            let across = 2.0 * k as f64 / (fibres - 1) as f64 - 1.0;
            fibre(|t| course.at(grid, t, across))
        })
        .collect()
}

/// Points about [`SPACING_MM`] apart on the curve `at(t)`, `t` in `[0, 1]`.
fn fibre(at: impl Fn(f64) -> Vec3) -> Vec<Vec3> {
    const FINE: u32 = 60;
    let parameter = |k: u32| f64::from(k) / f64::from(FINE);
    let fine: Vec<Vec3> = (0..=FINE).map(|k| at(parameter(k))).collect();
    let mut arc = vec![(0.0, 0.0)];
    for k in 1..=FINE {
        let i = k as usize;
        arc.push((arc[i - 1].0 + (fine[i] - fine[i - 1]).norm(), parameter(k)));
    }
    let length = arc[arc.len() - 1].0;
    let pieces = (length / SPACING_MM).round().max(2.0);
    let inverse = Curve::monotone(&arc);
    (0..=pieces as u32).map(|k| at(inverse.at(length * f64::from(k) / pieces))).collect()
}

/// A row's path as smooth curves of a parameter in `[0, 1]`.
struct Course {
    curves: [Curve; 4],
    start: f64,
    length: f64,
}

impl Course {
    fn new(row: &Row, parameters: &Parameters) -> Self {
        let drawn = row.path.iter().map(|&[x, y, depth, half_width]| {
            let (x, y) = parameters.moved(x, y);
            [x, y, depth, half_width]
        });
        let mut path: Vec<[f64; 4]> = drawn.collect();
        let (second, third) = (path[1], path[2]);
        if row.kind == Ring {
            // Mirrored neighbours beyond the mid-line make the ring smooth there.
            let n = path.len();
            let image = |p: [f64; 4]| [-p[0], p[1], p[2], p[3]];
            path.extend([image(path[n - 2]), image(path[n - 3])]);
            path.splice(0..0, [image(third), image(second)]);
        }
        let mut at = vec![0.0];
        for k in 1..path.len() {
            at.push(at[k - 1] + (path[k][0] - path[k - 1][0]).hypot(path[k][1] - path[k - 1][1]));
        }
        let (first, last) = if row.kind == Ring { (2, path.len() - 3) } else { (0, path.len() - 1) };
        let knots = |c: usize| -> Vec<_> { at.iter().copied().zip(path.iter().map(|p| p[c])).collect() };
        Self {
            curves: [0, 1, 2, 3].map(|c| Curve::natural(&knots(c))),
            start: at[first],
            length: at[last] - at[first],
        }
    }

    /// The tissue point at `t`, `across` (-1 to 1) the bundle.
    fn at(&self, grid: &Grid, t: f64, across: f64) -> Vec3 {
        let s = self.start + t * self.length;
        let [x, y, depth, half_width] = &self.curves;
        let h = 0.25;
        let (dx, dy) = (x.at(s + h) - x.at(s - h), y.at(s + h) - y.at(s - h));
        let off = across * half_width.at(s) / dx.hypot(dy);
        let place = grid.locate((x.at(s) + off * dy).max(0.0), y.at(s) - off * dx);
        grid.tissue(place, depth.at(s).clamp(0.02, 0.95))
    }
}
