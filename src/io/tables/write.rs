//! CSV tables: one header line, one row a node or vessel, every number with the digits that bring it back.

use std::borrow::Cow;
use std::io::{self, Write};

use super::column::{Column, Values, check_rows};

/// Writes columns of equal length as CSV with `\n` line ends; NaN is an empty field, infinity is `inf`.
///
/// # Errors
///
/// Columns of different lengths (`InvalidInput`), or the writer's own.
pub fn write_csv(out: impl Write, columns: &[Column]) -> io::Result<()> {
    write_table(out, b',', columns)
}

/// The same with another delimiter.
pub(crate) fn write_table(out: impl Write, delimiter: u8, columns: &[Column]) -> io::Result<()> {
    let rows = columns.first().map_or(0, |c| c.values.len());
    check_rows(columns, rows)?;
    let mut csv = csv::WriterBuilder::new().delimiter(delimiter).from_writer(out);
    if !columns.is_empty() {
        csv.write_record(columns.iter().map(|c| &*c.name))?;
    }
    for row in 0..rows {
        for column in columns {
            match &column.values {
                Values::Text(texts) => csv.write_field(plain(&texts[row]).as_bytes())?,
                values => csv.write_field(values.text(row))?,
            }
        }
        csv.write_record(None::<&[u8]>)?;
    }
    csv.flush()
}

/// Whether a spreadsheet would take a text for a formula, after any number of apostrophes.
fn is_formula(text: &str) -> bool {
    text.trim_start_matches('\'').starts_with(['=', '+', '-', '@', '\t', '\r'])
}

/// A text for a table: before what a spreadsheet would take for a formula stands an apostrophe, which readers here take off.
pub fn plain(text: &str) -> Cow<'_, str> {
    if is_formula(text) { Cow::Owned(format!("'{text}")) } else { Cow::Borrowed(text) }
}

/// The text that [`plain`] was given.
pub(crate) fn unplain(text: &str) -> &str {
    text.strip_prefix('\'').filter(|text| is_formula(text)).unwrap_or(text)
}
