//! Who touches whom, and how hard.

use super::Body;
use super::term::{Term, Terms};
use crate::units::Vec3;

/// A vertex and what it meets, or two edges, that push each other.
#[derive(Clone, Debug, PartialEq)]
pub struct ContactPoint {
    /// What either side belongs to.
    pub bodies: [Body; 2],
    /// Vertices (0-based) of either side, one to three.
    pub vertices: [Vec<usize>; 2],
    /// Middle of the gap, mm.
    pub position: Vec3,
    /// Width of the gap, mm.
    pub gap_mm: f64,
    /// Force on the first side, N; that on the second is its negative.
    pub force_n: Vec3,
}

impl Terms<'_> {
    pub(super) fn contact_point(&self, term: &Term) -> ContactPoint {
        let (first, second) = term.vertices[..term.n].split_at(term.n_first);
        let sides = [first, second].map(|side| side.iter().map(|&v| v as usize).collect::<Vec<_>>());
        let gradient = term.gradient(self.barrier, self.x);
        let x = Term::places(term.vertices, self.x);
        let shares = term.separation.shares;
        let on_first: Vec3 = (0..4).filter(|&i| shares[i] > 0.).map(|i| shares[i] * x[i]).sum();
        ContactPoint {
            bodies: [first[0], second[0]].map(|v| self.surface.body(v as usize)),
            position: on_first - 0.5 * term.separation.offset,
            gap_mm: term.separation.distance(),
            force_n: -gradient[..term.n_first].iter().sum::<Vec3>(),
            vertices: sides,
        }
    }
}
