//! Exact probabilities of the states of all nodes together, by belief propagation on a spanning forest; and what they say of candidates.
//!
//! Neighbours have the pair factors of the atlas. A node with three arms has one factor over the kinds of bifurcation, with its arms in
//! any order, mixed with the pair factors. A gap of probability p has the factor p B + (1 - p): names pass it as far as it is believed.
//! A loop loses the link that closes it.

use std::ops::Range;

use super::algebra::{AddRows, TableTimes, dot, largest, normalise};
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
            let most = largest(row);
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
    /// Per node what its children say, where it is a bifurcation.
    bifurcations: Vec<Option<BifurcationFactor>>,
    /// The sum of the logarithms of all that was divided by.
    log: f64,
}

/// What is known of a bifurcation.
#[derive(Clone)]
struct BifurcationFactor {
    /// What comes along its arms: from the children, and on the way down from the parent too.
    arms: Vec<ArmMessage>,
    /// Per kind its probability and that of the middle.
    middle: Vec<f64>,
    /// How probable it is that the arms meet at all: bridges may not exist.
    joined: f64,
}

/// What comes along an arm to a bifurcation.
#[derive(Clone)]
struct ArmMessage {
    /// Per kind of bifurcation and arm of it the probability of the message: kinds x 3.
    of_kinds: Vec<f64>,
    /// The message over the link.
    over: Vec<f64>,
    /// The logarithm of what the message was divided by.
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
        let mut bifurcations = vec![None; order.len()];
        for node in order.iter().rev() {
            let message = if is_bifurcation[*node] {
                let arms = children[*node].iter().map(|(child, link)| self.along_arm(*link, row(&below, *child)));
                let found = bifurcations[*node].insert(self.bifurcation(*node, arms.collect()));
                parent[*node].map(|(_, link)| self.out_of_bifurcation(*node, found, [0, 1], link))
            } else {
                log += normalise(row_mut(&mut below, *node)).ln();
                parent[*node].filter(|arm| !is_bifurcation[arm.0]).map(|(_, link)| self.message(link, row(&below, *node)))
            };
            if let (Some((message, scale)), Some((above, _))) = (&message, parent[*node]) {
                log += scale + multiply(row_mut(&mut below, above), message).ln();
            }
            up[*node] = message.map(|(message, _)| message);
        }
        Upward { below, up, bifurcations, log }
    }

    fn run(self) -> Beliefs {
        let NamingForest { order, parent, children, is_bifurcation, bridges } = self.forest;
        let Upward { below, up, mut bifurcations, log } = self.upward();
        let mut all = below.clone();
        let mut bridge_ratio = vec![None; *bridges];
        for node in order {
            if let Some(found) = &mut bifurcations[*node] {
                if let Some((above, link)) = parent[*node] {
                    let cavity = divided(row(&all, above), up[*node].as_deref());
                    found.arms.push(self.along_arm(link, &cavity));
                }
                row_mut(&mut all, *node).copy_from_slice(&self.at_bifurcation(*node, found));
                for ((child, link), others) in children[*node].iter().zip([[1, 2], [0, 2], [0, 1]]) {
                    let (message, _) = self.out_of_bifurcation(*node, found, others, *link);
                    let child = row_mut(&mut all, *child);
                    child.iter_mut().zip(&message).for_each(|(b, m)| *b *= m);
                    normalise(child);
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

    /// What is known of a bifurcation by what comes along some of its arms.
    fn bifurcation(&self, node: usize, arms: Vec<ArmMessage>) -> BifurcationFactor {
        let kinds = &self.atlas.bifurcations;
        let sum: f64 = row(&self.own, node).iter().sum();
        let middle = |(states, p): (&[f64], &f64)| p * self.middle_fit(node, states).sum::<f64>() / sum;
        let middle = kinds.middle.chunks(STATES).zip(&kinds.probability).map(middle).collect();
        let probability = |arm: &Neighbour| if let ForestLink::Gap { probability, .. } = arm.1 { probability } else { 1.0 };
        let links = self.forest.children[node].iter().chain(&self.forest.parent[node]);
        BifurcationFactor { arms, middle, joined: (1.0 - UNSEEN_KIND) * links.map(probability).product::<f64>() }
    }

    /// How well each state fits a node that is the middle of a bifurcation, given P(state of the middle) of its kind.
    fn middle_fit<'s>(&'s self, node: usize, states: &'s [f64]) -> impl Iterator<Item = f64> + 's {
        states.iter().zip(&self.atlas.prior).zip(row(&self.own, node)).map(|((m, prior), u)| m / prior * u)
    }

    fn along_arm(&self, link: ForestLink, message: &[f64]) -> ArmMessage {
        let sum: f64 = message.iter().sum();
        let of_kinds = self.product(self.table_of(link), message).into_iter().map(|weight| weight / sum).collect();
        ArmMessage { of_kinds, over: self.message(link, message).0, log: sum.ln() }
    }

    fn table_of(&self, link: ForestLink) -> &[f64] {
        let kinds = &self.atlas.bifurcations;
        if matches!(link, ForestLink::Gap { .. }) { &kinds.arm_behind_gap } else { &kinds.arm }
    }

    /// The belief of a bifurcation, by all of its arms.
    fn at_bifurcation(&self, node: usize, found: &BifurcationFactor) -> Vec<f64> {
        let [a, b, c] = [0, 1, 2].map(|arm| &found.arms[arm].of_kinds);
        let own = row(&self.own, node);
        let total: f64 = own.iter().sum();
        let mut posterior: Vec<f64> = own.iter().map(|u| (1.0 - found.joined) * u / total).collect();
        for arm in &found.arms {
            posterior.iter_mut().zip(&arm.over).for_each(|(p, m)| *p *= m * STATES as f64);
        }
        for ((k, middle), states) in found.middle.iter().enumerate().zip(self.atlas.bifurcations.middle.chunks(STATES)) {
            let orders: f64 = ORDERS.iter().map(|o| a[3 * k + o[0]] * b[3 * k + o[1]] * c[3 * k + o[2]]).sum();
            let weight = orders / 6.0 * middle;
            let fit: Vec<f64> = self.middle_fit(node, states).collect();
            let sum: f64 = fit.iter().sum();
            if sum > 0.0 {
                posterior.iter_mut().zip(&fit).for_each(|(p, f)| *p += found.joined * weight * f / sum);
            }
        }
        normalise(&mut posterior);
        posterior
    }

    /// The message of a bifurcation over the link of one of its arms, by what comes along the `others`; and the logarithm of what it was
    /// divided by.
    fn out_of_bifurcation(
        &self,
        node: usize,
        found: &BifurcationFactor,
        others: [usize; 2],
        link: ForestLink,
    ) -> (Vec<f64>, f64) {
        let [x, y] = others.map(|arm| &found.arms[arm]);
        // Each arm of the kind may be the one that leads there, and the others are the remaining two in either order.
        let weights = found.middle.iter().enumerate().flat_map(|(k, middle)| {
            let (x, y) = (&x.of_kinds[3 * k..], &y.of_kinds[3 * k..]);
            [[1, 2], [0, 2], [0, 1]].map(|[b, c]| found.joined * (x[b] * y[c] + x[c] * y[b]) * middle / 6.0)
        });
        let (weights, mut out) = (weights.collect::<Vec<f64>>(), vec![0.0; STATES]);
        self.instructions.run(AddRows { table: self.table_of(link), weights: &weights, out: &mut out });
        let own = row(&self.own, node);
        let total: f64 = own.iter().sum();
        let mut here: Vec<f64> = own.iter().map(|u| u / total).collect();
        for arm in [x, y] {
            here.iter_mut().zip(&arm.over).for_each(|(h, m)| *h *= m * STATES as f64);
        }
        let sum: f64 = here.iter().sum();
        let onward = self.message(link, &here).0;
        out.iter_mut().zip(&onward).for_each(|(o, m)| *o += (1.0 - found.joined) * m * sum * STATES as f64);
        let log = total.ln() + (x.log + y.log) + normalise(&mut out).ln();
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
    let most = largest(row);
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
