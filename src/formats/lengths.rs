//! Lengths and positions in a table: in mm where the name of the column says so, else in the unit of the file.

use super::rows::Row;
use crate::error::Fault;
use crate::geometry::Point;
use crate::units::Scale;

impl Row<'_> {
    /// The length in a column, m; NaN for an empty one.
    pub(super) fn length(&self, column: usize, scale: &Scale) -> Result<f64, Fault> {
        Ok(self.scale(column, scale).length(self.real(column)?))
    }

    /// The finite position in three columns, m.
    pub(super) fn point(&self, columns: [usize; 3], scale: &Scale) -> Result<Point, Fault> {
        let position = self.position(columns)?;
        Ok([0, 1, 2].map(|axis| self.scale(columns[axis], scale).position(position)[axis]))
    }

    fn scale(&self, column: usize, scale: &Scale) -> Scale {
        if self.name(column).to_ascii_lowercase().ends_with("_mm") { Scale::default() } else { *scale }
    }
}
