//! Plausible topologies, whole and with their weights, for questions that depend on many vessels at once, such as whether a circle is closed.
//!
//! The topologies are drawn one after another and counted, equal ones together. There are three ways to draw one:
//!
//! - [`TopologySource::FreeEnds`], where candidates come with evidence: a vessel does not end in the middle of nowhere. Every free end that
//!   is neither a known inlet nor a known outlet continues along one of its candidates, with the odds that the evidence gives each
//!   ([`continuation_odds`](crate::network::Evidence::continuation_odds)) against 1 for ending there, whatever the others do. Loops are allowed. A
//!   topology weighs 1, and e⁻² of it for every known outlet that no known inlet feeds: blood must reach what a person saw.
//! - [`TopologySource::Connections`], for what is measured of a network: a vessel may end anywhere. Where [fragments are known](knows_fragments) they form
//!   a forest: two belong together with the P of the most probable candidate between them, by one of their candidates in proportion to its P, and are not
//!   asked where others joined them. The most probable come first. Where candidates were judged by themselves, a free end goes on along one at most, with the
//!   odds P/(1 - P) of its probability against 1 for ending there; one between two free ends is asked by that which has the more probable candidates,
//!   so that alone it has its P. Topologies weigh as above.
//! - [`TopologySource::Samples`], the paper's: a sample of the ε-occlusion votes for its spanning forest of highest resilience and the open
//!   vessels above the median of L, which close its loops. It weighs its ρ_G; 1 under [`Weight::Count`].

use std::collections::BTreeMap;

use petgraph::unionfind::UnionFind;
use rand::RngExt;

use super::knows_fragments;
use crate::flow::{BatchSolver, Boundary, Circuit, Tube, state::State};
use crate::network::{END_ODDS, Evidence, MOST_ODDS, Network, Origin, Vessel, fragments, walks::other_end};
use crate::sampling::{Coins, Kruskal, SamplingOptions, Weight, options::Patterns};
use crate::support::random::{BLOCK, RandomStream, stream};
use crate::{error::Result, support::random};

