//! Activation maps, `map.npz`: a zip of NumPy arrays.

use std::io::{Cursor, Write};

use npyz::WriterBuilder;
use thiserror::Error;
use zip::write::SimpleFileOptions;
use zip::{CompressionMethod, DateTime, ZipWriter};

use crate::units::Vec3;

/// An activation map cannot be written.
#[derive(Debug, Error)]
#[non_exhaustive]
pub enum MapFileError {
    /// Not one field a muscle, or a field that has not three values a point.
    #[error("{fields} fields of {values} values, but {points} points and {muscles} muscles need {muscles} of {}", 3 * points)]
    Shape {
        /// Number of fields.
        fields: usize,
        /// Values of the field that does not fit, or of the first.
        values: usize,
        /// Number of points.
        points: usize,
        /// Number of muscles.
        muscles: usize,
    },
    /// The bytes cannot be put together.
    #[error("map.npz cannot be put together: {0}")]
    Npy(#[from] std::io::Error),
    /// The archive cannot be put together.
    #[error("map.npz cannot be put together: {0}")]
    Zip(#[from] zip::result::ZipError),
}

/// An activation map: what each muscle alone does to each point at full activation, without contact,
/// at one fixed stiffness.
#[derive(Clone, Copy, Debug)]
pub struct MapNpz<'a> {
    /// Rest positions of the `n` points, mm.
    pub points: &'a [Vec3],
    /// Names of the `m` muscles.
    pub muscles: &'a [String],
    /// Columns of `K^-1 F`: for each of the `m` muscles the displacement (3n, node-major xyz), mm per
    /// unit activation.
    pub displacement: &'a [Vec<f64>],
    /// The activation at which every muscle's stiffness is held, 0 to 1.
    pub stiffness: f64,
}

impl MapNpz<'_> {
    /// The bytes of the file: `points` (n, 3) mm, `displacement` (m, n, 3) mm per unit activation,
    /// `muscles` (m) names, `stiffness` () activation at which the stiffness is held.
    ///
    /// The arrays are stored, not compressed, under a fixed date: the same map gives the same bytes.
    /// NumPy opens them with `allow_pickle=False`.
    ///
    /// # Errors
    /// [`MapFileError`] when the shapes do not fit.
    pub fn to_bytes(&self) -> Result<Vec<u8>, MapFileError> {
        let (n, m) = (self.points.len(), self.muscles.len());
        let wrong = self.displacement.iter().map(Vec::len).find(|len| *len != 3 * n);
        if self.displacement.len() != m || wrong.is_some() {
            let (fields, values) = (self.displacement.len(), wrong.unwrap_or(3 * n));
            return Err(MapFileError::Shape { fields, values, points: n, muscles: m });
        }
        let (rows, layers) = (n as u64, m as u64);
        let points = self.points.iter().flat_map(|p| [p.x, p.y, p.z]);
        let displacement = self.displacement.iter().flatten().copied();
        let mut zip = ZipWriter::new(Cursor::new(Vec::new()));
        add(&mut zip, "points", &numbers(&[rows, 3], points)?)?;
        add(&mut zip, "displacement", &numbers(&[layers, rows, 3], displacement)?)?;
        add(&mut zip, "muscles", &names(self.muscles)?)?;
        add(&mut zip, "stiffness", &numbers(&[], [self.stiffness])?)?;
        Ok(zip.finish()?.into_inner())
    }
}

fn add(zip: &mut ZipWriter<Cursor<Vec<u8>>>, name: &str, npy: &[u8]) -> Result<(), MapFileError> {
    // Not the clock: two runs must give the same bytes. MS-DOS dates begin here.
    let options = SimpleFileOptions::default()
        .compression_method(CompressionMethod::Stored)
        .last_modified_time(DateTime::default())
        .unix_permissions(0o644)
        .large_file(u32::try_from(npy.len()).is_err());
    zip.start_file(format!("{name}.npy"), options)?;
    Ok(zip.write_all(npy)?)
}

fn numbers(shape: &[u64], values: impl IntoIterator<Item = f64>) -> std::io::Result<Vec<u8>> {
    let mut bytes = Vec::new();
    let options = npyz::WriteOptions::new().dtype(npyz::DType::Plain(little_endian("<f8")?));
    let mut writer = options.shape(shape).writer(&mut bytes).begin_nd()?;
    writer.extend(values)?;
    writer.finish()?;
    Ok(bytes)
}

fn names(values: &[String]) -> std::io::Result<Vec<u8>> {
    let width = values.iter().map(|v| v.chars().count()).max().unwrap_or(0).max(1);
    let mut bytes = Vec::new();
    let options = npyz::WriteOptions::new().dtype(npyz::DType::Plain(little_endian(&format!("<U{width}"))?));
    let mut writer = options.shape(&[values.len() as u64]).writer(&mut bytes).begin_nd()?;
    for value in values {
        writer.push(value.as_str())?;
    }
    writer.finish()?;
    Ok(bytes)
}

fn little_endian(code: &str) -> std::io::Result<npyz::TypeStr> {
    code.parse().map_err(|e| std::io::Error::other(format!("{code}: {e}")))
}

#[cfg(test)]
mod tests {
    use super::*;

    fn map(displacement: &[Vec<f64>]) -> Result<Vec<u8>, MapFileError> {
        let points = [Vec3::new(1., 2., 3.), Vec3::new(4., 5., 6.)];
        let muscles = ["a".to_owned(), "mentalis_é".to_owned(), "c".to_owned()];
        MapNpz { points: &points, muscles: &muscles, displacement, stiffness: 0.5 }.to_bytes()
    }

    fn entry(bytes: &[u8], name: &str) -> Vec<u8> {
        let mut archive = zip::ZipArchive::new(Cursor::new(bytes)).expect("a zip");
        let mut out = Vec::new();
        std::io::Read::read_to_end(&mut archive.by_name(name).expect("an entry"), &mut out).expect("read");
        out
    }

    #[test]
    fn arrays_come_back_with_their_shapes() {
        let u: Vec<Vec<f64>> =
            (0..3).map(|muscle| (0..6).map(|i| f64::from(10 * muscle + i) + 0.1).collect()).collect();
        let bytes = map(&u).expect("written");
        let npy = entry(&bytes, "displacement.npy");
        let file = npyz::NpyFile::new(&npy[..]).expect("npy");
        assert_eq!(file.shape(), [3, 2, 3]);
        let values: Vec<f64> = file.into_vec().expect("numbers");
        assert_eq!(values, u.concat());
        let npy = entry(&bytes, "muscles.npy");
        let names: Vec<String> = npyz::NpyFile::new(&npy[..]).expect("npy").into_vec().expect("names");
        assert_eq!(names, ["a", "mentalis_é", "c"]);
        assert_eq!(map(&u).expect("written"), bytes);
    }

    #[test]
    fn a_map_of_the_wrong_shape_is_refused() {
        assert!(matches!(
            map(&[vec![0.0; 6], vec![0.0; 5], vec![0.0; 6]]),
            Err(MapFileError::Shape { values: 5, .. })
        ));
        assert!(matches!(map(&[vec![0.0; 6], vec![0.0; 6]]), Err(MapFileError::Shape { fields: 2, .. })));
    }
}
