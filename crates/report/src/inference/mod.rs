//! What an inference writes: tables, topologies, matrices and pictures.

mod outcome;
mod pictures;
pub(super) mod questions;
pub(crate) mod tables;

use std::borrow::Cow;
use std::path::Path;

use serde_json::json;

use super::page::{infer_page, write_page};
use super::run_record::RunRecord;
use pictures::{overview, pictures};
use tables::{condition_columns, merged_columns, node_columns, pairing_columns, select, suggested_cut_columns};
use willis_core::error::{Error, Result};
use willis_core::flow::{Boundary, Circuit, pressures};
use willis_core::network::{Network, Node, fragments};
use willis_io::formats::{
    Checksummed, Column, graph_columns_with, is_forest, stated_columns, windkessel_columns, write_csv, write_graphml, write_npy,
    write_npz, write_swc, write_vtp,
};
use willis_io::output::names::{
    DENSE_LIKELIHOOD, EDGES, GRAPH, LIKELIHOOD, MEDIAN_TOPOLOGY, NODES, PAGE, PAIRINGS, REVIEW, SUGGESTED_CUTS, TOPOLOGY,
};
use willis_io::output::{write_file, write_record};

pub use outcome::{Outcome, SolverRecord, few_perfused};
pub use questions::{questions, review_columns};
pub use tables::{agreement, vessel_columns};

/// The largest matrix written densely, in nodes.
pub const DENSE_LIMIT: usize = 8192;
/// The largest network that gets a page: a browser takes seconds for so many vessels.
const PAGE_LIMIT: usize = 100_000;

/// What remains of the tables of an inference that are written: the columns of nodes.csv for a page, where there will be one, and notes.
pub type OutcomeTables = (Option<Vec<Column>>, Vec<String>);

/// Writes the tables of an inference and its topologies into a folder: before its record is made, which is as long as it has free ends.
///
/// # Errors
///
/// A file that cannot be written, or pressures that cannot be solved for.
pub fn write_tables(folder: &Path, outcome: &Outcome<'_>) -> Result<OutcomeTables> {
    let mut notes = Vec::new();
    // Columns are made for each file again: those of a million vessels are not held while a circuit is solved, nor for a page that is not made.
    write_file(&folder.join(EDGES), |out| write_csv(out, &vessel_columns(outcome)))?;
    let nodes = topology(folder, TOPOLOGY, outcome, &outcome.answer.kept, &mut notes)?;
    write_file(&folder.join(NODES), |out| write_csv(out, &nodes))?;
    let nodes = (outcome.network.vessel_count() <= PAGE_LIMIT).then_some(nodes);
    if outcome.answer.kept == outcome.answer.above_median {
        copy(folder, ["graphml", "vtp"])?;
    } else {
        topology(folder, MEDIAN_TOPOLOGY, outcome, &outcome.answer.above_median, &mut notes)?;
    }
    Ok((nodes, notes))
}

/// Writes the other files of an inference and returns what a person should know about files left out.
///
/// # Errors
///
/// A file that cannot be written.
pub fn write_outcome(
    folder: &Path,
    outcome: &Outcome<'_>,
    (for_page, mut notes): OutcomeTables,
    record: &mut RunRecord,
    dpi: u32,
) -> Result<Vec<String>> {
    if !outcome.suggested_cuts.is_empty() {
        write_file(&folder.join(SUGGESTED_CUTS), |out| write_csv(out, &suggested_cut_columns(outcome.suggested_cuts)))?;
    }
    if !outcome.pairings.is_empty() {
        write_file(&folder.join(PAIRINGS), |out| write_csv(out, &pairing_columns(outcome)))?;
    }
    let asked = questions(outcome);
    if let Some(columns) = review_columns(outcome, &asked) {
        write_file(&folder.join(REVIEW), |out| write_csv(out, &columns))?;
    }
    matrices(folder, outcome, &mut notes)?;
    *record.field("graph") = json!({ "path": GRAPH, "sha256": graph(&folder.join(GRAPH), outcome)? });
    if let Some(picture) = overview(outcome, &asked, &record.name()) {
        picture.write(folder, dpi)?;
    }
    let figures = pictures(folder, outcome, dpi)?;
    write_record(folder, record)?;
    if let Some(nodes) = for_page {
        let page = infer_page(outcome, &asked, record, vessel_columns(outcome), nodes, figures);
        write_file(&folder.join(PAGE), |out| write_page(out, &page))?;
    } else {
        notes.push(format!("{PAGE} is left out above {PAGE_LIMIT} vessels; {TOPOLOGY}.vtp opens in ParaView"));
    }
    Ok(notes)
}

