//! Graphs in two tables, one of nodes and one of edges: finds the other one beside the one given, and reads both.

use std::io::Read;
use std::path::{Path, PathBuf};

use super::document::{Content, ReadOptions};
use super::limit::bytes_within;
use super::rows::Rows;
use super::{read_vesselvio_edges, read_vesselvio_vertices, read_voreen_edges, read_voreen_nodes};
use crate::error::{Fault, Result};
use crate::geometry::distance;
use crate::network::{Network, Origin, Vessel};

/// What a table of nodes is called where the table of edges is called `edges`.
const NODES: [&str; 2] = ["nodes", "vertices"];

/// The table of nodes beside a table of edges: its name with `nodes` or `vertices` for `edges`, or `nodes.csv` or
/// `vertices.csv`.
pub(super) fn nodes_beside(edges: &Path) -> Option<PathBuf> {
    first(edges, NODES.into_iter().map(|nodes| ("edges", nodes)))
}

/// Where the table of nodes goes beside a table of edges that is written; `None` when that is its own name.
pub(super) fn nodes_path(edges: &Path) -> Option<PathBuf> {
    let name = edges.file_name()?.to_string_lossy();
    let nodes = if name.contains("edges") { name.replace("edges", "nodes") } else { "nodes.csv".to_owned() };
    (nodes != name).then(|| edges.with_file_name(nodes))
}

/// The table of edges beside a table of nodes, by the same names.
pub(super) fn edges_beside(nodes: &Path) -> Option<PathBuf> {
    first(nodes, NODES.into_iter().map(|nodes| (nodes, "edges")))
}

fn first(path: &Path, swaps: impl Iterator<Item = (&'static str, &'static str)>) -> Option<PathBuf> {
    let name = path.file_name()?.to_str()?;
    let capital = |word: &str| word[..1].to_uppercase() + &word[1..];
    let (mut names, mut plain) = (Vec::new(), Vec::new());
    for (from, to) in swaps {
        names.extend([name.replace(from, to), name.replace(&capital(from), &capital(to))]);
        plain.push(format!("{to}.csv"));
    }
    names.into_iter().chain(plain).filter(|n| n != name).map(|n| path.with_file_name(n)).find(|p| p.is_file())
}

/// Reads the two tables of Voreen, whichever of them is given.
pub(super) fn read_voreen(path: &Path, bytes: &[u8], options: &ReadOptions) -> Result<(Content, Vec<String>)> {
    let ends = ["node1id", "node2id"];
    let (nodes, edges, note) = both(path, bytes, &ends, options.max_input)?;
    let table = read_voreen_nodes(&nodes.1, &options.scale).map_err(|fault| fault.in_file(&nodes.0))?;
    let read = read_voreen_edges(&edges.1, table, &options.scale, options.radius_optional);
    let (network, mut notes) = read.map_err(|fault| fault.in_file(&edges.0))?;
    notes.push(note);
    Ok((Content::Vessels(network), notes))
}

/// Reads the two tables of VesselVio, whichever of them is given.
pub(super) fn read_vesselvio(path: &Path, bytes: &[u8], options: &ReadOptions) -> Result<(Content, Vec<String>)> {
    let ends = ["source id", "source"];
    let (vertices, edges, note) = both(path, bytes, &ends, options.max_input)?;
    let table = read_vesselvio_vertices(&vertices.1, &options.scale).map_err(|fault| fault.in_file(&vertices.0))?;
    let read = read_vesselvio_edges(&edges.1, table, &options.scale, options.radius_optional);
    let (content, mut notes) = read.map_err(|fault| fault.in_file(&edges.0))?;
    notes.push(note);
    Ok((content, notes))
}

type File = (PathBuf, Vec<u8>);

/// The table of nodes, that of edges, which has one of the columns `ends`, and a line about the one that was found.
fn both(path: &Path, bytes: &[u8], ends: &[&str], most: u64) -> Result<(File, File, String)> {
    let given = || (path.to_owned(), bytes.to_vec());
    let missing = |what: &str| {
        let renamed = "with \"nodes\" for \"edges\" in its name, or nodes.csv and edges.csv";
        Fault::file(format!("no table of {what} beside it"), format!("expected two tables, {renamed}")).in_file(path)
    };
    let is_edges = Rows::open(bytes).map_err(|fault| fault.in_file(path))?.find(ends).is_some();
    let other = if is_edges { nodes_beside(path) } else { edges_beside(path) };
    let other = other.ok_or_else(|| missing(if is_edges { "nodes" } else { "edges" }))?;
    let found = (other.clone(), bytes_within(&other, most)?);
    if is_edges {
        Ok((found, given(), format!("nodes are those of {}", other.display())))
    } else {
        Ok((given(), found, format!("edges are those of {}", other.display())))
    }
}

/// Whether the edges of a table refer to the rows of the table of nodes, as VesselVio's do: that table has no names.
pub(super) fn refers_to_rows(edges: &Path) -> bool {
    let mut bytes = Vec::new();
    let head = |nodes| std::fs::File::open(nodes).and_then(|file| file.take(1 << 16).read_to_end(&mut bytes)).ok();
    if nodes_beside(edges).and_then(head).is_none() {
        return false;
    }
    Rows::open(&bytes).is_ok_and(|rows| rows.find(&["node", "id"]).is_none() && rows.find(&["x", "pos_x"]).is_some())
}

/// An observed vessel between two nodes of which only the ends are known.
///
/// `length` is NaN where the file has none; then it is the distance between the nodes.
pub(super) fn add_straight(network: &mut Network, ends: [usize; 2], length: f64, radius: f64, label: &str) -> Option<()> {
    let length = if length.is_nan() {
        let [a, b] = ends.map(|end| network.node(end).position);
        distance(a?, b?)
    } else {
        length
    };
    if !(length > 0.0 && length.is_finite() || length == 0.0 && ends[0] == ends[1]) {
        return None;
    }
    let vessel = Vessel { label: label.to_owned(), ..Vessel::new(length, radius, Origin::Observed) };
    network.add_vessel(ends, vessel);
    Some(())
}
