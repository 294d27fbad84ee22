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

    /// The motion that is the `share` of the way to `other`: the rotation between the two about its own axis, while
    /// the centre of `other` (of this, where `other` is no rotation) goes straight.
    pub fn towards(&self, other: &Self, share: f64) -> Self {
        let turning = if other.rotation == Rotation3::identity() { self } else { other };
        let centre = turning.centre;
        let between = (other.rotation * self.rotation.inverse()).scaled_axis() * share;
        let rotation = Rotation3::new(between) * self.rotation;
        let translation = self.displacement(centre).lerp(&other.displacement(centre), share);
        Self { rotation, centre, translation }
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
    fn the_way_between_two_openings_of_a_hinge_is_an_opening() {
        let (hinge, axis) = (Vec3::new(0., 30., -88.), Vec3::new(1., 0., 0.));
        let open = |degrees| RigidMotion::rotation(hinge, axis, degrees).expect("an axis");
        let p = Vec3::new(3., -4., 7.);
        let between = open(2.).towards(&open(10.), 0.25);
        assert!((between.apply(p) - open(4.).apply(p)).norm() < 1e-12);
        let from_rest = RigidMotion::default().towards(&open(10.), 0.5);
        assert!((from_rest.apply(p) - open(5.).apply(p)).norm() < 1e-12);
        let back = open(10.).towards(&RigidMotion::default(), 0.5);
        assert!((back.apply(p) - open(5.).apply(p)).norm() < 1e-12);
    }

    #[test]
    fn a_translation_moves_every_point_by_itself_to_the_bit() {
        let t = Vec3::new(0.1, -0.2, 0.3);
        assert_eq!(RigidMotion::translation(t).displacement(Vec3::new(1e3, 7., -3.)), t);
    }
}
