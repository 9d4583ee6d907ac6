//! Exact probabilities of the states of all nodes together, by belief propagation on a spanning forest; and what they say of candidates.
//!
//! Neighbours have the pair factors of the atlas. A node with three arms has one factor over the kinds of bifurcation, with its arms in
//! any order, mixed with the pair factors. A gap of probability p has the factor p B + (1 - p): names pass it as far as it is believed.
//! A loop loses the link that closes it.

use std::ops::Range;

use super::algebra::{TableTimes, dot, normalise};
use super::atlas::{Atlas, STATES, row, row_mut};
use super::nodes::Nodes;
use willis_core::support::{numbered::grouped, simd::InstructionSet};

/// The share of the pair factors at a bifurcation, for kinds that were never seen.
const UNSEEN_KIND: f64 = 0.02;
/// The orders of three arms.
const ORDERS: [[usize; 3]; 6] = [[0, 1, 2], [0, 2, 1], [1, 0, 2], [1, 2, 0], [2, 0, 1], [2, 1, 0]];
/// No probability in a message is smaller.
const LEAST: f64 = 1e-30;

/// How two neighbours are linked.
#[derive(Debug, Clone, Copy, PartialEq)]
enum ForestLink {
    /// Within a branch (0), or one of them is a junction (1).
    Vessel(usize),
    /// Over a gap of about 2, 4 or 8 mm (0 to 2) with a probability; the number of the bridge.
    Gap { length: usize, probability: f64, bridge: usize },
}

/// What the nodes are together.
#[derive(Debug, Clone)]
pub struct Beliefs {
    /// The probability of each state of each node: nodes x states.
    pub states: Vec<f64>,
    /// Per bridge of the nodes the ratio of the probability of the names with it to that without it; `None` where it was not in the forest.
    pub bridge_ratio: Vec<Option<f64>>,
    /// The logarithm of the probability of everything, as the messages have it, up to what the log likelihoods of each node were divided by.
    log: f64,
}

/// A neighbour in the forest.
type Neighbour = (usize, ForestLink);

/// The forest in which messages pass.
pub struct NamingForest {
    /// Nodes, parents before children.
    pub order: Vec<usize>,
    parent: Vec<Option<Neighbour>>,
    children: Vec<Vec<Neighbour>>,
    /// Nodes that have the factor of a bifurcation.
    is_bifurcation: Vec<bool>,
    bridges: usize,
}

impl NamingForest {
    /// The spanning forest of the nodes and those of their bridges that are `used`.
    pub fn of(nodes: &Nodes, used: &[usize]) -> Self {
        let n = nodes.len();
        let vessel =
            |ends: &[usize; 2]| (*ends, ForestLink::Vessel(usize::from(ends.iter().any(|node| nodes.degree(*node) > 2))));
        let gap = |bridge: &usize| {
            let found = &nodes.bridges[*bridge];
            (found.nodes, ForestLink::Gap { length: found.length_class(), probability: found.probability, bridge: *bridge })
        };
        let links = nodes.links.iter().map(vessel).chain(used.iter().map(gap));
        let arms: Vec<Vec<Neighbour>> = grouped(n, links.flat_map(|([a, b], link)| [(a, (b, link)), (b, (a, link))]));
        let mut roots: Vec<usize> = (0..n).collect();
        roots.sort_by_key(|node| arms[*node].len());
        let (mut order, mut seen) = (Vec::with_capacity(n), vec![false; n]);
        let (mut parent, mut children) = (vec![None; n], vec![Vec::new(); n]);
        for root in roots {
            if seen[root] {
                continue;
            }
            seen[root] = true;
            let mut open = vec![root];
            while let Some(node) = open.pop() {
                order.push(node);
                for (next, link) in &arms[node] {
                    if !seen[*next] {
                        seen[*next] = true;
                        parent[*next] = Some((node, *link));
                        children[node].push((*next, *link));
                        open.push(*next);
                    }
                }
            }
        }
        let mut by_degree: Vec<usize> = (0..n).collect();
        by_degree.sort_by_key(|node| std::cmp::Reverse(nodes.degree(*node)));
        let mut is_bifurcation = vec![false; n];
        for node in by_degree {
            let arms: Vec<usize> = children[node].iter().chain(&parent[node]).map(|arm: &Neighbour| arm.0).collect();
            is_bifurcation[node] = arms.len() == 3 && nodes.degree(node) >= 2 && arms.iter().all(|arm| !is_bifurcation[*arm]);
        }
        Self { order, parent, children, is_bifurcation, bridges: nodes.bridges.len() }
    }

    /// The probabilities of all states, from the log likelihoods of each node in each state: nodes x states.
    pub fn beliefs(&self, atlas: &Atlas, log_likelihood: &[f64]) -> Beliefs {
        self.pass(atlas, log_likelihood).run()
    }

