//! What an inference writes: tables, topologies, matrices and pictures; and how far runs with different occlusion probabilities agree.

use std::borrow::Cow;
use std::path::Path;

use base64::Engine;
use base64::engine::general_purpose::STANDARD;
use serde::{Deserialize, Serialize};

use super::page::{infer_page, write_page};
use super::pictures::{overview, pictures};
use super::run_record::Summary;
use willis_core::decision::{Decision, ExpectedErrors, Keep, Topology};
use willis_core::error::{Error, Result};
use willis_core::flow::{Boundary, Circuit, pressures};
use willis_core::network::units::millimetres;
use willis_core::network::{Condition, Network, Origin, Role, fragments};
use willis_core::sampling::{Likelihood, Method, SamplingOptions};
use willis_core::support::geometry::Point;
use willis_io::formats::{
    Checksummed, Column, Values, graph_columns_with, is_forest, write_csv, write_graphml, write_npy, write_npz, write_swc,
    write_vtp,
};
use willis_io::masks::strips::Strip;
use willis_io::masks::{Affine, Foreground, RunLengths};
use willis_io::output::atomic::write_file;
use willis_io::output::names::{
    DENSE_LIKELIHOOD, EDGES, GRAPH, LIKELIHOOD, MEDIAN_TOPOLOGY, NODES, PAGE, PAIRINGS, SUGGESTED_CUTS, TOPOLOGY,
};
use willis_io::output::write_record;
use willis_models::contacts::pairings::Pairings;
use willis_models::contacts::suggested_cuts::SuggestedCut;

/// The columns of agreement.csv: per pair of occlusion probabilities how many uncertain vessels are decided alike, and of
/// how many.
pub fn agreement(decisions: &[(f64, Decision)], uncertain: &[bool]) -> Vec<Column> {
    let pairs: Vec<(usize, usize)> = (0..decisions.len()).flat_map(|i| (i + 1..decisions.len()).map(move |j| (i, j))).collect();
    let same = |(i, j): &(usize, usize)| {
        let (a, b) = (&decisions[*i].1.kept, &decisions[*j].1.kept);
        a.iter().zip(b).zip(uncertain).filter(|((a, b), uncertain)| **uncertain && a == b).count()
    };
    let uncertain_count = uncertain.iter().filter(|u| **u).count();
    vec![
        Column::real("epsilon_a", pairs.iter().map(|(i, _)| decisions[*i].0)),
        Column::real("epsilon_b", pairs.iter().map(|(_, j)| decisions[*j].0)),
        Column::whole("decided_alike", pairs.iter().map(same)),
        Column::whole("uncertain", pairs.iter().map(|_| uncertain_count)),
    ]
}

/// The largest matrix written densely, in nodes.
pub const DENSE_LIMIT: usize = 8192;
/// The largest network that gets a page: a browser takes seconds for so many vessels.
const PAGE_LIMIT: usize = 100_000;

/// Small pictures of the image along one vessel, for the page; see [`Strip`].
#[derive(Debug, Clone, Serialize, Deserialize)]
pub struct ImageCut {
    /// The row of the vessel.
    pub vessel: usize,
    /// Sizes of the straightened picture along and across the vessel, mm.
    pub size_mm: [f64; 2],
    /// [`Strip::pixels`] in base64.
    pub pixels: String,
}

impl ImageCut {
    /// The pictures of a vessel, by row.
    pub fn of(vessel: usize, strip: &Strip) -> Self {
        Self { vessel, size_mm: strip.size.map(millimetres), pixels: STANDARD.encode(&strip.pixels) }
    }
}

/// The faces of a segmentation's surface beyond which the page holds it in blocks of voxels: a graphics chip in a laptop draws so many.
const MOST_FACES: usize = 400_000;
/// The blocks of its box beyond which the page holds it in larger ones: a browser takes a byte for each.
const MOST_CELLS: usize = 1 << 26;

/// The segmentation that the vessels were found in, for the page, which makes a surface of it.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct Segmentation {
    /// The lengths of the box around it.
    pub shape: [usize; 3],
    /// Where the centre of each block of the box is, mm.
    pub affine: Affine,
    /// Voxels along each side of a block.
    pub block: usize,
    /// [`RunLengths::bytes`] in base64.
    pub runs: String,
}

