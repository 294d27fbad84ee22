//! OpenSim storage files, `.sto`.

use std::fmt::Write;

/// A table over time as OpenSim reads it (`TimeSeriesTable`): `name`, then a row a time with the values of the `columns`.
///
/// `rows` have one value a column; what is missing is NaN.
pub fn sto_text<'a>(
    name: &str,
    columns: &[String],
    rows: impl ExactSizeIterator<Item = (f64, &'a [f64])>,
) -> String {
    let mut text = format!(
        "{}\nversion=1\nnRows={}\nnColumns={}\ninDegrees=no\nendheader\ntime",
        name.replace(['\n', '\r'], " "),
        rows.len(),
        columns.len() + 1
    );
    for column in columns {
        // The format knows no quotes.
        text.push('\t');
        text.push_str(&column.replace(['\t', '\n', '\r'], " "));
    }
    text.push('\n');
    for (time_s, row) in rows {
        let _ = write!(text, "{time_s}");
        for value in row {
            let _ = write!(text, "\t{value}");
        }
        text.push('\n');
    }
    text
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_header_counts_rows_and_columns() {
        let columns = ["a".to_owned(), "b\tc".to_owned()];
        let rows: [(f64, &[f64]); 2] = [(0., &[0.5, 1.]), (0.1, &[f64::NAN, 0.])];
        let text = sto_text("activations", &columns, rows.into_iter());
        assert_eq!(
            text,
            "activations\nversion=1\nnRows=2\nnColumns=3\ninDegrees=no\nendheader\ntime\ta\tb c\n0\t0.5\t1\n0.1\tNaN\t0\n"
        );
    }
}