    /// The logarithm of the probability of everything, as the messages have it, less the same with no node in some states: minus the logarithm
    /// of the probability that none is, for each list of states. `beliefs` are those of the same log likelihoods.
    pub fn evidence(&self, atlas: &Atlas, log_likelihood: &[f64], beliefs: &Beliefs, lists: &[&Range<usize>]) -> Vec<f64> {
        let mut pass = self.pass(atlas, log_likelihood);
        let own = pass.own.clone();
        let without = lists.iter().map(|states| {
            pass.own.copy_from_slice(&own);
            for row in pass.own.chunks_mut(STATES) {
                row[(*states).clone()].fill(0.0);
            }
            beliefs.log - pass.upward().log
        });
        without.collect()
    }

    fn pass<'a>(&'a self, atlas: &'a Atlas, log_likelihood: &[f64]) -> MessagePass<'a> {
        let prior: Vec<f64> = atlas.prior.iter().map(|p| p.ln()).collect();
        let mut own = log_likelihood.to_vec();
        for row in own.chunks_mut(STATES) {
            row.iter_mut().zip(&prior).for_each(|(e, p)| *e += p);
            let most = row.iter().fold(f64::NEG_INFINITY, |a, b| a.max(*b));
            for e in row {
                *e = (*e - most).exp() + LEAST;
            }
        }
        MessagePass { forest: self, atlas, own, instructions: InstructionSet::detect() }
    }
}

/// What comes up the forest.
struct Upward {
    /// Per node the weights of its states by itself and what lies below it: nodes x states.
    below: Vec<f64>,
    /// Per node the message to its parent.
    up: Vec<Option<Vec<f64>>>,
    /// The sum of the logarithms of all that was divided by.
    log: f64,
}

/// One pass up and down the forest.
struct MessagePass<'a> {
    forest: &'a NamingForest,
    atlas: &'a Atlas,
    /// The weight of each state of each node by itself.
    own: Vec<f64>,
    instructions: InstructionSet,
}

