//! How likely each segment of the ring is there, read off the names: what is seen of it, and the ways between what lies at its two ends.

use Artery::{A1, A2, AComm, Ba, Ica, P1, P2, PComm};

use super::atlas::{LABELS, OTHER, label_of};
use super::{belief::probability_with, nodes::Nodes};
use crate::circle_of_willis::{Artery, BodySide, RING};
use willis_core::network::paths::{ShortestPaths, lengths_at};
use willis_core::{network::walks::Walk, support::geometry::distance};

/// How many features a segment has.
pub const PRESENCE_FEATURES: usize = 20;
/// How many kinds of segments there are: A1, AComm, PComm, P1.
pub const KINDS: usize = 4;
/// Their usual lengths, mm.
const USUAL: [f64; KINDS] = [15.0, 5.0, 15.0, 10.0];
/// Of a segment at least so much (mm) is seen where it is said to be seen; AComm is short.
const SEEN: [f64; KINDS] = [3.0, 1.5, 3.0, 3.0];

/// The kind of a segment of [`RING`].
pub fn kind_of(segment: usize) -> usize {
    match RING[segment] {
        A1(_) => 0,
        AComm => 1,
        PComm(_) => 2,
        _ => 3,
    }
}

/// What is seen of the segments.
#[derive(Debug, Clone, PartialEq)]
pub struct Seen {
    /// Per label its expected length, mm.
    pub length: [f64; LABELS],
    /// Per label the probability of the node that is most likely of it.
    pub best: [f64; LABELS],
    /// Per segment of [`RING`] minus the logarithm of the probability that no node has its name.
    pub evidence: [f64; 7],
    /// Per segment the cheapest way between its ends.
    pub ways: [Way; 7],
    /// How broken the case is, for what a gap or a piece of some size means depends on how many there are: the expected number of pieces that are
    /// arteries of the circle, and of those that are not, ...
    pub pieces: [f64; 2],
    /// ... the root mean square of the gaps that candidates cross (mm), each as often as it is probable, ...
    pub gap: f64,
    /// ... and the expected number of free ends of arteries of the circle.
    pub ends: f64,
}

impl Seen {
    /// What is seen, from the probabilities of the labels (nodes x labels), those of the pieces to be no artery of the circle, the factors
    /// that names give to the odds of the bridges, and the evidence for each segment.
    pub fn of(nodes: &Nodes, labels: &[[f64; LABELS]], false_pieces: &[f64], bridge_factor: &[f64], evidence: [f64; 7]) -> Self {
        let (mut length, mut best) = ([0.0; LABELS], [0.0_f64; LABELS]);
        for (p, w) in labels.iter().zip(&nodes.weight) {
            for label in 0..LABELS {
                length[label] += p[label] * w;
                best[label] = best[label].max(p[label]);
            }
        }
        let gaps = nodes.bridges.iter().zip(bridge_factor);
        let gaps = gaps.map(|(bridge, factor)| (probability_with(bridge.probability, *factor), bridge.gap));
        let gaps: Vec<(f64, f64)> = gaps.collect();
        let total: f64 = gaps.iter().map(|(p, _)| p).sum();
        let squares: f64 = gaps.iter().map(|(p, gap)| p * gap * gap).sum();
        let is_artery = |piece: usize| 1.0 - false_pieces[piece];
        Self {
            length,
            best,
            evidence,
            ways: ways(nodes, labels, bridge_factor),
            pieces: [(0..false_pieces.len()).map(is_artery).sum(), false_pieces.iter().sum()],
            gap: if total > 0.0 { (squares / total).sqrt() } else { 0.0 },
            ends: (0..nodes.len()).filter(|n| nodes.degree(*n) == 1).map(|n| is_artery(nodes.piece[n])).sum(),
        }
    }

    /// The features of a segment of [`RING`]: its length over the usual one, the logarithm of that, its best node, the lengths (cm) of what
    /// lies around it, the evidence for its name, the cheapest way between its ends, and how broken the case is.
    pub fn features(&self, segment: usize) -> Vec<f64> {
        let (kind, label) = (kind_of(segment), label_of(RING[segment]));
        let cm = |artery: Artery| (self.length[label_of(artery)] / 10.0).min(1.5);
        let mut around = match RING[segment] {
            A1(s) => [A2(s), AComm, Ica(s), A1(s.other()), A2(s.other())].map(cm).to_vec(),
            PComm(s) => [P2(s), P1(s), Ica(s), PComm(s.other())].map(cm).to_vec(),
            P1(s) => [P2(s), PComm(s), Ba, P1(s.other())].map(cm).to_vec(),
            _ => {
                let [[a, b], [c, d]] = [A1, A2].map(|artery: fn(BodySide) -> Artery| BodySide::BOTH.map(|side| cm(artery(side))));
                vec![a.min(b), a.max(b), c.min(d)]
            }
        };
        around.resize(5, 0.0);
        let x = (self.length[label] / USUAL[kind]).min(1.2);
        let (evidence, way) = (self.evidence[segment].max(0.0), &self.ways[segment]);
        let named: f64 = (0..LABELS).filter(|label| *label != OTHER).map(|label| self.length[label]).sum();
        [
            &[x, (0.02 + x).ln(), self.best[label]][..],
            &around,
            &[evidence.min(30.0) / 10.0, evidence.ln_1p(), way.observed.min(20.0) / 5.0, way.cost.min(20.0) / 5.0],
            &[way.gap.min(20.0) / 10.0, way.diameters.min(8.0), way.named.min(15.0) / 10.0],
            &[self.pieces[0].ln_1p(), self.pieces[1].ln_1p(), self.gap.min(15.0) / 5.0, self.ends.ln_1p(), named / 400.0],
        ]
        .concat()
    }

