//! Plots of results as SVG: colours that are told apart without colour vision, light or dark as the reader's system is.

mod activations;
mod chart;
mod jaw;
mod lengths;
mod recovery;
mod residuals;
mod sides;
mod svg;
mod weights;

pub use activations::{activation_plot, time_plot};
pub(super) use activations::{activations_inline, time_inline};
pub(super) use jaw::jaw_inline;
pub use lengths::length_plot;
pub use recovery::{Recovered, recovery_plot};
pub use residuals::residual_plot;
pub(super) use residuals::residuals_inline;
pub use sides::symmetry_plot;
pub(super) use svg::STYLE;
pub use weights::l_curve_plot;
