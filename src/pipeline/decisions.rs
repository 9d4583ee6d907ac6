//! Decisions of a person on connections: accepted ones are certain, rejected ones are gone, and those beside them follow.

use std::collections::BTreeMap;
use std::path::Path;

use serde::{Deserialize, Serialize};

use super::source_file::SourceFile;
use willis_core::error::{Error, Fault, Result};
use willis_core::network::{Evidence, Network, Origin};
use willis_io::formats::{ListedDecision, read_decisions};

/// A decision on one connection.
#[derive(Debug, Clone, PartialEq, Eq, Default, Serialize, Deserialize)]
pub struct ConnectionDecision {
    /// The row of the vessel in edges.csv.
    pub edge: usize,
    /// Whether the connection is there; none where the reader was unsure, which changes nothing.
    pub accepted: Option<bool>,
    /// Who decided; may be empty.
    #[serde(default)]
    pub who: String,
    /// When; may be empty.
    #[serde(default)]
    pub when: String,
    /// What was said of it; may be empty.
    #[serde(default, skip_serializing_if = "String::is_empty")]
    pub comment: String,
}

/// What a person decided, as run.json has it.
#[derive(Debug, Clone, Default, Serialize, Deserialize)]
pub(crate) struct Decided {
    /// The file that holds it; none where it was decided in a program.
    #[serde(flatten)]
    source: Option<SourceFile>,
    pub(super) made: Vec<ConnectionDecision>,
}

/// The decisions that a file lists.
pub(super) struct DecisionList {
    listed: Vec<ListedDecision>,
    source: SourceFile,
}

impl DecisionList {
    /// Reads a file.
    pub(super) fn read(path: &Path) -> Result<Self> {
        let (bytes, source) = SourceFile::read(path)?;
        Ok(Self { listed: read_decisions(&bytes).map_err(|fault| fault.in_file(path))?, source })
    }

    /// The decisions on a graph that was built of the input with this SHA-256.
    ///
    /// # Errors
    ///
    /// A file that was made for another input or another graph.
    pub(super) fn on(self, graph: &Network, input_sha256: &str) -> Result<Decided> {
        let Self { listed, source } = self;
        for decision in &listed {
            check(decision, graph, input_sha256).map_err(|fault| fault.in_file(&source.path))?;
        }
        let made = listed.into_iter().map(|d| {
            let ListedDecision { edge, accepted, who, when, comment, .. } = d;
            ConnectionDecision { edge, accepted, who, when, comment }
        });
        Ok(Decided { made: made.collect(), source: Some(source) })
    }
}

/// Refuses a decision on another graph than this.
fn check(decision: &ListedDecision, graph: &Network, input_sha256: &str) -> Result<(), Fault> {
    let ListedDecision { line, edge, ids: [a, b], input, .. } = decision;
    if !input.is_empty() && input != input_sha256 {
        let found = format!("edge {edge} was decided on for an input with SHA-256 {input}; this one has {input_sha256}");
        return Err(Fault::line(*line, found, "expected the input of the run that was looked at, unedited"));
    }
    let same = "expected the options of the run that was looked at, by which its candidates were built";
    if *edge >= graph.vessel_count() {
        let found = format!("edge {edge} ({a} to {b}) is none of the {} vessels", graph.vessel_count());
        return Err(Fault::line(*line, found, same));
    }
    let [here_a, here_b] = graph.ends(*edge).map(|node| graph.node(node).id.clone());
    if [&here_a, &here_b] != [a, b] {
        let found = format!("edge {edge} joins {a} to {b} in the list, and {here_a} to {here_b} here");
        return Err(Fault::line(*line, found, same));
    }
    if graph.vessel(*edge).origin == Origin::Observed {
        let found = format!("edge {edge} ({a} to {b}) is an observed vessel");
        return Err(Fault::line(*line, found, "expected a candidate or a contact"));
    }
    Ok(())
}

