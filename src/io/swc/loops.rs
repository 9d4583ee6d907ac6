//! The links that SWC cannot hold, since they close loops: a table of pairs of point ids, read and written.

use std::collections::HashMap;
use std::io::{self, Write};

use crate::error::Fault;
use crate::io::tables::rows::{Rows, uncommented};
use crate::network::centerlines::Centerlines;

const ACCEPTED: &str = "expected two point ids (id_a,id_b)";

/// Links the pairs of point ids of a table (headed `id_a,id_b` or `a,b`, or not at all); returns how many.
///
/// # Errors
///
/// A row that is no pair of ids of different points.
pub fn add_loops(bytes: &[u8], lines: &mut Centerlines) -> Result<usize, Fault> {
    let row_of: HashMap<u64, u32> = lines.ids.iter().enumerate().map(|(row, id)| (*id, row as u32)).collect();
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
    let mut rows = Rows::open(&text)?;
    let mut added = 0;
    let [a, b] = if let [Some(a), Some(b)] = [rows.find(&["id_a", "a"]), rows.find(&["id_b", "b"])] {
        [a, b]
    } else {
        let [a, b] = rows.header() else {
            return Err(Fault::line(rows.header_line(), format!("\"{}\"", rows.header().join(",")), ACCEPTED));
        };
        link(rows.header_line(), [a, b])?;
        added += 1;
        [0, 1]
    };
    while let Some(row) = rows.next()? {
        link(row.line, [row.text(a), row.text(b)])?;
        added += 1;
    }
    Ok(added)
}

/// Writes id pairs as the table that `--loops` takes.
///
/// # Errors
///
/// The writer's own.
pub fn write_loops(mut out: impl Write, loops: &[[u64; 2]]) -> io::Result<()> {
    writeln!(out, "id_a,id_b")?;
    for [a, b] in loops {
        writeln!(out, "{a},{b}")?;
    }
    out.flush()
}
