//! Reads labelled cases from folders: the centerlines, the artery of each point, and which segments of the ring are there.

use std::collections::{BTreeMap, BTreeSet};
use std::path::{Path, PathBuf};

use serde::Deserialize;

use crate::cases::{each_once, read_network, walk};
use willis_core::error::{Fault, Result, ensure, require};
use willis_core::network::{Frame, Network, paths::ShortestPaths};
use willis_core::support::geometry::{Point, distance, dot};
use willis_core::support::in_order;
use willis_io::formats::{is_there, open_regular, regular_bytes_of, tables::reader::TableReader};
use willis_models::candidates::{CandidateOptions, build_with_evidence, model::Weights};
use willis_models::circle_of_willis::{Artery, BodySide, LabelScheme, artery_of_label};
use willis_models::naming::Nodes;
use willis_models::naming::atlas::{
    ArteryLabel, AtlasState, LABELS, NOWHERE, OTHER, artery_of, begins_at, in_atlas, label_named, name_of, state_at,
};

const TRUTH: &str = "truth.json";
const LABELS_FILE: &str = "labels.csv";

/// A case whose arteries are known.
#[derive(Debug, Clone)]
pub struct LabelledCase {
    /// The patient.
    pub subject: String,
    /// What was done to the tracing: `whole`, `easy`, ...
    pub level: String,
    /// Whether nothing was done: the atlas is fitted to such cases.
    pub is_whole: bool,
    /// Its centerlines.
    pub network: Network,
    /// The over-connected graph.
    pub graph: Network,
    /// Its nodes with their true labels.
    pub truth: LabelledNodes,
    /// Per segment of the ring whether it is there, where that is known.
    pub present: [Option<bool>; 7],
}

#[derive(Deserialize)]
struct NamesTruthFile {
    subject: String,
    #[serde(default)]
    level: String,
    #[serde(default)]
    whole: bool,
    #[serde(default)]
    frame: String,
    #[serde(default)]
    phenotype: Vec<StatedSegment>,
}

#[derive(Deserialize)]
struct StatedSegment {
    segment: String,
    present: bool,
}

/// Reads all cases below some folders, in the order of their paths. A case folder holds `fragments.swc`, `labels.csv` (`id,label`: the artery of
/// each point, `other` for none of the circle), `truth.json` (`subject`, `level`, `whole`, `frame`, `phenotype`), and `loops.csv` where
/// there are any.
///
/// # Errors
///
/// A folder without a case; a file that cannot be read; a label that is no artery. Labels of points that are not in the tracing are passed over.
pub fn read_labelled_cases(folders: &[PathBuf]) -> Result<Vec<LabelledCase>> {
    let mut found = Vec::new();
    for folder in folders {
        let before = found.len();
        walk(folder, 0, &mut |path, _| {
            let is_case = [TRUTH, LABELS_FILE].iter().all(|name| is_there(&path.join(name)));
            found.extend(is_case.then(|| path.to_owned()));
            is_case
        })?;
        let accepted = "expected folders with fragments.swc, labels.csv and truth.json in them";
        require(found.len() > before, "CASES", format!("{}: no labelled case", folder.display()), accepted)?;
    }
    each_once(found.iter())?;
    let weights = Weights::shipped()?;
    in_order(&found, |_, folder| read_case(folder, &weights)).into_iter().collect()
}

fn read_case(folder: &Path, weights: &Weights) -> Result<LabelledCase> {
    let path = folder.join("fragments.swc");
    let loops = Some(folder.join("loops.csv")).filter(|path| is_there(path));
    [Some(&path), loops.as_ref()].into_iter().flatten().try_for_each(|path| open_regular(path).map(drop))?;
    let (mut network, _) = read_network(&path, loops)?;
    let truth_file = folder.join(TRUTH);
    let truth: NamesTruthFile = serde_json::from_slice(&regular_bytes_of(&truth_file)?).map_err(|e| {
        Fault::line(e.line().max(1), e.to_string(), "expected an object with subject and phenotype").in_file(&truth_file)
    })?;
    if !network.frame.is_known() {
        network.frame = Frame::of_word(&truth.frame);
        let fault = || Fault::item("frame", format!("\"{}\"", truth.frame), "expected RAS or LPS").in_file(&truth_file);
        ensure(network.frame.is_known() || truth.frame.is_empty(), fault)?;
    }
    let labels_file = folder.join(LABELS_FILE);
    let labels = read_labels(&regular_bytes_of(&labels_file)?).map_err(|fault| fault.in_file(&labels_file))?;
    let mut present = [None; 7];
    for segment in &truth.phenotype {
        let artery = artery_of_label(&segment.segment, LabelScheme::Names);
        let Some(row) = artery.and_then(Artery::in_ring) else {
            let why =
                Fault::item(format!("segment \"{}\"", segment.segment), "is none", "expected one of the ring, such as L-A1");
            return Err(why.in_file(&truth_file));
        };
        present[row] = Some(segment.present);
    }
    let graph = build_with_evidence(&network, &[], &CandidateOptions::default(), weights)?.0;
    // Nodes have the labels of the points that they lie nearest to.
    let nodes = Nodes::of(&graph, graph.frame);
    let label: Vec<ArteryLabel> = nodes.id.iter().map(|id| id.and_then(|id| labels.get(&id)).copied().unwrap_or(OTHER)).collect();
    Ok(LabelledCase {
        subject: truth.subject,
        level: truth.level,
        is_whole: truth.whole,
        truth: LabelledNodes { state: true_states(&nodes, &label), nodes, label },
        network,
        graph,
        present,
    })
}

