//! Graphs in two tables, one of nodes and one of edges, whichever of them is given.

use std::path::{Path, PathBuf};

use crate::error::{Fault, Result};
use crate::io::companions::other_table;
use crate::io::limit::bytes_within;
use crate::io::read::{Content, ReadOptions};
use crate::io::vendors::vesselvio::{read_vesselvio_edges, read_vesselvio_vertices};
use crate::io::vendors::voreen::{read_voreen_edges, read_voreen_nodes};
use crate::network::{Network, Origin, Vessel};
use crate::support::geometry::distance;

/// Reads the two tables of Voreen, whichever of them is given.
pub(crate) fn read_voreen(path: &Path, bytes: &[u8], options: &ReadOptions) -> Result<(Content, Vec<String>)> {
    let (nodes, edges, note) = both(path, bytes, options.max_input)?;
    let table = read_voreen_nodes(&nodes.1, &options.scale).map_err(|fault| fault.in_file(&nodes.0))?;
    let read = read_voreen_edges(&edges.1, table, &options.scale, options.default_radius.is_some());
    let (network, mut notes) = read.map_err(|fault| fault.in_file(&edges.0))?;
    notes.push(note);
    Ok((Content::Vessels(network), notes))
}

/// Reads the two tables of VesselVio, whichever of them is given.
pub(crate) fn read_vesselvio(path: &Path, bytes: &[u8], options: &ReadOptions) -> Result<(Content, Vec<String>)> {
    let (vertices, edges, note) = both(path, bytes, options.max_input)?;
    let table = read_vesselvio_vertices(&vertices.1, &options.scale).map_err(|fault| fault.in_file(&vertices.0))?;
    let read = read_vesselvio_edges(&edges.1, table, &options.scale, options.default_radius.is_some());
    let (content, mut notes) = read.map_err(|fault| fault.in_file(&edges.0))?;
    notes.push(note);
    Ok((content, notes))
}

type File = (PathBuf, Vec<u8>);

/// The table of nodes, that of edges, and a line about the one that was found.
fn both(path: &Path, bytes: &[u8], most: u64) -> Result<(File, File, String)> {
    let given = || (path.to_owned(), bytes.to_vec());
    let missing = |what: &str| {
        let renamed = "with \"nodes\" for \"edges\" in its name, or nodes.csv and edges.csv";
        Fault::file(format!("no table of {what} beside it"), format!("expected two tables, {renamed}")).in_file(path)
    };
    let (is_edges, other) = other_table(path, bytes).map_err(|fault| fault.in_file(path))?;
    let other = other.ok_or_else(|| missing(if is_edges { "nodes" } else { "edges" }))?;
    let found = (other.clone(), bytes_within(&other, most)?);
    if is_edges {
        Ok((found, given(), format!("nodes are those of {}", other.display())))
    } else {
        Ok((given(), found, format!("edges are those of {}", other.display())))
    }
}

/// An observed vessel between two nodes of which only the ends are known.
///
/// `length` is NaN where the file has none; then it is the distance between the nodes.
pub(crate) fn add_straight(network: &mut Network, ends: [usize; 2], length: f64, radius: f64, label: &str) -> Option<()> {
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
