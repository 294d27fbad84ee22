//! Lengths between two points.

use nalgebra::DVector;

use crate::inverse::target::Axis;
use crate::inverse::term::{Row, State, Term};
use crate::units::Vec3;

/// A signed component: `r = (e . (x_to + u_to - x_from - u_from) - v) / sigma`.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Component {
    /// Observed point at one end, from 0.
    pub from: usize,
    /// Observed point at the other end, from 0.
    pub to: usize,
    /// Direction `e`.
    pub axis: Axis,
    /// `e . (x_to - x_from)` at rest, mm.
    pub rest_mm: f64,
    /// Value asked for, `v`, mm.
    pub value_mm: f64,
    /// Standard deviation, mm.
    pub sigma_mm: f64,
}

impl Term for Component {
    fn rows(&self, state: &State) -> Vec<Row> {
        let weight = 1.0 / self.sigma_mm;
        let (from, to) = (3 * self.from + self.axis.index(), 3 * self.to + self.axis.index());
        let length = self.rest_mm + state.observed[to] - state.observed[from];
        vec![Row {
            value: (length - self.value_mm) * weight,
            observed: vec![(to, weight), (from, -weight)],
            activation: Vec::new(),
        }]
    }
}

/// A distance: `r = (|x_to + u_to - x_from - u_from| - v) / sigma`, linear only about a state.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Distance {
    /// Observed point at one end, from 0.
    pub from: usize,
    /// Observed point at the other end, from 0.
    pub to: usize,
    /// `x_to - x_from` at rest, mm, not zero.
    pub rest_mm: Vec3,
    /// Value asked for, `v`, mm.
    pub value_mm: f64,
    /// Standard deviation, mm.
    pub sigma_mm: f64,
}

impl Distance {
    fn span(&self, observed: &DVector<f64>) -> Vec3 {
        let at =
            |point: usize| Vec3::new(observed[3 * point], observed[3 * point + 1], observed[3 * point + 2]);
        self.rest_mm + at(self.to) - at(self.from)
    }
}

impl Term for Distance {
    fn rows(&self, state: &State) -> Vec<Row> {
        let weight = 1.0 / self.sigma_mm;
        let span = self.span(&state.observed);
        // Two points that meet have no direction; the one at rest keeps the step finite.
        let direction = span.try_normalize(0.0).unwrap_or_else(|| self.rest_mm.normalize());
        let ends = [(self.to, weight), (self.from, -weight)];
        let observed = ends
            .into_iter()
            .flat_map(|(point, w)| (0..3).map(move |axis| (3 * point + axis, w * direction[axis])))
            .collect();
        vec![Row { value: (span.norm() - self.value_mm) * weight, observed, activation: Vec::new() }]
    }

    fn is_linear(&self) -> bool {
        false
    }
}
