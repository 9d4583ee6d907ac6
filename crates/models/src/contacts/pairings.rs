//! Which vessels are one at a contact, and which others might be.

use serde::{Deserialize, Serialize};

use super::partition::numbered;
use willis_core::network::path_places::at_even_steps;
use willis_core::network::units::millimetres;
use willis_core::network::{Edit, Network};
use willis_core::support::arc_lengths::in_direction;
use willis_core::support::geometry::{Point, distance};

/// A place that stands for a vessel of a pairing is so far from its end, m, but no further than its middle.
const OUTSIDE: f64 = 0.003;
const STEPS: usize = 64;

/// The vessels that end at a place where vessels touch or, without contacts, may only touch, and the ways to pair them.
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

/// A vessel by its row, its node at a place, and its block there.
pub type PlacedVessel = (usize, usize, usize);

/// What says one way to pair vessels to a run: contacts that are accepted and rejected or, where no contacts say it, an edit.
#[derive(Debug, Default)]
pub struct PairingDecision {
    /// Rows of the graph.
    pub accept: Vec<usize>,
    /// Rows of the graph.
    pub reject: Vec<usize>,
    /// Parts the vessels; the contacts are left to it.
    pub part: Option<Edit>,
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

    /// What a person decides who takes a way; `None` where both ends of a vessel are here, which no places tell apart.
    pub fn decision(&self, way: &[usize], graph: &Network) -> Option<PairingDecision> {
        let ends = 0..self.vessels.len();
        let one = |blocks: &[usize], [a, b]: [usize; 2]| blocks[a] == blocks[b];
        if ends.clone().all(|a| ends.clone().all(|b| !one(&self.opened, [a, b]) || one(way, [a, b]))) {
            let of_block = |block: usize| self.opened.iter().position(|of| *of == block).unwrap_or_default();
            let (accept, reject) = self.contacts.iter().partition::<Vec<_>, _>(|(blocks, _)| one(way, blocks.map(of_block)));
            let rows = |contacts: Vec<&([usize; 2], usize)>| contacts.into_iter().map(|(_, row)| *row).collect();
            return Some(PairingDecision { accept: rows(accept), reject: rows(reject), part: None });
        }
        if ends.clone().any(|end| self.vessels[..end].contains(&self.vessels[end])) {
            return None;
        }
        let mut groups = vec![Vec::new(); way.iter().max().map_or(0, |most| most + 1)];
        for (vessel, block) in self.vessels.iter().zip(way) {
            groups[*block].push(self.outside(graph, *vessel).map(|x| (millimetres(x) * 1e3).round() / 1e3));
        }
        Some(PairingDecision { part: Some(Edit::Part(groups)), ..PairingDecision::default() })
    }

    /// A place on a vessel a little outside of where it meets the others. Contacts are looked for only where every node has a position.
    fn outside(&self, graph: &Network, vessel: usize) -> Point {
        let path = graph.path_of(vessel);
        let [first, last] = [path[0], path[path.len() - 1]].map(|end| distance(end.position, self.position));
        let path = in_direction(path, first <= last);
        let step = ((OUTSIDE / graph.vessel(vessel).length * STEPS as f64) as usize).clamp(1, STEPS / 2);
        at_even_steps(&path, STEPS)[step].on(&path).position
    }

    /// Where one line may show two vessels: the probability that it does, and the vessels with their nodes here and their blocks in the most probable way.
    pub fn doubt(&self, graph: &Network) -> Option<(f64, Vec<PlacedVessel>)> {
        let apart = |way: &Vec<usize>| way.iter().any(|block| *block > 0);
        let (way, _) = self.ways.iter().find(|(way, _)| self.contacts.is_empty() && apart(way))?;
        let chance = self.ways.iter().filter(|(way, _)| apart(way)).map(|(_, p)| p).sum();
        let near = |row: usize| {
            let away = |node: &usize| graph.node(*node).position.map_or(f64::INFINITY, |at| distance(at, self.position));
            let [a, b] = graph.ends(row);
            if away(&b) < away(&a) { b } else { a }
        };
        Some((chance, self.vessels.iter().zip(way).map(|(row, block)| (*row, near(*row), *block)).collect()))
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
