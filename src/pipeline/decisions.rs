//! Decisions of a person on connections: accepted ones are certain, rejected ones are gone, and those beside them follow; those of two readers side by side.

use std::{collections::BTreeMap, collections::BTreeSet, path::Path};

use serde::{Deserialize, Serialize};

use super::{Input, SourceFile, models::Contacts, require};
use crate::{Error, Network, Result};
use willis_core::decision::{BESIDE_ACCEPTED, knows_fragments};
use willis_core::flow::boundary_conditions::find_again;
use willis_core::network::{Evidence, GraphEditor, Origin, Vessel, fragments};
use willis_core::{error::Fault, network::units::millimetres, support::geometry::distance};
use willis_io::formats::{ListedDecision, ListedDecisions, read_decisions};
use willis_report::TwiceRead;

pub use willis_io::formats::{ConnectionDecision, GraphEdit};

/// A connection whose row moved is found again if both its nodes are so near to where they were, mm.
const MOVED: f64 = 0.5;

/// What a person decided, as run.json has it.
#[derive(Debug, Clone, Default, Serialize, Deserialize)]
pub(crate) struct Decided {
    /// The file that holds it; none where it was decided in a program.
    #[serde(flatten)]
    pub(super) source: Option<SourceFile>,
    pub(super) made: Vec<ConnectionDecision>,
    /// Edits, in their order; they come after what is decided on connections.
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    pub(super) edits: Vec<GraphEdit>,
}

/// The decisions that a file lists.
pub(super) struct DecisionList {
    listed: ListedDecisions,
    source: SourceFile,
}

impl DecisionList {
    /// Reads a file.
    pub(super) fn read(path: &Path) -> Result<Self> {
        let (bytes, source) = SourceFile::read(path)?;
        Ok(Self { listed: read_decisions(&bytes).map_err(|fault| fault.in_file(path))?, source })
    }

    /// The decisions on a graph that was built of the input with this SHA-256. A connection that has another row here is found again by the
    /// places of its nodes, where the list has them.
    ///
    /// # Errors
    ///
    /// A file that was made for another input or another graph.
    pub(super) fn on(self, graph: &Network, input_sha256: &str) -> Result<Decided> {
        let Self { listed, source } = self;
        let (mut made, mut decided) = (Vec::new(), BTreeSet::new());
        for decision in listed.connections {
            let places = decision.places.filter(|_| decision.input.is_empty() || decision.input == input_sha256);
            let row = check(&decision, graph, input_sha256).map(|()| decision.made.edge);
            let row = row.or_else(|fault| places.and_then(|at| moved(graph, at, &decision.ids)).ok_or(fault));
            let edge = row.map_err(|fault| fault.in_file(&source.path))?;
            if !decided.insert(edge) {
                let found = format!("edge {edge} comes again, by its places");
                return Err(Fault::line(decision.line, found, "expected one decision an edge").in_file(&source.path));
            }
            made.push(ConnectionDecision { edge, ..decision.made });
        }
        Ok(Decided { made, edits: listed.edits, source: Some(source) })
    }
}

/// The row of the candidate or contact whose nodes are nearest to these places (mm), in either order, one between nodes of these ids before
/// others; `None` where each is too far, or several are as near, as the contacts of one junction are.
fn moved(graph: &Network, places: [[f64; 3]; 2], [id_a, id_b]: &[String; 2]) -> Option<usize> {
    let away = |node, place: [f64; 3]| graph.node(node).position.map_or(f64::INFINITY, |at| distance(at.map(millimetres), place));
    let worst = |[a, b]: [usize; 2]| away(a, places[0]).max(away(b, places[1])).min(away(b, places[0]).max(away(a, places[1])));
    let is_named = |ends: [usize; 2]| {
        let ids = ends.map(|node| &graph.node(node).id);
        ids == [id_a, id_b] || ids == [id_b, id_a]
    };
    let open = graph.vessels().enumerate().filter(|(_, (_, vessel))| vessel.origin != Origin::Observed);
    let mut near: Vec<_> =
        open.map(|(row, (ends, _))| (!is_named(ends), worst(ends), row)).filter(|(_, away, _)| *away <= MOVED).collect();
    near.sort_by(|a, b| a.0.cmp(&b.0).then(a.1.total_cmp(&b.1)));
    match near[..] {
        [] => None,
        [first, second, ..] if (first.0, first.1) == (second.0, second.1) => None,
        [(_, _, row), ..] => Some(row),
    }
}

