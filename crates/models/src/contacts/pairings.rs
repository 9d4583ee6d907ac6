//! Which vessels are one at a contact, and which others might be.

use serde::{Deserialize, Serialize};

use super::partition::numbered;
use willis_core::network::Network;
use willis_core::support::geometry::{Point, distance};

/// The vessels that end at a place where vessels touch, and the ways to pair them.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct Pairings {
    /// The middle of the place, m.
    pub position: Point,
    /// The vessel of each end, a row of the opened graph.
    pub vessels: Vec<usize>,
    /// The way in which it was opened, as the block of each end.
    pub opened: Vec<usize>,
    /// The most probable ways with their probabilities, the most probable first; none where they are too many to be summed.
    pub ways: Vec<(Vec<usize>, f64)>,
    /// The contacts between two blocks of the way in which it was opened, rows of the opened graph.
    pub contacts: Vec<([usize; 2], usize)>,
}

impl Pairings {
    /// The way that a decision takes: the blocks that kept contacts join are one.
    pub fn taken(&self, kept: &[bool]) -> Vec<usize> {
        let mut blocks = self.opened.clone();
        let mut name: Vec<usize> = (0..blocks.len()).collect();
        for ([a, b], _) in self.contacts.iter().filter(|(_, row)| kept[*row]) {
            let (from, to) = (name[*b], name[*a]);
            name.iter_mut().filter(|block| **block == from).for_each(|block| *block = to);
        }
        for block in &mut blocks {
            *block = name[*block];
        }
        numbered(blocks)
    }

    /// A way in words: vessels of one block with a plus between them, blocks with a bar, as in `12+45 | 31+46`.
    pub fn told(&self, way: &[usize]) -> String {
        let count = way.iter().max().map_or(0, |most| most + 1);
        let block = |which: usize| {
            let own = self.vessels.iter().zip(way).filter(|(_, block)| **block == which);
            own.map(|(vessel, _)| vessel.to_string()).collect::<Vec<String>>().join("+")
        };
        (0..count).map(block).collect::<Vec<String>>().join(" | ")
    }

    /// The vessels at this place once some were divided: of both parts the nearer one. `divided` are pairs of rows.
    pub fn follow(&mut self, graph: &Network, divided: &[[usize; 2]]) {
        let away = |row: usize| {
            let ends =
                graph.ends(row).map(|node| graph.node(node).position.map_or(f64::INFINITY, |at| distance(at, self.position)));
            ends[0].min(ends[1])
        };
        for [row, other] in divided {
            if away(*other) < away(*row) {
                self.vessels.iter_mut().filter(|vessel| *vessel == row).for_each(|vessel| *vessel = *other);
            }
        }
    }
}
