//! An inference with everything its files are made of, its tables, and what a person is asked about it, what a right answer puts right most first.

use std::borrow::Cow;
use std::collections::BTreeSet;

use serde::{Deserialize, Serialize};
use serde_json::{Value, json};

use crate::page::{ImagePlace, Segmentation};
use crate::run_record::{CONDITIONS, Provenance, RunRecord, conditions, outlets_found};
use willis_core::decision::{Decision, ExpectedErrors, Keep, Topology, UNDECIDED_BAND, UNDECIDED_Z};
use willis_core::flow::{Boundary, FoundOutlets};
use willis_core::network::units::{centipoise, millimetres};
use willis_core::network::{Merged, Network, Origin, Role, dependents, fragments, if_parted, merge, weakest_of_loops};
use willis_core::sampling::{Likelihood, Method, SamplingOptions};
use willis_core::support::geometry::Point;
use willis_io::formats::{self, Column, POSITION_COLUMNS, Values, coordinate_columns};
use willis_models::candidates::CandidateOptions;
use willis_models::contacts::split::SuggestedCut;
use willis_models::contacts::split::{PairingDecision, Pairings};

/// How samples were computed, as run.json has it.
#[derive(Debug, Clone, Serialize, Deserialize)]
pub struct SolverRecord {
    /// The solver: `lanes`, `gradients` or `reference`.
    pub flow: String,
    size: usize,
    forest: String,
    forest_joins: Option<usize>,
}

impl From<Method> for SolverRecord {
    fn from(Method { solver, solver_size, forest, forest_joins, .. }: Method) -> Self {
        Self { flow: solver.to_owned(), size: solver_size, forest: forest.to_owned(), forest_joins }
    }
}

/// The share of the samples in which blood flows below which a run is warned of.
const FEW_PERFUSED: f64 = 0.5;

/// An inference and everything its files are made of.
#[derive(Debug)]
pub struct Outcome<'a> {
    /// The over-connected graph.
    pub network: &'a Network,
    /// The same without what a person decided on connections, row for row; none where nobody did.
    pub without_decisions: Option<Cow<'a, Network>>,
    /// The rows of its first nodes that are the input's own, which no file of a topology leaves out.
    pub own_nodes: usize,
    /// Its boundary conditions.
    pub boundary: &'a Boundary,
    /// Cuts that are suggested, the surest first.
    pub suggested_cuts: &'a [SuggestedCut],
    /// How the vessels at each opened contact may be paired.
    pub pairings: &'a [Pairings],
    /// The names of observed vessels by row, where arteries were named by their geometry.
    pub arteries: &'a [(usize, String)],
    /// What an image shows around doubtful vessels.
    pub image_places: &'a [ImagePlace],
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
    pub solver: &'a SolverRecord,
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
        "The inlets found lie at ends that other vessels probably join: state where blood enters, with `inlet`."
    } else if sampling.epsilon > 0.0 {
        "A smaller `epsilon` leaves more ways from inlets to outlets open."
    } else {
        "State where blood leaves, with `outlet`."
    };
    Some(format!("Blood flows {what}, so {so}. {advice}"))
}

