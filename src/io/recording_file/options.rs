//! What a file of markers cannot say of itself.

use std::path::Path;

use crate::units::LengthUnit;

/// What a file of markers may leave unsaid; the default leaves all to the file.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct ReadOptions<'a> {
    /// The unit of its lengths; it goes before the one that the file states.
    pub unit: Option<LengthUnit>,
    /// Frames a second of a table that numbers its frames and gives no time.
    pub rate_hz: Option<f64>,
    /// The file of the positions from which the displacements of a table count.
    pub neutral: Option<&'a Path>,
}