    /// Whether enough of a segment is seen.
    pub fn is_seen(&self, segment: usize) -> bool {
        self.length[label_of(RING[segment])] > SEEN[kind_of(segment)]
    }
}

/// What a millimetre of centerline costs, and what one more costs where it is named as nothing that lies there.
const STEP: f64 = 0.05;
const ELSEWHERE: f64 = 0.5;
/// Twice the negative logarithm of a probability is a cost; no probability counts as smaller than these: of a name, of a candidate.
const LEAST_NAME: f64 = 1e-3;
const LEAST_CANDIDATE: f64 = 1e-4;

/// The cheapest way between the ends of a segment.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub struct Way {
    /// Its cost.
    pub cost: f64,
    /// The cost of the cheapest way along centerlines alone.
    pub observed: f64,
    /// The gaps on it, mm.
    pub gap: f64,
    /// The gaps on it in diameters of its vessels.
    pub diameters: f64,
    /// The expected length (mm) on it that has the segment's name.
    pub named: f64,
}

/// The ways of the segments of [`RING`], from the probabilities of the labels (nodes x labels) and the factors that names give to the odds of
/// the bridges.
pub fn ways(nodes: &Nodes, labels: &[[f64; LABELS]], bridge_factor: &[f64]) -> [Way; 7] {
    let mut paths = ShortestPaths::new(nodes.len() + 1);
    RING.map(|segment| way(nodes, labels, bridge_factor, segment, &mut paths))
}

/// The arteries at either end of a segment.
fn ends(segment: Artery) -> [Vec<Artery>; 2] {
    let [mut from, mut to] = segment.joins();
    match segment {
        Artery::A1(side) => {
            from.push(Artery::M1(side));
            to.push(Artery::AComm);
        }
        Artery::P1(side) => to.push(Artery::PComm(side)),
        _ => {}
    }
    [from, to]
}

fn way(nodes: &Nodes, labels: &[[f64; LABELS]], bridge_factor: &[f64], segment: Artery, paths: &mut ShortestPaths) -> Way {
    let own = label_of(segment);
    let of = |arteries: Vec<Artery>| -> Vec<f64> {
        let arteries: Vec<usize> = arteries.into_iter().map(label_of).collect();
        labels.iter().map(|p| arteries.iter().map(|artery| p[*artery]).sum()).collect()
    };
    let [from, to] = ends(segment).map(of);
    let belongs: Vec<f64> = (0..nodes.len()).map(|n| (from[n] + to[n] + labels[n][own]).min(1.0)).collect();
    let elsewhere = |[a, b]: [usize; 2], length: f64| ELSEWHERE * length * (1.0 - 0.5 * (belongs[a] + belongs[b]));
    let improbable = |p: f64, least: f64| -2.0 * p.max(least).ln();
    let start = nodes.len();
    let links = nodes.links.iter().map(|[a, b]| {
        let length = distance(nodes.at[*a], nodes.at[*b]);
        ([*a, *b], STEP * length + elsewhere([*a, *b], length))
    });
    let bridges = nodes.bridges.iter().zip(bridge_factor).map(|(bridge, factor)| {
        let probability = probability_with(bridge.probability, *factor);
        (bridge.nodes, improbable(probability, LEAST_CANDIDATE) + elsewhere(bridge.nodes, bridge.gap))
    });
    // Edges: links, then bridges; the last ones lead from the start to every node as far as it is what lies at the first end.
    let edges: Vec<([usize; 2], f64)> = links.chain(bridges).collect();
    let arrival: Vec<f64> = to.iter().map(|p| improbable(p.min(1.0), LEAST_NAME)).collect();
    let mut by = |edges: &[([usize; 2], f64)]| {
        let mut at = lengths_at(start + 1, edges.iter().enumerate().map(|(number, (ends, cost))| (number, *ends, *cost)));
        at[start] = from.iter().enumerate().map(|(n, p)| (usize::MAX, n, improbable(p.min(1.0), LEAST_NAME))).collect();
        // The least cost of a way from the start that ends at any node, with the cost of ending there; and that node.
        let mut best = (f64::INFINITY, 0);
        let edges = |node: usize| at[node].iter().copied();
        paths.search(&[start], f64::INFINITY, edges, |costs, node| {
            if node != start && costs[node] + arrival[node] < best.0 {
                best = (costs[node] + arrival[node], node);
            }
            costs[node] < best.0
        });
        best
    };
    let (observed, _) = by(&edges[..nodes.links.len()]);
    let (cost, end) = by(&edges);
    let Walk { nodes: mut along, edges: used } = paths.path_to(end);
    along.retain(|n| *n != start);
    let bridges = used.iter().filter_map(|edge| edge.checked_sub(nodes.links.len())).filter_map(|row| nodes.bridges.get(row));
    let gap: f64 = bridges.map(|bridge| bridge.gap).sum();
    let mut radii: Vec<f64> = along.iter().map(|n| nodes.log_radius[*n]).collect();
    radii.sort_by(f64::total_cmp);
    let middle = 0.5 * (radii[(radii.len() - 1) / 2] + radii[radii.len() / 2]);
    Way {
        cost,
        observed,
        gap,
        diameters: gap / (2.0 * middle.exp()),
        named: along.iter().map(|n| labels[*n][own] * nodes.weight[*n]).sum(),
    }
}
