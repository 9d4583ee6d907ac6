//! A part of a run: the blocks that are finished, in any order, and the convergence record over them.

use std::{collections::BTreeMap, ops::Range};

use super::{DyadicSums, Snapshot, Summed, Sums};
use crate::support::random::BLOCK;

/// How many points the convergence record should have.
const SNAPSHOTS: u64 = 128;
/// About the most numbers that the record may hold. With more uncertain vessels it has fewer points.
const MOST_NUMBERS: u64 = 1 << 24;

/// What is finished of a run. The same blocks make the same part, bit for bit, whatever the order in which they were added.
#[derive(Debug, Clone, PartialEq)]
pub struct PartialRun {
    uncertain: Vec<bool>,
    samples: u64,
    /// Blocks between two points of the convergence record, a power of two.
    step: u64,
    sums: DyadicSums<Sums>,
    /// L of the uncertain vessels over each step that is finished.
    steps: BTreeMap<u64, Vec<f64>>,
}

impl PartialRun {
    /// An empty part of a run of `samples`, whose `uncertain` vessels are marked.
    pub fn new(uncertain: Vec<bool>, samples: u64) -> Self {
        let step = step(samples.div_ceil(BLOCK), uncertain.iter().filter(|u| **u).count());
        Self { uncertain, samples, step, sums: DyadicSums::default(), steps: BTreeMap::new() }
    }

    /// Samples of the whole run.
    pub fn samples(&self) -> u64 {
        self.samples
    }

    /// Blocks of the whole run.
    pub fn blocks(&self) -> u64 {
        self.samples.div_ceil(BLOCK)
    }

    /// Blocks between two points of the convergence record, a power of two.
    pub fn step(&self) -> u64 {
        self.step
    }

    /// Whether each vessel is uncertain.
    pub fn uncertain(&self) -> &[bool] {
        &self.uncertain
    }

    /// Samples that are finished.
    pub fn done(&self) -> u64 {
        self.sums.nodes().map(|(_, _, sums)| sums.samples).sum()
    }

    /// Samples in a range of blocks.
    pub fn samples_in(&self, blocks: &Range<u64>) -> u64 {
        let border = |block: u64| (block * BLOCK).min(self.samples);
        border(blocks.end) - border(blocks.start)
    }

    /// The sums over the blocks that are finished, as the largest nodes of the dyadic tree that they fill. Each has its first block, its
    /// number of blocks, and their sum.
    pub fn nodes(&self) -> impl ExactSizeIterator<Item = (u64, u64, &Sums)> {
        self.sums.nodes()
    }

    /// L of the uncertain vessels over each step that is finished, by its number.
    pub fn steps(&self) -> impl ExactSizeIterator<Item = (u64, &[f64])> {
        self.steps.iter().map(|(at, likelihood)| (*at, &likelihood[..]))
    }

    /// Whether the node of so many blocks from `first` on can be added: it is a node of this run, and none of it is finished yet.
    pub fn takes(&self, first: u64, blocks: u64) -> bool {
        DyadicSums::<Sums>::is_node(first, blocks)
            && first + blocks <= self.blocks()
            && !self.sums.overlaps(first..first + blocks)
    }

    /// Adds the sums of a node for which [`PartialRun::takes`] holds; memory that is no longer needed goes to `spare`.
    pub fn insert(&mut self, first: u64, blocks: u64, sums: Sums, spare: &mut Vec<Sums>) {
        let (uncertain, step, steps) = (&self.uncertain, self.step, &mut self.steps);
        self.sums.insert(first, blocks, sums, spare, |first, blocks, sums| {
            if blocks == step {
                steps.insert(first / step, of_uncertain(&sums.likelihood, uncertain));
            }
        });
    }

    /// Whether all blocks of a step are finished.
    pub fn holds_step(&self, at: u64) -> bool {
        let last = (at + 1).checked_mul(self.step).filter(|last| *last <= self.blocks());
        last.is_some_and(|last| self.gaps(last - self.step..last).is_empty())
    }