impl Outcome<'_> {
    /// How many contacts there are: places where observed vessels may only touch.
    pub fn contacts(&self) -> usize {
        self.network.vessels().filter(|(_, vessel)| vessel.origin == Origin::Contact).count()
    }

    /// The boundary conditions that hold in the kept topology.
    pub fn held(&self) -> Boundary {
        self.boundary.held(self.network, |row| self.answer.kept[row])
    }

    /// A topology of the vessels that are kept, with the conditions that hold there. Where only a candidate or a contact ended that is not kept,
    /// the vessel goes on: its parts are one again, but for those that were uncertain one by one.
    pub fn topology(&self, kept: &[bool]) -> Merged<'static> {
        let boundary = self.boundary.held(self.network, |row| kept[row]);
        let (mut graph, rows) = self.network.subgraph(|row| kept[row]);
        (0..rows.len()).for_each(|row| graph.vessel_mut(row).kept = Some(true));
        self.merged(&boundary, Cow::Owned(boundary.stated_in(graph)), &rows)
    }

    /// The same of the graph of the kept vessels, with their rows and the conditions that hold there; what its outlets and inner nodes state stays
    /// as it is, so that they are shared with the graph that they are of. One that is borrowed, and of which no node can go, is as it is.
    pub(super) fn merged<'g>(&self, boundary: &Boundary, graph: Cow<'g, Network>, rows: &[usize]) -> Merged<'g> {
        let mut may_go = vec![true; graph.node_count()];
        may_go[..self.own_nodes].fill(false);
        for row in rows.iter().filter(|row| self.result.uncertain[**row]) {
            self.network.ends(*row).into_iter().for_each(|node| may_go[node] = false);
        }
        let graph = match graph {
            Cow::Borrowed(_) if !may_go.contains(&true) => graph,
            graph => {
                let mut graph = graph.into_owned();
                for (row, role) in boundary.roles.iter().enumerate() {
                    let node = graph.node(row);
                    let says_nothing = node.role.is_none_or(|role| role == Role::Inner) && node.condition.is_none();
                    match role {
                        Role::Outlet if node.role != Some(Role::Inlet) => may_go[row] = false,
                        Role::Inner if says_nothing => {}
                        _ => {
                            let node = graph.node_mut(row);
                            (node.role, node.condition) = (Some(*role), boundary.condition(row));
                        }
                    }
                }
                Cow::Owned(graph)
            }
        };
        let mut merged = merge(graph, |node| may_go[node]);
        merged.parts.iter_mut().flatten().for_each(|part| *part = rows[*part]);
        merged
    }

    /// The contacts that are cut, by row.
    pub fn cuts(&self) -> impl Iterator<Item = usize> {
        let decided = self.network.vessels().zip(&self.answer.kept).enumerate();
        decided.filter(|(_, ((_, vessel), kept))| vessel.origin == Origin::Contact && !**kept).map(|(row, _)| row)
    }
}

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

/// The columns of the vessels of a topology from those of edges.csv. Of vessels that were merged, L and its error are means weighted by volume,
/// as ρ is of what it adds up over, and the frequency is the least; their other figures are equal.
pub fn merged_columns(network: &Network, merged: &Merged<'_>, vessels: Vec<Column>) -> Vec<Column> {
    let parts = &merged.parts;
    let words = parts.iter().map(|parts| parts.iter().map(usize::to_string).collect::<Vec<_>>().join("+"));
    let edges = Column::text("edges", words);
    let kept = Column::whole("kept", parts.iter().map(|_| 1));
    let first: Vec<usize> = parts.iter().filter_map(|parts| parts.iter().min().copied()).collect();
    if parts.len() == network.vessel_count() {
        // All are as they were.
        let each = vessels.into_iter().map(|column| if column.name == "kept" { kept.clone() } else { column });
        return each.chain([edges]).collect();
    }
    let is_merged = parts.iter().any(|parts| parts.len() > 1);
    let mut own = if is_merged { formats::vessel_columns(&merged.network) } else { Vec::new() };
    let volume = |row: &usize| network.vessel(*row).volume();
    let mean = |of: &[f64], parts: &[usize]| {
        if let [row] = parts {
            return of[*row];
        }
        let whole: f64 = parts.iter().map(volume).sum();
        parts.iter().map(|row| of[*row] * (volume(row) / whole)).sum()
    };
    let least = |of: &[f64], parts: &[usize]| parts.iter().map(|row| of[*row]).fold(f64::INFINITY, f64::min);
    let column = |all: Column| match (&*all.name, &all.values) {
        ("likelihood" | "std_error", Values::Real(of)) => {
            Column { values: Values::Real(parts.iter().map(|parts| mean(of, parts)).collect()), name: all.name }
        }
        ("frequency", Values::Real(of)) => Column::real("frequency", parts.iter().map(|parts| least(of, parts))),
        ("kept", _) => kept.clone(),
        ("node_a" | "node_b", _) => {
            let side = usize::from(all.name == "node_b");
            Column::whole(all.name, merged.network.vessels().map(|(ends, _)| merged.nodes[ends[side]]))
        }
        (name, _) => match own.iter().position(|own| own.name == name && name != "edge") {
            Some(at) => own.swap_remove(at),
            None => picked(&all, &first),
        },
    };
    vessels.into_iter().map(column).chain([edges]).collect()
}

