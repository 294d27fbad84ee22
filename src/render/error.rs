//! Why there is no picture.

use thiserror::Error;

/// Why there is no picture.
#[derive(Clone, Debug, Error, PartialEq)]
#[non_exhaustive]
pub enum RenderError {
    /// A displacement or activation of another face.
    #[error("{what} has {found} values and the face needs {expected}; compute it on this face")]
    Length {
        /// What has them.
        what: &'static str,
        /// How many it has.
        found: usize,
        /// How many are needed.
        expected: usize,
    },
    /// A value that is not finite.
    #[error("{what} is not finite at {index}; compute it again")]
    NotFinite {
        /// What is not.
        what: &'static str,
        /// Position of the first such value.
        index: usize,
    },
    /// A picture too small or too large.
    #[error("a picture of {width} x {height} pixels; each side may be from {least} to {most}")]
    Size {
        /// Pixels across.
        width: usize,
        /// Pixels down.
        height: usize,
        /// Fewest pixels of a side.
        least: usize,
        /// Most pixels of a side.
        most: usize,
    },
    /// A picture that the format cannot hold.
    #[error("the picture does not fit into a PNG file: {0}; make it smaller")]
    Png(String),
}