/// Writes the matrix L.
fn matrices(folder: &Path, outcome: &Outcome<'_>, notes: &mut Vec<String>) -> Result<()> {
    let nodes = outcome.network.node_count();
    let matrix = outcome.result.matrix(outcome.network);
    write_file(&folder.join(LIKELIHOOD), |out| write_npz(out, nodes, &matrix))?;
    if nodes <= DENSE_LIMIT {
        write_file(&folder.join(DENSE_LIKELIHOOD), |out| write_npy(out, nodes, &matrix))?;
    } else {
        notes.push(format!("{DENSE_LIKELIHOOD} is left out above {DENSE_LIMIT} nodes; {LIKELIHOOD} holds the matrix"));
    }
    Ok(())
}

/// Gives the topology above the median the files of the kept one, which it is.
fn copy(folder: &Path, endings: [&str; 2]) -> Result<()> {
    for ending in endings {
        let [from, to] = [TOPOLOGY, MEDIAN_TOPOLOGY].map(|name| folder.join(format!("{name}.{ending}")));
        if from.exists() {
            std::fs::copy(&from, &to).map_err(|source| Error::Write { path: to, source })?;
        }
    }
    Ok(())
}

/// Writes the graph that was sampled, so that a later command can take it up again, and returns its SHA-256.
fn graph(path: &Path, outcome: &Outcome<'_>) -> Result<String> {
    let graph = outcome.network;
    let (nodes, mut vessels) = graph_columns_with(graph, &outcome.boundary.stated());
    for column in vessels.iter_mut().filter(|column| outcome.sampling.uniform_prior && column.name == "prior") {
        *column = Column::real("prior", graph.vessels().map(|_| 1.0));
    }
    let mut sum = String::new();
    write_file(path, |out| {
        let mut summed = Checksummed::new(out);
        write_graphml(&mut summed, graph, &nodes, &vessels).map(|()| sum = summed.finish())
    })?;
    Ok(sum)
}

/// The columns of nodes.csv, for the vessels that are kept, with pressures and conditions.
///
/// # Errors
///
/// Pressures that cannot be solved for.
pub fn topology_columns(outcome: &Outcome<'_>, kept: &[bool]) -> Result<Vec<Column>> {
    let boundary = outcome.boundary.held(outcome.network, |row| kept[row]);
    columns_of_nodes(&outcome.network.subgraph(|row| kept[row]).0, &boundary, outcome.sampling.viscosity)
}

fn columns_of_nodes(graph: &Network, boundary: &Boundary, viscosity: f64) -> Result<Vec<Column>> {
    let pressure = pressures::pressures(&Circuit::new(graph, boundary, viscosity)?, |_| true)?;
    let mut nodes = node_columns(graph, boundary, &pressure, &fragments(graph, |_, _| true).of_node);
    nodes.extend(condition_columns(graph, boundary));
    Ok(nodes)
}

/// Writes a topology, every vessel of it kept, in every format that can hold it, and returns its node columns, those of merged nodes too.
fn topology(folder: &Path, name: &str, outcome: &Outcome<'_>, kept: &[bool], notes: &mut Vec<String>) -> Result<Vec<Column>> {
    let boundary = outcome.boundary.held(outcome.network, |row| kept[row]);
    // A graph of which all is kept is not copied.
    let (graph, rows) = if kept.contains(&false) {
        let (graph, rows) = outcome.network.subgraph(|row| kept[row]);
        (Cow::Owned(graph), rows)
    } else {
        (Cow::Borrowed(outcome.network), (0..kept.len()).collect())
    };
    let mut all_nodes = columns_of_nodes(&graph, &boundary, outcome.sampling.viscosity)?;
    let merged = outcome.merged(&boundary, graph, &rows);
    let graph = &*merged.network;
    let mut vessels = merged_columns(outcome.network, &merged, vessel_columns(outcome));
    let (shown, known) = (vessels.len(), all_nodes.len());
    vessels.extend(stated_columns(graph));
    let file = |ending: &str| folder.join(format!("{name}.{ending}"));
    // A copy only of what differs.
    let mut some = (merged.nodes.len() < outcome.network.node_count()).then(|| select(&all_nodes, &merged.nodes));
    let nodes = some.as_mut().unwrap_or(&mut all_nodes);
    nodes.extend(windkessel_columns(&graph.nodes().map(Node::windkessel).collect::<Vec<_>>()));
    write_file(&file("graphml"), |out| write_graphml(out, graph, nodes, &vessels))?;
    vessels.truncate(shown);
    all_nodes.truncate(known);
    if graph.has_positions() {
        write_file(&file("vtp"), |out| write_vtp(out, graph, &vessels))?;
        if name == TOPOLOGY {
            if is_forest(graph) {
                write_file(&file("swc"), |out| write_swc(out, graph).map(drop))?;
            } else {
                notes.push("topology.swc is left out: the kept graph has cycles, which SWC cannot hold".into());
            }
        }
    } else if name == TOPOLOGY {
        notes.push("topology.vtp and topology.swc are left out: the nodes have no coordinates".into());
    }
    Ok(all_nodes)
}
