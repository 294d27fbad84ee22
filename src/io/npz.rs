//! Archives of NumPy arrays.

use std::io::{self, Cursor, Write};

use npyz::WriterBuilder;
use zip::write::SimpleFileOptions;
use zip::{CompressionMethod, DateTime, ZipWriter};

use crate::face::Landmark;
use crate::units::Vec3;

/// A zip of NumPy arrays that NumPy opens with `allow_pickle=False`.
///
/// The arrays are stored, not compressed, under a fixed date: the same arrays give the same bytes.
pub(super) struct Npz(ZipWriter<Cursor<Vec<u8>>>);

impl Npz {
    /// Without arrays.
    pub(super) fn new() -> Self {
        Self(ZipWriter::new(Cursor::new(Vec::new())))
    }

    /// The array `name` of numbers, the last index fastest.
    pub(super) fn numbers(
        &mut self,
        name: &str,
        shape: &[u64],
        values: impl IntoIterator<Item = f64>,
    ) -> io::Result<()> {
        let mut bytes = Vec::new();
        let options = npyz::WriteOptions::new().dtype(npyz::DType::Plain(little_endian("<f8")?));
        let mut writer = options.shape(shape).writer(&mut bytes).begin_nd()?;
        writer.extend(values)?;
        writer.finish()?;
        self.add(name, &bytes)
    }

    /// The array `name` of texts.
    pub(super) fn names(&mut self, name: &str, values: &[String]) -> io::Result<()> {
        let width = values.iter().map(|v| v.chars().count()).max().unwrap_or(0).max(1);
        let mut bytes = Vec::new();
        let kind = npyz::DType::Plain(little_endian(&format!("<U{width}"))?);
        let options = npyz::WriteOptions::new().dtype(kind);
        let mut writer = options.shape(&[values.len() as u64]).writer(&mut bytes).begin_nd()?;
        for value in values {
            writer.push(value.as_str())?;
        }
        writer.finish()?;
        self.add(name, &bytes)
    }

    /// Of points (l) on a face their names as `landmarks`, places as `landmark_points` (l, 3), mm, and displacements in each of
    /// `fields` (3n) as `landmark_displacement`, of `shape` before the last two indices.
    pub(super) fn landmarks(
        &mut self,
        landmarks: &[Landmark],
        shape: &[u64],
        fields: &[&[f64]],
    ) -> io::Result<()> {
        let names: Vec<String> = landmarks.iter().map(|landmark| landmark.name.clone()).collect();
        self.names("landmarks", &names)?;
        let rows = [landmarks.len() as u64, 3];
        let xyz = |v: Vec3| [v.x, v.y, v.z];
        self.numbers("landmark_points", &rows, landmarks.iter().flat_map(|l| xyz(l.site.position)))?;
        let moved =
            |u: &&[f64]| landmarks.iter().flat_map(|l| xyz(l.site.displacement(u))).collect::<Vec<_>>();
        self.numbers("landmark_displacement", &[shape, &rows].concat(), fields.iter().flat_map(moved))
    }

    /// The bytes of the archive.
    pub(super) fn finish(self) -> io::Result<Vec<u8>> {
        Ok(self.0.finish()?.into_inner())
    }

    fn add(&mut self, name: &str, npy: &[u8]) -> io::Result<()> {
        // Not the clock: two runs must give the same bytes. MS-DOS dates begin here.
        let options = SimpleFileOptions::default()
            .compression_method(CompressionMethod::Stored)
            .last_modified_time(DateTime::default())
            .unix_permissions(0o644)
            .large_file(u32::try_from(npy.len()).is_err());
        self.0.start_file(format!("{name}.npy"), options)?;
        self.0.write_all(npy)
    }
}

fn little_endian(code: &str) -> io::Result<npyz::TypeStr> {
    code.parse().map_err(|e| io::Error::other(format!("{code}: {e}")))
}