/// The columns of edges.csv.
pub fn vessel_columns(outcome: &Outcome<'_>) -> Vec<Column> {
    let (network, result, answer) = (outcome.network, outcome.result, outcome.answer);
    let flag = |name, flags: &[bool]| Column::whole(name, flags.iter().map(|f| usize::from(*f)));
    let mut columns = formats::vessel_columns(network);
    columns.extend([
        Column::real("prior", network.vessels().map(|(_, v)| if outcome.sampling.uniform_prior { 1.0 } else { v.prior })),
        Column::real("likelihood", result.likelihood.iter().copied()),
        Column::real("std_error", result.std_error.iter().copied()),
        Column::real("frequency", result.frequency.iter().copied()),
        Column::real("probability", network.vessels().map(|(_, v)| v.evidence().map_or(f64::NAN, |e| e.probability))),
        Column::real("needed", answer.needed.iter().copied()),
        Column::real("instead", answer.instead.iter().map(|row| row.map_or(f64::NAN, |row| row as f64))),
        flag("above_median", &answer.above_median),
        flag("kept", &answer.kept),
    ]);
    columns
}

/// The columns of suggested-cuts.csv; `None` where no cut is suggested.
pub fn suggested_cut_columns(cuts: &[SuggestedCut]) -> Option<Vec<Column>> {
    let mut columns = positions(|| cuts.iter().map(|cut| cut.position));
    columns.extend([
        Column::real("radius_mm", cuts.iter().map(|cut| millimetres(cut.radius))),
        Column::text("node", cuts.iter().map(|cut| cut.node.clone())),
        Column::real("probability", cuts.iter().map(|cut| cut.probability)),
    ]);
    (!cuts.is_empty()).then_some(columns)
}

/// Three columns of positions.
pub(super) fn positions<I: Iterator<Item = Point>>(of: impl Fn() -> I) -> Vec<Column> {
    coordinate_columns(POSITION_COLUMNS, || of().map(|at| at.map(millimetres))).to_vec()
}

/// A way to pair the vessels at a place, as a row of pairings.csv.
struct PairingRow<'a> {
    place: &'a Pairings,
    told: String,
    probability: f64,
    taken: bool,
    decision: PairingDecision,
}

/// The columns of pairings.csv; `None` where no contact was opened.
pub fn pairing_columns(outcome: &Outcome<'_>) -> Option<Vec<Column>> {
    let mut rows: Vec<PairingRow<'_>> = Vec::new();
    for place in outcome.pairings {
        let taken = place.taken(&outcome.answer.kept);
        let is_listed = place.ways.iter().any(|(way, _)| *way == taken);
        let unlisted = (!is_listed).then(|| (taken.clone(), f64::NAN));
        for (way, probability) in place.ways.iter().chain(&unlisted) {
            let decision = place.decision(way, outcome.network).unwrap_or_default();
            rows.push(PairingRow { place, told: place.told(way), probability: *probability, taken: *way == taken, decision });
        }
    }
    // A space before a minus, which is no formula then.
    let as_text = |places: String| if places.starts_with('-') { format!(" {places}") } else { places };
    let listed = |of: &[usize]| of.iter().map(usize::to_string).collect::<Vec<String>>().join(" ");
    let contacts = |row: &PairingRow<'_>| listed(&row.place.contacts.iter().map(|(_, row)| *row).collect::<Vec<_>>());
    let part = |row: &PairingRow<'_>| row.decision.part.as_ref().map_or_else(String::new, |edit| as_text(edit.places()));
    let mut columns = positions(|| rows.iter().map(|row| row.place.position));
    columns.extend([
        Column::text("vessels", rows.iter().map(|row| row.told.clone())),
        Column::real("probability", rows.iter().map(|row| row.probability)),
        Column::whole("taken", rows.iter().map(|row| usize::from(row.taken))),
        Column::text("contacts", rows.iter().map(contacts)),
        Column::text("accept", rows.iter().map(|row| listed(&row.decision.accept))),
        Column::text("reject", rows.iter().map(|row| listed(&row.decision.reject))),
        Column::text("part", rows.iter().map(part)),
    ]);
    (!outcome.pairings.is_empty()).then_some(columns)
}

/// Some rows of a column.
pub fn picked(column: &Column, rows: &[usize]) -> Column {
    let values = match &column.values {
        Values::Real(v) => Values::Real(rows.iter().map(|r| v[*r]).collect()),
        Values::Integer(v) => Values::Integer(rows.iter().map(|r| v[*r]).collect()),
        Values::Text(v) => Values::Text(rows.iter().map(|r| &v[*r]).collect()),
    };
    Column { name: column.name.clone(), values }
}

/// A part without flow is asked about from this length on, and what is kept of masks if it is expected to be wrong about more than this, m.
pub const WORTH: f64 = 0.01;

