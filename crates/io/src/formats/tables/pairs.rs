//! Graphs in two tables, of nodes and of edges: how the second is found by the name of the first, and both are read.

use std::io::Read;
use std::path::{Path, PathBuf};

use super::graph::{checksum_of_pair, stated_checksum};
use crate::formats::input::{HEAD, content_beside, unpacked_head, unpacked_name, without_mark};
use crate::formats::{ReadOptions, is_there, open_regular, read_csv_edges, read_csv_nodes, tables::reader::TableReader};
use willis_core::error::{Fault, Result};
use willis_core::network::{Network, Scale};

/// The words for a table of nodes, where the table of edges is called `edges`.
const NODES: [&str; 2] = ["nodes", "vertices"];
/// The column of the first node of an edge, in any table of edges.
const FIRST_NODE: [&str; 4] = ["node1id", "source id", "source", "node_a"];

/// The first bytes of a file; none where it cannot be read, or where it is a pipe, whose first bytes would then be gone.
pub(crate) fn head(path: &Path) -> Vec<u8> {
    let mut bytes = Vec::new();
    // A file that cannot be read gives an error later, when it is read.
    let _ = open_regular(path).map(|file| file.take(HEAD).read_to_end(&mut bytes));
    unpacked_head(&bytes, HEAD as usize)
}

/// The table of nodes in the folder of a table of edges: its name with `.nodes` before the ending, or with `nodes` or `vertices` for
/// `edges`, or `nodes.csv` or `vertices.csv`.
pub(crate) fn find_nodes_table(edges: &Path) -> Option<PathBuf> {
    first(edges, |name| Some(with_nodes(name)), NODES.map(|nodes| ("edges", nodes)))
}

/// The table of edges in the folder of a table of nodes, by the same names.
pub(crate) fn find_edges_table(nodes: &Path) -> Option<PathBuf> {
    let without = |name: &str| {
        let (stem, ending) = name.rsplit_once('.')?;
        Some(format!("{}.{ending}", stem.strip_suffix(".nodes")?))
    };
    first(nodes, without, NODES.map(|nodes| (nodes, "edges")))
}

/// `A.nodes.csv` for `A.csv`.
fn with_nodes(edges: &str) -> String {
    let (stem, ending) = edges.rsplit_once('.').unwrap_or((edges, "csv"));
    format!("{stem}.nodes.{ending}")
}

/// The first of the names of the other table that is in the folder: the one that `own` makes of this name, this name with one word for
/// the other of each swap, and the plain ones. Each of the two tables may be packed or not.
fn first(path: &Path, own: impl Fn(&str) -> Option<String>, swaps: [(&str, &str); 2]) -> Option<PathBuf> {
    let name = path.file_name()?.to_str()?;
    let without_gz = |name: &str| unpacked_name(Path::new(name)).to_string_lossy().into_owned();
    let unpacked = without_gz(name);
    let capital = |word: &str| word[..1].to_uppercase() + &word[1..];
    let swapped = swaps.map(|(from, to)| [name.replace(from, to), name.replace(&capital(from), &capital(to))]);
    let plain = swaps.map(|(_, to)| format!("{to}.csv"));
    let names = [own(name), own(&unpacked)].into_iter().flatten().chain(swapped.into_iter().flatten()).chain(plain);
    let either = |name: String| {
        let plain = without_gz(&name);
        [name, plain.clone(), format!("{plain}.gz")]
    };
    let others = names.flat_map(either).filter(|other| without_gz(other) != unpacked);
    others.map(|other| path.with_file_name(other)).find(|path| is_there(path))
}

/// Whether a table is that of the edges, and the other table, if it is in the same folder.
pub(crate) fn other_table(path: &Path, bytes: &[u8]) -> Result<(bool, Option<PathBuf>), Fault> {
    let is_edges = TableReader::open(bytes)?.find(&FIRST_NODE).is_some();
    Ok((is_edges, if is_edges { find_nodes_table(path) } else { find_edges_table(path) }))
}

