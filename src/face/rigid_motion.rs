//! How a bone moves.

use nalgebra::{Rotation3, Unit};

use crate::units::Vec3;

/// A rigid motion `p -> o + R (p - o) + t`: a rotation `R` about an axis through the point `o`, then a
/// translation `t`, mm. Exact for any angle.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct RigidMotion {
    rotation: Rotation3<f64>,
    centre: Vec3,
    translation: Vec3,
}

impl Default for RigidMotion {
    /// No motion.
    fn default() -> Self {
        Self { rotation: Rotation3::identity(), centre: Vec3::zeros(), translation: Vec3::zeros() }
    }
}

impl RigidMotion {
    /// A translation by `t`, mm.
    pub fn translation(t: Vec3) -> Self {
        Self { translation: t, ..Self::default() }
    }

    /// A right-handed rotation by `degrees` about the axis through `point` (mm) along `direction`; `None`
    /// when the direction has no length.
    pub fn rotation(point: Vec3, direction: Vec3, degrees: f64) -> Option<Self> {
        let axis = Unit::try_new(direction, 1e-12)?;
        let rotation = Rotation3::from_axis_angle(&axis, degrees.to_radians());
        Some(Self { rotation, centre: point, translation: Vec3::zeros() })
    }

    /// This motion and then a translation by `t`, mm.
    pub fn then_by(mut self, t: Vec3) -> Self {
        self.translation += t;
        self
    }

    /// Where it brings the point `p`, mm.
    pub fn apply(&self, p: Vec3) -> Vec3 {
        p + self.displacement(p)
    }

    /// How far it moves the point `p`, mm: exactly the translation when there is no rotation.
    pub fn displacement(&self, p: Vec3) -> Vec3 {
        let arm = p - self.centre;
        if self.rotation == Rotation3::identity() {
            return self.translation;
        }
        self.rotation * arm - arm + self.translation
    }

    /// The point that it brings to `p`, mm.
    pub fn origin_of(&self, p: Vec3) -> Vec3 {
        self.centre + self.rotation.inverse() * (p - self.centre - self.translation)
    }

    /// The direction `v` turned along.
    pub fn turned(&self, v: Vec3) -> Vec3 {
        self.rotation * v
    }

    /// The direction that is turned to `v`.
    pub fn turned_back(&self, v: Vec3) -> Vec3 {
        self.rotation.inverse() * v
    }

    /// Angle of the rotation, degrees.
    pub fn angle_deg(&self) -> f64 {
        self.rotation.angle().to_degrees()
    }

    /// Whether nothing moves.
    pub fn is_rest(&self) -> bool {
        *self == Self { centre: self.centre, ..Self::default() }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_quarter_turn_about_an_axis_off_the_origin_goes_where_it_must() {
        let turn = RigidMotion::rotation(Vec3::new(1., 2., 0.), Vec3::new(0., 0., 3.), 90.).expect("an axis");
        let moved = turn.then_by(Vec3::new(0., 0., 5.));
        assert!((moved.apply(Vec3::new(3., 2., 1.)) - Vec3::new(1., 4., 6.)).norm() < 1e-12);
        assert!((moved.origin_of(Vec3::new(1., 4., 6.)) - Vec3::new(3., 2., 1.)).norm() < 1e-12);
        assert!((moved.angle_deg() - 90.).abs() < 1e-9);
        assert!(!moved.is_rest() && RigidMotion::default().is_rest());
        assert_eq!(RigidMotion::rotation(Vec3::zeros(), Vec3::zeros(), 1.), None);
    }

    #[test]
    fn a_translation_moves_every_point_by_itself_to_the_bit() {
        let t = Vec3::new(0.1, -0.2, 0.3);
        assert_eq!(RigidMotion::translation(t).displacement(Vec3::new(1e3, 7., -3.)), t);
    }
}
