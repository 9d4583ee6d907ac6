//! How likely each segment of the ring is there, read off the names: what is seen of it, and what lies before, behind and beside it.

use super::nodes::Nodes;
use super::states::{ACOMM, BA, LABELS, Label, Sided};
use crate::circle_of_willis::{Artery, RING, Side};

/// How many features a segment has.
pub const PRESENCE_FEATURES: usize = 8;
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

/// The label of a segment of [`RING`].
pub fn label_of_segment(segment: usize) -> Label {
    match RING[segment] {
        Artery::A1(side) => Sided::A1.on(side),
        Artery::PComm(side) => Sided::PComm.on(side),
        Artery::P1(side) => Sided::P1.on(side),
        _ => ACOMM,
    }
}

/// What is seen of the segments.
#[derive(Debug, Clone, PartialEq)]
pub struct Seen {
    /// Per label its expected length, mm.
    pub length: [f64; LABELS],
    /// Per label the probability of the node that is most likely of it.
    pub best: [f64; LABELS],
}

impl Seen {
    /// What is seen, from the probabilities of the labels: nodes x labels.
    pub fn of(nodes: &Nodes, labels: &[[f64; LABELS]]) -> Self {
        let (mut length, mut best) = ([0.0; LABELS], [0.0_f64; LABELS]);
        for (p, w) in labels.iter().zip(&nodes.weight) {
            for label in 0..LABELS {
                length[label] += p[label] * w;
                best[label] = best[label].max(p[label]);
            }
        }
        Self { length, best }
    }

    /// The features of a segment of [`RING`]: its length over the usual one, the logarithm of that, its best node, and the lengths (cm) of
    /// what lies around it.
    pub fn features(&self, segment: usize) -> [f64; PRESENCE_FEATURES] {
        let (kind, label) = (kind_of(segment), label_of_segment(segment));
        let cm = |label: Label| (self.length[label] / 10.0).min(1.5);
        let around = match RING[segment] {
            Artery::A1(side) => {
                let other = side.other();
                [Sided::A2.on(side), ACOMM, Sided::Ica.on(side), Sided::A1.on(other), Sided::A2.on(other)].map(cm)
            }
            Artery::PComm(side) => {
                let [a, b, c, d] =
                    [Sided::P2.on(side), Sided::P1.on(side), Sided::Ica.on(side), Sided::PComm.on(side.other())].map(cm);
                [a, b, c, d, 0.0]
            }
            Artery::P1(side) => {
                let [a, b, c, d] = [Sided::P2.on(side), Sided::PComm.on(side), BA, Sided::P1.on(side.other())].map(cm);
                [a, b, c, d, 0.0]
            }
            _ => {
                let [a, b] = Side::BOTH.map(|side| cm(Sided::A1.on(side)));
                let [c, d] = Side::BOTH.map(|side| cm(Sided::A2.on(side)));
                [a.min(b), a.max(b), c.min(d), 0.0, 0.0]
            }
        };
        let x = (self.length[label] / USUAL[kind]).min(1.2);
        let [a, b, c, d, e] = around;
        [x, (0.02 + x).ln(), self.best[label], a, b, c, d, e]
    }

    /// Whether enough of a segment is seen.
    pub fn is_seen(&self, segment: usize) -> bool {
        self.length[label_of_segment(segment)] > SEEN[kind_of(segment)]
    }
}
