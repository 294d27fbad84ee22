//! Where the face is seen from.

use crate::units::Vec3;

/// A standard view of the face.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum View {
    /// From the front: the subject's left is on the right of the picture.
    Front,
    /// From the subject's left: the face looks to the left of the picture.
    Profile,
    /// From the subject's left front and a little above.
    ThreeQuarter,
}

impl View {
    /// The names accepted at interfaces.
    pub const NAMES: [&'static str; 3] = ["front", "profile", "three-quarter"];

    /// The view called `name`, or `None`.
    pub fn parse(name: &str) -> Option<Self> {
        match name {
            "front" => Some(Self::Front),
            "profile" => Some(Self::Profile),
            "three-quarter" => Some(Self::ThreeQuarter),
            _ => None,
        }
    }

    /// Turn to the subject's left and lift of the viewer, degrees.
    fn angles(self) -> (f64, f64) {
        match self {
            Self::Front => (0., 0.),
            Self::Profile => (90., 0.),
            Self::ThreeQuarter => (38., 6.),
        }
    }
}

/// A point in the picture.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Projected {
    /// Pixels from the left edge.
    pub x: f64,
    /// Pixels from the upper edge.
    pub y: f64,
    /// Height towards the viewer, mm: the greater hides the smaller.
    pub depth: f64,
}

/// A parallel projection, so that one scale bar holds for the whole picture:
/// `x = x0 + s r.(p - c)`, `y = y0 - s u.(p - c)`, `depth = v.(p - c)`.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Camera {
    centre: Vec3,
    right: Vec3,
    up: Vec3,
    /// Unit vector from the face to the viewer.
    toward: Vec3,
    middle: (f64, f64),
    pixels_per_mm: f64,
}

/// Pixels kept free at the edges of a picture: left, top, right and bottom.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Margins {
    /// Left.
    pub left: f64,
    /// Top.
    pub top: f64,
    /// Right.
    pub right: f64,
    /// Bottom.
    pub bottom: f64,
}

impl Camera {
    /// The camera of `view` that shows the box of `points` (mm) as large as `size` (width, height, pixels)
    /// allows within `margins`.
    pub fn fit(view: View, points: &[Vec3], size: (usize, usize), margins: Margins) -> Self {
        let (yaw, lift) = view.angles();
        let ((sy, cy), (sl, cl)) = (yaw.to_radians().sin_cos(), lift.to_radians().sin_cos());
        let right = Vec3::new(cy, 0., -sy);
        let toward = Vec3::new(sy * cl, sl, cy * cl);
        let up = toward.cross(&right);
        let span = |axis: &Vec3| {
            let along = points.iter().map(|p| p.dot(axis));
            along.fold((f64::INFINITY, f64::NEG_INFINITY), |(lo, hi), t| (lo.min(t), hi.max(t)))
        };
        let axes = [right, up, toward];
        let spans = axes.map(|axis| if points.is_empty() { (0., 1.) } else { span(&axis) });
        let centre = axes.iter().zip(spans).map(|(axis, (lo, hi))| axis * (lo + hi) / 2.).sum();
        let free = (
            (size.0 as f64 - margins.left - margins.right).max(1.),
            (size.1 as f64 - margins.top - margins.bottom).max(1.),
        );
        let needs = spans.map(|(lo, hi)| (hi - lo).max(1e-9));
        Self {
            centre,
            right,
            up,
            toward,
            middle: (margins.left + free.0 / 2., margins.top + free.1 / 2.),
            pixels_per_mm: (free.0 / needs[0]).min(free.1 / needs[1]),
        }
    }

    /// The same view at another scale: panels of one figure compare.
    #[must_use]
    pub fn at_scale(self, pixels_per_mm: f64) -> Self {
        Self { pixels_per_mm, ..self }
    }

    /// The same view of a picture `factor` times larger.
    #[must_use]
    pub fn enlarged(self, factor: f64) -> Self {
        let middle = (self.middle.0 * factor, self.middle.1 * factor);
        Self { middle, pixels_per_mm: self.pixels_per_mm * factor, ..self }
    }

    /// Where `p` (mm) is seen.
    pub fn project(&self, p: Vec3) -> Projected {
        let d = p - self.centre;
        Projected {
            x: self.middle.0 + self.pixels_per_mm * d.dot(&self.right),
            y: self.middle.1 - self.pixels_per_mm * d.dot(&self.up),
            depth: d.dot(&self.toward),
        }
    }

    /// `v` in the axes of the picture: right, up and towards the viewer.
    pub fn turn(&self, v: Vec3) -> Vec3 {
        Vec3::new(v.dot(&self.right), v.dot(&self.up), v.dot(&self.toward))
    }

    /// Pixels to the millimetre.
    pub fn pixels_per_mm(&self) -> f64 {
        self.pixels_per_mm
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn cube() -> Vec<Vec3> {
        (0..8)
            .map(|k| Vec3::new(f64::from(k & 1), f64::from(k >> 1 & 1), f64::from(k >> 2 & 1)) * 10.)
            .collect()
    }

    fn near(camera: &Camera, p: [f64; 3], expect: [f64; 3]) {
        let seen = camera.project(Vec3::from(p));
        let seen = Vec3::new(seen.x, seen.y, seen.depth);
        assert!((seen - Vec3::from(expect)).norm() < 1e-9, "{p:?}: {seen:?} {expect:?}");
    }

    #[test]
    fn the_front_has_the_subjects_left_on_the_right() {
        let camera = Camera::fit(View::Front, &cube(), (100, 120), Margins::default());
        assert!((camera.pixels_per_mm() - 10.).abs() < 1e-12);
        near(&camera, [5., 5., 5.], [50., 60., 0.]);
        near(&camera, [10., 5., 5.], [100., 60., 0.]);
        near(&camera, [5., 10., 5.], [50., 10., 0.]);
        near(&camera, [5., 5., 10.], [50., 60., 5.]);
    }

    #[test]
    fn the_profile_looks_to_the_left() {
        let camera = Camera::fit(View::Profile, &cube(), (100, 100), Margins::default());
        near(&camera, [5., 5., 10.], [0., 50., 0.]);
        near(&camera, [10., 5., 5.], [50., 50., 5.]);
        near(&camera, [5., 0., 5.], [50., 100., 0.]);
    }

    #[test]
    fn every_view_is_a_rigid_turn() {
        for view in [View::Front, View::Profile, View::ThreeQuarter] {
            let camera = Camera::fit(view, &cube(), (80, 60), Margins::default());
            let axes = [Vec3::x(), Vec3::y(), Vec3::z()].map(|v| camera.turn(v));
            assert!((axes[0].cross(&axes[1]) - axes[2]).norm() < 1e-12, "{view:?}");
            assert!(axes.iter().all(|v| (v.norm() - 1.).abs() < 1e-12));
        }
    }

    #[test]
    fn margins_are_kept_free() {
        let margins = Margins { left: 10., top: 30., right: 20., bottom: 5. };
        let camera = Camera::fit(View::Front, &cube(), (100, 100), margins);
        for p in cube() {
            let seen = camera.project(p);
            assert!((10. - 1e-9..=80. + 1e-9).contains(&seen.x), "{seen:?}");
            assert!((30. - 1e-9..=95. + 1e-9).contains(&seen.y), "{seen:?}");
        }
    }
}
