//! Where the grid's columns and rows meet skin, skull and mucosa.

use super::arches::Arch;
use super::curve::{Curve, bell, step};
use super::parameters::Parameters;
use super::relief::Relief;
use super::resolution::Resolution;
use super::section::{LABELS, Section, Sections};
use super::thickness::Thickness;
use crate::units::Vec3;

/// Label where the lower lip's rows end and the chin's begin.
const SUBLABIALE: f64 = -18.0;
/// Label where the rows of the lower nose end: the tip.
const NOSE_TIP: f64 = 34.0;
/// Height of the nasion above the subnasale: the length of the nose, mm.
pub(super) const NOSE_LENGTH: f64 = 50.1;
/// Label of the upper edge away from the nose, and how much lower it runs under the eye, mm.
const RIM: f64 = 59.0;
const RIM_DIP: f64 = 5.0;
/// How far the lips turn away from each other on their way to the teeth, mm.
const ROLL_MM: f64 = 2.6;
/// Exponent by which the vermilion's rows are drawn together at the slit, where the lips are thinnest and
/// roundest.
const SLIT_GRADING: f64 = 1.35;
/// Label of the slit's row at the side edge, where rows are evenly spaced.
const SIDE_SLIT: f64 = -6.0;
/// Share of the nose that the cartilage, fixed like bone, follows.
const CARTILAGE: f64 = 0.55;

/// A featureless point and how the grid reached it.
pub(super) struct Station {
    pub(super) base: Vec3,
    /// Unit normal into the head.
    inward: Vec3,
    /// Length along the section from the mid-line, mm.
    length: f64,
    /// Label, mm.
    label: f64,
}

/// Places the grid's nodes.
pub(super) struct Builder {
    sections: Sections,
    relief: Relief,
    thickness: Thickness,
    arches: [Arch; 2],
    parameters: Parameters,
    resolution: Resolution,
    /// Label of each row at the mid-line and at the side edge.
    pub(super) labels: Vec<f64>,
    side_labels: Vec<f64>,
    /// Share of the way from the corner of the mouth to the side edge, of each cheek column.
    cheek: Vec<f64>,
}

impl Builder {
    /// The builder of a face's grid.
    pub(super) fn new(parameters: &Parameters, resolution: &Resolution) -> Self {
        let p = parameters;
        let [vermilion, lip, nose, top] = resolution.rows_above;
        let [lower_vermilion, lower_lip, chin] = resolution.rows_below;
        let slit = lower_vermilion + lower_lip + chin;
        let mut knots = vec![(0usize, LABELS.0)];
        let stretches = [
            (chin, SUBLABIALE),
            (lower_lip, -p.lower_vermilion_mm),
            (lower_vermilion, 0.0),
            (vermilion, p.upper_vermilion_mm),
            (lip, p.upper_lip_mm),
            (nose, NOSE_TIP + p.nose_shift()),
            (top, RIM),
        ];
        for (cells, label) in stretches {
            knots.push((knots[knots.len() - 1].0 + cells, label));
        }
        let rows = knots[knots.len() - 1].0 + 1;
        let knots: Vec<_> = knots.into_iter().map(|(row, label)| (row as f64, label)).collect();
        let spacing = Curve::monotone(&knots);
        let drawn_to_slit = |label: f64| {
            let vermilion = if label > 0.0 { p.upper_vermilion_mm } else { p.lower_vermilion_mm };
            let share = label.abs() / vermilion;
            if share < 1.0 { (vermilion * share.powf(SLIT_GRADING)).copysign(label) } else { label }
        };
        let labels = (0..rows)
            .map(|row| if row == slit { 0.0 } else { drawn_to_slit(spacing.at(row as f64)) })
            .collect();
        let side_labels = (0..rows)
            .map(|row| {
                if row <= slit {
                    LABELS.0 + (SIDE_SLIT - LABELS.0) * row as f64 / slit as f64
                } else {
                    SIDE_SLIT + (RIM - SIDE_SLIT) * (row - slit) as f64 / (rows - 1 - slit) as f64
                }
            })
            .collect();
        let sections = Sections::new();
        let middle = sections.section(0.0);
        let mouth = middle.length_to(0.5 * p.mouth_width_mm);
        let cheek = graded(
            mouth / resolution.mouth_columns as f64,
            middle.length() - mouth,
            resolution.cheek_columns,
        );
        Self {
            sections,
            relief: Relief::new(p),
            thickness: Thickness::new(),
            arches: [true, false].map(|upper| Arch::new(p, upper, p.mucosa_gap_mm)),
            parameters: p.clone(),
            resolution: *resolution,
            labels,
            side_labels,
            cheek,
        }
    }

