//! The likelihood matrix: sums over samples, in an order that neither threads nor a stop can change. They are taken over the dyadic tree of
//! block indices (node = left + right): the same bits in whatever order blocks arrive.
//!
//! A part of a run is the blocks that are finished, in any order, and the convergence record over them.

use std::{collections::BTreeMap, ops::Range};

use serde::{Deserialize, Serialize};

use crate::{network::Network, support::random::BLOCK};

/// A vessel that fewer samples saw has an error that allows for those that did not.
const FEW: f64 = 20.0;
/// What 95 % of runs miss at the most, in standard errors of which 1.96 hold 95 %.
const RULE_OF_THREE: f64 = 3.0 / 1.96;

/// Sums over a range of samples, per vessel.
#[derive(Debug, Clone, PartialEq, Default, Serialize, Deserialize)]
pub struct Sums {
    /// Σ of the contributions: L.
    pub likelihood: Vec<f64>,
    /// Σ of the squared contributions, infinite beyond what a double can hold.
    #[serde(with = "as_bits")]
    pub square: Vec<f64>,
    /// Samples with the vessel in the forest; their probability in an enumeration.
    pub count: Vec<f64>,
    /// Σ ρ_G of the samples, W/m³.
    pub network_resilience: f64,
    /// Samples in which blood flows; their probability in an enumeration.
    pub perfused: f64,
    /// The largest relative residual ‖b - A P‖/‖b‖ of the samples that were checked, one of a block.
    pub residual: f64,
    /// How many samples.
    pub samples: u64,
}

impl Sums {
    /// The sums over no samples, for so many vessels.
    pub fn zero(vessels: usize) -> Self {
        Self { likelihood: vec![0.0; vessels], square: vec![0.0; vessels], count: vec![0.0; vessels], ..Self::default() }
    }

    /// Adds what a vessel contributes to a sample that counts with a probability.
    pub fn add(&mut self, vessel: usize, value: f64, probability: f64) {
        self.likelihood[vessel] += probability * value;
        self.square[vessel] += probability * value * value;
        self.count[vessel] += probability;
    }

    /// Sets all sums to zero.
    pub fn clear(&mut self) {
        self.likelihood.fill(0.0);
        self.square.fill(0.0);
        self.count.fill(0.0);
        (self.network_resilience, self.perfused, self.residual, self.samples) = (0.0, 0.0, 0.0, 0);
    }

    /// The Monte-Carlo standard error of each vessel's L, a sum over n samples: sqrt(n) times the standard deviation of
    /// one contribution; not a number for fewer than two samples.
    ///
    /// Where fewer than 20 samples saw the vessel these do not tell how often it is seen, nor how much it then contributes. The rule of three
    /// (Hanley and Lippman-Hand 1983, doi:10.1001/jama.1983.03330370053031) bounds the times that n samples missed with 95 % by 3. Each may have
    /// contributed as much as the vessel of the run that contributed most whenever it was seen, w = max sqrt(Σx²/k). So (3w/1.96)² is added
    /// to the square of the error: 1.96 of these errors hold the three.
    ///
    /// Where blood flowed in no sample, w is unknown, and so is every error: not a number. It is zero only where all contributions are equal.
    pub fn standard_errors(&self) -> Vec<f64> {
        let n = self.samples as f64;
        let seen = |(square, times): (&f64, &f64)| if *times > 0.0 { square / times } else { 0.0 };
        let heaviest = self.square.iter().zip(&self.count).map(seen).fold(0.0, f64::max);
        let nothing_flowed = heaviest == 0.0;
        let unseen = RULE_OF_THREE * RULE_OF_THREE * heaviest;
        let each = self.likelihood.iter().zip(&self.square).zip(&self.count);
        each.map(|((sum, square), times)| {
            let spread = square - sum * sum / n;
            // What equal contributions leave is rounding.
            let spread = if spread <= 8.0 * f64::EPSILON * square { 0.0 } else { spread };
            let unseen = if *times < FEW { unseen } else { 0.0 };
            if nothing_flowed || n <= 1.0 { f64::NAN } else { (n * spread / (n - 1.0) + unseen).sqrt() }
        })
        .collect()
    }

