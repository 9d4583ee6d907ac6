//! Named columns over the nodes or vessels of a network: what every writer of tables and attributes is given.

/// A column with one value a row.
#[derive(Debug, Clone, PartialEq)]
pub struct Column {
    /// The header, with its unit (`length_mm`).
    pub name: &'static str,
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
