//! Which branch ends at a cluster are one vessel: a probability for every set partition of them.
//!
//! P(z) ~ exp(θ·f(z)), where f adds up the scores of pairs in one block, and counts blocks. A cluster of more ends than the exact sum
//! takes is put together greedily.
//!
//! Loops around a hole that is narrower than the vessels: two vessels that touch in two places, or one that is pierced. Brains have
//! none, so each is opened at the contact where that is most probable.
//!
//! A loop lives, in the distance to the wall, from the depth of its weakest neck inside down to the width of its hole outside: the
//! persistence of Edelsbrunner, Letscher and Zomorodian, "Topological persistence and simplification" (2002). Of a narrow one the life is
//! shorter than a vessel is wide.

use std::cmp::Reverse;
use std::collections::{BTreeMap, BTreeSet, BinaryHeap};

use super::branches::{BranchEnd, Branches, MOST_ENDS};
use super::features::{PairTable, pairs_among};
use willis_core::support::geometry::{Point, centroid, lerp};
use willis_core::support::statistics::{median, sigmoid};
use willis_io::masks::Field;

/// Features of a partition; weights differ for two or three ends, four, and more.
pub const PARTITION_FEATURES: usize = 6;
/// Kinds of clusters by their number of ends.
pub const SIZES: usize = 3;
/// So many partitions are told of a cluster, and those that are as probable as this.
const MOST_WAYS: usize = 5;
const LEAST_OF_WAY: f64 = 0.01;

/// Weights θ of the features of a partition, for each kind of cluster.
pub type PartitionWeights = [[f64; PARTITION_FEATURES]; SIZES];

/// The kind of a cluster of so many ends.
pub fn size_of(ends: usize) -> usize {
    ends.saturating_sub(3).min(SIZES - 1)
}

/// The set partitions of so many ends: the block of each end, blocks numbered in the order of their first ends.
pub fn partitions(ends: usize) -> Vec<Vec<usize>> {
    let mut out = vec![vec![0; ends.min(1)]];
    for _ in 1..ends {
        let longer = |blocks: Vec<usize>| (0..=block_count(&blocks)).map(move |block| [&blocks[..], &[block]].concat());
        out = out.into_iter().flat_map(longer).collect();
    }
    out
}

/// The features of a partition: the scores of pairs in one block, the negative ones alone, blocks, blocks of one, blocks of two (from
/// four ends on), and whether exactly one pair is left together (from three ends on).
pub fn partition_features(blocks: &[usize], scores: &PairTable) -> [f64; PARTITION_FEATURES] {
    let ends = scores.ends();
    let (mut sum, mut against) = (0.0, 0.0);
    for [i, j] in pairs_among(ends).filter(|[i, j]| blocks[*i] == blocks[*j]) {
        sum += scores.get(i, j);
        against += scores.get(i, j).min(0.0);
    }
    let count = block_count(blocks);
    let of_size = |size: usize| (0..count).filter(|b| blocks.iter().filter(|x| *x == b).count() == size).count();
    let pairs = if ends >= 4 { of_size(2) as f64 } else { 0.0 };
    let one_pair = ends > 2 && count == ends - 1;
    [sum, against, count as f64 - 1.0, of_size(1) as f64, pairs, f64::from(u8::from(one_pair))]
}

/// Whether no pair of ends that must stay apart is in one block.
fn keeps_apart(of_end: &[usize], apart: &BTreeSet<[usize; 2]>) -> bool {
    apart.iter().all(|[a, b]| of_end[*a] != of_end[*b])
}

/// The blocks of a cluster's ends, and how probable it is that two blocks are one vessel after all.
#[derive(Debug, Clone, Default, PartialEq)]
pub struct Blocks {
    /// The block of each end, numbered in the order of their first ends.
    pub of_end: Vec<usize>,
    /// Pairs of blocks with the probability that some end of one is joined to some end of the other.
    pub joined: Vec<([usize; 2], f64)>,
    /// The most probable partitions with their probabilities, this one among them; none where they are not summed.
    pub ways: Vec<(Vec<usize>, f64)>,
    /// The logarithm of the weight of these blocks.
    pub log: f64,
}

impl Blocks {
    /// How many blocks there are.
    pub fn count(&self) -> usize {
        block_count(&self.of_end)
    }

    /// The probability that the ends are not all of one vessel; zero where the partitions are not summed.
    pub fn apart(&self) -> f64 {
        self.ways.iter().filter(|(way, _)| way.iter().any(|block| *block > 0)).map(|(_, p)| p).sum()
    }
}

