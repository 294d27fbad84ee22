//! Archives of NumPy arrays.

use std::io::{self, Cursor, Write};

use npyz::WriterBuilder;
use zip::write::SimpleFileOptions;
use zip::{CompressionMethod, DateTime, ZipWriter};

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
