//! Dental arches: their outline, and the teeth as closed horseshoe bands of crowns.

use super::curve::step;
use super::parameters::Parameters;
use crate::face::{Jaw, Teeth};
use crate::mesh::Surface;
use crate::units::Vec3;

/// Pieces of the polyline that stands for half an outline.
const PIECES: u32 = 400;
/// Widths of the crowns from the mid-line backward, mm: adult means (Wheeler's Dental Anatomy).
const UPPER_CROWNS_MM: [f64; 8] = [8.5, 6.5, 7.5, 7.0, 7.0, 10.0, 9.0, 8.5];
const LOWER_CROWNS_MM: [f64; 8] = [5.0, 5.5, 7.0, 7.0, 7.0, 11.0, 10.5, 10.0];
/// How far each crown ends short of the arch's edge: laterals and cheek teeth are shorter in view.
const SHORTER_MM: [f64; 8] = [0.0, 0.4, 0.0, 0.7, 0.9, 1.0, 1.2, 1.4];
/// Sections at shares of a crown: close together where it turns into its neighbour.
const STATIONS: [f64; 8] = [0.04, 0.1, 0.2, 0.35, 0.65, 0.8, 0.9, 0.96];
/// Depth of the groove between crowns and height of the notch between their edges, mm: shallow, and
/// inward only, so that lips slide over the teeth and the front faces keep to the outline.
const GROOVE_MM: f64 = 0.5;
const NOTCH_MM: f64 = 0.8;
/// Height of a crown from its edge to the gum, mm.
const CROWN_MM: f64 = 10.0;
/// Rounding of the band's long edges, mm: small, for a lip pressed on the teeth must find the front
/// face and not roll over an edge.
const ROUNDING_MM: f64 = 0.8;
/// Heights of the incisal edges; the arches are apart by their difference.
const UPPER_EDGE_MM: f64 = -3.2;
const LOWER_EDGE_MM: f64 = -3.9;
/// Heights of the far edges of the bands: in the gum, beyond the fornices of the vestibule.
const UPPER_GUM_MM: f64 = 18.0;
const LOWER_GUM_MM: f64 = -19.0;
/// Thickness of a band from its front face, mm.
const BAND_MM: f64 = 6.0;

/// Outline of an arch's front faces in a horizontal plane: half a superellipse
/// `|x/a|^p + |(z - z0 + b)/b|^p = 1`, `z >= z0 - b`.
#[derive(Clone, Debug)]
pub(super) struct Arch {
    points: Vec<(f64, f64)>,
    arc: Vec<f64>,
}

impl Arch {
    /// The outline moved outward by about `off_mm` (never more; 5 % less where it curves).
    ///
    /// The exponents are those that keep the outline within 1 mm of the canines of a public dental
    /// scan; with the ellipse (2) the upper canines stand 2 to 4 mm before the outline.
    pub(super) fn new(parameters: &Parameters, upper: bool, off_mm: f64) -> Self {
        let p = parameters;
        let (half_width, depth, front, exponent) = if upper {
            (p.upper_arch_half_width_mm, p.upper_arch_depth_mm, -p.upper_incisor_depth_mm, 2.2)
        } else {
            (p.lower_arch_half_width_mm, p.lower_arch_depth_mm, -p.lower_incisor_depth_mm, 2.0)
        };
        let (a, b, power) = (half_width + off_mm, depth + off_mm, 2.0 / exponent);
        let points: Vec<(f64, f64)> = (0..=PIECES)
            .map(|k| {
                let angle = std::f64::consts::FRAC_PI_2 * f64::from(k) / f64::from(PIECES);
                let cosine = if k == PIECES { 0.0 } else { angle.cos() };
                (a * angle.sin().powf(power), front - depth + b * cosine.powf(power))
            })
            .collect();
        let mut arc = vec![0.0; points.len()];
        for k in 1..points.len() {
            let (a, b) = (points[k - 1], points[k]);
            arc[k] = arc[k - 1] + (b.0 - a.0).hypot(b.1 - a.1);
        }
        Self { points, arc }
    }

    /// Length from the mid-line to an end, mm.
    pub(super) fn length(&self) -> f64 {
        self.arc[self.arc.len() - 1]
    }

