//! The head without nose, lips and chin: one smooth section curve per height.

use super::curve::{Curve, step};
use crate::units::Vec3;

/// Pieces of the polyline that stands for a section.
const PIECES: u32 = 240;
/// Where the section stops, as a fraction of its depth short of its widest point.
const EDGE: f64 = 0.12;

/// Lowest and highest label of the map, mm.
pub(super) const LABELS: (f64, f64) = (-68.0, 72.0);

/// The family of sections. A section's label is its height at the mid-line; below the chin labels
/// run on along the underside, so that the family never folds.
#[derive(Clone, Debug)]
pub(super) struct Sections {
    mid_y: Curve,
    mid_z: Curve,
    side_x: Curve,
    side_y: Curve,
    side_z: Curve,
    exponent: Curve,
}

impl Sections {
    /// Knots: label; mid-line height and depth; half width, height and depth at the side; exponent
    /// of the superellipse. Drawn for a bizygomatic breadth of 134 mm and a bigonial of 107.
    pub(super) fn new() -> Self {
        const KNOTS: [[f64; 7]; 13] = [
            [-70.0, -50.6, -35.5, 46.0, -38.0, -80.0, 2.00],
            [-60.0, -49.0, -25.8, 51.0, -32.0, -82.0, 1.92],
            [-52.0, -46.8, -18.2, 55.0, -26.0, -83.5, 1.86],
            [-45.0, -43.2, -11.4, 57.8, -20.5, -84.5, 1.83],
            [-38.0, -37.8, -7.2, 60.0, -15.0, -85.5, 1.82],
            [-30.0, -30.0, -4.6, 61.8, -9.0, -86.5, 1.83],
            [-18.0, -18.0, -2.2, 64.4, -1.0, -87.5, 1.88],
            [0.0, 0.0, 0.0, 67.4, 9.0, -89.0, 1.95],
            [14.0, 14.0, -0.6, 69.4, 18.5, -90.5, 2.05],
            [30.0, 30.0, -5.4, 71.4, 30.5, -92.0, 2.28],
            [45.0, 45.0, -11.2, 72.8, 43.5, -93.0, 2.52],
            [60.0, 60.0, -17.0, 73.6, 57.0, -94.0, 2.66],
            [75.0, 75.0, -22.0, 74.0, 72.0, -94.5, 2.70],
        ];
        let column = |c: usize| Curve::natural(&KNOTS.map(|k| (k[0], k[c])));
        Self {
            mid_y: column(1),
            mid_z: column(2),
            side_x: column(3),
            side_y: column(4),
            side_z: column(5),
            exponent: column(6),
        }
    }

    /// The section labelled `label`.
    pub(super) fn section(&self, label: f64) -> Section {
        let (width, front, back) = (self.side_x.at(label), self.mid_z.at(label), self.side_z.at(label));
        let power = 2.0 / self.exponent.at(label);
        let widest = EDGE.powf(1.0 / power).acos();
        let outline: Vec<(f64, f64)> = (0..=PIECES)
            .map(|k| {
                let angle = widest * f64::from(k) / f64::from(PIECES);
                (width * angle.sin().powf(power), back + (front - back) * angle.cos().powf(power))
            })
            .collect();
        let mut arc = vec![0.0; outline.len()];
        for k in 1..outline.len() {
            let (a, b) = (outline[k - 1], outline[k]);
            arc[k] = arc[k - 1] + (b.0 - a.0).hypot(b.1 - a.1);
        }
        let under_chin = step(-label, 24.0, 48.0);
        let (mid_y, side_y) = (self.mid_y.at(label), self.side_y.at(label));
        Section { mid_y, side_y, level: 27.0 - 20.0 * under_chin, under_chin, outline, arc }
    }
}

/// A section from the mid-line to the left side edge.
#[derive(Clone, Debug)]
pub(super) struct Section {
    mid_y: f64,
    side_y: f64,
    /// Length up to which the section is level, so that in front a label is a height, mm.
    level: f64,
    /// 1 where the section goes round the chin's underside and climbs at once along the jaw.
    under_chin: f64,
    outline: Vec<(f64, f64)>,
    arc: Vec<f64>,
}

impl Section {
    /// Length from the mid-line to the side edge, mm.
    pub(super) fn length(&self) -> f64 {
        self.arc[self.arc.len() - 1]
    }

    /// Length from the mid-line to half width `x`, mm.
    pub(super) fn length_to(&self, x: f64) -> f64 {
        let k = self.outline.partition_point(|p| p.0 < x).clamp(1, self.outline.len() - 1);
        let (a, b) = (self.outline[k - 1].0, self.outline[k].0);
        self.arc[k - 1] + (self.arc[k] - self.arc[k - 1]) * (x - a) / (b - a)
    }

    /// The point at `length` from the mid-line.
    pub(super) fn at(&self, length: f64) -> Vec3 {
        let k = self.arc.partition_point(|&s| s < length).clamp(1, self.arc.len() - 1);
        let t = (length - self.arc[k - 1]) / (self.arc[k] - self.arc[k - 1]);
        let (a, b) = (self.outline[k - 1], self.outline[k]);
        let far = ((length - self.level) / (self.length() - self.level)).max(0.0);
        let beside_mouth = 0.5 * far * far * (3.0 - far) * (0.4 + 0.6 * step(far, 0.0, 0.6));
        let climb = beside_mouth + self.under_chin * (far.powf(1.6) - beside_mouth);
        Vec3::new(
            a.0 + t * (b.0 - a.0),
            self.mid_y + (self.side_y - self.mid_y) * climb,
            a.1 + t * (b.1 - a.1),
        )
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn sections_start_on_the_mid_line_and_run_backward_without_turning() {
        let sections = Sections::new();
        for k in 0..=60 {
            let section = sections.section(LABELS.0 + (LABELS.1 - LABELS.0) * f64::from(k) / 60.0);
            assert_eq!(section.at(0.0).x, 0.0);
            let points: Vec<Vec3> =
                (0..=50).map(|s| section.at(f64::from(s) / 50.0 * section.length())).collect();
            assert!(points.windows(2).all(|w| w[1].x > w[0].x && w[1].z < w[0].z));
        }
    }

    #[test]
    fn in_front_a_label_is_a_height() {
        let sections = Sections::new();
        for label in [-18.0, -5.0, 0.0, 12.0, 21.4] {
            assert!((sections.section(label).at(20.0).y - label).abs() < 0.1, "{label}");
        }
    }

    #[test]
    fn a_length_finds_its_half_width_again() {
        let section = Sections::new().section(0.0);
        for x in [3.0, 11.0, 25.35, 50.0] {
            assert!((section.at(section.length_to(x)).x - x).abs() < 1e-9);
        }
    }
}
