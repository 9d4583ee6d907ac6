//! A graph as CSV: a table of edges, and beside it, where there is one, a table of nodes.

use std::collections::{HashMap, hash_map::Entry};
use std::io::BufRead;
use std::path::{Path, PathBuf};

use super::attributes::{Record, nodes, vessels};
use crate::error::Fault;
use crate::network::{Network, Node};
use crate::units::Scale;

const ENDS: [[&str; 2]; 2] = [["node_a", "node_b"], ["source", "target"]];

/// The nodes of a table and the name by which the edges know each.
#[derive(Debug, Clone)]
pub struct NodeTable {
    nodes: Vec<Node>,
    row_of: HashMap<String, usize>,
}

/// Whether a line is the header of a table of edges.
pub(super) fn is_header(line: &str) -> bool {
    let columns: Vec<&str> = line.split(',').map(|column| column.trim().trim_matches('"')).collect();
    ENDS.iter().any(|ends| ends.iter().all(|end| columns.contains(end)))
}

/// The table of nodes beside a table of edges: its name with `nodes` for `edges`, or `nodes.csv`.
pub(super) fn nodes_beside(edges: &Path) -> Option<PathBuf> {
    let name = edges.file_name()?.to_str()?;
    let renamed = name.replace("edges", "nodes");
    [renamed.as_str(), "nodes.csv"].into_iter().filter(|n| *n != name).map(|n| edges.with_file_name(n)).find(|p| p.is_file())
}

/// Reads a table of nodes: `node` (the name in the table of edges), `id`, and the attributes of GraphML nodes.
///
/// # Errors
///
/// A table without `node` and `id`, a name or id that comes twice, an attribute that is wrong.
pub fn read_csv_nodes(input: impl BufRead, scale: &Scale) -> Result<NodeTable, Fault> {
    let (header, records) = table(input)?;
    let Some(key) = ["node", "id"].into_iter().find(|key| header.iter().any(|h| h == key)) else {
        return Err(Fault::line(1, format!("columns {}", header.join(",")), "expected a column node or id"));
    };
    let mut row_of = HashMap::with_capacity(records.len());
    let mut named = Vec::with_capacity(records.len());
    for (row, mut record) in records.into_iter().enumerate() {
        let name = record.values.remove(key).unwrap_or_default();
        if name.is_empty() {
            return Err(Fault::line(record.line, format!("no {key}"), "expected the name of a node"));
        }
        let id = record.values.remove("id").filter(|id| !id.is_empty()).unwrap_or_else(|| name.clone());
        if row_of.insert(name.clone(), row).is_some() {
            return Err(Fault::line(record.line, format!("{key} {name} comes twice"), "expected every node once"));
        }
        named.push((id, record));
    }
    Ok(NodeTable { nodes: nodes(&named, scale)?, row_of })
}