/// The kind of a question about a part that nothing connects.
pub const PART: &str = "part";
/// That of one about a loop.
pub const LOOP: &str = "loop";
/// That of one about a place where one line may show two vessels.
pub const TOUCH: &str = "touch";

/// One question.
pub struct Question {
    /// The row that it is about.
    pub row: usize,
    /// The origin of that, `part`, `loop` or `touch`.
    pub kind: &'static str,
    /// Where it is.
    pub at: Point,
    words: String,
    /// The probability of the row, or that it is one vessel there.
    probability: f64,
    /// The length that hangs on it, m.
    pub hangs: f64,
    /// What a right answer is expected to put right, m.
    pub gain: f64,
}

/// The columns of review.csv; `None` where nothing is asked.
pub fn review_columns(outcome: &Outcome<'_>, asked: &[Question]) -> Option<Vec<Column>> {
    let kept = &outcome.answer.kept;
    let mut columns = vec![
        Column::whole("rank", 1..=asked.len()),
        Column::whole("edge", asked.iter().map(|one| one.row)),
        Column::text("kind", asked.iter().map(|one| one.kind.to_owned())),
    ];
    columns.extend(positions(|| asked.iter().map(|one| one.at)));
    columns.extend([
        Column::text("question", asked.iter().map(|one| one.words.clone())),
        Column::real("probability", asked.iter().map(|one| one.probability)),
        Column::whole("kept", asked.iter().map(|one| usize::from(kept[one.row]))),
        Column::real("hangs_mm", asked.iter().map(|one| millimetres(one.hangs))),
        Column::real("gain_mm", asked.iter().map(|one| millimetres(one.gain))),
    ]);
    (!asked.is_empty()).then_some(columns)
}

/// What a person is asked: about the undecided vessels, the parts that nothing connects, and of masks what is kept and probably wrong about much. Nothing
/// where no probabilities say how doubtful they are.
///
/// The gain is what a right answer is expected to put right: the chance that the decision is wrong times the length that hangs on it and its own; of a
/// part without flow its length.
pub fn questions(outcome: &Outcome<'_>) -> Vec<Question> {
    if !outcome.rule.asks_evidence() {
        return Vec::new();
    }
    let (network, answer) = (outcome.network, outcome.answer);
    let hangs = dependents(network, &answer.kept);
    let wrong = |row: usize| {
        network.vessel(row).evidence().map_or(0.0, |e| if answer.kept[row] { 1.0 - e.probability } else { e.probability })
    };
    let one_by_one = outcome.rule.is_one_by_one();
    let costs =
        |row: &usize| one_by_one && answer.kept[*row] && outcome.result.uncertain[*row] && wrong(*row) * hangs[*row] > WORTH;
    let mut asked = loose_parts(outcome);
    if one_by_one {
        asked.extend(loops(outcome).filter(|one| one.gain > WORTH));
        let taken = asked.iter().map(|one| one.row).collect();
        asked.extend(touches(outcome, taken));
    }
    let mut rows: BTreeSet<usize> = answer.undecided.iter().copied().chain((0..network.vessel_count()).filter(costs)).collect();
    for one in &asked {
        rows.remove(&one.row);
    }
    asked.extend(rows.into_iter().map(|row| {
        let [a, b] = network.ends(row).map(|node| &*network.node(node).id);
        let vessel = network.vessel(row);
        let words = match vessel.origin {
            Origin::Candidate => format!("Does a vessel go on from {a} to {b}?"),
            _ => format!("Are {a} and {b} of one vessel, or do two only touch here?"),
        };
        let (kind, at) = (vessel.origin.name(), network.middle_of(network.ends(row), vessel));
        let (probability, hangs) = (probability(outcome, row), hangs[row]);
        Question { row, kind, at, words, probability, hangs, gain: wrong(row) * (hangs + vessel.length) }
    }));
    asked.sort_by(|a, b| b.gain.total_cmp(&a.gain).then(a.row.cmp(&b.row)));
    asked
}

