//! Sums over the dyadic tree of block indices (node = left + right): the same bits in whatever order blocks arrive.

use std::collections::BTreeMap;
use std::ops::Range;

/// What can be summed over a range of blocks.
pub trait Summed: Clone {
    /// The sum of this and of `right`, which comes from later blocks.
    #[must_use]
    fn plus(self, right: &Self) -> Self;
}

impl Summed for Vec<f64> {
    fn plus(mut self, right: &Self) -> Self {
        self.iter_mut().zip(right).for_each(|(a, b)| *a += b);
        self
    }
}

/// The sums over the blocks that are finished: the largest nodes of the tree that they fill.
#[derive(Debug, Clone, PartialEq, Default)]
pub struct DyadicSums<T> {
    /// Blocks of each node and their sum, by the node's first block. A node has 2^k blocks and begins at a multiple of that.
    nodes: BTreeMap<u64, (u64, T)>,
}

impl<T: Summed> DyadicSums<T> {
    /// Whether the tree has a node of so many blocks from `first` on.
    pub fn is_node(first: u64, blocks: u64) -> bool {
        blocks.is_power_of_two() && first.is_multiple_of(blocks) && first.checked_add(blocks).is_some()
    }

    /// Adds the sum over a node of so many blocks, and joins it with its sibling as long as that is there. None of its blocks may be there yet.
    ///
    /// `done` is called for every node that this completes, beginning with the one given; memory that is no longer needed goes to `spare`.
    pub fn insert(&mut self, mut first: u64, mut size: u64, mut sum: T, spare: &mut Vec<T>, mut done: impl FnMut(u64, u64, &T)) {
        debug_assert!(Self::is_node(first, size) && !self.overlaps(first..first + size));
        loop {
            done(first, size, &sum);
            let sibling = first ^ size;
            let is_there = self.nodes.get(&sibling).is_some_and(|(blocks, _)| *blocks == size);
            let Some((_, other)) = is_there.then(|| self.nodes.remove(&sibling)).flatten() else { break };
            let (left, right) = if sibling < first { (other, sum) } else { (sum, other) };
            sum = left.plus(&right);
            spare.push(right);
            (first, size) = (first.min(sibling), 2 * size);
        }
        self.nodes.insert(first, (size, sum));
    }

    /// Each node's first block, number of blocks and sum, by first block.
    pub fn nodes(&self) -> impl ExactSizeIterator<Item = (u64, u64, &T)> {
        self.nodes.iter().map(|(first, (blocks, sum))| (*first, *blocks, sum))
    }

    /// The same, by value.
    pub fn into_nodes(self) -> impl ExactSizeIterator<Item = (u64, u64, T)> {
        self.nodes.into_iter().map(|(first, (blocks, sum))| (first, blocks, sum))
    }

    /// Whether one of these blocks is there already.
    pub fn overlaps(&self, blocks: Range<u64>) -> bool {
        self.nodes.range(..blocks.end).next_back().is_some_and(|(first, (size, _))| first + size > blocks.start)
    }

    /// The blocks of a range that are not there.
    pub fn gaps(&self, blocks: Range<u64>) -> Vec<Range<u64>> {
        let (mut gaps, mut at) = (Vec::new(), blocks.start);
        for (first, (size, _)) in &self.nodes {
            let (from, to) = ((*first).min(blocks.end), (first + size).min(blocks.end));
            if from > at {
                gaps.push(at..from);
            }
            at = at.max(to);
        }
        if at < blocks.end {
            gaps.push(at..blocks.end);
        }
        gaps
    }

    /// The sum over all blocks that are there; `None` before the first.
    pub fn total(&self) -> Option<T> {
        let mut nodes = self.nodes.values().rev();
        let mut total = nodes.next()?.1.clone();
        for (_, left) in nodes {
            total = left.clone().plus(&total);
        }
        Some(total)
    }
}
