//! Activations over time as OpenSim's storage files, `.sto`.

use super::ActivationTable;

/// `table` under the heading `name` as OpenSim reads it: a header that ends in `endheader`, then `time` and the muscles in
/// columns parted by tabs. Blanks and control characters in names become underscores, as they part columns.
///
/// Source: OpenSim documentation, "Storage (.sto) Files".
pub fn sto_text(name: &str, table: &ActivationTable) -> String {
    let word = |name: &str| -> String {
        name.chars().map(|c| if c.is_whitespace() || c.is_control() { '_' } else { c }).collect()
    };
    let labels: Vec<String> = table.muscles.iter().map(|muscle| word(muscle)).collect();
    let mut text = format!(
        "{}\nversion=1\nnRows={}\nnColumns={}\ninDegrees=no\nendheader\ntime\t{}\n",
        word(name),
        table.times_s.len(),
        1 + labels.len(),
        labels.join("\t")
    );
    for (time, row) in table.times_s.iter().zip(&table.rows) {
        let row: Vec<String> = row.iter().map(f64::to_string).collect();
        text += &format!("{time}\t{}\n", row.join("\t"));
    }
    text
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn rows_and_columns_are_counted() {
        let table = ActivationTable {
            muscles: vec!["a b".to_owned(), "c".to_owned()],
            times_s: vec![0., 0.5],
            rows: vec![vec![0., 1.], vec![0.25, 0.]],
        };
        let expected = "smile\nversion=1\nnRows=2\nnColumns=3\ninDegrees=no\nendheader\ntime\ta_b\tc\n0\t0\t1\n0.5\t0.25\t0\n";
        assert_eq!(sto_text("smile", &table), expected);
    }
}