/// Reads a table of edges: `node_a,node_b` (or `source,target`) and the attributes of GraphML edges; returns also what
/// a person should know. Without a table of nodes they come in the order of their first edge, placed by
/// `ax_mm,ay_mm,az_mm` and `bx_mm,by_mm,bz_mm` where these are there.
///
/// # Errors
///
/// A table without the two columns or without rows, a node that the table of nodes lacks, an attribute that is wrong.
pub fn read_csv_edges(
    input: impl BufRead,
    table_of_nodes: Option<NodeTable>,
    scale: &Scale,
) -> Result<(Network, Vec<String>), Fault> {
    let (header, records) = table(input)?;
    let Some(ends) = ENDS.into_iter().find(|ends| ends.iter().all(|end| header.iter().any(|h| h == end))) else {
        let found = format!("columns {}", header.join(","));
        return Err(Fault::line(1, found, "expected a table of edges with columns node_a,node_b or source,target"));
    };
    let given = table_of_nodes.is_some();
    let (found, mut row_of) = table_of_nodes.map_or_else(Default::default, |table| (table.nodes, table.row_of));
    let mut made: Vec<(String, Record)> = Vec::new();
    let mut edges = Vec::with_capacity(records.len());
    for (row, record) in records.into_iter().enumerate() {
        let mut rows = [0; 2];
        for (side, column) in ends.iter().enumerate() {
            let name = record.values.get(*column).map_or("", String::as_str);
            if name.is_empty() {
                return Err(Fault::line(record.line, format!("edge {row}: no {column}"), "expected the name of a node"));
            }
            rows[side] = match row_of.get(name) {
                Some(node) => *node,
                None if given => {
                    let wrong = format!("edge {row}: {column} {name} is not in the table of nodes");
                    return Err(Fault::line(record.line, wrong, "expected a name of its column node"));
                }
                None => {
                    made.push((name.to_owned(), Record { line: record.line, ..Record::default() }));
                    row_of.insert(name.to_owned(), made.len() - 1);
                    made.len() - 1
                }
            };
            if let Some((_, node)) = made.get_mut(rows[side]).filter(|(_, node)| node.values.is_empty()) {
                place(node, &record, ["a", "b"][side]);
            }
        }
        edges.push((rows, record));
    }
    if edges.is_empty() {
        return Err(Fault::file("no edges", "expected a row for every edge"));
    }
    let mut network = Network::new();
    for node in if given { found } else { nodes(&made, scale)? } {
        network.add_node(node);
    }
    let notes = vessels(&mut network, &edges, scale)?;
    Ok((network, notes))
}

/// Takes a node's position from the columns of one side of an edge.
fn place(node: &mut Record, edge: &Record, side: &str) {
    for axis in ["x", "y", "z"] {
        if let Some(value) = edge.values.get(&format!("{side}{axis}_mm")).filter(|value| !value.is_empty()) {
            node.values.insert(format!("{axis}_mm"), value.clone());
        }
    }
    node.line = edge.line;
}

/// The header and the rows of a CSV file.
fn table(input: impl BufRead) -> Result<(Vec<String>, Vec<Record>), Fault> {
    let mut reader = csv::ReaderBuilder::new().trim(csv::Trim::All).from_reader(input);
    let header: Vec<String> = reader.headers().map_err(|e| csv_fault(&e))?.iter().map(str::to_owned).collect();
    let mut seen = HashMap::new();
    for (column, name) in header.iter().enumerate() {
        match seen.entry(name.as_str()) {
            Entry::Vacant(slot) => _ = slot.insert(column),
            Entry::Occupied(_) => {
                return Err(Fault::line(1, format!("column \"{name}\" comes twice"), "expected every column once"));
            }
        }
    }
    let mut records = Vec::new();
    for row in reader.records() {
        let row = row.map_err(|e| csv_fault(&e))?;
        let values = header.iter().zip(row.iter()).filter(|(_, value)| !value.is_empty());
        records.push(Record {
            line: row.position().map_or(0, |p| p.line() as usize),
            values: values.map(|(name, value)| (name.clone(), value.to_owned())).collect(),
        });
    }
    Ok((header, records))
}

/// A CSV reader of rows of any length that counts lines right: with its own line ends it is one line behind after `\r\n`.
pub(super) fn lines_of<R: std::io::Read>(input: R, delimiter: u8) -> csv::Reader<R> {
    let mut builder = csv::ReaderBuilder::new();
    builder.delimiter(delimiter).flexible(true).trim(csv::Trim::All).terminator(csv::Terminator::Any(b'\n')).from_reader(input)
}

/// A fault of the CSV reader in words of a person.
pub(super) fn csv_fault(error: &csv::Error) -> Fault {
    let line = error.position().map_or(1, |p| p.line() as usize);
    match error.kind() {
        csv::ErrorKind::UnequalLengths { expected_len, len, .. } => {
            Fault::line(line, format!("{len} columns"), format!("expected {expected_len}, as in the header"))
        }
        csv::ErrorKind::Utf8 { err, .. } => {
            Fault::line(line, format!("column {} is not UTF-8", err.field() + 1), "expected UTF-8 text")
        }
        _ => Fault::line(line, format!("not CSV: {error}"), "expected comma-separated values"),
    }
}