    /// `(x, z)` at `length` from the mid-line along the left half.
    pub(super) fn at(&self, length: f64) -> (f64, f64) {
        let length = length.clamp(0.0, self.length());
        let k = self.arc.partition_point(|&s| s < length).clamp(1, self.arc.len() - 1);
        let t = (length - self.arc[k - 1]) / (self.arc[k] - self.arc[k - 1]);
        let (a, b) = (self.points[k - 1], self.points[k]);
        (a.0 + t * (b.0 - a.0), a.1 + t * (b.1 - a.1))
    }

    /// Unit inward normal `(x, z)` at `length`.
    fn inward(&self, length: f64) -> (f64, f64) {
        let (a, b) = (self.at(length - 1.0), self.at(length + 1.0));
        let (dx, dz) = (b.0 - a.0, b.1 - a.1);
        let norm = dx.hypot(dz);
        // At the very middle the left half alone would lean; the mirror image evens it out.
        if length <= 0.0 { (0.0, -1.0) } else { (dz / norm, -dx / norm) }
    }
}

/// Both arches as closed outward-oriented bands.
pub(super) fn teeth(parameters: &Parameters) -> Vec<Teeth> {
    let bone = |upper: bool| if upper { "skull" } else { "mandible" }.to_owned();
    [true, false]
        .map(|upper| Teeth {
            upper,
            bone: bone(upper),
            surface: band(&Arch::new(parameters, upper, 0.0), upper),
        })
        .into()
}

/// The jaw joint: Bonwill's triangle between the condyles and the lower incisal point, tilted by Balkwill's
/// angle upward from the occlusal plane, which is level here.
pub(super) fn jaw(parameters: &Parameters) -> Jaw {
    let side = parameters.bonwill_side_mm;
    let incisor = Vec3::new(0.0, LOWER_EDGE_MM, -parameters.lower_incisor_depth_mm);
    let height = side * 0.75f64.sqrt();
    let (sin, cos) = parameters.balkwill_angle_deg.to_radians().sin_cos();
    let condyles = [0.5, -0.5].map(|x| incisor + Vec3::new(x * side, height * sin, -height * cos));
    Jaw { bone: "mandible".into(), condyles, incisor }
}

/// A section of an arch: its length from the mid-line, how far the crown's front lies behind the outline
/// and its edge behind the arch's, mm.
struct Station {
    length: f64,
    groove: f64,
    shorter: f64,
}

/// Sections from the mid-line to the end of the arch, crown by crown; the last crown takes what is left.
fn stations(arch: &Arch, upper: bool) -> Vec<Station> {
    let widths = if upper { UPPER_CROWNS_MM } else { LOWER_CROWNS_MM };
    let mut stations = vec![Station { length: 0.0, groove: GROOVE_MM, shorter: SHORTER_MM[0] + NOTCH_MM }];
    let mut start = 0.0;
    for (crown, width) in widths.into_iter().enumerate() {
        let width = width.min(arch.length() - start);
        // Less than a millimetre of a crown is no tooth.
        if width < 1.0 {
            break;
        }
        for share in STATIONS {
            let turned = (2.0 * share - 1.0).abs().powi(6);
            stations.push(Station {
                length: start + share * width,
                groove: GROOVE_MM * turned,
                shorter: SHORTER_MM[crown] + NOTCH_MM * turned,
            });
        }
        start += width;
        let next = SHORTER_MM[(crown + 1).min(SHORTER_MM.len() - 1)];
        let shorter = SHORTER_MM[crown].max(next) + NOTCH_MM;
        stations.push(Station { length: start, groove: GROOVE_MM, shorter });
    }
    stations
}

