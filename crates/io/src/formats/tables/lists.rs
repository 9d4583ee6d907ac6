//! Small tables that a person writes beside an input: correct connections, links that close loops.

use std::io::{self, Write};

use super::reader::{TableReader, uncommented};
use willis_core::{error::Fault, support::geometry::Point};

/// A candidate that a person lists as correct.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct KnownConnection {
    /// Its line, counted from 1.
    pub line: usize,
    /// The positions of its two ends, m.
    pub ends: [Point; 2],
}

/// Reads the correct candidates, as a person lists them or leaves them in a corrected edges.csv: the columns
/// `ax_mm,ay_mm,az_mm,bx_mm,by_mm,bz_mm`. With a column `kept` only the rows with 1 count, with a
/// column `origin` only the candidates.
///
/// # Errors
///
/// A missing column, a value that is wrong, a table without a correct candidate.
pub fn read_links(bytes: &[u8]) -> Result<Vec<KnownConnection>, Fault> {
    let mut rows = TableReader::open(bytes)?;
    let [a, b] = crate::formats::END_POSITION_COLUMNS;
    let of_end = |[x, y, z]: [&str; 3]| rows.columns([&[x], &[y], &[z]], "the ends of every correct candidate");
    let columns = [of_end(a)?, of_end(b)?];
    let (kept, origin) = (rows.find(&["kept"]), rows.find(&["origin"]));
    let mut out = Vec::new();
    while let Some(row) = rows.row()? {
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
                "observed" | "contact" => continue,
                other => {
                    return Err(Fault::line(row.line, format!("origin \"{other}\""), "expected observed, candidate or contact"));
                }
            }
        }
        let ends = [row.position(columns[0])?, row.position(columns[1])?].map(|p| p.map(willis_core::network::metres));
        out.push(KnownConnection { line: row.line, ends });
    }
    if out.is_empty() {
        let which = if kept.is_some() { "at least one candidate with kept 1" } else { "at least one row" };
        return Err(Fault::file("no correct candidate", format!("expected {which}")));
    }
    Ok(out)
}

const ACCEPTED: &str = "expected two point ids (id_a,id_b)";

/// Links the pairs of point ids that SWC cannot hold, since they close loops: a table headed `id_a,id_b` or `a,b`, or without a
/// header. Returns the number of links.
///
/// # Errors
///
/// A row that is not a pair of ids of different points.
pub fn add_loops(bytes: &[u8], lines: &mut willis_core::network::Centerlines) -> Result<usize, Fault> {
    let row_of: std::collections::HashMap<u64, u32> = lines.ids.iter().enumerate().map(|(row, id)| (*id, row as u32)).collect();
    let mut link = |line: usize, pair: [&str; 2]| {
        let row = |word: &str| {
            let word = word.split('#').next().unwrap_or_default().trim_end();
            let id = word.parse::<u64>().map_err(|_| Fault::line(line, format!("\"{word}\""), ACCEPTED))?;
            row_of.get(&id).copied().ok_or_else(|| Fault::line(line, format!("point {id} does not exist"), ACCEPTED))
        };
        let [a, b] = [row(pair[0])?, row(pair[1])?];
        if a == b {
            return Err(Fault::line(line, format!("point {} twice", pair[0]), "expected two different points"));
        }
        lines.links.push([a, b]);
        Ok(())
    };
    let text = uncommented(bytes);
    let mut rows = TableReader::open(&text)?;
    let mut added = 0;
    let [a, b] = if let [Some(a), Some(b)] = [rows.find(&["id_a", "a"]), rows.find(&["id_b", "b"])] {
        [a, b]
    } else {
        let [a, b] = rows.header.as_slice() else {
            return Err(Fault::line(rows.header_line, format!("\"{}\"", rows.header.join(",")), ACCEPTED));
        };
        link(rows.header_line, [a, b])?;
        added += 1;
        [0, 1]
    };
    while let Some(row) = rows.row()? {
        link(row.line, [row.text(a), row.text(b)])?;
        added += 1;
    }
    Ok(added)
}

/// Writes id pairs as the table that [`add_loops`] reads.
///
/// # Errors
///
/// The writer's own.
pub fn write_loops(mut out: impl Write, loops: &[[u64; 2]]) -> io::Result<()> {
    writeln!(out, "id_a,id_b")?;
    loops.iter().try_for_each(|[a, b]| writeln!(out, "{a},{b}"))?;
    out.flush()
}
