//! The jaw joint.

use super::RigidMotion;
use crate::units::Vec3;

/// Least distance of the condyles from each other and of the incisal point from their axis, mm.
pub(super) const LEAST_ARM_MM: f64 = 10.;
/// Greatest such distances, mm: half as much again as the mandible of any adult.
pub(super) const MOST_ARM_MM: f64 = 250.;
/// Widest opening, mm: active mouth opening of adults is 40 to 60 mm.
const WIDEST_MM: f64 = 60.;

/// The hinge of the jaw: opening turns the bone about the line through the condyles. The glide of the condyles
/// along the articular eminence, which begins beyond about 20 mm, is left out.
#[derive(Clone, Debug, PartialEq)]
pub struct Jaw {
    /// The bone that turns, with every piece of it: `mandible`.
    pub bone: String,
    /// Centres of the subject's left and right condyle, mm.
    pub condyles: [Vec3; 2],
    /// Lower incisal point, mm: where the opening is measured.
    pub incisor: Vec3,
}

/// The openings between which an unknown one is sought, mm: it is counted in shares of the range, 0 to 1, like
/// an activation.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct JawRange {
    /// Least opening, mm.
    pub min_mm: f64,
    /// Greatest opening, mm.
    pub max_mm: f64,
}

impl JawRange {
    /// Greatest minus least opening, mm.
    pub fn width_mm(&self) -> f64 {
        self.max_mm - self.min_mm
    }

    /// The opening at a share of the range, mm.
    pub fn at(&self, share: f64) -> f64 {
        self.min_mm + share * self.width_mm()
    }
}

impl Jaw {
    /// Widest opening that may be asked for, mm.
    pub const WIDEST_MM: f64 = WIDEST_MM;

    /// Unit vector along the condylar axis, from right to left: turning about it lowers the chin.
    pub fn axis(&self) -> Vec3 {
        (self.condyles[0] - self.condyles[1]).try_normalize(0.).unwrap_or_else(Vec3::x)
    }

    /// Distance `r` of the lower incisal point from the condylar axis, mm.
    pub fn arm_mm(&self) -> f64 {
        self.axis().cross(&(self.incisor - self.condyles[1])).norm()
    }

    /// The rotation about the condylar axis whose arc at the lower incisal point is `opening_mm` long: by
    /// `opening_mm / r` radians.
    pub fn motion(&self, opening_mm: f64) -> RigidMotion {
        let degrees = (opening_mm / self.arm_mm()).to_degrees();
        RigidMotion::rotation(self.condyles[1], self.axis(), degrees).unwrap_or_default()
    }

    /// How the point that rests at `p` moves per millimetre of opening, at the opening `opening_mm`:
    /// `e x (x(p) - o) / r`, mm/mm.
    pub fn slope(&self, opening_mm: f64, p: Vec3) -> Vec3 {
        let arm = self.motion(opening_mm).apply(p) - self.condyles[1];
        self.axis().cross(&arm) / self.arm_mm()
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn jaw() -> Jaw {
        let condyles = [Vec3::new(51., 34., -86.), Vec3::new(-51., 34., -86.)];
        Jaw { bone: "mandible".into(), condyles, incisor: Vec3::new(0., -4., -7.) }
    }

    #[test]
    fn opening_lowers_the_incisor_along_an_arc_of_that_length_and_holds_the_condyles() {
        let jaw = jaw();
        let moved = jaw.motion(4.);
        let u = moved.displacement(jaw.incisor);
        assert!(u.y < -3. && u.z < 0. && u.x.abs() < 1e-12, "down and back: {u:?}");
        let arc = moved.angle_deg().to_radians() * 38f64.hypot(79.);
        assert!((arc - 4.).abs() < 1e-12, "{arc}");
        for condyle in jaw.condyles {
            assert!(moved.displacement(condyle).norm() < 1e-12);
        }
    }

    #[test]
    fn the_slope_is_the_derivative_of_the_motion() {
        let (jaw, p, h) = (jaw(), Vec3::new(12., -40., -20.), 1e-4);
        for q in [0., 7., 20.] {
            let difference =
                (jaw.motion(q + h).displacement(p) - jaw.motion(q - h).displacement(p)) / (2. * h);
            assert!((jaw.slope(q, p) - difference).norm() < 1e-9);
        }
    }
}