/// The label of each point.
fn read_labels(bytes: &[u8]) -> Result<BTreeMap<u64, ArteryLabel>, Fault> {
    let mut rows = TableReader::ragged(bytes)?;
    let line = rows.header_line;
    let column =
        |name: &str| rows.find(&[name]).ok_or_else(|| Fault::line(line, format!("no column {name}"), "expected id,label"));
    let (id, label) = (column("id")?, column("label")?);
    let mut labels = BTreeMap::new();
    while let Some(row) = rows.row()? {
        let text = row.text(label).to_owned();
        let number: u64 =
            row.text(id).parse().map_err(|_| Fault::line(row.line, format!("id \"{}\"", row.text(id)), "expected a number"))?;
        let known = label_named(&text).or_else(|| label_named(&text.replace("M3", "M2")));
        let Some(known) = known.or_else(|| (text.is_empty() || text.ends_with("VA")).then_some(OTHER)) else {
            let names: BTreeSet<String> = (0..LABELS).map(name_of).collect();
            let accepted = format!("expected one of {}", names.into_iter().collect::<Vec<_>>().join(", "));
            return Err(Fault::line(row.line, format!("label \"{text}\""), accepted));
        };
        labels.insert(number, known);
    }
    Ok(labels)
}

/// The nodes of a case with what they are.
#[derive(Debug, Clone)]
pub struct LabelledNodes {
    /// The nodes.
    pub nodes: Nodes,
    /// The label of each.
    pub label: Vec<ArteryLabel>,
    /// The state of each.
    pub state: Vec<AtlasState>,
}

/// The states of nodes whose labels are known.
fn true_states(nodes: &Nodes, label: &[ArteryLabel]) -> Vec<AtlasState> {
    let mut state = vec![NOWHERE; nodes.len()];
    let mut paths = ShortestPaths::new(nodes.len());
    for artery in 0..OTHER {
        let own: Vec<usize> = (0..nodes.len()).filter(|n| label[*n] == artery).collect();
        if own.is_empty() {
            continue;
        }
        let is_reference = |n: &usize| nodes.neighbours[*n].iter().any(|z| label[*z] != artery && begins_at(artery, label[*z]));
        let mut sources: Vec<usize> = own.iter().copied().filter(is_reference).collect();
        if sources.is_empty() {
            let highest =
                |best: usize, n: &usize| if height(nodes.at[*n], artery) > height(nodes.at[best], artery) { *n } else { best };
            sources.push(own.iter().fold(own[0], highest));
        }
        let edges = |n: usize| {
            let next = nodes.neighbours[n].iter().filter(|z| label[**z] == artery);
            next.map(|z| (0, *z, distance(nodes.at[n], nodes.at[*z]))).collect::<Vec<_>>()
        };
        paths.search(&sources, f64::INFINITY, edges, |_, _| true);
        let along = paths.lengths();
        for n in &own {
            let far = if along[*n].is_finite() {
                along[*n]
            } else {
                // A second part of the artery, behind a gap.
                let reached = own.iter().filter(|q| along[**q].is_finite());
                let away = reached.map(|q| (distance(nodes.at[*q], nodes.at[*n]), *q));
                away.min_by(|a, b| a.0.total_cmp(&b.0)).map_or(0.0, |(d, q)| along[q] + d)
            };
            state[*n] = state_at(artery, far);
        }
    }
    state
}

/// How far a position lies in the direction in which the reference end of an artery is expected.
fn height(at: Point, artery: ArteryLabel) -> f64 {
    let is_right = artery_of(artery).and_then(Artery::side) == Some(BodySide::Right);
    dot(in_atlas(artery).begins, if is_right { [-at[0], at[1], at[2]] } else { at })
}