    /// The sum of this and of `right`, which comes from later samples.
    #[must_use]
    pub fn plus(mut self, right: &Self) -> Self {
        add(&mut self.likelihood, &right.likelihood);
        add(&mut self.square, &right.square);
        add(&mut self.count, &right.count);
        self.network_resilience += right.network_resilience;
        self.perfused += right.perfused;
        self.residual = self.residual.max(right.residual);
        self.samples += right.samples;
        self
    }
}

fn add(sums: &mut [f64], others: &[f64]) {
    sums.iter_mut().zip(others).for_each(|(sum, other)| *sum += other);
}

/// The state of the uncertain vessels after some of the samples.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct Snapshot {
    /// Samples so far.
    pub samples: u64,
    /// L of each uncertain vessel so far, in row order.
    #[serde(with = "as_bits")]
    pub likelihood: Vec<f64>,
}

/// The result of the samples, per vessel.
#[derive(Debug, Clone, Default, PartialEq, Serialize, Deserialize)]
pub struct Likelihood {
    /// L of each vessel, W/m³.
    #[serde(with = "as_bits")]
    pub likelihood: Vec<f64>,
    /// The Monte-Carlo standard error of L, W/m³; not a number where it is unknown.
    #[serde(with = "as_bits")]
    pub std_error: Vec<f64>,
    /// Share of the samples with the vessel in the forest.
    #[serde(with = "as_bits")]
    pub frequency: Vec<f64>,
    /// Whether the vessel was uncertain.
    pub uncertain: Vec<bool>,
    /// Mean of ρ_G over the samples, W/m³.
    pub network_resilience: f64,
    /// Share of the samples in which blood flows.
    pub perfused: f64,
    /// The largest relative residual of the samples that were checked.
    pub residual: f64,
    /// How many samples there were.
    pub samples: u64,
    /// L of the uncertain vessels along the way.
    pub trace: Vec<Snapshot>,
}

/// Numbers as their bits, so that any number comes back.
mod as_bits {
    use serde::{Deserialize, Deserializer, Serializer};

    pub fn serialize<S: Serializer>(numbers: &[f64], to: S) -> Result<S::Ok, S::Error> {
        to.collect_seq(numbers.iter().map(|x| x.to_bits()))
    }

    pub fn deserialize<'de, D: Deserializer<'de>>(from: D) -> Result<Vec<f64>, D::Error> {
        Ok(Vec::<u64>::deserialize(from)?.into_iter().map(f64::from_bits).collect())
    }
}

impl Likelihood {
    /// From the sums over all samples.
    pub fn new(sums: Sums, uncertain: Vec<bool>, trace: Vec<Snapshot>) -> Self {
        let n = sums.samples.max(1) as f64;
        // Where nothing is uncertain samples differ only in what decides between equals: those that the forest always or never has are exact.
        let varies = uncertain.contains(&true);
        let errors = sums.standard_errors().into_iter().zip(&sums.count);
        let std_error = errors.map(|(error, count)| if varies || (*count > 0.0 && *count < n) { error } else { 0.0 }).collect();
        Self {
            std_error,
            frequency: sums.count.iter().map(|c| c / n).collect(),
            network_resilience: sums.network_resilience / n,
            perfused: sums.perfused / n,
            residual: sums.residual,
            samples: sums.samples,
            likelihood: sums.likelihood,
            uncertain,
            trace,
        }
    }

    /// From the sums over all patterns, weighted by probability: the expectation of a run of `samples`, without error.
    pub fn exact(sums: Sums, uncertain: Vec<bool>, samples: u64) -> Self {
        let n = samples as f64;
        Self {
            std_error: vec![0.0; sums.likelihood.len()],
            likelihood: sums.likelihood.iter().map(|e| n * e).collect(),
            frequency: sums.count,
            network_resilience: sums.network_resilience,
            perfused: sums.perfused,
            residual: sums.residual,
            samples,
            uncertain,
            trace: Vec::new(),
        }
    }

    /// The upper triangle of the symmetric N x N matrix L, row by row: L(j1, j2) sums over parallel vessels; self-loops and
    /// zeros are left out.
    pub fn matrix(&self, network: &Network) -> Vec<(u32, u32, f64)> {
        let mut cells = std::collections::BTreeMap::new();
        for (([a, b], _), value) in network.vessels().zip(&self.likelihood) {
            if a != b && *value != 0.0 {
                *cells.entry((a.min(b) as u32, a.max(b) as u32)).or_insert(0.0) += value;
            }
        }
        cells.into_iter().map(|((a, b), value)| (a, b, value)).collect()
    }
}

