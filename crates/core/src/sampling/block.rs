//! A block of samples that are taken together, and the sums over its forests, vessel by vessel.

#![expect(clippy::inline_always, reason = "compiled as a whole for each instruction set")]

use super::batch_forest::InForest;
use super::choose_solver::FULL_GRAPH_LANES as B;
use super::coins::Coins;
use super::likelihood::Sums;
use super::per_sample::{PerSample, SUM_LANES, pairwise};
use crate::support::random::BLOCK;
use crate::support::simd::{Lanes, SampleBits, Simd, masked_by, plus, plus_product};

/// Samples that are taken together.
#[derive(Debug)]
pub struct Block<'a> {
    /// Per vessel the samples in which it is open, then per terminal of the circuit those in which it holds; no bit beyond `samples`. May be
    /// overwritten.
    pub masks: &'a mut [u64],
    /// What each sample counts, for an enumeration; one without.
    pub probability: Option<&'a [f64; BLOCK as usize]>,
    /// What decides between vessels of equal resilience in a sample that is drawn.
    pub coins: &'a Coins,
    /// The figures of the samples for that.
    pub coin: &'a PerSample,
    /// How many samples, at most 64.
    pub samples: usize,
}

/// The forests of a block of a full graph.
#[derive(Debug, Clone, Copy)]
pub struct BlockForests<'a> {
    /// Which vessels each has, one group of samples after another.
    pub in_forest: &'a [InForest<B>],
    /// How many vessels.
    pub vessels: usize,
}

impl BlockForests<'_> {
    /// Sums over all vessels; `value` gives what a vessel contributes to the eight samples from one on.
    #[inline(always)]
    pub fn add_up<S: Simd>(&self, simd: S, value: impl Fn(usize, usize) -> Lanes<SUM_LANES>, sums: &mut Sums) {
        for vessel in 0..self.vessels {
            let word = self.word(vessel);
            let (mut likelihood, mut square) = (Lanes::ZERO, Lanes::ZERO);
            for first in (0..BLOCK as usize).step_by(SUM_LANES) {
                let value = masked_by(simd, &value(vessel, first), &ACROSS, word, first);
                likelihood = plus(simd, &likelihood, &value);
                square = plus_product(simd, &square, &value, &value);
            }
            sums.likelihood[vessel] = pairwise(&likelihood);
            sums.square[vessel] = pairwise(&square);
            sums.count[vessel] = f64::from(word.count_ones());
        }
    }

    /// The samples whose forest has the vessel, as the bits [`ACROSS`] of a word.
    #[inline(always)]
    fn word(&self, vessel: usize) -> u64 {
        let (row, rows) = (self.vessels - vessel, self.vessels + 1);
        let mut word = 0;
        for eight in 0..BLOCK as usize / 8 {
            let samples = self.in_forest[8 * eight / B * rows + row].as_chunks().0[eight % (B / 8)];
            word |= u64::from_le_bytes(samples) & 0x0101_0101_0101_0101 << eight;
        }
        word
    }
}

static ACROSS: SampleBits = SampleBits::ACROSS;
