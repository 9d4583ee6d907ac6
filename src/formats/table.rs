//! CSV tables: one header line, one row a node or vessel, every number with the digits that bring it back.

use std::io::{self, Write};

use super::column::{Column, check_rows};

/// Writes columns of equal length as CSV with `\n` line ends; NaN is an empty field, infinity is `inf`.
///
/// # Errors
///
/// Columns of different lengths (`InvalidInput`), or the writer's own.
pub fn write_csv(out: impl Write, columns: &[Column]) -> io::Result<()> {
    write_table(out, b',', columns)
}

/// The same with another delimiter.
pub(super) fn write_table(out: impl Write, delimiter: u8, columns: &[Column]) -> io::Result<()> {
    let rows = columns.first().map_or(0, |c| c.values.len());
    check_rows(columns, rows)?;
    let mut csv = csv::WriterBuilder::new().delimiter(delimiter).from_writer(out);
    if !columns.is_empty() {
        csv.write_record(columns.iter().map(|c| c.name))?;
    }
    for row in 0..rows {
        csv.write_record(columns.iter().map(|c| c.values.text(row)))?;
    }
    csv.flush()
}