/// About each loop of kept vessels, by its least probable connection: is it there that two vessels only touch?
fn loops(outcome: &Outcome<'_>) -> impl Iterator<Item = Question> {
    let network = outcome.network;
    weakest_of_loops(network, &outcome.answer.kept).into_iter().map(|(row, round)| {
        let (ends, vessel) = (network.ends(row), network.vessel(row));
        let [a, b] = ends.map(|node| &*network.node(node).id);
        let words = format!("These vessels make a loop of {:.0} mm: do two only touch between {a} and {b}?", millimetres(round));
        let wrong = vessel.evidence().map_or(0.0, |e| 1.0 - e.probability);
        let (at, gain) = (network.middle_of(ends, vessel), wrong * (round + vessel.length));
        Question { row, kind: LOOP, at, words, probability: 1.0 - wrong, hangs: round, gain }
    })
}

fn probability(outcome: &Outcome<'_>, row: usize) -> f64 {
    outcome.network.vessel(row).evidence().map_or(f64::NAN, |evidence| evidence.probability)
}

/// About each place that was left as it is where one line may show two vessels, by a vessel there that is at no other and stands for nothing else.
fn touches(outcome: &Outcome<'_>, mut taken: BTreeSet<usize>) -> Vec<Question> {
    let (network, kept) = (outcome.network, &outcome.answer.kept);
    let mut found = Vec::new();
    let mut places = vec![0; network.vessel_count()];
    let left = || outcome.pairings.iter().filter(|pairings| pairings.contacts.is_empty());
    left().flat_map(|pairings| &pairings.vessels).for_each(|row| places[*row] += 1);
    for pairings in left() {
        let Some((chance, ends)) = pairings.doubt(network) else { continue };
        let hangs = if_parted(network, kept, &ends);
        let row = ends.iter().map(|(row, ..)| *row).find(|row| kept[*row] && places[*row] == 1 && !taken.contains(row));
        if let Some(row) = row.filter(|_| chance * hangs > WORTH) {
            taken.insert(row);
            let words = format!("{} vessels meet: do some only touch here?", ends.len());
            let (at, probability, gain) = (pairings.position, 1.0 - chance, chance * hangs);
            found.push(Question { row, kind: TOUCH, at, words, probability, hangs, gain });
        }
    }
    found
}

/// What may stand for a part that nothing connects: a candidate that leads out of it, or an observed vessel with a free end there.
struct WayOn {
    row: usize,
    /// The node of the part.
    node: usize,
    /// The probability of a candidate; zero of an observed vessel.
    chance: f64,
    /// The radius there, m.
    radius: f64,
}

/// The parts of the kept graph that no blood flows through: where does each go on? The most probable candidate that leads out of a part stands for it, but
/// for those that stand for longer parts; where there is none, the observed vessel with its widest free end.
fn loose_parts(outcome: &Outcome<'_>) -> Vec<Question> {
    let (network, answer) = (outcome.network, outcome.answer);
    let parts = fragments(network, |row, _| answer.kept[row]);
    let carries = willis_core::flow::floating_components::parts_that_carry(&parts, &outcome.held());
    let degree = network.degrees(|vessel| vessel.origin == Origin::Observed);
    let mut length = vec![0.0; parts.count];
    let mut ways: Vec<Vec<WayOn>> = std::iter::repeat_with(Vec::new).take(parts.count).collect();
    for (row, (ends, vessel)) in network.vessels().enumerate() {
        let of = ends.map(|node| parts.of_node[node]);
        if answer.kept[row] {
            length[of[0]] += vessel.length;
        }
        let chance = match (vessel.origin, vessel.evidence()) {
            (Origin::Observed, _) => 0.0,
            (_, Some(evidence)) if !answer.kept[row] && of[0] != of[1] && evidence.probability > 0.0 => evidence.probability,
            _ => continue,
        };
        let may_stand = |(end, node): &(usize, usize)| !carries[of[*end]] && (chance > 0.0 || degree[*node] == 1);
        for (end, node) in ends.into_iter().enumerate().filter(may_stand) {
            ways[of[end]].push(WayOn { row, node, chance, radius: vessel.end_radius(end == 1) });
        }
    }
    let mut loose: Vec<usize> = (0..parts.count).filter(|part| !carries[*part] && length[*part] >= WORTH).collect();
    loose.sort_by(|a, b| length[*b].total_cmp(&length[*a]));
    let mut taken = BTreeSet::new();
    let question = |part: usize| {
        let free = ways[part].iter().filter(|way| !taken.contains(&way.row));
        let WayOn { row, node, .. } = free.min_by(|a, b| b.chance.total_cmp(&a.chance).then(b.radius.total_cmp(&a.radius)))?;
        taken.insert(*row);
        let (id, mm) = (&network.node(*node).id, millimetres(length[part]));
        let words = format!("Nothing connects {mm:.0} mm of vessels: where do they go on, from {id} or another end?");
        let (at, probability) = (network.node(*node).position.unwrap_or_default(), probability(outcome, *row));
        Some(Question { row: *row, kind: PART, at, words, probability, hangs: length[part], gain: length[part] })
    };
    loose.into_iter().filter_map(question).collect()
}

