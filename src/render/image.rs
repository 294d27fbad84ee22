//! A picture, its text, and its bytes.

use noto_sans_mono_bitmap::{FontWeight, RasterHeight, get_raster};

use super::RenderError;

/// Width of a letter, pixels: the font has one.
pub const LETTER: usize = 7;
/// Height of a line of text, pixels.
pub const LINE: usize = 16;

/// A picture of sRGB pixels, row by row from the upper left.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Image {
    /// Pixels to a row.
    pub width: usize,
    /// Rows.
    pub height: usize,
    /// The pixels.
    pub pixels: Vec<[u8; 3]>,
}

impl Image {
    /// A white picture.
    pub fn new(width: usize, height: usize) -> Self {
        Self { width, height, pixels: vec![[255; 3]; width * height] }
    }

    /// Sets the pixel at (`x`, `y`) towards `colour` by `cover` (0 to 255); nothing outside the picture.
    pub fn blend(&mut self, x: i64, y: i64, colour: [u8; 3], cover: u8) {
        let inside = |v: i64, end: usize| usize::try_from(v).ok().filter(|v| *v < end);
        if let (Some(x), Some(y)) = (inside(x, self.width), inside(y, self.height)) {
            let pixel = &mut self.pixels[y * self.width + x];
            for (p, c) in pixel.iter_mut().zip(colour) {
                let (old, new, cover) = (u32::from(*p), u32::from(c), u32::from(cover));
                *p = ((old * (255 - cover) + new * cover + 127) / 255) as u8;
            }
        }
    }

    /// Fills the box from (`x`, `y`) of `width` x `height` pixels.
    pub fn fill(&mut self, x: i64, y: i64, width: usize, height: usize, colour: [u8; 3]) {
        for row in 0..height as i64 {
            for column in 0..width as i64 {
                self.blend(x + column, y + row, colour, 255);
            }
        }
    }

    /// Writes `text` with its upper left corner at (`x`, `y`); letters beyond ASCII become `?`.
    pub fn write(&mut self, x: i64, y: i64, text: &str, bold: bool, colour: [u8; 3]) {
        let weight = if bold { FontWeight::Bold } else { FontWeight::Regular };
        let letter = |c: char| get_raster(c, weight, RasterHeight::Size16);
        for (k, c) in text.chars().enumerate() {
            let Some(raster) = letter(c).or_else(|| letter('?')) else { continue };
            for (row, line) in raster.rows().enumerate() {
                for (column, &cover) in line.iter().enumerate() {
                    self.blend(x + (k * LETTER + column) as i64, y + row as i64, colour, cover);
                }
            }
        }
    }

    /// Copies `other` with its upper left corner at (`x`, `y`).
    pub fn place(&mut self, x: usize, y: usize, other: &Self) {
        for row in 0..other.height.min(self.height.saturating_sub(y)) {
            let width = other.width.min(self.width.saturating_sub(x));
            let from = &other.pixels[row * other.width..][..width];
            self.pixels[(y + row) * self.width + x..][..width].copy_from_slice(from);
        }
    }

    /// The picture as a PNG file: the same bytes for the same pixels.
    ///
    /// # Errors
    /// [`RenderError::Png`] when the picture is too large for the format.
    pub fn to_png(&self) -> Result<Vec<u8>, RenderError> {
        let side =
            |n: usize| u32::try_from(n).map_err(|_| RenderError::Png("a side over 2^32 pixels".into()));
        let told = |e: png::EncodingError| RenderError::Png(e.to_string());
        let mut bytes = Vec::new();
        let mut encoder = png::Encoder::new(&mut bytes, side(self.width)?, side(self.height)?);
        encoder.set_color(png::ColorType::Rgb);
        encoder.set_depth(png::BitDepth::Eight);
        encoder.set_source_srgb(png::SrgbRenderingIntent::Perceptual);
        encoder.set_compression(png::Compression::High);
        encoder.set_filter(png::Filter::Adaptive);
        let mut writer = encoder.write_header().map_err(told)?;
        writer.write_image_data(self.pixels.as_flattened()).map_err(told)?;
        writer.finish().map_err(told)?;
        Ok(bytes)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn text_leaves_ink_inside_its_box_only() {
        let mut image = Image::new(80, 40);
        image.write(10, 10, "10 mm", true, [0; 3]);
        let ink = |k: &usize| image.pixels[*k] != [255; 3];
        let inked: Vec<usize> = (0..80 * 40).filter(ink).collect();
        assert!(inked.len() > 40);
        assert!(
            inked
                .iter()
                .all(|k| (10..10 + 5 * LETTER).contains(&(k % 80)) && (10..10 + LINE).contains(&(k / 80)))
        );
        image.write(-30, -9, "off the picture", false, [0; 3]);
        image.write(70, 35, "off the picture", false, [0; 3]);
    }

    #[test]
    fn a_png_reads_back() {
        let mut image = Image::new(5, 3);
        image.fill(1, 1, 2, 1, [10, 200, 30]);
        let bytes = image.to_png().expect("small");
        let mut reader = png::Decoder::new(std::io::Cursor::new(&bytes)).read_info().expect("a PNG");
        let mut pixels = vec![0; reader.output_buffer_size().expect("a size")];
        reader.next_frame(&mut pixels).expect("a frame");
        assert_eq!(pixels, image.pixels.as_flattened());
    }
}
