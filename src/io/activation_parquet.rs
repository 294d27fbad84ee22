//! Activations over time as Apache Parquet.

use std::io::{self, Error};
use std::sync::Arc;

use parquet::basic::{Repetition, Type as PhysicalType};
use parquet::data_type::DoubleType;
use parquet::file::properties::WriterProperties;
use parquet::file::writer::SerializedFileWriter;
use parquet::schema::types::Type;

use super::ActivationTable;

impl ActivationTable {
    /// As Apache Parquet: `time_s` and the muscles, doubles that are never null. The same table gives the same bytes.
    ///
    /// # Errors
    /// When it cannot be put together.
    pub fn parquet(&self) -> io::Result<Vec<u8>> {
        let column = |name: &str| {
            Type::primitive_type_builder(name, PhysicalType::DOUBLE)
                .with_repetition(Repetition::REQUIRED)
                .build()
                .map(Arc::new)
        };
        let names = std::iter::once("time_s").chain(self.muscles.iter().map(String::as_str));
        let fields = names.map(column).collect::<Result<Vec<_>, _>>().map_err(Error::other)?;
        let schema = Type::group_type_builder("frames").with_fields(fields).build().map_err(Error::other)?;
        let properties = WriterProperties::builder()
            .set_created_by(concat!("modiolus ", env!("CARGO_PKG_VERSION")).to_owned())
            .build();
        let mut bytes = Vec::new();
        let mut writer = SerializedFileWriter::new(&mut bytes, Arc::new(schema), Arc::new(properties))
            .map_err(Error::other)?;
        let mut group = writer.next_row_group().map_err(Error::other)?;
        let mut index = 0;
        while let Some(mut column) = group.next_column().map_err(Error::other)? {
            let values: Vec<f64> = match index {
                0 => self.times_s.clone(),
                k => self.rows.iter().map(|row| row[k - 1]).collect(),
            };
            column.typed::<DoubleType>().write_batch(&values, None, None).map_err(Error::other)?;
            column.close().map_err(Error::other)?;
            index += 1;
        }
        group.close().map_err(Error::other)?;
        writer.close().map_err(Error::other)?;
        Ok(bytes)
    }
}

#[cfg(test)]
mod tests {
    use std::io::Write;

    use parquet::file::reader::{FileReader, SerializedFileReader};
    use parquet::record::RowAccessor;

    use super::*;

    #[test]
    fn what_is_written_is_read_again() {
        let table = ActivationTable {
            muscles: vec!["a".into(), "b".into()],
            times_s: vec![0., 0.1],
            rows: vec![vec![0.5, 1. / 3.], vec![0., 1.]],
        };
        let bytes = table.parquet().expect("written");
        assert_eq!(bytes, table.parquet().expect("written"));
        let mut file = tempfile::tempfile().expect("a file");
        file.write_all(&bytes).expect("written");
        let reader = SerializedFileReader::new(file).expect("read");
        let rows: Vec<_> = reader.get_row_iter(None).expect("rows").map(|row| row.expect("row")).collect();
        let value = |row: usize, k| rows[row].get_double(k).expect("a number");
        assert_eq!([value(0, 0), value(0, 1), value(0, 2), value(1, 0)], [0., 0.5, 1. / 3., 0.1]);
        assert_eq!((rows.len(), value(1, 2)), (2, 1.));
    }
}