    /// Number of columns of the left half.
    pub(super) fn columns(&self) -> usize {
        self.resolution.mouth_columns + self.cheek.len() + 1
    }

    /// The featureless point of `column` and `row`.
    pub(super) fn station(&self, column: usize, row: usize) -> Station {
        let mouth = self.resolution.mouth_columns;
        let half = self.relief.mouth_half();
        let (x, far) = if column <= mouth {
            (half * column as f64 / mouth as f64, 0.0)
        } else {
            let far = self.cheek[column - mouth - 1];
            (half * (1.0 + 1.2 * far), far)
        };
        let spread = step(far, 0.0, 0.85);
        let label = (1.0 - spread) * self.row_label(self.labels[row], x) + spread * self.side_labels[row];
        let section = self.sections.section(label);
        let length = self.length(&section, x, far);
        let base = section.at(length);
        let h = 0.5;
        // At the mid-line the section's mirror image stands for its other side.
        let across =
            if column == 0 { Vec3::x() } else { section.at(length + h) - section.at(length - h.min(length)) };
        let near = |label: f64| {
            let section = self.sections.section(label);
            section.at(self.length(&section, x, far))
        };
        let up = near(label + h) - near(label - h);
        let inward = -across.cross(&up).normalize();
        Station { base, inward, length, label }
    }

    /// Length along `section` of half width `x` within the mouth, of the share `far` beyond it.
    fn length(&self, section: &Section, x: f64, far: f64) -> f64 {
        let half = self.relief.mouth_half();
        if far <= 0.0 {
            return if x > 0.0 { section.length_to(x) } else { 0.0 };
        }
        let corner = section.length_to(half);
        corner + far * (section.length() - corner)
    }

    /// Label of the row `label` at half width `x`: rows follow the slit and the vermilion.
    fn row_label(&self, label: f64, x: f64) -> f64 {
        let p = &self.parameters;
        let (size, vermilion, border, far) = if label >= 0.0 {
            (label, p.upper_vermilion_mm, self.relief.upper_vermilion(x), p.upper_lip_mm)
        } else {
            (-label, p.lower_vermilion_mm, self.relief.lower_vermilion(x), -SUBLABIALE)
        };
        // Rows keep some height at the corner, where the vermilion has none.
        let least = 0.55 * vermilion;
        let border = least + 0.5 * ((border - least) + (border - least).hypot(1.2)) - 0.5 * 0.04;
        let follow = if size <= vermilion {
            size / vermilion * border
        } else if size <= far {
            border + (size - vermilion) * (far - border) / (far - vermilion)
        } else {
            size
        };
        let fade = (1.0 - size / far).max(0.0);
        let tip = NOSE_TIP + p.nose_shift();
        let up = ((label - tip) / (RIM - tip)).max(0.0);
        follow.copysign(label) + self.relief.slit(x) * fade + up.powf(1.5) * (self.edge(x) - RIM)
    }

    /// Label of the upper edge at half width `x`: it follows the lower rim of the orbit and climbs along
    /// the nose's side to the nasion.
    fn edge(&self, x: f64) -> f64 {
        let nasion = self.parameters.upper_lip_mm + NOSE_LENGTH;
        let rim = RIM - RIM_DIP * bell(x - 31.0, 13.0);
        rim + (nasion - RIM) * (-(x / 12.5).powi(4)).exp()
    }