fn band(arch: &Arch, upper: bool) -> Surface {
    let ring = ring(upper);
    let n = ring.len();
    let sections = stations(arch, upper);
    let stations = sections.len() - 1;
    let (edge, to_gum) = if upper { (UPPER_EDGE_MM, 1.0) } else { (LOWER_EDGE_MM, -1.0) };
    let mut surface = Surface::default();
    // Left half outward from the middle, then the right half as its mirror image.
    for side in [1.0, -1.0] {
        for (k, section) in sections.iter().enumerate().skip(usize::from(side < 0.0)) {
            let ((x, z), (nx, nz)) = (arch.at(section.length), arch.inward(section.length));
            for &(depth, y) in &ring {
                let height = to_gum * (y - edge);
                let crown = 1.0 - step(height, CROWN_MM - 2.0, CROWN_MM);
                let front = 1.0 - step(depth, 0.0, 0.5 * BAND_MM);
                let depth = depth + section.groove * crown * front;
                let y = y + to_gum * section.shorter * (1.0 - step(height, 0.0, 0.6 * CROWN_MM));
                let across = if k == 0 { 0.0 } else { side * (x + depth * nx) };
                surface.points.push(Vec3::new(across, y, z + depth * nz));
            }
        }
    }
    let id = |k: usize, j: usize, left: bool| {
        let station = if left || k == 0 { k } else { stations + k };
        station * n + j % n
    };
    for left in [true, false] {
        let mut push = |a: usize, b: usize, c: usize| {
            surface.triangles.push(if left { [a, b, c] } else { [a, c, b] });
        };
        for k in 0..stations {
            for j in 0..n {
                let q = [id(k, j, left), id(k + 1, j, left), id(k + 1, j + 1, left), id(k, j + 1, left)];
                push(q[0], q[1], q[2]);
                push(q[0], q[2], q[3]);
            }
        }
        // About its middle: the groove leaves the end's rim hollow, and a fan from the rim folds there.
        let rim: Vec<usize> = (0..n).map(|j| id(stations, j, left)).collect();
        let hub = surface.points.len();
        surface.points.push(rim.iter().map(|&v| surface.points[v]).sum::<Vec3>() / n as f64);
        for j in 0..n {
            surface.triangles.push(if left {
                [hub, rim[(j + 1) % n], rim[j]]
            } else {
                [hub, rim[j], rim[(j + 1) % n]]
            });
        }
    }
    surface
}

/// Section of a band as `(depth behind the front face, height)`: a rounded rectangle, front face
/// upward, over the top and down the back.
fn ring(upper: bool) -> Vec<(f64, f64)> {
    let (low, high) = if upper { (UPPER_EDGE_MM, UPPER_GUM_MM) } else { (LOWER_GUM_MM, LOWER_EDGE_MM) };
    let (r, front, back) = (ROUNDING_MM, ROUNDING_MM, BAND_MM - ROUNDING_MM);
    let corners = [(front, low + r), (front, high - r), (back, high - r), (back, low + r)];
    let mut ring = Vec::new();
    for (c, &(depth, y)) in corners.iter().enumerate() {
        for step in 0..=4 {
            let angle = std::f64::consts::FRAC_PI_2 * (c as f64 - 1.0 + f64::from(step) / 4.0);
            ring.push((depth - r * angle.cos(), y + r * angle.sin()));
        }
        let (next_depth, next_y) = corners[(c + 1) % 4];
        let angle = std::f64::consts::FRAC_PI_2 * c as f64;
        let (shift_depth, shift_y) = (-r * angle.cos(), r * angle.sin());
        let length = (next_depth - depth).hypot(next_y - y);
        let pieces = (length / 1.5).ceil() as usize;
        for k in 1..pieces {
            let t = k as f64 / pieces as f64;
            ring.push((depth + t * (next_depth - depth) + shift_depth, y + t * (next_y - y) + shift_y));
        }
    }
    ring
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_upper_outline_keeps_to_measured_teeth() {
        let arch = Arch::new(&Parameters::default(), true, 0.0);
        // Front-most points of a public dental scan: half width and z, mm.
        for (x, z) in [(0.0, -5.0), (9.0, -7.1), (12.0, -8.2), (18.0, -13.3), (21.0, -15.0), (24.0, -22.0)] {
            let length = (0..=6000).map(|k| f64::from(k) * 0.01).find(|&s| arch.at(s).0 >= x);
            let found = arch.at(length.unwrap_or(0.0)).1;
            assert!((found - z).abs() < 1.6, "{x}: {found:.2}, not {z}");
        }
    }

    #[test]
    fn moving_the_outline_moves_it_by_about_that_much() {
        let [near, far] = [0.0, 0.5].map(|off| Arch::new(&Parameters::default(), true, off));
        for k in 0..=100 {
            let p = far.at(far.length() * f64::from(k) / 100.0);
            let gap = (0..=4000)
                .map(|s| near.at(near.length() * f64::from(s) / 4000.0))
                .map(|q| (p.0 - q.0).hypot(p.1 - q.1))
                .fold(f64::INFINITY, f64::min);
            assert!((0.4..=0.51).contains(&gap), "{p:?}: {gap}");
        }
    }
}
