//! CSV of landmarks: `label,x_mm,y_mm,z_mm`, one a row.

use std::io::{self, Write};

use super::rows::Rows;
use crate::error::Fault;
use crate::network::units::{Scale, millimetres};
use crate::support::geometry::Point;

/// A landmark of a table.
#[derive(Debug, Clone, PartialEq)]
pub struct ListedLandmark {
    /// Its line, counted from 1.
    pub line: usize,
    /// Its label as given.
    pub label: String,
    /// Where, m.
    pub position: Point,
}

/// Reads the columns `label,x_mm,y_mm,z_mm`, or `x,y,z` in the unit of `scale`. Rows that begin with `#` are comments.
///
/// # Errors
///
/// A missing column; the line and a value that is no finite number; no row.
pub fn read_landmarks(bytes: &[u8], scale: &Scale) -> Result<Vec<ListedLandmark>, Fault> {
    const WHAT: &str = "label,x_mm,y_mm,z_mm";
    // A comment has as many columns as it has commas.
    let mut rows = Rows::ragged(bytes)?;
    let label = rows.column(&["label"], WHAT)?;
    let place = [rows.column(&["x_mm", "x"], WHAT)?, rows.column(&["y_mm", "y"], WHAT)?, rows.column(&["z_mm", "z"], WHAT)?];
    let mut landmarks = Vec::new();
    while let Some(row) = rows.next()? {
        if row.texts().next().is_none() || row.text(0).starts_with('#') {
            continue;
        }
        landmarks.push(ListedLandmark { line: row.line, label: row.text(label).to_owned(), position: row.point(place, scale)? });
    }
    if landmarks.is_empty() {
        return Err(Fault::file("no landmark", "expected a row for every landmark"));
    }
    Ok(landmarks)
}

/// Writes landmarks: `label,x_mm,y_mm,z_mm`.
///
/// # Errors
///
/// Those of `out`.
pub fn write_landmarks(mut out: impl Write, landmarks: &[(&str, Point)]) -> io::Result<()> {
    writeln!(out, "label,x_mm,y_mm,z_mm")?;
    for (label, position) in landmarks {
        let [x, y, z] = position.map(millimetres);
        writeln!(out, "{label},{x},{y},{z}")?;
    }
    out.flush()
}