/// What topologies are drawn from.
#[derive(Debug, Clone, Copy)]
pub enum TopologySource<'a> {
    /// The free ends, which continue by the evidence.
    FreeEnds(KnownEnds<'a>),
    /// The connections, by their probabilities.
    Connections(KnownEnds<'a>),
    /// The votes of samples; per vessel whether its L is above the median.
    Samples(&'a [bool]),
}

/// Topologies that were drawn.
#[derive(Debug, Clone, PartialEq, Default)]
pub struct Topologies {
    /// Each different one, as whether it holds each vessel, with its share of the weight; heaviest first.
    pub weighted: Vec<(Vec<bool>, f64)>,
    /// How many were drawn.
    pub samples: u64,
}

impl Topologies {
    /// Draws topologies of an over-connected graph; those of a seed are the same at any number of threads.
    ///
    /// # Errors
    ///
    /// A parameter or vessel out of its range, too many vessels to enumerate, a breakdown of the solver.
    pub fn draw(network: &Network, boundary: &Boundary, params: &SamplingOptions, source: TopologySource<'_>) -> Result<Self> {
        params.validate()?;
        match source {
            TopologySource::FreeEnds(known) => Ok(Self::of_free_ends(network, known, params)),
            TopologySource::Connections(known) if knows_fragments(network) => {
                Ok(known.draw(network, params, &known.pairs_in_turn(network)))
            }
            TopologySource::Connections(known) => Ok(known.draw(network, params, &known.ends_in_turn(network))),
            TopologySource::Samples(above_median) => Self::of_samples(network, boundary, params, above_median),
        }
    }

    /// Draws topologies whose free ends continue by the evidence ([`TopologySource::FreeEnds`]); they need no flow.
    pub fn of_free_ends(network: &Network, known: KnownEnds<'_>, params: &SamplingOptions) -> Self {
        let ends = known.choices(network, Vessel::is_given, |e, end| e.continuation_odds[end]).into_values();
        known.draw(network, params, &ends.map(Alternatives::of_end).collect::<Vec<Alternatives>>())
    }

    /// Of the topology that each sample votes for, with its weight.
    fn of_samples(network: &Network, boundary: &Boundary, params: &SamplingOptions, above_median: &[bool]) -> Result<Self> {
        let mut count = Count::default();
        let uncertain = params.uncertain.vessels(network);
        let provisional = params.provisional(network, boundary);
        let patterns = Patterns::new(network, &provisional, params)?;
        let at_rest = Tube::at_rest(network, params.viscosity);
        let circuit = Circuit::with(network, boundary, &provisional, &at_rest)?;
        let solver = BatchSolver::for_few(&circuit)?;
        let (mut forest, coins) = (Kruskal::default(), Coins::new(network.vessel_count(), params.seed));
        let mut vote = |open: &dyn Fn(usize) -> bool, probability: f64, coin: f64| -> Result<()> {
            let above_level = solver.above_level(&circuit, open)?;
            let mut tubes = at_rest.clone();
            for (row, tube) in tubes.iter_mut().enumerate().filter(|(row, _)| !open(*row)) {
                debug_assert!(uncertain[row]);
                tube.resistance = f64::INFINITY;
            }
            let state = State::at_pressures(&circuit.in_sample(open), boundary, &tubes, params.viscosity, &above_level, None);
            let mut kept: Vec<bool> = (0..tubes.len()).map(|row| !uncertain[row] || (open(row) && above_median[row])).collect();
            forest.clear();
            for (row, vessel) in state.vessels.iter().enumerate().filter(|(_, vessel)| vessel.resilience > 0.0) {
                forest.add(coins.key(vessel.resilience, row, coin));
            }
            forest.grow(state.pressure.len(), &circuit.ends, |key| coins.vessel(key), |row| kept[row] = true);
            let weight = if params.weight == Weight::Count { 1.0 } else { state.network_resilience };
            count.add(&kept, weight * probability);
            Ok(())
        };
        let (mut masks, mut probability) = (Vec::new(), [1.0; BLOCK as usize]);
        let samples = patterns.samples(params.samples);
        for first in (0..samples).step_by(BLOCK as usize) {
            patterns.fill(first / BLOCK, &mut masks, &mut probability);
            let coin = coins.of_block(first / BLOCK);
            for (sample, probability) in probability.iter().enumerate().take((samples - first).min(BLOCK) as usize) {
                vote(&|row| masks[row] >> sample & 1 == 1, *probability, coin[sample])?;
            }
        }
        Ok(count.finish(|_| 1.0))
    }
}

/// Topologies by what they hold, 64 vessels a word.
#[derive(Default)]
struct Count {
    weight: BTreeMap<Vec<u64>, f64>,
    vessels: usize,
    samples: u64,
}

impl Count {
    fn add(&mut self, kept: &[bool], weight: f64) {
        self.vessels = kept.len();
        self.samples += 1;
        let words = kept.chunks(64).map(|some| some.iter().enumerate().fold(0, |word, (i, k)| word | u64::from(*k) << i));
        *self.weight.entry(words.collect()).or_default() += weight;
    }

    /// The shares of the weight, that of each topology multiplied by its `factor`.
    fn finish(self, factor: impl Fn(&[bool]) -> f64) -> Topologies {
        let open = |words: &[u64]| (0..self.vessels).map(|row| words[row / 64] >> (row % 64) & 1 == 1).collect();
        let weigh = |(words, weight): (&Vec<u64>, &f64)| {
            let kept: Vec<bool> = open(words);
            let weight = weight * factor(&kept);
            (kept, weight)
        };
        let mut weighted: Vec<(Vec<bool>, f64)> = self.weight.iter().map(weigh).collect();
        let total: f64 = weighted.iter().map(|(_, weight)| weight).sum();
        for (_, weight) in &mut weighted {
            *weight = if total > 0.0 { *weight / total } else { 0.0 };
        }
        weighted.sort_by(|a, b| b.1.total_cmp(&a.1));
        Topologies { weighted, samples: self.samples }
    }
}

/// The factor of a topology for each known outlet that nothing feeds, the same as for an end that ends where it is. It is not zero, because
/// the vessel that feeds it may lie beyond the field of view.
const UNFED: f64 = END_ODDS;

/// Candidates of which one is taken at most: those along which a free end goes on, or those that join two fragments.
struct Alternatives {
    choices: Vec<Alternative>,
    /// The fragments that any of them joins; none is taken where they are joined already.
    joins: Option<[usize; 2]>,
}

impl Alternatives {
    fn of_end(choices: Vec<Alternative>) -> Self {
        Self { choices, joins: None }
    }

    /// The largest odds.
    fn best(&self) -> f64 {
        self.choices.iter().map(|choice| choice.odds).fold(0.0, f64::max)
    }
}

/// One of them.
struct Alternative {
    row: usize,
    /// Against 1 for none.
    odds: f64,
    /// The number of the free end to which it leads, where that is not asked any more once this is taken.
    other: Option<usize>,
}

/// What is known of the nodes of a network.
#[derive(Debug, Clone, Copy)]
pub struct KnownEnds<'a> {
    /// Per node whether it is known for an inlet or outlet, so that no vessel continues from there.
    pub ends: &'a [bool],
    /// The nodes where blood is known to come in; none when that is not known; outlets then need not be fed.
    pub inlets: &'a [usize],
}

impl KnownEnds<'_> {
    /// Draws as many topologies as there are samples: contacts by their probabilities, and of alternatives one or none.
    fn draw(&self, network: &Network, params: &SamplingOptions, asked_in_turn: &[Alternatives]) -> Topologies {
        let mut count = Count::default();
        let all = network.vessels().enumerate().filter(|(_, (_, v))| v.origin == Origin::Contact && !v.certain);
        let contacts: Vec<(usize, f64)> = all.map(|(row, (_, v))| (row, v.evidence().map_or(1.0, |e| e.probability))).collect();
        let given: Vec<bool> = network.vessels().map(|(_, v)| v.is_given()).collect();
        let fragments = asked_in_turn.iter().filter_map(|a| a.joins).flatten().max().map_or(0, |last| last + 1);
        for first in (0..params.samples).step_by(BLOCK as usize) {
            let mut rng = stream(params.seed, random::ends(first / BLOCK));
            for _ in first..params.samples.min(first + BLOCK) {
                let mut kept = given.clone();
                for (row, p) in &contacts {
                    kept[*row] = rng.random::<f64>() < *p;
                }
                connect(asked_in_turn, fragments, &mut rng, &mut kept);
                count.add(&kept, 1.0);
            }
        }
        count.finish(|kept| self.supply(network, kept))
    }

    /// The factor of a topology that holds the vessels `kept`: e⁻² for each known outlet that is connected with no known inlet.
    fn supply(&self, network: &Network, kept: &[bool]) -> f64 {
        if self.inlets.is_empty() {
            return 1.0;
        }
        let fed = fragments(network, |row, _| kept[row]).holding(self.inlets.iter().copied());
        let unfed = (0..self.ends.len()).filter(|node| self.ends[*node] && !fed[*node]);
        unfed.fold(1.0, |weight, _| weight * UNFED)
    }

    /// Per end that is free of all vessels but one of those that `hold` it, and may continue, its candidates with their odds, which are `of` the evidence
    /// and the end.
    fn choices(
        &self,
        network: &Network,
        hold: impl Fn(&Vessel) -> bool,
        of: impl Fn(&Evidence, usize) -> f64,
    ) -> BTreeMap<usize, Vec<Alternative>> {
        let degree = network.degrees(hold);
        let mut at: BTreeMap<usize, Vec<Alternative>> = BTreeMap::new();
        for (row, (ends, vessel)) in network.vessels().enumerate() {
            let Some(evidence) = vessel.evidence().filter(|_| vessel.origin == Origin::Candidate && !vessel.certain) else {
                continue;
            };
            for (end, node) in ends.into_iter().enumerate() {
                let odds = of(&evidence, end);
                if odds > 0.0 && degree[node] <= 1 && !self.ends[node] {
                    at.entry(node).or_default().push(Alternative { row, odds, other: None });
                }
            }
        }
        at
    }

    /// The free ends in the order in which they are asked, by their most probable candidate, each candidate with the free end to which it leads.
    fn ends_in_turn(&self, network: &Network) -> Vec<Alternatives> {
        let at = self.choices(network, holds, |e, _| by_itself(e.probability));
        let mut ends: Vec<(usize, Alternatives)> =
            at.into_iter().map(|(node, choices)| (node, Alternatives::of_end(choices))).collect();
        ends.sort_by(|a, b| b.1.best().total_cmp(&a.1.best()).then(a.0.cmp(&b.0)));
        let number: BTreeMap<usize, usize> = ends.iter().enumerate().map(|(number, (node, _))| (*node, number)).collect();
        for (node, end) in &mut ends {
            for choice in &mut end.choices {
                choice.other = number.get(&other_end(network, choice.row, *node)).copied();
            }
        }
        ends.into_iter().map(|(_, end)| end).collect()
    }

    /// The pairs of fragments in the order in which they are asked, by their most probable candidate: one of theirs is true with its P. A candidate
    /// within one fragment, which closes a loop, is asked by itself.
    fn pairs_in_turn(&self, network: &Network) -> Vec<Alternatives> {
        let fragment = fragments(network, |_, v| v.is_given()).of_node;
        let open = self.choices(network, holds, |e, _| e.probability).into_values().flatten();
        let rows: BTreeMap<usize, Alternative> = open.map(|choice| (choice.row, choice)).collect();
        let (mut loops, mut between) = (Vec::new(), BTreeMap::<[usize; 2], Vec<Alternative>>::new());
        for (row, choice) in rows {
            let [a, b] = network.ends(row).map(|node| fragment[node]);
            if a == b {
                loops.push(Alternatives { choices: vec![choice], joins: None });
            } else {
                between.entry([a.min(b), a.max(b)]).or_default().push(choice);
            }
        }
        let between = between.into_iter().map(|(joins, choices)| Alternatives { choices, joins: Some(joins) });
        let mut pairs: Vec<Alternatives> = loops.into_iter().chain(between).collect();
        pairs.sort_by(|a, b| b.best().total_cmp(&a.best()));
        for pair in &mut pairs {
            let (odds, sum) = (by_itself(pair.best()), pair.choices.iter().map(|choice| choice.odds).sum::<f64>());
            pair.choices.iter_mut().for_each(|choice| choice.odds *= odds / sum);
        }
        pairs
    }
}