/// Applies decisions to a graph. An accepted connection is certain, with P = 1. A rejected one has A = 0 and P = 0, so that no sample and
/// no rule has it; its row stays, so that every other row does.
///
/// Of the candidates that leave one free end at most one is true. So those beside an accepted one have P = 0, and those beside rejected
/// ones P / (1 - Σ P of the rejected), at most 1.
///
/// # Errors
///
/// A row that is no candidate and no contact.
pub fn apply(graph: &mut Network, decisions: &[ConnectionDecision]) -> Result<()> {
    let decided: BTreeMap<usize, bool> = decisions.iter().filter_map(|d| Some((d.edge, d.accepted?))).collect();
    for edge in decisions.iter().map(|d| d.edge) {
        if edge >= graph.vessel_count() || graph.vessel(edge).origin == Origin::Observed {
            return Err(Error::parameter("decisions", edge, "expected the row of a candidate or of a contact"));
        }
    }
    let mut degree = vec![0_usize; graph.node_count()];
    for (ends, _) in graph.vessels().filter(|(_, v)| v.origin == Origin::Observed) {
        for node in ends {
            degree[node] += 1;
        }
    }
    // Per free end whether a connection was accepted there, and the sum of P of the rejected.
    let mut at: BTreeMap<usize, (bool, f64)> = BTreeMap::new();
    for (&edge, &accepted) in &decided {
        let probability = graph.vessel(edge).evidence.map_or(0.0, |e| e.probability);
        for node in graph.ends(edge).into_iter().filter(|node| degree[*node] <= 1) {
            let (taken, gone) = at.entry(node).or_default();
            *taken |= accepted;
            *gone += if accepted { 0.0 } else { probability };
        }
    }
    for row in 0..graph.vessel_count() {
        let ends = graph.ends(row);
        let vessel = graph.vessel_mut(row);
        match decided.get(&row) {
            Some(true) => {
                vessel.certain = true;
                vessel.prior = 1.0;
                vessel.evidence = vessel.evidence.map(|e| scaled(e, 1.0 / e.probability.max(f64::MIN_POSITIVE)));
            }
            Some(false) => {
                vessel.certain = false;
                vessel.prior = 0.0;
                vessel.evidence = vessel.evidence.map(|e| scaled(e, 0.0));
            }
            None if vessel.origin != Origin::Observed && !vessel.certain => {
                let Some(evidence) = vessel.evidence else { continue };
                let factor = |node: &usize| match at.get(node) {
                    Some((true, _)) => 0.0,
                    Some((false, gone)) => 1.0 / (1.0 - gone).max(f64::EPSILON),
                    None => 1.0,
                };
                let by: f64 = ends.iter().map(factor).product();
                if by.to_bits() != 1.0_f64.to_bits() {
                    let follows = scaled(evidence, by);
                    vessel.prior = follows.probability;
                    vessel.evidence = Some(follows);
                }
            }
            None => {}
        }
    }
    Ok(())
}

/// Applies decisions to a graph, and returns whether A = 1 still stands for the priors of all vessels: a rejected connection has A = 0,
/// so from then on the vessels' own priors count, which are set to 1.
pub(super) fn decide_on(graph: &mut Network, made: &[ConnectionDecision], uniform_prior: bool) -> Result<bool> {
    let any = made.iter().any(|d| d.accepted.is_some());
    if uniform_prior && any {
        (0..graph.vessel_count()).for_each(|row| graph.vessel_mut(row).prior = 1.0);
    }
    apply(graph, made)?;
    Ok(uniform_prior && !any)
}

/// The evidence with its probability times a factor, at most 1.
fn scaled(evidence: Evidence, by: f64) -> Evidence {
    let probability = (by * evidence.probability).min(1.0);
    let ratio = if evidence.probability > 0.0 { probability / evidence.probability } else { 0.0 };
    let odds = Evidence::odds(probability);
    Evidence {
        probability,
        attached: evidence.attached.map(|p| (ratio * p).min(1.0)),
        continuation_odds: evidence.continuation_odds.map(|x| if x > 0.0 { odds } else { 0.0 }),
    }
}