    /// Whether L is known over every step whose blocks are finished.
    pub fn is_traced(&self) -> bool {
        let whole = |(first, blocks, _): (u64, u64, &Sums)| first.div_ceil(self.step)..(first + blocks) / self.step;
        self.sums.nodes().flat_map(whole).all(|at| self.steps.contains_key(&at))
    }

    /// Whether what L grew by in the steps of each node, which is at least a step wide, adds up to its L; up to the last digits.
    pub fn is_trace_of_its_sums(&self) -> bool {
        let fits = |(sum, traced): (f64, f64)| (sum - traced).abs() <= 1e-9 * sum.abs();
        let is_figure = |x: &f64| x.is_finite() && *x >= 0.0;
        self.steps.values().flatten().all(is_figure)
            && self.sums.nodes().filter(|(_, blocks, _)| *blocks >= self.step).all(|(first, blocks, sums)| {
                let steps = self.steps.range(first / self.step..(first + blocks) / self.step).map(|(_, step)| step);
                let mut traced = vec![0.0; self.uncertain.iter().filter(|u| **u).count()];
                steps.for_each(|step| traced.iter_mut().zip(step).for_each(|(sum, x)| *sum += x));
                of_uncertain(&sums.likelihood, &self.uncertain).into_iter().zip(traced).all(fits)
            })
    }

    /// Adds L of the uncertain vessels over a step whose blocks are finished.
    pub fn insert_step(&mut self, at: u64, likelihood: Vec<f64>) {
        self.steps.insert(at, likelihood);
    }

    /// The blocks of a range that are not finished.
    pub fn gaps(&self, blocks: Range<u64>) -> Vec<Range<u64>> {
        self.sums.gaps(blocks)
    }

    /// Makes this the part of a run of twice as many samples. The run must consist of whole blocks.
    pub fn double(&mut self) {
        debug_assert!(self.samples.is_multiple_of(BLOCK));
        self.samples *= 2;
        let step = step(self.blocks(), self.uncertain.iter().filter(|u| **u).count());
        while self.step < step {
            let mut pairs = BTreeMap::new();
            for (at, left) in std::mem::take(&mut self.steps) {
                pairs.entry(at / 2).or_insert_with(Vec::new).push(left);
            }
            let joined = |(at, mut pair): (u64, Vec<Vec<f64>>)| {
                let right = pair.pop().filter(|_| pair.len() == 1)?;
                Some((at, pair.pop()?.plus(&right)))
            };
            self.steps = pairs.into_iter().filter_map(joined).collect();
            self.step *= 2;
        }
    }

    /// The sums over all that is finished; `None` where nothing is.
    pub fn total(&self) -> Option<Sums> {
        self.sums.total()
    }

    /// The convergence record of a part that is the whole run: L of the uncertain vessels after each step.
    pub fn trace(&self) -> Vec<Snapshot> {
        let (mut so_far, mut trace, mut spare) = (DyadicSums::default(), Vec::new(), Vec::new());
        for (at, likelihood) in self.steps() {
            so_far.insert(at, 1, likelihood.to_vec(), &mut spare, |_, _, _| {});
            let samples = ((at + 1) * self.step * BLOCK).min(self.samples);
            trace.extend(so_far.total().map(|likelihood| Snapshot { samples, likelihood }));
        }
        if !self.blocks().is_multiple_of(self.step)
            && let Some(total) = self.total()
        {
            trace.push(Snapshot { samples: total.samples, likelihood: of_uncertain(&total.likelihood, &self.uncertain) });
        }
        trace
    }
}

/// Blocks between two points of the convergence record. They depend on the run alone, not on its threads or parts.
fn step(blocks: u64, uncertain: usize) -> u64 {
    let snapshots = (MOST_NUMBERS / (uncertain as u64).max(1)).clamp(1, SNAPSHOTS);
    (blocks / snapshots).max(1).next_power_of_two()
}

fn of_uncertain(values: &[f64], uncertain: &[bool]) -> Vec<f64> {
    values.iter().zip(uncertain).filter(|(_, u)| **u).map(|(x, _)| *x).collect()
}
