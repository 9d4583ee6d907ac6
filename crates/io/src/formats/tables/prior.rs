//! Anatomical priors A from a file: a matrix over pairs of nodes, or a table of vessels.

use super::reader::{Row, TableReader, columns};
use crate::formats::numpy::array::read_npy_matrix;
use willis_core::{error::Fault, network::Network};

/// Gives every vessel the prior that a symmetric N x N matrix of numbers from 0 to 1 has for its two nodes, in the order of
/// nodes.csv.
///
/// # Errors
///
/// Another shape, an entry out of its range, or two that contradict each other.
pub fn read_prior_npy(bytes: &[u8], network: &mut Network) -> Result<(), Fault> {
    let matrix = read_npy_matrix(bytes, network.node_count())?;
    for vessel in 0..network.vessel_count() {
        let [a, b] = network.ends(vessel);
        let (prior, other) = (matrix[[a, b]], matrix[[b, a]]);
        if !(0.0..=1.0).contains(&prior) {
            return Err(Fault::item(format!("A[{a}, {b}]"), prior.to_string(), "expected a number from 0 to 1"));
        }
        if prior != other {
            let found = format!("{prior}, and A[{b}, {a}] {other}");
            return Err(Fault::item(format!("A[{a}, {b}]"), found, "expected a symmetric matrix"));
        }
        network.vessel_mut(vessel).prior = prior;
    }
    Ok(())
}

/// Gives vessels the priors of a table with a column `prior` (0 to 1) and either `edge`, the row in edges.csv, or `node_a` and
/// `node_b`, rows in nodes.csv; edges.csv itself is such a table. Vessels that the table does not name, or with an empty prior,
/// keep theirs.
///
/// # Errors
///
/// A table without these columns, a vessel that is not there, a number out of its range.
pub fn read_prior_csv(bytes: &[u8], network: &mut Network) -> Result<(), Fault> {
    let mut rows = TableReader::open(bytes)?;
    let prior = rows.column(&["prior"], "the prior of a vessel")?;
    let (edge, ends) = (rows.find(&["edge"]), [rows.find(&["node_a"]), rows.find(&["node_b"])]);
    if edge.is_none() && ends.contains(&None) {
        let accepted = "expected a column edge, or columns node_a,node_b";
        return Err(Fault::line(rows.header_line, columns(&rows.header), accepted));
    }
    let mut between = std::collections::HashMap::<[usize; 2], Vec<usize>>::new();
    for vessel in 0..network.vessel_count() {
        let [a, b] = network.ends(vessel);
        between.entry([a.min(b), a.max(b)]).or_default().push(vessel);
    }
    while let Some(row) = rows.row()? {
        let value = row.real(prior)?;
        if value.is_nan() {
            continue;
        }
        if !(0.0..=1.0).contains(&value) {
            return Err(Fault::line(row.line, format!("prior {value}"), "expected a number from 0 to 1"));
        }
        let named = match (edge, ends) {
            (Some(edge), _) => vec![below(&row, edge, network.vessel_count())?],
            (None, [Some(a), Some(b)]) => {
                let [a, b] = [below(&row, a, network.node_count())?, below(&row, b, network.node_count())?];
                let apart = || Fault::line(row.line, format!("{a} - {b}"), "expected two nodes that a vessel joins");
                between.get(&[a.min(b), a.max(b)]).cloned().ok_or_else(apart)?
            }
            _ => Vec::new(),
        };
        for vessel in named {
            network.vessel_mut(vessel).prior = value;
        }
    }
    Ok(())
}

/// A whole number below a count.
fn below(row: &Row<'_>, column: usize, count: usize) -> Result<usize, Fault> {
    let text = row.text(column);
    text.parse::<usize>().ok().filter(|n| *n < count).ok_or_else(|| {
        Fault::line(row.line, format!("{} \"{text}\"", row.header[column]), format!("expected a row below {count}"))
    })
}
