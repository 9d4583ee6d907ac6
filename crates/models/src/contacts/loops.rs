//! Loops around a hole that is narrower than the vessels: two vessels that touch in two places, or one that is pierced. Brains have
//! none, so each is opened at the contact where that is most probable.
//!
//! A loop lives, in the distance to the wall, from the depth of its weakest neck inside down to the width of its hole outside: the
//! persistence of Edelsbrunner, Letscher and Zomorodian, "Topological persistence and simplification" (2002). Of a narrow one the life is
//! shorter than a vessel is wide.

use std::cmp::Reverse;
use std::collections::{BTreeMap, BTreeSet, BinaryHeap};

use super::branches::{BranchEnd, Branches};
use super::features::PairTable;
use super::partition::{Blocks, JoinableEnds, PartitionWeights, most_probable};
use willis_core::support::geometry::{Point, centroid, lerp};
use willis_core::support::statistics::median;
use willis_io::masks::Field;

/// Loops longer than so many of their radii are not looked at.
const LONGEST: f64 = 60.0;
/// Holes that are not wider than so many voxels are no better known than the wall.
const RESOLUTION: f64 = 1.5;
/// A loop is not looked for beyond so many blocks: in a sponge it would be looked for all over.
const MOST_BLOCKS: usize = 1000;
/// Places along the way from a loop to its middle where its hole is looked for.
const STEPS: usize = 4;

/// A block of a cluster.
type Vertex = (usize, usize);

/// A loop: its branches, and per block that it passes the two ends by which it does.
struct Loop {
    branches: Vec<usize>,
    passes: Vec<(usize, [usize; 2])>,
}

/// The blocks of clusters, and which of their ends may not be one vessel.
struct Opening<'a> {
    branches: &'a Branches,
    tables: &'a [PairTable],
    weights: &'a PartitionWeights,
    blocks: Vec<Blocks>,
    apart: Vec<BTreeSet<[usize; 2]>>,
    /// Per branch end its row in its cluster.
    row_of: BTreeMap<BranchEnd, usize>,
    /// Per block the branch ends at it.
    at: BTreeMap<Vertex, Vec<BranchEnd>>,
}

/// The blocks of clusters with narrow loops opened; `tables` are the scores of the pairs of ends of each cluster.
pub fn without_narrow_loops(
    branches: &Branches,
    tables: &[PairTable],
    blocks: Vec<Blocks>,
    weights: &PartitionWeights,
    field: &Field,
) -> Vec<Blocks> {
    let rows = branches.clusters.iter().flat_map(|cluster| cluster.ends.iter().copied().zip(0..));
    let mut opening = Opening {
        branches,
        tables,
        weights,
        apart: vec![BTreeSet::new(); blocks.len()],
        blocks,
        row_of: rows.collect(),
        at: BTreeMap::new(),
    };
    for cluster in 0..branches.clusters.len() {
        opening.place(cluster);
    }
    for row in 0..branches.branches.len() {
        while let Some(found) = opening.shortest_loop(row).filter(|found| opening.is_narrow(found, field)) {
            if !opening.open(&found) {
                break;
            }
        }
    }
    opening.blocks
}

