//! The box around points.

use crate::units::Vec3;

/// The smallest axis-parallel box around some points, mm; with `lo > hi` the box of none.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Extent {
    /// Smallest corner.
    pub lo: Vec3,
    /// Largest corner.
    pub hi: Vec3,
}

impl Extent {
    /// The box around `points`, mm.
    pub fn of<'a>(points: impl IntoIterator<Item = &'a Vec3>) -> Self {
        let none = Self { lo: Vec3::repeat(f64::INFINITY), hi: Vec3::repeat(f64::NEG_INFINITY) };
        points.into_iter().fold(none, |b, p| Self { lo: b.lo.inf(p), hi: b.hi.sup(p) })
    }

    /// Its longest side, mm; minus infinity for the box of no point.
    pub fn longest_mm(&self) -> f64 {
        (self.hi - self.lo).max()
    }

    /// How far it is from `other`, mm: the longest of the gaps along the axes, 0 where the boxes meet.
    pub fn gap_mm(&self, other: &Self) -> f64 {
        (other.lo - self.hi).sup(&(self.lo - other.hi)).max().max(0.)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn boxes_apart_have_a_gap_and_boxes_that_meet_none() {
        let a = Extent::of(&[Vec3::zeros(), Vec3::new(2., 1., 1.)]);
        let b = Extent::of(&[Vec3::new(5., 0.5, -4.), Vec3::new(6., 0.6, -1.)]);
        assert_eq!((a.longest_mm(), b.longest_mm()), (2., 3.));
        assert_eq!((a.gap_mm(&b), b.gap_mm(&a), a.gap_mm(&a)), (3., 3., 0.));
        assert_eq!(Extent::of(&[]).longest_mm(), f64::NEG_INFINITY);
    }
}