/// Whether the edges of a table refer to the rows of the table of nodes, as VesselVio's do: that table has no names.
pub(crate) fn edges_refer_to_rows(edges: &Path) -> bool {
    let Some(nodes) = find_nodes_table(edges) else { return false };
    TableReader::open(&head(&nodes))
        .is_ok_and(|rows| rows.find(&["node", "id"]).is_none() && rows.find(&["x", "pos_x"]).is_some())
}

/// The path of the table of nodes for a table of edges that is written: a name of its own, so that no other pair has it; `None` for the name
/// of a table of nodes.
pub(crate) fn nodes_table_path(edges: &Path) -> Option<PathBuf> {
    let name = edges.file_name()?.to_string_lossy();
    if NODES.iter().any(|nodes| name == format!("{nodes}.csv")) {
        return None;
    }
    Some(edges.with_file_name(if name.contains("edges") { name.replace("edges", "nodes") } else { with_nodes(&name) }))
}

/// Reads a graph in two tables, whichever of them is given.
pub(crate) fn read_table_pair<N, C>(
    path: &Path,
    bytes: &[u8],
    options: &ReadOptions,
    read_nodes: impl Fn(&[u8], &Scale) -> Result<N, Fault>,
    read_edges: impl Fn(&[u8], N, &ReadOptions) -> Result<(C, Vec<String>), Fault>,
) -> Result<(C, Vec<String>)> {
    let missing = |what: &str| {
        let renamed = "with \"nodes\" for \"edges\" in its name, or nodes.csv and edges.csv";
        Fault::file(format!("no table of {what} beside it"), format!("expected two tables, {renamed}")).in_file(path)
    };
    let (is_edges, other) = other_table(path, bytes).map_err(|fault| fault.in_file(path))?;
    let other = other.ok_or_else(|| missing(if is_edges { "nodes" } else { "edges" }))?;
    let content = content_beside(&other, options.max_input)?;
    let (given, found) = ((path, bytes), (other.as_path(), content.as_slice()));
    let (nodes, edges) = if is_edges { (found, given) } else { (given, found) };
    let table = read_nodes(nodes.1, &options.scale).map_err(|fault| fault.in_file(nodes.0))?;
    let (content, mut notes) = read_edges(edges.1, table, options).map_err(|fault| fault.in_file(edges.0))?;
    notes.push(format!("{} are those of {}", if is_edges { "nodes" } else { "edges" }, other.display()));
    Ok((content, notes))
}

/// Reads a table of edges, and the table of nodes in its folder if there is one. A table of edges that was written with one has no conditions
/// without it, so that it is missed.
pub(crate) fn read_csv_tables(path: &Path, bytes: &[u8], options: &ReadOptions) -> Result<(Network, Vec<String>)> {
    let found = find_nodes_table(path);
    let read = |nodes: &PathBuf| {
        let bytes = content_beside(nodes, options.max_input)?;
        let table = read_csv_nodes(without_mark(&bytes), &options.scale).map_err(|fault| fault.in_file(nodes))?;
        Ok((table, checksum_of_pair(&bytes)))
    };
    if found.is_none() && stated_checksum(bytes).is_some_and(|stated| !stated.is_empty()) {
        let name = nodes_table_path(&unpacked_name(path)).unwrap_or_else(|| path.with_file_name("nodes.csv"));
        let accepted =
            "expected it beside it, with the nodes and their conditions; without the column nodes_sha256 it is not looked for";
        return Err(Fault::file(format!("its table of nodes, {}, is not there", name.display()), accepted).in_file(path));
    }
    let (nodes, checksum) = found.as_ref().map(read).transpose()?.unzip();
    let (network, mut notes) = read_csv_edges(bytes, nodes, options).map_err(|fault| fault.in_file(path))?;
    if let Some(nodes) = found {
        notes.push(format!("nodes are those of {}", nodes.display()));
        if stated_checksum(bytes).is_some_and(|stated| checksum.is_none_or(|found| found != stated)) {
            notes.push(format!("{} is not as it was when {} was written with it", nodes.display(), path.display()));
        }
    }
    Ok((network, notes))
}