/// The set partitions of the ends of a cluster, with the logarithm of the weight of each.
fn log_weights(scores: &PairTable, weights: &PartitionWeights) -> (Vec<Vec<usize>>, Vec<f64>) {
    let (theta, all) = (weights[size_of(scores.ends())], partitions(scores.ends()));
    let log_weight = |z: &Vec<usize>| partition_features(z, scores).iter().zip(theta).map(|(f, t)| f * t).sum();
    let log = all.iter().map(log_weight).collect();
    (all, log)
}

/// The most probable blocks of the ends of a cluster, given the scores of their pairs and the pairs that must stay apart, the lower end first.
pub fn most_probable(scores: &PairTable, weights: &PartitionWeights, apart: &BTreeSet<[usize; 2]>) -> Blocks {
    if scores.ends() > MOST_ENDS {
        return greedy(scores, apart);
    }
    let (all, log) = log_weights(scores, weights);
    let allowed = (0..all.len()).filter(|z| keeps_apart(&all[*z], apart));
    let best = allowed.max_by(|a, b| log[*a].total_cmp(&log[*b]).then(b.cmp(a))).unwrap_or(0);
    let weight: Vec<f64> = log.iter().map(|l| (l - log[best]).exp()).collect();
    let total: f64 = weight.iter().sum();
    let of_end = all[best].clone();
    let joined = pairs_of_blocks(&of_end, |a, b| {
        let [a, b] = [a, b].map(|block| members(&of_end, block));
        let joins = |z: &[usize]| a.iter().any(|i| b.iter().any(|j| z[*i] == z[*j]));
        all.iter().zip(&weight).filter(|(z, _)| joins(z)).map(|(_, w)| w).sum::<f64>() / total
    });
    let mut order: Vec<usize> = (0..all.len()).filter(|z| *z == best || weight[*z] >= LEAST_OF_WAY * total).collect();
    order.sort_by(|a, b| weight[*b].total_cmp(&weight[*a]).then(a.cmp(b)));
    if let Some(dropped) = order.get(MOST_WAYS..).filter(|dropped| dropped.contains(&best)) {
        order.truncate(order.len() - dropped.len() - 1);
        order.push(best);
    }
    let ways = order.into_iter().take(MOST_WAYS).map(|z| (all[z].clone(), weight[z] / total)).collect();
    Blocks { of_end, joined, ways, log: log[best] }
}

/// The most probable blocks of each cluster, given the scores of its pairs.
pub fn most_probable_blocks(scores: &[PairTable], weights: &PartitionWeights) -> Vec<Blocks> {
    scores.iter().map(|scores| most_probable(scores, weights, &BTreeSet::new())).collect()
}

/// Per pair of ends the probability that they are one vessel; only for clusters that are summed exactly.
pub fn pair_probabilities(scores: &PairTable, weights: &PartitionWeights) -> Vec<f64> {
    let (all, log) = log_weights(scores, weights);
    let most = log.iter().copied().fold(f64::NEG_INFINITY, f64::max);
    let weight: Vec<f64> = log.iter().map(|l| (l - most).exp()).collect();
    let total: f64 = weight.iter().sum();
    let of = |[i, j]: [usize; 2]| all.iter().zip(&weight).filter(|(z, _)| z[i] == z[j]).map(|(_, w)| w).sum::<f64>() / total;
    pairs_among(scores.ends()).map(of).collect()
}

/// Pairs of blocks with a figure of each.
fn pairs_of_blocks(of_end: &[usize], figure: impl Fn(usize, usize) -> f64) -> Vec<([usize; 2], f64)> {
    pairs_among(block_count(of_end)).map(|[a, b]| ([a, b], figure(a, b))).collect()
}