    /// The skin over `station`.
    pub(super) fn skin(&self, station: &Station) -> Vec3 {
        let (x, y) = (station.base.x, station.base.y);
        let above = station.label - self.relief.slit(x);
        let rise = self.relief.rise(x, y, above);
        station.base + self.relief.nose(x, y) + Vec3::new(0.0, 0.0, rise)
    }

    /// Share of vestibule: free mucosa between the fornices, as far back as the molars.
    pub(super) fn vestibule_share(&self, station: &Station) -> f64 {
        let y = station.base.y;
        let low = 10.0 * step(station.length, 30.0, 55.0);
        let height = step(y, -22.5 - low, -13.8 - 0.2 * low) * (1.0 - step(y, 14.0, 22.0));
        height * (1.0 - step(station.length, 66.0, 92.0))
    }

    /// How far the upper or lower lip's inner surface at `column` and `row` is turned up or down: the lips
    /// go round to the teeth, most at the slit and at the middle.
    pub(super) fn turned(&self, column: usize, row: usize, upper: bool) -> f64 {
        let p = &self.parameters;
        let vermilion = if upper { p.upper_vermilion_mm } else { p.lower_vermilion_mm };
        let near = 1.0 - self.labels[row].abs() / vermilion;
        let across = column as f64 / self.resolution.mouth_columns as f64;
        if near <= 0.0 || across >= 1.0 {
            return 0.0;
        }
        let turned = ROLL_MM * near * near * (1.0 - across.powi(4));
        if upper { turned } else { -turned }
    }

    /// The inner surface under `station`, before it is `turned`: bone, or mucosa before the upper or lower
    /// teeth.
    pub(super) fn inner(&self, station: &Station, share: f64, upper: bool, turned: f64) -> Vec3 {
        let (x, y) = (station.base.x, station.base.y);
        // Under the nose the columns lean back and up, square to the underside.
        let nose = self.relief.nose(x, y);
        let lean = self.relief.underside(x, y);
        let cartilage = Vec3::new(0.0, lean, CARTILAGE * nose.z);
        let mental = 1.5 * bell(x, 12.0) * bell(y + 33.0, 9.0);
        let skull =
            station.base + self.thickness.at(x, y) * station.inward + cartilage + Vec3::new(0.0, 0.0, mental);
        if share <= 0.0 {
            return skull;
        }
        // Equal shares of the way back along the skin and along the arch.
        let along = station.length * (0.83 - 0.0012 * station.length);
        let [top, low] = &self.arches;
        let ((xt, zt), (xl, zl)) = (top.at(along), low.at(along));
        // In front the columns are level; in the cheeks they lean like the skin's normals.
        let height = y + (skull.y - y) * step(station.length, 34.0, 66.0);
        // Just under the slit the lower lip still covers the edges of the upper incisors.
        let below = if upper { 0.0 } else { step(-height - turned, 3.4, 6.4) };
        let teeth = Vec3::new(xt + below * (xl - xt), height, zt + below * (zl - zt));
        skull + share * (teeth - skull)
    }
}

/// Shares of the way after each of `cells` steps that grow by one factor, the first of `first`
/// and all of `total` length.
fn graded(first: f64, total: f64, cells: usize) -> Vec<f64> {
    let sum = |factor: f64| (0..cells).fold(0.0, |sum, _| sum * factor + 1.0);
    let (mut low, mut high) = (0.5, 2.0);
    for _ in 0..60 {
        let middle = 0.5 * (low + high);
        if first * sum(middle) < total { low = middle } else { high = middle }
    }
    let (mut length, mut at) = (1.0, 0.0);
    let all = sum(low);
    (0..cells)
        .map(|_| {
            at += length / all;
            length *= low;
            at
        })
        .collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn graded_steps_grow_to_the_whole() {
        let shares = graded(2.0, 100.0, 15);
        assert!((shares[0] - 0.02).abs() < 1e-9 && (shares[14] - 1.0).abs() < 1e-12);
        assert!(shares.windows(3).all(|w| w[2] - w[1] > w[1] - w[0]));
    }
}
