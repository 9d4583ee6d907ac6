//! Right bridges as a table: the ends of each, as a person lists them or leaves them in a corrected edges.csv.

use super::graph_columns::END_PLACES;
use super::rows::Rows;
use crate::error::Fault;
use crate::network::units::metres;
use crate::support::geometry::Point;

/// A bridge of a table.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct ListedBridge {
    /// Its line, counted from 1.
    pub line: usize,
    /// Its two ends, m.
    pub ends: [Point; 2],
}

/// Reads the columns `ax_mm,ay_mm,az_mm,bx_mm,by_mm,bz_mm`; where there is a column `kept` only the rows with 1, where there is a
/// column `origin` only candidates.
///
/// # Errors
///
/// The line, its value and what is accepted; a table of no right bridge.
pub fn read_links(bytes: &[u8]) -> Result<Vec<ListedBridge>, Fault> {
    let mut rows = Rows::open(bytes)?;
    let mut columns = [[0; 3]; 2];
    for (columns, names) in columns.iter_mut().zip(END_PLACES) {
        for (column, name) in columns.iter_mut().zip(names) {
            *column = rows.column(&[name], "the ends of every right bridge")?;
        }
    }
    let (kept, origin) = (rows.find(&["kept"]), rows.find(&["origin"]));
    let mut out = Vec::new();
    while let Some(row) = rows.next()? {
        if let Some(kept) = kept {
            match row.text(kept) {
                "1" => {}
                "0" => continue,
                other => return Err(Fault::line(row.line, format!("kept \"{other}\""), "expected 1 or 0")),
            }
        }
        if let Some(origin) = origin {
            match row.text(origin) {
                "candidate" => {}
                "observed" => continue,
                other => return Err(Fault::line(row.line, format!("origin \"{other}\""), "expected observed or candidate")),
            }
        }
        let ends = [row.position(columns[0])?, row.position(columns[1])?].map(|p| p.map(metres));
        out.push(ListedBridge { line: row.line, ends });
    }
    if out.is_empty() {
        let which = if kept.is_some() { "one candidate at least with kept 1" } else { "one row at least" };
        return Err(Fault::file("no right link", format!("expected {which}")));
    }
    Ok(out)
}