/// Blocks put together two by two while the sum of the scores between them is positive, the largest sum first.
fn greedy(scores: &PairTable, apart: &BTreeSet<[usize; 2]>) -> Blocks {
    let ends = scores.ends();
    let mut of_end: Vec<usize> = (0..ends).collect();
    let between = |of_end: &[usize], blocks: [usize; 2]| {
        let [a, b] = blocks.map(|block| members(of_end, block));
        a.iter().flat_map(|i| b.iter().map(|j| scores.get(*i, *j))).sum::<f64>()
    };
    // A block has the number of its first end.
    let mut sums: BTreeMap<[usize; 2], f64> = pairs_among(ends).map(|pair| (pair, between(&of_end, pair))).collect();
    loop {
        let joined = |[a, b]: [usize; 2]| of_end.iter().map(|block| if *block == b { a } else { *block }).collect::<Vec<usize>>();
        let mut best: Option<(f64, [usize; 2])> = None;
        for (pair, sum) in &sums {
            if *sum > best.map_or(0.0, |(most, _)| most) && keeps_apart(&joined(*pair), apart) {
                best = Some((*sum, *pair));
            }
        }
        let Some((_, [a, b])) = best else { break };
        of_end = joined([a, b]);
        sums.retain(|pair, _| !pair.contains(&b));
        for (pair, sum) in sums.iter_mut().filter(|(pair, _)| pair.contains(&a)) {
            *sum = between(&of_end, *pair);
        }
    }
    let of_end = numbered(of_end);
    let joined = pairs_of_blocks(&of_end, |a, b| sigmoid(between(&of_end, [a, b])));
    let within = pairs_among(ends).filter(|[i, j]| of_end[*i] == of_end[*j]);
    let log = within.map(|[i, j]| scores.get(i, j)).sum();
    Blocks { of_end, joined, ways: Vec::new(), log }
}

/// The ends of a block.
fn members(of_end: &[usize], block: usize) -> Vec<usize> {
    (0..of_end.len()).filter(|end| of_end[*end] == block).collect()
}

/// How many blocks there are.
pub fn block_count(of_end: &[usize]) -> usize {
    of_end.iter().max().map_or(0, |most| most + 1)
}

/// Blocks numbered in the order of their first ends.
pub fn numbered(mut of_end: Vec<usize>) -> Vec<usize> {
    let mut number = BTreeMap::new();
    for block in &mut of_end {
        let next = number.len();
        *block = *number.entry(*block).or_insert(next);
    }
    of_end
}

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

/// A loop: its branches, and per block that it passes its cluster and the two ends by which it does.
type Loop = (Vec<usize>, Vec<(usize, [usize; 2])>);

/// The blocks of clusters, and which of their ends may not be one vessel.
struct Opening<'a> {
    branches: &'a Branches,
    scores: &'a [PairTable],
    weights: &'a PartitionWeights,
    blocks: Vec<Blocks>,
    apart: Vec<BTreeSet<[usize; 2]>>,
    /// Per branch end its row in its cluster.
    row_of: BTreeMap<BranchEnd, usize>,
}

/// The most probable blocks of each cluster with narrow loops opened, given the scores of its pairs.
pub fn without_narrow_loops(branches: &Branches, scores: &[PairTable], weights: &PartitionWeights, field: &Field) -> Vec<Blocks> {
    let (blocks, apart) = (most_probable_blocks(scores, weights), vec![BTreeSet::new(); scores.len()]);
    let rows = branches.clusters.iter().flat_map(|cluster| cluster.ends.iter().copied().zip(0..));
    let mut opening = Opening { branches, scores, weights, blocks, apart, row_of: rows.collect() };
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
            let ends = self.branches.clusters[here.0].ends.iter().zip(&self.blocks[here.0].of_end);
            for (end, _) in ends.filter(|(end, block)| **block == here.1 && end.branch != row) {
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
                return Some((branches, passes));
            }
            branches.push(back.branch);
            by = back.other();
            here = self.vertex(by)?;
        }
    }

    /// Whether the hole of a loop is nowhere as wide as its vessels: at no place on the ways from the loop to its middle.
    fn is_narrow(&self, (branches, _): &Loop, field: &Field) -> bool {
        let courses = || branches.iter().map(|row| &self.branches.branches[*row]);
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
    fn open(&mut self, (_, passes): &Loop) -> bool {
        let ways = passes.iter().filter(|(_, [a, b])| a != b).map(|(cluster, [a, b])| {
            let mut apart = self.apart[*cluster].clone();
            apart.insert([*a.min(b), *a.max(b)]);
            let opened = most_probable(&self.scores[*cluster], self.weights, &apart);
            (self.blocks[*cluster].log - opened.log, *cluster, apart, opened)
        });
        let least = ways.reduce(|best, next| if next.0 < best.0 { next } else { best });
        let Some((_, cluster, apart, blocks)) = least else { return false };
        (self.apart[cluster], self.blocks[cluster]) = (apart, blocks);
        true
    }
}