/// Whether a vessel holds its ends whatever is decided: candidates beside one that a person accepted have a probability of their own.
fn holds(vessel: &Vessel) -> bool {
    vessel.is_given() && vessel.origin != Origin::Candidate
}

/// The odds of what is true with a probability, if it is asked by itself.
fn by_itself(probability: f64) -> f64 {
    (probability / (1.0 - probability)).min(MOST_ODDS)
}

/// The one that is taken, by the odds of each against 1 for none.
fn chosen<'a>(mut choices: impl Iterator<Item = &'a Alternative> + Clone, rng: &mut RandomStream) -> Option<&'a Alternative> {
    let total: f64 = 1.0 + choices.clone().map(|choice| choice.odds).sum::<f64>();
    let mut left = total * rng.random::<f64>() - 1.0;
    if left < 0.0 {
        return None;
    }
    choices.find(|choice| {
        left -= choice.odds;
        left < 0.0
    })
}

/// Takes one or none of alternatives after alternatives: none of a free end to which another went on, or of fragments that are joined, and nothing that
/// leads to a free end that was asked.
fn connect(asked_in_turn: &[Alternatives], fragments: usize, rng: &mut RandomStream, kept: &mut [bool]) {
    let (mut asked, mut parts) = (vec![false; asked_in_turn.len()], UnionFind::<usize>::new(fragments));
    for (at, alternatives) in asked_in_turn.iter().enumerate() {
        if std::mem::replace(&mut asked[at], true) || alternatives.joins.is_some_and(|[a, b]| parts.equiv(a, b)) {
            continue;
        }
        let open = alternatives.choices.iter().filter(|choice| choice.other.is_none_or(|other| !asked[other]));
        let Some(choice) = chosen(open, rng) else { continue };
        kept[choice.row] = true;
        if let Some(other) = choice.other {
            asked[other] = true;
        }
        if let Some([a, b]) = alternatives.joins {
            parts.union(a, b);
        }
    }
}