impl Segmentation {
    /// The voxels inside vessels, in blocks where they are very many.
    pub fn of(vessels: &Foreground) -> Self {
        let RunLengths { shape, affine, block, bytes } = RunLengths::of(vessels, MOST_FACES, MOST_CELLS);
        Self { shape, affine, block, runs: STANDARD.encode(bytes) }
    }
}

/// The share of the samples in which blood flows below which a run is warned of.
const FEW_PERFUSED: f64 = 0.5;

/// An inference and everything its files are made of.
#[derive(Debug)]
pub struct Outcome<'a> {
    /// The over-connected graph.
    pub network: &'a Network,
    /// Its boundary conditions.
    pub boundary: &'a Boundary,
    /// Cuts that are suggested, the surest first.
    pub suggested_cuts: &'a [SuggestedCut],
    /// How the vessels at each opened contact may be paired.
    pub pairings: &'a [Pairings],
    /// What an image shows along doubtful vessels, by row.
    pub image_cuts: &'a [ImageCut],
    /// The segmentation that they were found in, where they were.
    pub segmentation: Option<&'a Segmentation>,
    /// What the samples say.
    pub result: &'a Likelihood,
    /// The rule that decided.
    pub rule: Keep,
    /// The decisions.
    pub answer: &'a Decision,
    /// Whether every decision on L is clear; `None` where the run was not to go on until it is.
    pub stable: Option<bool>,
    /// The kept graph.
    pub kept: Topology,
    /// The graph above the median.
    pub above_median: Topology,
    /// The errors that the evidence expects of the kept graph, where there is evidence.
    pub expected: Option<ExpectedErrors>,
    /// How it was sampled.
    pub sampling: &'a SamplingOptions,
    /// How the samples were computed.
    pub method: Method,
}

/// That blood flows in this share of the samples, and what raises it, where it is below one half.
pub fn few_perfused(network: &Network, boundary: &Boundary, sampling: &SamplingOptions, share: f64) -> Option<String> {
    if network.vessel_count() == 0 || share >= FEW_PERFUSED {
        return None;
    }
    let (what, so) = if share == 0.0 {
        ("in none of the samples".to_owned(), "they tell nothing of L")
    } else {
        (format!("in {:.1} % of the samples", 100.0 * share), "L rests on few")
    };
    let advice = if sampling.chance_of_an_inlet(network, boundary) < FEW_PERFUSED {
        "The inlets found lie at ends that other vessels probably join: state where blood enters, with --inlet."
    } else if sampling.epsilon > 0.0 {
        "A smaller --epsilon leaves more ways from inlets to outlets open."
    } else {
        "State where blood leaves, with --outlet."
    };
    Some(format!("Blood flows {what}, so {so}. {advice}"))
}

impl Outcome<'_> {
    /// As [`few_perfused`].
    pub fn few_perfused(&self) -> Option<String> {
        few_perfused(self.network, self.boundary, self.sampling, self.result.perfused)
    }

    /// How many contacts there are: places where observed vessels may only touch.
    pub fn contacts(&self) -> usize {
        self.network.vessels().filter(|(_, vessel)| vessel.origin == Origin::Contact).count()
    }

    /// The boundary conditions that hold in the kept topology.
    pub fn held(&self) -> Boundary {
        self.boundary.held(self.network, |row| self.answer.kept[row])
    }

    /// The contacts that are cut, by row.
    pub fn cuts(&self) -> impl Iterator<Item = usize> {
        let decided = self.network.vessels().zip(&self.answer.kept).enumerate();
        decided.filter(|(_, ((_, vessel), kept))| vessel.origin == Origin::Contact && !**kept).map(|(row, _)| row)
    }
}

