//! A graph as CSV: a table of edges, and beside it, where there is one, a table of nodes.

use std::collections::HashMap;
use std::io::{self, Write};

use super::graph_columns::{END_PLACES, PLACE, graph_columns, points_column};
use super::rows::{Rows, columns, delimiter};
use super::write::write_csv;
use crate::error::Fault;
use crate::io::attributes;
use crate::io::attributes::edge::vessels;
use crate::io::attributes::node::nodes;
use crate::io::attributes::records::Records;
use crate::network::units::Scale;
use crate::network::{Network, Node};

/// The columns of the names of nodes.
const NAMES: [&str; 2] = ["node", "id"];
const ENDS: [[&str; 2]; 2] = [["node_a", "node_b"], ["source", "target"]];

/// The nodes of a table and the name by which the edges know each.
#[derive(Debug, Clone)]
pub struct NodeTable {
    pub(crate) nodes: Vec<Node>,
    pub(crate) row_of: HashMap<String, usize>,
}

/// Whether a line is the header of a table of edges.
pub(crate) fn is_header(line: &str) -> bool {
    let columns: Vec<&str> = line.split(delimiter(line)).map(|column| column.trim().trim_matches('"')).collect();
    ENDS.iter().any(|ends| ends.iter().all(|end| columns.contains(end)))
}

/// Reads a table of nodes: `node` (the name in the table of edges), `id`, and the attributes of GraphML nodes.
///
/// # Errors
///
/// A table without `node` and `id`, a name or id that comes twice, an attribute that is wrong.
pub fn read_csv_nodes(bytes: &[u8], scale: &Scale) -> Result<NodeTable, Fault> {
    let (header, records) = table(bytes)?;
    let Some(key) = NAMES.into_iter().find(|key| header.iter().any(|h| h == key)) else {
        return Err(Fault::line(1, columns(&header), "expected a column node or id"));
    };
    let mut row_of = HashMap::with_capacity(records.len());
    let mut ids = Vec::with_capacity(records.len());
    for (row, record) in records.iter().enumerate() {
        let Some(name) = record.text(key) else {
            return Err(Fault::line(record.line, format!("no {key}"), "expected the name of a node"));
        };
        ids.push(record.text("id").unwrap_or(name));
        if row_of.insert(name.to_owned(), row).is_some() {
            return Err(Fault::line(record.line, format!("{key} {name} comes twice"), "expected every node once"));
        }
    }
    Ok(NodeTable { nodes: nodes(&ids, &records, scale)?, row_of })
}

/// Reads a table of edges: `node_a,node_b` (or `source,target`) and the attributes of GraphML edges; returns also what
/// a person should know. Without a table of nodes they come in the order of their first edge, placed by
/// `ax_mm,ay_mm,az_mm` and `bx_mm,by_mm,bz_mm` where these are there.
///
/// # Errors
///
/// A table without the two columns or without rows, a node that the table of nodes lacks, an attribute that is wrong.
pub fn read_csv_edges(
    bytes: &[u8],
    table_of_nodes: Option<NodeTable>,
    scale: &Scale,
    radius_optional: bool,
) -> Result<(Network, Vec<String>), Fault> {
    let (header, records) = table(bytes)?;
    let Some(ends) = ENDS.into_iter().find(|ends| ends.iter().all(|end| header.iter().any(|h| h == end))) else {
        let accepted = if header.iter().any(|column| column == "node") {
            "these are nodes; give the table of edges, with columns node_a,node_b or source,target"
        } else {
            "expected a table of edges with columns node_a,node_b or source,target"
        };
        return Err(Fault::line(1, columns(&header), accepted));
    };
    let given = table_of_nodes.is_some();
    let (found, mut row_of) = table_of_nodes.map_or_else(Default::default, |table| (table.nodes, table.row_of));
    // Nodes without a table: their names, and the edge and the side that place each.
    let mut made: Vec<&str> = Vec::new();
    let mut placed: Vec<Option<(usize, usize)>> = Vec::new();
    let mut rows = Vec::with_capacity(records.len());
    for (row, record) in records.iter().enumerate() {
        let mut both = [0; 2];
        for (side, (end, column)) in both.iter_mut().zip(ends).enumerate() {
            let Some(name) = record.text(column) else {
                return Err(Fault::line(record.line, format!("edge {row}: no {column}"), "expected the name of a node"));
            };
            *end = match row_of.get(name) {
                Some(node) => *node,
                None if given => {
                    let wrong = format!("edge {row}: {column} {name} is not in the table of nodes");
                    return Err(Fault::line(record.line, wrong, "expected a name of its column node"));
                }
                None => {
                    made.push(name);
                    placed.push(None);
                    row_of.insert(name.to_owned(), made.len() - 1);
                    made.len() - 1
                }
            };
            if let Some(place @ None) = placed.get_mut(*end) {
                *place = END_PLACES[side].iter().any(|axis| record.text(axis).is_some()).then_some((row, side));
            }
        }
        rows.push(both);
    }
    if rows.is_empty() {
        return Err(Fault::file("no edges", "expected a row for every edge"));
    }
    let mut network = Network::new();
    for node in if given { found } else { nodes(&made, &places(&records, &placed), scale)? } {
        network.add_node(node);
    }
    let notes = vessels(&mut network, &rows, &records, scale, radius_optional)?;
    Ok((network, notes))
}

/// The nodes' positions, from the columns of one side of an edge for each.
fn places(edges: &Records, placed: &[Option<(usize, usize)>]) -> Records {
    let mut nodes = Records::named(&PLACE);
    for place in placed {
        let edge = place.map(|(row, side)| (edges.get(row), END_PLACES[side]));
        nodes.begin(edge.map_or(0, |(record, _)| record.line));
        for (axis, column) in edge.iter().flat_map(|(_, columns)| columns.iter().enumerate()) {
            if let Some(text) = edge.and_then(|(record, _)| record.text(column)) {
                nodes.put(axis, text);
            }
        }
    }
    nodes
}

/// Writes a network as the two tables that [`read_csv_nodes`] and [`read_csv_edges`] take, with every attribute of GraphML:
/// the nodes with their ids and conditions, the vessels in their order, each with its points.
///
/// # Errors
///
/// The writers' own.
pub fn write_csv_graph(nodes: impl Write, edges: impl Write, network: &Network) -> io::Result<()> {
    let (node_columns, mut vessel_columns) = graph_columns(network);
    vessel_columns.extend(points_column(network));
    write_csv(nodes, &node_columns)?;
    write_csv(edges, &vessel_columns)
}

/// Whether a column is read.
pub(crate) fn is_wanted(name: &str) -> bool {
    let own = [&NAMES[..], ENDS.as_flattened(), END_PLACES.as_flattened()];
    attributes::is_wanted(name) || own.iter().any(|names| names.contains(&name))
}

/// The header and the rows of a file, these without the columns that nothing asks for.
fn table(bytes: &[u8]) -> Result<(Vec<String>, Records), Fault> {
    let mut rows = Rows::open(bytes)?;
    let header = rows.header().to_vec();
    let wanted: Vec<bool> = header.iter().map(|name| is_wanted(name)).collect();
    let mut records = Records::named(&header);
    while let Some(row) = rows.next()? {
        records.begin(row.line);
        for (column, text) in row.texts().filter(|(column, _)| wanted[*column]) {
            records.put(column, text);
        }
    }
    Ok((header, records))
}