impl Opening<'_> {
    fn vertex(&self, end: BranchEnd) -> Option<Vertex> {
        let cluster = self.branches.cluster(end)?;
        Some((cluster, self.blocks[cluster].of_end[self.row_of[&end]]))
    }

    /// Notes which ends are at the blocks of a cluster.
    fn place(&mut self, cluster: usize) {
        let old: Vec<Vertex> = self.at.range((cluster, 0)..(cluster + 1, 0)).map(|(vertex, _)| *vertex).collect();
        for vertex in old {
            self.at.remove(&vertex);
        }
        for (end, block) in self.branches.clusters[cluster].ends.iter().zip(&self.blocks[cluster].of_end) {
            self.at.entry((cluster, *block)).or_default().push(*end);
        }
    }

    /// The shortest loop through a branch.
    fn shortest_loop(&self, row: usize) -> Option<Loop> {
        let [first, last] = [false, true].map(|last| BranchEnd { branch: row, last });
        let (from, to) = (self.vertex(last)?, self.vertex(first)?);
        // Per block how far it is, and the end by which it is left towards the start.
        let mut best: BTreeMap<Vertex, (f64, BranchEnd)> = BTreeMap::from([(from, (0.0, last))]);
        // Lengths are not negative, so that their bits are in their order.
        let mut open = BinaryHeap::from([Reverse((0_u64, from))]);
        while let Some(Reverse((bits, here))) = open.pop() {
            let so_far = f64::from_bits(bits);
            if here == to {
                break;
            }
            if best.len() > MOST_BLOCKS {
                return None;
            }
            if best[&here].0 < so_far {
                continue;
            }
            for end in self.at[&here].iter().filter(|end| end.branch != row) {
                let length = so_far + self.branches.branches[end.branch].length;
                let Some(next) = self.vertex(end.other()) else { continue };
                if best.get(&next).is_none_or(|(known, _)| length < *known) {
                    best.insert(next, (length, end.other()));
                    open.push(Reverse((length.to_bits(), next)));
                }
            }
        }
        let (mut branches, mut passes, mut here, mut by) = (vec![row], Vec::new(), to, first);
        loop {
            let (_, back) = best.get(&here)?;
            passes.push((here.0, [self.row_of[&by], self.row_of[back]]));
            if here == from {
                return Some(Loop { branches, passes });
            }
            branches.push(back.branch);
            by = back.other();
            here = self.vertex(by)?;
        }
    }

    /// Whether the hole of a loop is nowhere as wide as its vessels: at no place on the ways from the loop to its middle.
    fn is_narrow(&self, found: &Loop, field: &Field) -> bool {
        let courses = || found.branches.iter().map(|row| &self.branches.branches[*row]);
        let points: Vec<Point> = courses().flat_map(|branch| branch.points.iter().map(|point| point.position)).collect();
        let radii: Vec<f64> = courses().flat_map(|branch| branch.points.iter().map(|point| point.radius)).collect();
        let radius = median(&radii).unwrap_or(0.0);
        let within = (radius + 0.5 * field.voxel()).max(RESOLUTION * field.voxel());
        if courses().map(|branch| branch.length).sum::<f64>() > LONGEST * within {
            return false;
        }
        let middle = centroid(points.iter().copied());
        let mut places =
            points.iter().flat_map(|point| (0..STEPS).map(move |step| lerp(middle, *point, step as f64 / STEPS as f64)));
        !places.any(|place| field.signed(place) < 0.0 && field.voxels_around(place, within).is_empty())
    }

    /// Opens a loop at the block where that costs least probability; `false` where it cannot be.
    fn open(&mut self, found: &Loop) -> bool {
        let mut best: Option<(f64, usize, [usize; 2], Blocks)> = None;
        for (cluster, [a, b]) in found.passes.iter().copied().filter(|(_, [a, b])| a != b) {
            let table = &self.tables[cluster];
            let pair = [a.min(b), a.max(b)];
            let ends = self.branches.clusters[cluster].ends.len();
            let now = most_probable(table, ends, self.weights, JoinableEnds::except(&self.apart[cluster]));
            let mut apart = self.apart[cluster].clone();
            apart.insert(pair);
            let then = most_probable(table, ends, self.weights, JoinableEnds::except(&apart));
            let cost = now.log - then.log;
            if best.as_ref().is_none_or(|(least, ..)| cost < *least) {
                best = Some((cost, cluster, pair, then));
            }
        }
        let Some((_, cluster, pair, blocks)) = best else { return false };
        self.apart[cluster].insert(pair);
        self.blocks[cluster] = blocks;
        self.place(cluster);
        true
    }
}
