//! Named columns over the nodes or vessels of a network, and their CSV: each number with the digits that bring it back.

use std::borrow::Cow;
use std::io::{self, Write};

use willis_core::network::{PathPoint, is_radius, millimetres};

/// A named column with one value per row.
#[derive(Debug, Clone, PartialEq)]
pub struct Column {
    /// The header, with its unit (`length_mm`).
    pub name: Cow<'static, str>,
    /// The values by row.
    pub values: Values,
}

/// The values of a column. A missing number is NaN and is written as an empty field.
#[derive(Debug, Clone, PartialEq)]
pub enum Values {
    /// Numbers, written with the digits that give the same bits again.
    Real(Vec<f64>),
    /// Whole numbers.
    Integer(Vec<i64>),
    /// Text.
    Text(Texts),
}

/// The texts of a column behind one another: of a million words in a few forms a string for each would take five times as much.
#[derive(Debug, Clone, PartialEq, Eq, Default)]
pub struct Texts {
    all: String,
    /// Where each ends.
    ends: Vec<usize>,
}

impl Texts {
    /// Adds one.
    pub(crate) fn push(&mut self, text: &str) {
        self.all.push_str(text);
        self.ends.push(self.all.len());
    }

    /// All by row.
    pub fn iter(&self) -> impl ExactSizeIterator<Item = &str> {
        (0..self.ends.len()).map(|row| &self[row])
    }
}

impl std::ops::Index<usize> for Texts {
    type Output = str;

    fn index(&self, row: usize) -> &str {
        let start = if row == 0 { 0 } else { self.ends[row - 1] };
        &self.all[start..self.ends[row]]
    }
}

impl<S: AsRef<str>> FromIterator<S> for Texts {
    fn from_iter<I: IntoIterator<Item = S>>(texts: I) -> Self {
        let mut made = Self::default();
        texts.into_iter().for_each(|text| made.push(text.as_ref()));
        made.all.shrink_to_fit();
        made.ends.shrink_to_fit();
        made
    }
}

impl Column {
    /// A column of numbers; NaN is missing.
    pub fn real(name: impl Into<Cow<'static, str>>, values: impl Iterator<Item = f64>) -> Self {
        Self { name: name.into(), values: Values::Real(values.collect()) }
    }

    /// A column of whole numbers.
    pub fn whole(name: impl Into<Cow<'static, str>>, values: impl Iterator<Item = usize>) -> Self {
        Self { name: name.into(), values: Values::Integer(values.map(|v| v as i64).collect()) }
    }

    /// A column of text.
    pub fn text(name: impl Into<Cow<'static, str>>, values: impl Iterator<Item = impl AsRef<str>>) -> Self {
        Self { name: name.into(), values: Values::Text(values.collect()) }
    }
}

/// Three columns of coordinates, as they are.
pub fn coordinate_columns<I: Iterator<Item = [f64; 3]>>(names: [&'static str; 3], of: impl Fn() -> I) -> [Column; 3] {
    [0, 1, 2].map(|axis| Column::real(names[axis], of().map(move |at| at[axis])))
}

impl Values {
    /// How many rows there are.
    pub fn rows(&self) -> usize {
        match self {
            Self::Real(values) => values.len(),
            Self::Integer(values) => values.len(),
            Self::Text(values) => values.ends.len(),
        }
    }

    /// The value of a row as text; empty for a missing number.
    pub fn text(&self, row: usize) -> Cow<'_, str> {
        match self {
            Self::Real(values) => real(values[row]).into(),
            Self::Integer(values) => values[row].to_string().into(),
            Self::Text(values) => Cow::Borrowed(&values[row]),
        }
    }
}

/// The shortest text that gives the same number again; empty for NaN.
pub(crate) fn real(x: f64) -> String {
    if x.is_nan() {
        String::new()
    } else if x == 0.0 || x.is_infinite() || (1e-5..1e16).contains(&x.abs()) {
        x.to_string()
    } else {
        format!("{x:e}")
    }
}

/// The position and the radius of a point in mm; a missing radius is `missing`.
pub(crate) fn figures(point: &PathPoint, missing: &str) -> [String; 4] {
    let [x, y, z] = point.position.map(|x| real(millimetres(x)));
    let radius = if is_radius(point.radius) { real(millimetres(point.radius)) } else { missing.to_owned() };
    [x, y, z, radius]
}

/// Checks that every column has one value for each of `rows`.
pub(crate) fn check_rows(columns: &[Column], rows: usize) -> io::Result<()> {
    columns.iter().find(|column| column.values.rows() != rows).map_or(Ok(()), |Column { name, values }| {
        Err(crate::formats::refused(format!("column {name} has {} values for {rows} rows", values.rows())))
    })
}

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
    let rows = columns.first().map_or(0, |c| c.values.rows());
    check_rows(columns, rows)?;
    let mut csv = csv::WriterBuilder::new().delimiter(delimiter).from_writer(out);
    if !columns.is_empty() {
        csv.write_record(columns.iter().map(|column| escape_formula(&column.name).into_owned()))?;
    }
    for row in 0..rows {
        for column in columns {
            match &column.values {
                Values::Text(texts) => csv.write_field(escape_formula(&texts[row]).as_bytes())?,
                values => csv.write_field(values.text(row).as_bytes())?,
            }
        }
        csv.write_record(None::<&[u8]>)?;
    }
    csv.flush()
}

/// Writes tables of the same columns as one, one below the other.
///
/// # Errors
///
/// As [`write_csv`].
pub fn write_stacked(mut out: impl Write, tables: &[&[Column]]) -> io::Result<()> {
    for (at, columns) in tables.iter().enumerate() {
        let mut table = Vec::new();
        write_csv(&mut table, columns)?;
        let header = table.iter().position(|byte| *byte == b'\n').map_or(0, |end| end + 1);
        out.write_all(&table[if at == 0 { 0 } else { header }..])?;
    }
    Ok(())
}

/// Whether a spreadsheet would take a text for a formula, leading apostrophes aside.
fn is_formula(text: &str) -> bool {
    text.trim_start_matches('\'').starts_with(['=', '+', '-', '@', '\t', '\r', '＝', '＋', '－', '＠'])
}

/// The text for a table cell. Text that a spreadsheet would take for a formula gets a leading apostrophe, which
/// `unescape_formula` removes.
pub fn escape_formula(text: &str) -> Cow<'_, str> {
    if is_formula(text) { Cow::Owned(format!("'{text}")) } else { Cow::Borrowed(text) }
}

/// The text that [`escape_formula`] wrote.
pub(crate) fn unescape_formula(text: &str) -> &str {
    text.strip_prefix('\'').filter(|text| is_formula(text)).unwrap_or(text)
}