impl MessagePass<'_> {
    fn upward(&self) -> Upward {
        let NamingForest { order, parent, children, is_bifurcation, .. } = self.forest;
        let (mut below, mut log) = (self.own.clone(), 0.0);
        let mut up: Vec<Option<Vec<f64>>> = vec![None; order.len()];
        for node in order.iter().rev() {
            let message = if is_bifurcation[*node] {
                parent[*node].map(|_| {
                    let messages: Vec<Option<&[f64]>> =
                        children[*node].iter().map(|arm| Some(row(&below, arm.0))).chain([None]).collect();
                    self.out_of_bifurcation(*node, &messages, 2)
                })
            } else {
                log += normalise(row_mut(&mut below, *node)).ln();
                parent[*node].filter(|arm| !is_bifurcation[arm.0]).map(|(_, link)| self.message(link, row(&below, *node)))
            };
            if let (Some((message, scale)), Some((above, _))) = (&message, parent[*node]) {
                log += scale + multiply(row_mut(&mut below, above), message).ln();
            }
            up[*node] = message.map(|(message, _)| message);
        }
        Upward { below, up, log }
    }

    fn run(self) -> Beliefs {
        let NamingForest { order, parent, children, is_bifurcation, bridges } = self.forest;
        let Upward { below, up, log } = self.upward();
        let mut all = below.clone();
        let mut bridge_ratio = vec![None; *bridges];
        for node in order {
            if is_bifurcation[*node] {
                let cavity = parent[*node].map(|(above, _)| divided(row(&all, above), up[*node].as_deref()));
                let messages: Vec<Option<&[f64]>> =
                    children[*node].iter().map(|arm| Some(row(&below, arm.0))).chain(cavity.as_deref().map(Some)).collect();
                let posterior = self.at_bifurcation(*node, &messages);
                let outward = |arm: usize| {
                    let mut others = messages.clone();
                    others[arm] = None;
                    self.out_of_bifurcation(*node, &others, arm).0
                };
                let outward: Vec<Vec<f64>> = (0..children[*node].len()).map(outward).collect();
                row_mut(&mut all, *node).copy_from_slice(&posterior);
                for ((child, _), message) in children[*node].iter().zip(&outward) {
                    let beliefs: Vec<f64> = row(&below, *child).iter().zip(message).map(|(b, m)| b * m).collect();
                    row_mut(&mut all, *child).copy_from_slice(&beliefs);
                    normalise(row_mut(&mut all, *child));
                }
                continue;
            }
            if let Some((above, link)) = parent[*node].filter(|arm| !is_bifurcation[arm.0]) {
                let cavity = divided(row(&all, above), up[*node].as_deref());
                let message = self.message(link, &cavity).0;
                if let ForestLink::Gap { bridge, length, .. } = link {
                    bridge_ratio[bridge] = Some(ratio(&self.atlas.gaps[length], row(&below, *node), &cavity));
                }
                multiply(row_mut(&mut all, *node), &message);
            }
            let node = row_mut(&mut all, *node);
            normalise(node);
        }
        Beliefs { states: all, bridge_ratio, log }
    }

    fn product(&self, table: &[f64], by: &[f64]) -> Vec<f64> {
        let mut out = vec![0.0; table.len() / STATES];
        self.instructions.run(TableTimes { table, by, out: &mut out });
        out
    }

    /// A message over a link, and the logarithm of what it was divided by.
    fn message(&self, link: ForestLink, from: &[f64]) -> (Vec<f64>, f64) {
        let mut log = 0.0;
        let mut out = match link {
            ForestLink::Vessel(kind) => self.product(&self.atlas.pairs[kind], from),
            ForestLink::Gap { length, probability, .. } => {
                let sum: f64 = from.iter().sum();
                log += sum.ln();
                let mut out = self.product(&self.atlas.gaps[length], from);
                for m in &mut out {
                    *m = probability * *m / sum + (1.0 - probability);
                }
                out
            }
        };
        log += normalise(&mut out).ln();
        (out, log)
    }

    /// The arms of a node, the parent last.
    fn arms(&self, node: usize) -> Vec<Neighbour> {
        self.forest.children[node].iter().chain(&self.forest.parent[node]).copied().collect()
    }

    /// Per kind of bifurcation and arm the probability of an arm's message, kinds x 3.
    fn arm_weights(&self, arms: &[Neighbour], messages: &[Option<&[f64]>]) -> [Vec<f64>; 3] {
        let kinds = self.atlas.bifurcations.kinds.len();
        [0, 1, 2].map(|arm| {
            let Some(message) = messages[arm] else { return Vec::new() };
            let sum: f64 = message.iter().sum();
            let table = self.table_of(arms[arm].1);
            self.product(&table[..kinds * 3 * STATES], message).into_iter().map(|weight| weight / sum).collect()
        })
    }

    fn table_of(&self, link: ForestLink) -> &[f64] {
        let kinds = &self.atlas.bifurcations;
        if matches!(link, ForestLink::Gap { .. }) { &kinds.arm_behind_gap } else { &kinds.arm }
    }

    /// Per kind its probability and that of the middle.
    fn middle_weights(&self, node: usize) -> Vec<f64> {
        let kinds = &self.atlas.bifurcations;
        let own = row(&self.own, node);
        let sum: f64 = own.iter().sum();
        let middle = |(states, p): (&[f64], &f64)| {
            let fit: f64 = states.iter().zip(&self.atlas.prior).zip(own).map(|((m, prior), u)| m / prior * u).sum();
            p * fit / sum
        };
        kinds.middle.chunks(STATES).zip(&kinds.probability).map(middle).collect()
    }

    /// How probable it is that the arms meet at all: bridges may not exist.
    fn joined(arms: &[Neighbour]) -> f64 {
        let probability = |arm: &Neighbour| if let ForestLink::Gap { probability, .. } = arm.1 { probability } else { 1.0 };
        (1.0 - UNSEEN_KIND) * arms.iter().map(probability).product::<f64>()
    }

    /// The belief of a bifurcation.
    fn at_bifurcation(&self, node: usize, messages: &[Option<&[f64]>]) -> Vec<f64> {
        let arms = self.arms(node);
        let [a, b, c] = self.arm_weights(&arms, messages);
        let joined = Self::joined(&arms);
        let of_kind = |(k, middle): (usize, &f64)| {
            let sum: f64 = ORDERS.iter().map(|o| a[3 * k + o[0]] * b[3 * k + o[1]] * c[3 * k + o[2]]).sum();
            sum / 6.0 * middle
        };
        let of_kind: Vec<f64> = self.middle_weights(node).iter().enumerate().map(of_kind).collect();
        let own = row(&self.own, node);
        let total: f64 = own.iter().sum();
        let mut posterior: Vec<f64> = own.iter().map(|u| (1.0 - joined) * u / total).collect();
        for (arm, message) in arms.iter().zip(messages).filter_map(|(arm, m)| m.map(|m| (arm, m))) {
            let over = self.message(arm.1, message).0;
            posterior.iter_mut().zip(&over).for_each(|(p, m)| *p *= m * STATES as f64);
        }
        for (weight, states) in of_kind.iter().zip(self.atlas.bifurcations.middle.chunks(STATES)) {
            let fit: Vec<f64> = states.iter().zip(&self.atlas.prior).zip(own).map(|((m, prior), u)| m / prior * u).collect();
            let sum: f64 = fit.iter().sum();
            if sum > 0.0 {
                posterior.iter_mut().zip(&fit).for_each(|(p, f)| *p += joined * weight * f / sum);
            }
        }
        normalise(&mut posterior);
        posterior
    }

    /// The message of a bifurcation to one of its arms, and the logarithm of what it was divided by.
    fn out_of_bifurcation(&self, node: usize, messages: &[Option<&[f64]>], target: usize) -> (Vec<f64>, f64) {
        let arms = self.arms(node);
        let weights = self.arm_weights(&arms, messages);
        let others: Vec<usize> = (0..3).filter(|arm| *arm != target).collect();
        let joined = Self::joined(&arms);
        let table = self.table_of(arms[target].1);
        let mut out = vec![0.0; STATES];
        for (k, middle) in self.middle_weights(node).iter().enumerate() {
            let mut at = [0.0; 3];
            for order in ORDERS {
                at[order[target]] += weights[others[0]][3 * k + order[others[0]]] * weights[others[1]][3 * k + order[others[1]]];
            }
            for (number, share) in at.iter().enumerate() {
                let weight = joined * share * middle / 6.0;
                if weight > 0.0 {
                    let states = row(table, 3 * k + number);
                    out.iter_mut().zip(states).for_each(|(o, s)| *o += weight * s);
                }
            }
        }
        let own = row(&self.own, node);
        let total: f64 = own.iter().sum();
        let mut here: Vec<f64> = own.iter().map(|u| u / total).collect();
        for other in others {
            if let Some(message) = messages[other] {
                let over = self.message(arms[other].1, message).0;
                here.iter_mut().zip(&over).for_each(|(h, m)| *h *= m * STATES as f64);
            }
        }
        let sum: f64 = here.iter().sum();
        let onward = self.message(arms[target].1, &here).0;
        out.iter_mut().zip(&onward).for_each(|(o, m)| *o += (1.0 - joined) * m * sum * STATES as f64);
        let of_arms: f64 = messages.iter().flatten().map(|message| message.iter().sum::<f64>().ln()).sum();
        let log = total.ln() + of_arms + normalise(&mut out).ln();
        (out, log)
    }
}

