//! What a term of the objective is.

use nalgebra::DVector;

/// Where the objective is linearised.
#[derive(Clone, Debug, PartialEq)]
pub struct State {
    /// Displacements `P u` of the observed points (d = 3p, point-major xyz), mm.
    pub observed: DVector<f64>,
    /// Activations `a` (m), and after them the share of the jaw's opening where that is unknown.
    pub activation: DVector<f64>,
}

/// A residual and its derivatives, weighted and therefore dimensionless.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Row {
    /// The residual at the state.
    pub value: f64,
    /// Derivative by the observed displacements: (row of `P u`, 1/mm).
    pub observed: Vec<(usize, f64)>,
    /// Derivative by the activations, and the share of the jaw's opening: (unknown, 1).
    pub activation: Vec<(usize, f64)>,
}

/// A part of the objective: `1/2 sum r^2 + sum slope x` over its residuals `r` and the unknowns `x`.
///
/// What is observed makes residuals; what a unit of an unknown costs, however much of it there is already, is a slope.
pub trait Term: std::fmt::Debug + Send + Sync {
    /// The residuals at `state` with their derivatives.
    fn rows(&self, state: &State) -> Vec<Row>;

    /// The slopes of the linear part, dimensionless: (unknown, slope). Most terms have none.
    fn slopes(&self) -> Vec<(usize, f64)> {
        Vec::new()
    }

    /// Whether the derivatives are the same at every state.
    fn is_linear(&self) -> bool {
        true
    }
}

/// `1/2 sum r^2 + sum slope x` of `terms` at `state`.
pub fn objective(terms: &[Box<dyn Term>], state: &State) -> f64 {
    let squares = terms.iter().flat_map(|term| term.rows(state)).map(|row| 0.5 * row.value * row.value);
    squares.sum::<f64>() + linear(terms.iter().flat_map(|term| term.slopes()), &state.activation)
}

/// `sum slope x` at the unknowns `x`.
pub(super) fn linear(slopes: impl IntoIterator<Item = (usize, f64)>, x: &DVector<f64>) -> f64 {
    slopes.into_iter().map(|(k, slope)| slope * x[k]).sum()
}