/// The sums over the blocks that are finished: the largest nodes of the tree that they fill.
#[derive(Debug, Clone, PartialEq, Default, Serialize, Deserialize)]
pub struct DyadicSums {
    /// Blocks of each node and their sum, by the node's first block. A node has 2^k blocks and begins at a multiple of that.
    nodes: BTreeMap<u64, (u64, Sums)>,
}

impl DyadicSums {
    /// Adds the sum over a node of so many blocks, and joins it with its sibling as long as that is there. None of its blocks may be there yet.
    ///
    /// `done` is called for every node that this completes, beginning with the one given; memory that is no longer needed goes to `spare`.
    pub fn insert(
        &mut self,
        mut first: u64,
        mut size: u64,
        mut sum: Sums,
        spare: &mut Vec<Sums>,
        mut done: impl FnMut(u64, u64, &Sums),
    ) {
        debug_assert!(size.is_power_of_two() && first.is_multiple_of(size));
        debug_assert_eq!(self.gaps(first..first + size), std::slice::from_ref(&(first..first + size)));
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
    pub fn nodes(&self) -> impl ExactSizeIterator<Item = (u64, u64, &Sums)> {
        self.nodes.iter().map(|(first, (blocks, sum))| (*first, *blocks, sum))
    }

    /// The same, by value.
    pub fn into_nodes(self) -> impl ExactSizeIterator<Item = (u64, u64, Sums)> {
        self.nodes.into_iter().map(|(first, (blocks, sum))| (first, blocks, sum))
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
    pub fn total(&self) -> Option<Sums> {
        let mut nodes = self.nodes.values().rev();
        let mut total = nodes.next()?.1.clone();
        for (_, left) in nodes {
            total = left.clone().plus(&total);
        }
        Some(total)
    }
}

/// How many points the convergence record should have.
const SNAPSHOTS: u64 = 128;
/// About the most numbers that the record may hold. With more uncertain vessels it has fewer points.
const MOST_NUMBERS: u64 = 1 << 24;

/// What is finished of a run. The same blocks make the same part, bit for bit, whatever the order in which they were added.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct PartialRun {
    uncertain: Vec<bool>,
    samples: u64,
    /// Blocks between two points of the convergence record, a power of two.
    step: u64,
    sums: DyadicSums,
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

    /// The sums over the blocks that are finished.
    pub fn sums(&self) -> &DyadicSums {
        &self.sums
    }

    /// Adds the sums of a node of so many blocks from `first` on, none of which is finished yet; memory that is no longer needed goes to `spare`.
    pub fn insert(&mut self, first: u64, blocks: u64, sums: Sums, spare: &mut Vec<Sums>) {
        let (uncertain, step, steps) = (&self.uncertain, self.step, &mut self.steps);
        self.sums.insert(first, blocks, sums, spare, |first, blocks, sums| {
            if blocks == step {
                steps.insert(first / step, of_uncertain(&sums.likelihood, uncertain));
            }
        });
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
                let mut both = pair.pop()?;
                add(&mut both, &right);
                Some((at, both))
            };
            self.steps = pairs.into_iter().filter_map(joined).collect();
            self.step *= 2;
        }
    }

    /// The convergence record of a part that is the whole run: L of the uncertain vessels after each step.
    pub fn trace(&self) -> Vec<Snapshot> {
        let (mut so_far, mut trace, mut spare) = (DyadicSums::default(), Vec::new(), Vec::new());
        for (at, likelihood) in &self.steps {
            let step = Sums { likelihood: likelihood.clone(), ..Sums::default() };
            so_far.insert(*at, 1, step, &mut spare, |_, _, _| {});
            let samples = ((at + 1) * self.step * BLOCK).min(self.samples);
            trace.extend(so_far.total().map(|sums| Snapshot { samples, likelihood: sums.likelihood }));
        }
        if !self.blocks().is_multiple_of(self.step)
            && let Some(total) = self.sums.total()
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
