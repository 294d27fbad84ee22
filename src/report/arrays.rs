//! Numbers of a page in one block of bytes.

use std::io::Write;

use base64::Engine;
use base64::engine::general_purpose::STANDARD;
use flate2::Compression;
use flate2::write::ZlibEncoder;
use serde::Serialize;

/// Largest magnitude of a quantised value.
const FULL: f64 = 32767.;

/// Where an array lies in the block: little-endian values of `kind`, each to be multiplied by `scale`.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub(super) struct ArrayRef {
    /// First byte; aligned to four.
    at: usize,
    /// Number of values.
    len: usize,
    kind: Kind,
    scale: f64,
}

#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize)]
#[serde(rename_all = "lowercase")]
enum Kind {
    U8,
    I16,
    U16,
    U32,
}

/// The block, as it grows.
#[derive(Clone, Debug, Default)]
pub(super) struct Arrays {
    bytes: Vec<u8>,
}

impl Arrays {
    fn put(&mut self, kind: Kind, scale: f64, len: usize, bytes: impl Iterator<Item = u8>) -> ArrayRef {
        let at = self.bytes.len();
        self.bytes.extend(bytes);
        self.bytes.resize(self.bytes.len().next_multiple_of(4), 0);
        ArrayRef { at, len, kind, scale }
    }

    /// Reals to within 1/65534 of the largest; what is not finite becomes zero.
    pub(super) fn reals(&mut self, values: &[f64]) -> ArrayRef {
        let largest = values.iter().filter(|v| v.is_finite()).fold(0., |most: f64, v| most.max(v.abs()));
        let scale = if largest > 0. { largest / FULL } else { 1. };
        // A cast takes what is not a number to zero.
        let bytes = values.iter().flat_map(|v| ((v / scale).round() as i16).to_le_bytes());
        self.put(Kind::I16, scale, values.len(), bytes)
    }

    /// Shares from 0 to 1, to within 1/131070.
    pub(super) fn shares(&mut self, values: &[f64]) -> ArrayRef {
        let full = f64::from(u16::MAX);
        let bytes = values.iter().flat_map(|v| ((v.clamp(0., 1.) * full).round() as u16).to_le_bytes());
        self.put(Kind::U16, 1. / full, values.len(), bytes)
    }

    /// Indices, in two bytes each where that is enough.
    pub(super) fn indices(&mut self, values: &[usize]) -> ArrayRef {
        match values.iter().all(|v| *v <= usize::from(u16::MAX)) {
            true => {
                self.put(Kind::U16, 1., values.len(), values.iter().flat_map(|v| (*v as u16).to_le_bytes()))
            }
            false => {
                self.put(Kind::U32, 1., values.len(), values.iter().flat_map(|v| (*v as u32).to_le_bytes()))
            }
        }
    }

    /// Bytes as they are.
    pub(super) fn bytes(&mut self, values: &[u8]) -> ArrayRef {
        self.put(Kind::U8, 1., values.len(), values.iter().copied())
    }

    /// The block as zlib in base64.
    pub(super) fn to_base64(&self) -> std::io::Result<String> {
        let mut zlib = ZlibEncoder::new(Vec::new(), Compression::best());
        zlib.write_all(&self.bytes)?;
        Ok(STANDARD.encode(zlib.finish()?))
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn values_come_back_to_what_is_promised() {
        let mut arrays = Arrays::default();
        arrays.bytes(&[1, 2, 3]);
        let given = [12.5, -3.25, 0., f64::NAN, 1e-6];
        let ArrayRef { at, len, kind, scale } = arrays.reals(&given);
        assert_eq!((at, len, kind), (4, 5, Kind::I16));
        for (k, value) in given.iter().enumerate() {
            let byte = at + 2 * k;
            let read = f64::from(i16::from_le_bytes([arrays.bytes[byte], arrays.bytes[byte + 1]])) * scale;
            assert!((read - if value.is_nan() { 0. } else { *value }).abs() <= 12.5 / 65534. + 1e-12);
        }
        assert_eq!(arrays.indices(&[0, 65_535]).kind, Kind::U16);
        assert_eq!(arrays.indices(&[0, 65_536]).kind, Kind::U32);
        assert_eq!(arrays.reals(&[0.; 3]).scale, 1.);
    }
}
