//! Two moved faces set against each other, such as before and after an operation.

use std::collections::BTreeSet;

use super::mirror::{Mirrored, mirrored_pairs};
use crate::face::{Face, Landmark};
use crate::units::Vec3;

/// A face that muscles moved.
#[derive(Clone, Copy, Debug)]
pub struct Posed<'a> {
    /// The face.
    pub face: &'a Face,
    /// Activations (m).
    pub activation: &'a [f64],
    /// Displacement (3n), mm.
    pub displacement: &'a [f64],
}

/// One quantity of two faces, by name: `None` where a face has none of it.
#[derive(Clone, Debug, PartialEq)]
pub struct Pair<T> {
    /// What it is of.
    pub name: String,
    /// That of the first and of the second face.
    pub values: [Option<T>; 2],
}

/// A landmark of a moved face.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct MovedLandmark {
    /// Where it is at rest, mm.
    pub rest_mm: Vec3,
    /// How far it moved, mm.
    pub displacement_mm: Vec3,
}

/// How symmetric a moved face is.
#[derive(Clone, Debug, PartialEq)]
pub struct Sides {
    /// Left activation minus right one, of each pair of muscles by name without side.
    pub activation: Vec<(String, f64)>,
    /// Root mean square of those; `None` without a pair.
    pub activation_rms: Option<f64>,
    /// Length of `u_l - M u_r`, mm, of each pair of landmarks by name without side, `M` the mirror in the mid-sagittal
    /// plane.
    pub landmarks_mm: Vec<(String, f64)>,
    /// Root mean square of those, mm; `None` without a pair.
    pub landmarks_rms_mm: Option<f64>,
}

/// Two moved faces set against each other.
#[derive(Clone, Debug, PartialEq)]
pub struct Comparison {
    /// Activations, the muscles of the first face in its order, then those of the second alone.
    pub activations: Vec<Pair<f64>>,
    /// Landmarks, in the same order.
    pub landmarks: Vec<Pair<MovedLandmark>>,
    /// How symmetric each is.
    pub sides: [Sides; 2],
}

impl<T> Pair<T> {
    /// Both values, where both faces have one.
    pub fn both(&self) -> Option<[&T; 2]> {
        let [a, b] = &self.values;
        Some([a.as_ref()?, b.as_ref()?])
    }
}

impl Comparison {
    /// `faces` set against each other; muscles and landmarks are matched by name.
    ///
    /// # Requires
    /// Activations (m) and displacements (3n) of their faces.
    pub fn of(faces: [Posed<'_>; 2]) -> Self {
        let activations = faces.map(|p| {
            let names = p.face.muscles.iter().map(|m| m.name.clone());
            names.zip(p.activation.iter().copied()).collect::<Vec<_>>()
        });
        let landmarks = faces.map(|p| {
            let moved = |l: &Landmark| MovedLandmark {
                rest_mm: l.site.position,
                displacement_mm: l.site.displacement(p.displacement),
            };
            p.face.landmarks.iter().map(|l| (l.name.clone(), moved(l))).collect::<Vec<_>>()
        });
        let sides = [0, 1].map(|k| Sides::of(&activations[k], &landmarks[k]));
        Self { activations: matched(&activations), landmarks: matched(&landmarks), sides }
    }
}

impl Sides {
    fn of(activations: &[(String, f64)], landmarks: &[(String, MovedLandmark)]) -> Self {
        let activation: Vec<(String, f64)> =
            mirrored_pairs(activations).map(|Mirrored { stem, left, right }| (stem, left - right)).collect();
        let landmarks_mm: Vec<(String, f64)> = mirrored_pairs(landmarks)
            .map(|Mirrored { stem, left, right }| {
                let [l, mut r] = [left.displacement_mm, right.displacement_mm];
                r.x = -r.x;
                (stem, (l - r).norm())
            })
            .collect();
        let rms = |all: &[(String, f64)]| {
            let sum: f64 = all.iter().map(|(_, x)| x * x).sum();
            (!all.is_empty()).then(|| (sum / all.len() as f64).sqrt())
        };
        let (activation_rms, landmarks_rms_mm) = (rms(&activation), rms(&landmarks_mm));
        Self { activation, activation_rms, landmarks_mm, landmarks_rms_mm }
    }
}

/// What two lists have, by name.
pub fn matched<T: Copy>(lists: &[Vec<(String, T)>; 2]) -> Vec<Pair<T>> {
    let of = |list: &[(String, T)], name: &str| list.iter().find(|(n, _)| n == name).map(|(_, value)| *value);
    let mut seen = BTreeSet::new();
    let names = lists.iter().flatten().map(|(name, _)| name).filter(|name| seen.insert((*name).clone()));
    names
        .map(|name| Pair { name: name.clone(), values: [of(&lists[0], name), of(&lists[1], name)] })
        .collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn what_one_alone_has_is_told_in_order() {
        let list = |names: &[&str]| names.iter().map(|n| ((*n).to_owned(), 1.)).collect::<Vec<_>>();
        let pairs = matched(&[list(&["b", "a"]), list(&["c", "a"])]);
        let told: Vec<(&str, bool, bool)> =
            pairs.iter().map(|p| (&*p.name, p.values[0].is_some(), p.values[1].is_some())).collect();
        assert_eq!(told, [("b", true, false), ("a", true, true), ("c", false, true)]);
    }

    #[test]
    fn mirrored_movements_are_symmetric_and_the_rest_is_counted() {
        let moved =
            |x: f64, y: f64| MovedLandmark { rest_mm: Vec3::zeros(), displacement_mm: Vec3::new(x, y, 0.) };
        let named = |n: &str| n.to_owned();
        let landmarks = [
            (named("a_l"), moved(2., 1.)),
            (named("a_r"), moved(-2., 1.)),
            (named("b_r"), moved(3., 0.)),
            (named("b_l"), moved(3., 8.)),
            (named("middle"), moved(9., 9.)),
        ];
        let sides = Sides::of(&[(named("m_l"), 0.5), (named("m_r"), 0.2)], &landmarks);
        assert_eq!(sides.landmarks_mm, [(named("a"), 0.), (named("b"), 10.)]);
        assert_eq!(sides.landmarks_rms_mm, Some(50f64.sqrt()));
        assert_eq!(sides.activation, [(named("m"), 0.3)]);
    }
}