/// Writes every file of an inference into a folder and returns what a person should know about files left out.
///
/// # Errors
///
/// A file that cannot be written, or pressures that cannot be solved for.
pub fn write_outcome(folder: &Path, outcome: &Outcome<'_>, summary: &mut Summary, dpi: u32) -> Result<Vec<String>> {
    let mut notes = Vec::new();
    let network = outcome.network;
    let vessels = vessel_columns(outcome);
    write_file(&folder.join(EDGES), |out| write_csv(out, &vessels))?;
    let kept_nodes = topology(folder, TOPOLOGY, outcome, &outcome.answer.kept, &vessels, &mut notes)?;
    write_file(&folder.join(NODES), |out| write_csv(out, &kept_nodes))?;
    if outcome.answer.kept == outcome.answer.above_median {
        copy(folder, ["graphml", "vtp"])?;
    } else {
        topology(folder, MEDIAN_TOPOLOGY, outcome, &outcome.answer.above_median, &vessels, &mut notes)?;
    }
    if !outcome.suggested_cuts.is_empty() {
        write_file(&folder.join(SUGGESTED_CUTS), |out| write_csv(out, &suggested_cut_columns(outcome.suggested_cuts)))?;
    }
    if !outcome.pairings.is_empty() {
        write_file(&folder.join(PAIRINGS), |out| write_csv(out, &pairing_columns(outcome)))?;
    }
    // Columns of a large network are not kept for a page that is not made.
    let for_page = (network.vessel_count() <= PAGE_LIMIT).then_some((vessels, kept_nodes));
    matrices(folder, outcome, &mut notes)?;
    summary.state_graph(GRAPH, &graph(&folder.join(GRAPH), outcome)?);
    if let Some(picture) = overview(outcome, summary) {
        picture.write(folder, dpi)?;
    }
    let figures = pictures(folder, outcome, dpi)?;
    write_record(folder, summary)?;
    if let Some((vessels, nodes)) = for_page {
        let page = infer_page(outcome, &*summary, &vessels, nodes, figures);
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
        write_graphml(&mut summed, graph, &nodes, &vessels)?;
        sum = summed.finish();
        Ok(())
    })?;
    Ok(sum)
}

/// The vessels that are kept, with all nodes and their roles, the rows of those vessels, and the conditions that hold there.
fn kept_graph<'a>(outcome: &Outcome<'a>, kept: &[bool]) -> (Cow<'a, Network>, Vec<usize>, Boundary) {
    let boundary = outcome.boundary.held(outcome.network, |row| kept[row]);
    let whole = kept.iter().all(|kept| *kept);
    if whole && outcome.network.nodes().zip(&boundary.roles).all(|(node, role)| node.role == Some(*role)) {
        return (Cow::Borrowed(outcome.network), (0..kept.len()).collect(), boundary);
    }
    let (mut graph, rows) = outcome.network.subgraph(|row| kept[row]);
    for (node, role) in boundary.roles.iter().enumerate() {
        graph.node_mut(node).role = Some(*role);
    }
    (Cow::Owned(graph), rows, boundary)
}

/// The columns of the nodes of a topology, with their pressures and conditions.
fn columns_of_nodes(graph: &Network, boundary: &Boundary, viscosity: f64) -> Result<Vec<Column>> {
    let circuit = Circuit::new(graph, boundary, viscosity)?;
    let pressure = pressures::pressures(&circuit, |_| true)?;
    let mut nodes = node_columns(graph, boundary, &pressure, &fragments(graph, |_, _| true).of_node);
    nodes.extend(condition_columns(graph, boundary));
    Ok(nodes)
}

/// The columns of nodes.csv, for the vessels that are kept.
///
/// # Errors
///
/// Pressures that cannot be solved for.
pub fn topology_columns(outcome: &Outcome<'_>, kept: &[bool]) -> Result<Vec<Column>> {
    let (graph, _, boundary) = kept_graph(outcome, kept);
    columns_of_nodes(&graph, &boundary, outcome.sampling.viscosity)
}

/// Writes a topology, every vessel of it kept, in every format that can hold it and returns its node columns.
fn topology(
    folder: &Path,
    name: &str,
    outcome: &Outcome<'_>,
    kept: &[bool],
    vessels: &[Column],
    notes: &mut Vec<String>,
) -> Result<Vec<Column>> {
    let (graph, rows, boundary) = kept_graph(outcome, kept);
    let nodes = columns_of_nodes(&graph, &boundary, outcome.sampling.viscosity)?;
    let mut vessels = select(vessels, &rows);
    for column in vessels.iter_mut().filter(|column| column.name == "kept") {
        *column = Column::whole("kept", rows.iter().map(|_| 1));
    }
    let file = |ending: &str| folder.join(format!("{name}.{ending}"));
    write_file(&file("graphml"), |out| write_graphml(out, &graph, &nodes, &vessels))?;
    if graph.has_positions() {
        write_file(&file("vtp"), |out| write_vtp(out, &graph, &vessels))?;
        if name == TOPOLOGY {
            if is_forest(&graph) {
                write_file(&file("swc"), |out| write_swc(out, &graph).map(drop))?;
            } else {
                notes.push("topology.swc is left out: the kept graph has cycles, which SWC cannot hold".into());
            }
        }
    } else if name == TOPOLOGY {
        notes.push("topology.vtp and topology.swc are left out: the nodes have no coordinates".into());
    }
    Ok(nodes)
}

