//! Named columns over the nodes or vessels of a network: what every writer of tables and attributes is given.

use std::borrow::Cow;
use std::fmt::Write;
use std::io;

/// A column with one value a row.
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
    /// Numbers, written with as many digits as bring the same bits back.
    Real(Vec<f64>),
    /// Whole numbers.
    Integer(Vec<i64>),
    /// Text.
    Text(Vec<String>),
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
    pub fn text(name: impl Into<Cow<'static, str>>, values: impl Iterator<Item = String>) -> Self {
        Self { name: name.into(), values: Values::Text(values.collect()) }
    }
}

impl Values {
    /// How many rows there are.
    pub fn len(&self) -> usize {
        match self {
            Self::Real(values) => values.len(),
            Self::Integer(values) => values.len(),
            Self::Text(values) => values.len(),
        }
    }

    /// Whether there is no row.
    pub fn is_empty(&self) -> bool {
        self.len() == 0
    }

    /// The value of a row as text; empty for a missing number.
    pub(crate) fn text(&self, row: usize) -> String {
        let mut text = String::new();
        self.put(row, &mut text);
        text
    }

    /// Puts the value of a row in place of `text`, which is reused.
    pub(crate) fn put(&self, row: usize, text: &mut String) {
        text.clear();
        // A string takes whatever is written to it.
        let _ = match self {
            Self::Real(values) => put_real(values[row], text),
            Self::Integer(values) => write!(text, "{}", values[row]),
            Self::Text(values) => text.write_str(&values[row]),
        };
    }
}

/// The shortest text that brings the same number back; empty for NaN.
pub(crate) fn real(x: f64) -> String {
    let mut text = String::new();
    let _ = put_real(x, &mut text);
    text
}

/// Adds the text that [`real`] gives.
fn put_real(x: f64, text: &mut String) -> std::fmt::Result {
    if x.is_nan() {
        Ok(())
    } else if x == 0.0 || x.is_infinite() || (1e-5..1e16).contains(&x.abs()) {
        write!(text, "{x}")
    } else {
        write!(text, "{x:e}")
    }
}

/// Refuses columns that do not have one value for each of `rows`.
pub(crate) fn check_rows(columns: &[Column], rows: usize) -> io::Result<()> {
    for column in columns {
        if column.values.len() != rows {
            let found = format!("column {} has {} values for {rows} rows", column.name, column.values.len());
            return Err(io::Error::new(io::ErrorKind::InvalidInput, found));
        }
    }
    Ok(())
}
