//! What a file of markers cannot say of itself.

use std::path::Path;

use crate::units::LengthUnit;

/// What a file of markers may leave unsaid; the default leaves all to the file.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct ReadOptions<'a> {
    /// The unit of its lengths; it goes before the one that the file states.
    pub unit: Option<LengthUnit>,
    /// Frames a second of a file that numbers its frames and gives no time; it goes before the rate that the file states.
    pub rate_hz: Option<f64>,
    /// The file of the positions from which the displacements of a table count.
    pub neutral: Option<&'a Path>,
    /// Width and height in pixels of the image of which landmarks are shares; they go before those that the file states.
    pub image: Option<[f64; 2]>,
    /// What tells how large the face in an image is.
    pub scale: ImageScale<'a>,
}

/// What tells how large a face in an image is.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub enum ImageScale<'a> {
    /// Its irises, which are 11.77 mm wide.
    #[default]
    Iris,
    /// A length that was measured.
    Length {
        /// A landmark, or `p` and the index of a point.
        from: &'a str,
        /// Another.
        to: &'a str,
        /// The distance between them, mm.
        length_mm: f64,
    },
}