/// How much more probable the names at both sides of a gap are if one vessel passes it than if they have nothing to do with each other:
/// Σ a B b / (Σ a Σ b).
pub fn ratio(gap: &[f64], a: &[f64], b: &[f64]) -> f64 {
    let (sum_a, sum_b): (f64, f64) = (a.iter().sum(), b.iter().sum());
    gap.chunks(STATES).zip(a).map(|(states, p)| p * dot(states, b)).sum::<f64>() / (sum_a * sum_b)
}

/// Multiplies and divides by the largest, so that nothing becomes too small; returns that.
fn multiply(row: &mut [f64], by: &[f64]) -> f64 {
    row.iter_mut().zip(by).for_each(|(r, b)| *r *= b);
    let most = row.iter().fold(0.0_f64, |a, b| a.max(*b));
    for r in row.iter_mut() {
        *r /= most;
    }
    most
}

/// What a node knows without what came up from one child.
fn divided(belief: &[f64], message: Option<&[f64]>) -> Vec<f64> {
    let mut out: Vec<f64> = match message {
        Some(message) => belief.iter().zip(message).map(|(b, m)| b / m.max(LEAST)).collect(),
        None => belief.to_vec(),
    };
    normalise(&mut out);
    out
}

/// No factor is larger, nor smaller than one over it: names are only one witness.
const MOST: f64 = 100.0;

/// The factor of each bridge: the probability of the names at its ends if a vessel passes between them, over that if they have nothing to
/// do with each other. A false piece says nothing.
pub fn factors(nodes: &Nodes, atlas: &Atlas, beliefs: &Beliefs, false_pieces: &[f64]) -> Vec<f64> {
    let each = nodes.bridges.iter().zip(&beliefs.bridge_ratio).map(|(bridge, known)| {
        let [a, b] = bridge.nodes;
        let ratio =
            known.unwrap_or_else(|| ratio(&atlas.gaps[bridge.length_class()], row(&beliefs.states, a), row(&beliefs.states, b)));
        let is_true = (1.0 - false_pieces[nodes.piece[a]]) * (1.0 - false_pieces[nodes.piece[b]]);
        (is_true * ratio + 1.0 - is_true).clamp(1.0 / MOST, MOST)
    });
    each.collect()
}

/// A probability whose odds are multiplied by the factor that names give them.
pub fn probability_with(probability: f64, factor: f64) -> f64 {
    let odds = probability / (1.0 - probability).max(1e-12) * factor;
    odds / (1.0 + odds)
}