/// Refuses a decision on another graph than this.
fn check(decision: &ListedDecision, graph: &Network, input_sha256: &str) -> Result<(), Fault> {
    let ListedDecision { made: ConnectionDecision { edge, .. }, line, ids: [a, b], input, .. } = decision;
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
/// Candidates beside accepted ones follow: by the law of [forests](knows_fragments) those that close a loop are gone, and a fragment hangs on one other
/// at most; judged one by one they keep half of their P ([`BESIDE_ACCEPTED`]), once for each end, however many are accepted there and when. Candidates
/// beside rejected ones, and contacts, keep theirs.
///
/// # Errors
///
/// A row that is no candidate and no contact.
pub fn apply(graph: &mut Network, decisions: &[ConnectionDecision]) -> Result<()> {
    let decided: BTreeMap<usize, bool> = decisions.iter().filter_map(|d| Some((d.edge, d.accepted?))).collect();
    for edge in decisions.iter().map(|d| d.edge) {
        let is_open = edge < graph.vessel_count() && graph.vessel(edge).origin != Origin::Observed;
        require(is_open, "decisions", edge, "expected the row of a candidate or of a contact")?;
    }
    let excluded = Excluded::by(graph, &decided);
    for row in 0..graph.vessel_count() {
        let ends = graph.ends(row);
        let vessel = graph.vessel_mut(row);
        match decided.get(&row) {
            Some(accepted) => {
                let probability = f64::from(u8::from(*accepted));
                (vessel.certain, vessel.prior) = (*accepted, probability);
                vessel.evidence = vessel.evidence().map(|e| Box::new(e.with_probability(probability)));
            }
            None if vessel.origin == Origin::Candidate && !vessel.certain => {
                let Some(follows) = vessel.evidence().and_then(|evidence| excluded.leave(evidence, ends)) else { continue };
                vessel.prior = follows.probability;
                vessel.evidence = Some(Box::new(follows));
            }
            None => {}
        }
    }
    Ok(())
}

/// What accepted candidates leave of others.
///
/// Fragments form a forest, so a candidate between two that are joined by now is gone. And a fragment hangs on one other at most, while any number
/// hang on it. So of the probability that the fragment of a free end hangs on another from there, what is left is the probability that it does not hang by
/// an accepted candidate; that others hang on it stays as probable as it was.
struct Excluded {
    of_forest: bool,
    /// Per free end that accepted candidates leave, the probability that its fragment hangs by none of them: where it hangs on one at most,
    /// 1 / (1 + Σ of the odds that it hangs by each). Judged one by one, an end where one was accepted before has taken the half of others.
    hangs_by_none: BTreeMap<usize, f64>,
    /// Per node its fragment before and after.
    parts: [Vec<usize>; 2],
}

impl Excluded {
    fn by(graph: &Network, decided: &BTreeMap<usize, bool>) -> Self {
        let degree = graph.degrees(|vessel| vessel.origin == Origin::Observed);
        let accepted = |row: usize| decided.get(&row) == Some(&true);
        let of_forest = knows_fragments(graph);
        let mut odds: BTreeMap<usize, f64> = BTreeMap::new();
        let mut taken = BTreeSet::new();
        for (row, (ends, vessel)) in graph.vessels().enumerate().filter(|(_, (_, vessel))| vessel.origin == Origin::Candidate) {
            if !accepted(row) {
                let is_taken = !of_forest && vessel.certain && !decided.contains_key(&row);
                taken.extend(ends.into_iter().filter(|_| is_taken));
                continue;
            }
            let Evidence { probability: p, attached, .. } = vessel.evidence().unwrap_or(Evidence::undirected(0.0));
            for (node, hangs) in ends.into_iter().zip(attached).filter(|(node, _)| degree[*node] <= 1) {
                // Either way is as probable where nothing is known.
                *odds.entry(node).or_default() += if p > 0.0 { hangs / (p - hangs).max(0.0) } else { 1.0 };
            }
        }
        let before = fragments(graph, |row, vessel| vessel.is_given() && !accepted(row)).of_node;
        let after = fragments(graph, |row, vessel| vessel.is_given() || accepted(row)).of_node;
        let open = odds.into_iter().filter(|(node, _)| !taken.contains(node));
        let hangs_by_none = open.map(|(node, odds)| (node, 1.0 / (1.0 + odds))).collect();
        Self { of_forest, hangs_by_none, parts: [before, after] }
    }

    /// What is left of a candidate; `None` where nothing of it is excluded.
    fn leave(&self, evidence: Evidence, [a, b]: [usize; 2]) -> Option<Evidence> {
        let beside = [a, b].map(|node| self.hangs_by_none.get(&node).copied());
        let Evidence { probability, attached, .. } = evidence;
        if !self.of_forest {
            let by: f64 = beside.iter().flatten().map(|_| BESIDE_ACCEPTED).product();
            return (beside != [None; 2]).then(|| evidence.with_probability(by * probability));
        }
        let [were, are] = [&self.parts[0], &self.parts[1]].map(|parts| parts[a] == parts[b]);
        if are != were {
            return Some(evidence.with_probability(0.0));
        }
        let left = [0, 1].map(|end| attached[end] * beside[end].unwrap_or(1.0));
        let gone = (attached[0] - left[0]) + (attached[1] - left[1]);
        (gone > 0.0).then(|| Evidence { attached: left, ..evidence.with_probability((probability - gone).max(0.0)) })
    }
}

/// What a person decides on: the over-connected graph, its contacts, and whether A = 1 stands for the priors of all its vessels.
#[derive(Debug, Clone, Serialize, Deserialize)]
pub(crate) struct Decidable {
    pub(super) graph: Network,
    pub(super) contacts: Contacts,
    pub(super) uniform_prior: bool,
}

impl Decidable {
    /// The same where a person has marked candidates or contacts of the file as certain: they are accepted. What was accepted before it was written has A = 1.
    ///
    /// # Errors
    ///
    /// None where rows are those of the graph.
    pub(super) fn with_marks(mut self) -> Result<Self> {
        let is_mark = |v: &Vessel| v.certain && v.origin != Origin::Observed && v.evidence.is_some() && v.prior < 1.0;
        let marks = self.graph.vessels().enumerate().filter(|(_, (_, vessel))| is_mark(vessel));
        let accept = |(edge, _)| ConnectionDecision { edge, accepted: Some(true), ..Default::default() };
        let marks: Vec<ConnectionDecision> = marks.map(accept).collect();
        apply(&mut self.graph, &marks)?;
        Ok(self)
    }

    /// The same with decisions, as one after the other leaves it. A rejected connection has A = 0, so from then on the vessels' own priors count, which
    /// are set to 1. Pairings follow vessels that an edit divides; inlets and outlets that an earlier run found, the ends that are left.
    ///
    /// # Errors
    ///
    /// A row that is no candidate and no contact; an edit whose places mean nothing here.
    pub(super) fn decided(self, decided: &Decided) -> Result<Self> {
        let Self { mut graph, mut contacts, uniform_prior } = self;
        let Decided { made, edits, source } = decided;
        let any = made.iter().any(|d| d.accepted.is_some()) || !edits.is_empty();
        if uniform_prior && any {
            (0..graph.vessel_count()).for_each(|row| graph.vessel_mut(row).prior = 1.0);
        }
        apply(&mut graph, made)?;
        for GraphEdit { edit, line, .. } in edits {
            let mut editor = GraphEditor::new(graph);
            editor.edit(edit).map_err(|why| match source {
                Some(source) if *line > 0 => Fault::line(*line, edit.to_string(), why).in_file(&source.path),
                _ => Error::parameter("decisions", edit.to_string(), why),
            })?;
            let accept = |edge: &usize| ConnectionDecision { edge: *edge, accepted: Some(true), ..Default::default() };
            let (joined, divided): (Vec<_>, _) =
                (editor.joined.iter().map(accept).collect(), std::mem::take(&mut editor.divided));
            graph = editor.finish();
            apply(&mut graph, &joined)?;
            contacts.pairings.iter_mut().for_each(|pairings| pairings.follow(&graph, &divided));
        }
        let graph = if any { find_again(graph) } else { graph };
        Ok(Self { graph, contacts, uniform_prior: uniform_prior && !any })
    }
}

/// What two readers decided on the connections of a run, as [`read_run`](crate::read_run) has it, in the order of its rows: each that one of them decided on. `files` are their
/// decisions, as the page of the run writes them; `name` is that of the subject.
///
/// # Errors
///
/// An input that is no run; a file that cannot be read, or is of another run.
pub fn twice_read(name: &str, input: &Input, files: [&Path; 2]) -> Result<Vec<TwiceRead>> {
    let Some(run) = &input.run else {
        let accepted = "expected the folder of the run of willis infer that was looked at";
        return Err(Fault::file("no run, so nobody decided on it", accepted).in_file(Path::new(&input.provenance.input)));
    };
    let network = &input.network;
    let mut rows: BTreeMap<usize, [Option<ConnectionDecision>; 2]> = BTreeMap::new();
    for (reader, file) in files.into_iter().enumerate() {
        for made in DecisionList::read(file)?.on(network, &run.input_sha256)?.made {
            let read = rows.entry(made.edge).or_default();
            read[reader] = Some(made);
        }
    }
    let row = |(edge, read): (usize, [Option<ConnectionDecision>; 2])| {
        let (subject, ends, vessel) = (name.to_owned(), network.ends(edge), network.vessel(edge));
        let (ids, middle) = (ends.map(|node| network.node(node).id.clone()), network.middle_of(ends, vessel).map(millimetres));
        let probability = vessel.evidence().map_or(f64::NAN, |evidence| evidence.probability);
        TwiceRead { subject, kind: vessel.origin.name(), edge, ids, middle, probability, read }
    };
    Ok(rows.into_iter().map(row).collect())
}
