//! How likely each segment of the ring is there, read off the names: what is seen of it, and what lies before, behind and beside it.

use super::joins::probability_with;
use super::nodes::Nodes;
use super::states::{LABELS, OTHER, label_of};
use super::ways::{Way, ways};
use crate::circle_of_willis::{Artery, BodySide, RING};

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
        Artery::A1(_) => 0,
        Artery::AComm => 1,
        Artery::PComm(_) => 2,
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
        let (mut total, mut squares) = (0.0, 0.0);
        for (bridge, factor) in nodes.bridges.iter().zip(bridge_factor) {
            let p = probability_with(bridge.probability, *factor);
            total += p;
            squares += p * bridge.gap * bridge.gap;
        }
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
    pub fn features(&self, segment: usize) -> [f64; PRESENCE_FEATURES] {
        let (kind, label) = (kind_of(segment), label_of(RING[segment]));
        let cm = |artery: Artery| (self.length[label_of(artery)] / 10.0).min(1.5);
        let mut around = match RING[segment] {
            Artery::A1(s) => {
                [Artery::A2(s), Artery::AComm, Artery::Ica(s), Artery::A1(s.other()), Artery::A2(s.other())].map(cm).to_vec()
            }
            Artery::PComm(s) => [Artery::P2(s), Artery::P1(s), Artery::Ica(s), Artery::PComm(s.other())].map(cm).to_vec(),
            Artery::P1(s) => [Artery::P2(s), Artery::PComm(s), Artery::Ba, Artery::P1(s.other())].map(cm).to_vec(),
            _ => {
                let [a, b] = BodySide::BOTH.map(|side| cm(Artery::A1(side)));
                let [c, d] = BodySide::BOTH.map(|side| cm(Artery::A2(side)));
                vec![a.min(b), a.max(b), c.min(d)]
            }
        };
        around.resize(5, 0.0);
        let x = (self.length[label] / USUAL[kind]).min(1.2);
        let (evidence, way) = (self.evidence[segment].max(0.0), &self.ways[segment]);
        let named: f64 = (0..LABELS).filter(|label| *label != OTHER).map(|label| self.length[label]).sum();
        [
            x,
            (0.02 + x).ln(),
            self.best[label],
            around[0],
            around[1],
            around[2],
            around[3],
            around[4],
            evidence.min(30.0) / 10.0,
            evidence.ln_1p(),
            way.observed.min(20.0) / 5.0,
            way.cost.min(20.0) / 5.0,
            way.gap.min(20.0) / 10.0,
            way.diameters.min(8.0),
            way.named.min(15.0) / 10.0,
            self.pieces[0].ln_1p(),
            self.pieces[1].ln_1p(),
            self.gap.min(15.0) / 5.0,
            self.ends.ln_1p(),
            named / 400.0,
        ]
    }

    /// Whether enough of a segment is seen.
    pub fn is_seen(&self, segment: usize) -> bool {
        self.length[label_of(RING[segment])] > SEEN[kind_of(segment)]
    }
}