fn topology(t: &Topology) -> Value {
    json!({
        "kept": t.kept, "pruned": t.pruned, "kept_candidates": t.kept_candidates, "pruned_observed": t.observed[1],
        "components": t.components, "cycles": t.cycles, "unperfused_components": t.unperfused,
    })
}

/// Gathers the record of a run of infer with its `options` as they were given, which every later command reads back; candidates were `built`
/// so, where the input was no graph of them.
pub fn infer_record(
    outcome: &Outcome<'_>,
    provenance: &Provenance,
    options: &impl Serialize,
    built: Option<&CandidateOptions>,
    outlets: FoundOutlets,
) -> RunRecord {
    let (network, result, answer) = (outcome.network, outcome.result, outcome.answer);
    let count = |origin: Origin| network.vessels().filter(|(_, v)| v.origin == origin).count();
    let by_evidence = outcome.rule.asks_evidence();
    let both = answer.kept.iter().zip(&answer.above_median).zip(&result.uncertain).filter(|(_, u)| **u);
    let parameters = json!({
        "epsilon": outcome.sampling.epsilon,
        "samples": result.samples,
        "exact": outcome.sampling.exact,
        "uncertain": outcome.sampling.uncertain,
        "weight": outcome.sampling.weight,
        "keep": outcome.rule,
        "viscosity_cP": centipoise(outcome.sampling.viscosity),
        "outlets_found": outlets_found(outlets),
        "candidates": built.map(|p| json!({
            "k": p.k,
            "max_gap_mm": p.max_gap.map(millimetres),
            "attach": p.attach,
            "candidate_radius": p.radius,
            "max_candidate_radius_mm": p.max_radius.map(millimetres),
            "radius": p.radius_rule.name(),
        })),
    });
    let counts = json!({
        "nodes": network.node_count(),
        "observed": count(Origin::Observed),
        "candidates": count(Origin::Candidate),
        "contacts": outcome.contacts(),
        "cut": outcome.cuts().count(),
        "suggested_cuts": outcome.suggested_cuts.len(),
        "left_open": answer.left_open.len(),
        "fragments": fragments(network, |_, v| v.origin == Origin::Observed).count,
        "uncertain": result.uncertain.iter().filter(|u| **u).count(),
        "inlets": outcome.boundary.count(Role::Inlet),
        "outlets": outcome.boundary.count(Role::Outlet),
        "unfed_fragments": willis_core::flow::boundary_conditions::unfed_fragments(network, outcome.boundary),
        "topology": topology(&outcome.kept),
        "topology_median": topology(&outcome.above_median),
        "decisions_shared_with_median": both.filter(|((kept, above), _)| kept == above).count(),
    });
    let convergence = json!({
        "perfused_share": result.perfused,
        "undecided": answer.undecided.len(),
        "stable": outcome.stable,
        "undecided_edges": answer.undecided,
        "within_standard_errors": (!by_evidence).then_some(UNDECIDED_Z),
        "within_probability": by_evidence.then_some(UNDECIDED_BAND),
    });
    let mut solver = json!(outcome.solver);
    solver["residual"] = json!(result.residual);
    RunRecord::new(
        provenance,
        conditions(network, outcome.boundary, Some(&outcome.held())),
        vec![
            ("seed", json!(outcome.sampling.seed)),
            ("options", json!(options)),
            ("parameters", parameters),
            CONDITIONS,
            ("counts", counts),
            ("threshold", json!({ "rule": outcome.rule, "value": answer.threshold, "median": answer.median })),
            ("convergence", convergence),
            ("expected_errors", outcome.expected.map_or(Value::Null, |e| json!({ "wrong": e.wrong, "missed": e.missed }))),
            ("rho_G_W_per_m3", json!(result.network_resilience)),
            ("solver", solver),
            ("graph", Value::Null),
            ("phenotype", Value::Null),
            ("notes", json!(provenance.notes)),
            // What differs between two runs of one command.
            ("time", Value::Null),
        ],
    )
}
