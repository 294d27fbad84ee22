//! Recordings: measured markers over time, and the activations behind them.

#[expect(clippy::module_inception, reason = "one noun a file")]
mod recording;

pub use recording::{Recording, RecordingError};