/// The columns of nodes.csv. `pressure` in Pa.
pub fn node_columns(network: &Network, boundary: &Boundary, pressure: &[Option<f64>], component: &[usize]) -> Vec<Column> {
    let roles: Vec<Option<Role>> = boundary.roles.iter().copied().map(Some).collect();
    willis_io::formats::node_columns(network, &roles, pressure, component)
}

/// The terminal resistances and flows of the nodes, and which of their conditions were found, by which a graph file keeps its boundary
/// conditions.
pub fn condition_columns(network: &Network, boundary: &Boundary) -> Vec<Column> {
    let conditions: Vec<Option<Condition>> = (0..network.node_count()).map(|node| boundary.condition(node)).collect();
    let found: Vec<bool> = (0..network.node_count()).map(|node| boundary.is_found(node)).collect();
    willis_io::formats::condition_columns(&conditions).into_iter().chain(willis_io::formats::found_column(&found)).collect()
}

/// The columns of edges.csv.
pub fn vessel_columns(outcome: &Outcome<'_>) -> Vec<Column> {
    let (network, result, answer) = (outcome.network, outcome.result, outcome.answer);
    let flag = |name, flags: &[bool]| Column::whole(name, flags.iter().map(|f| usize::from(*f)));
    let mut columns = willis_io::formats::vessel_columns(network);
    columns.extend([
        Column::real("prior", network.vessels().map(|(_, v)| if outcome.sampling.uniform_prior { 1.0 } else { v.prior })),
        Column::real("likelihood", result.likelihood.iter().copied()),
        Column::real("std_error", result.std_error.iter().copied()),
        Column::real("frequency", result.frequency.iter().copied()),
        Column::real("probability", network.vessels().map(|(_, v)| v.evidence.map_or(f64::NAN, |e| e.probability))),
        Column::real("needed", answer.needed.iter().copied()),
        Column::real("instead", answer.instead.iter().map(|row| row.map_or(f64::NAN, |row| row as f64))),
        flag("above_median", &answer.above_median),
        flag("kept", &answer.kept),
    ]);
    columns
}

/// The columns of suggested-cuts.csv.
pub fn suggested_cut_columns(cuts: &[SuggestedCut]) -> Vec<Column> {
    let place = |name, axis: usize| Column::real(name, cuts.iter().map(move |cut| millimetres(cut.position[axis])));
    vec![
        place("x_mm", 0),
        place("y_mm", 1),
        place("z_mm", 2),
        Column::real("radius_mm", cuts.iter().map(|cut| millimetres(cut.radius))),
        Column::text("node", cuts.iter().map(|cut| cut.node.clone())),
        Column::real("probability", cuts.iter().map(|cut| cut.probability)),
    ]
}

/// The columns of pairings.csv.
pub fn pairing_columns(outcome: &Outcome<'_>) -> Vec<Column> {
    let kept = &outcome.answer.kept;
    let mut rows: Vec<(Point, String, f64, bool)> = Vec::new();
    for pairings in outcome.pairings {
        let taken = pairings.taken(kept);
        rows.extend(pairings.ways.iter().map(|(way, p)| (pairings.position, pairings.told(way), *p, *way == taken)));
        if pairings.ways.iter().all(|(way, _)| *way != taken) {
            rows.push((pairings.position, pairings.told(&taken), f64::NAN, true));
        }
    }
    let place = |name, axis: usize| Column::real(name, rows.iter().map(move |row| millimetres(row.0[axis])));
    vec![
        place("x_mm", 0),
        place("y_mm", 1),
        place("z_mm", 2),
        Column::text("vessels", rows.iter().map(|row| row.1.clone())),
        Column::real("probability", rows.iter().map(|row| row.2)),
        Column::whole("taken", rows.iter().map(|row| usize::from(row.3))),
    ]
}

/// The rows of some columns.
pub fn select(columns: &[Column], rows: &[usize]) -> Vec<Column> {
    let pick = |values: &Values| match values {
        Values::Real(v) => Values::Real(rows.iter().map(|r| v[*r]).collect()),
        Values::Integer(v) => Values::Integer(rows.iter().map(|r| v[*r]).collect()),
        Values::Text(v) => Values::Text(rows.iter().map(|r| v[*r].clone()).collect()),
    };
    columns.iter().map(|c| Column { name: c.name.clone(), values: pick(&c.values) }).collect()
}
