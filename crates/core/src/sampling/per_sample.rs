//! One figure for each sample of a block: how many vessels are open, whether blood flows, sums over the samples.

#![expect(clippy::inline_always, reason = "compiled as a whole for each instruction set")]

use crate::support::{random::BLOCK, simd::Lanes};

/// Sums are kept in so many lanes, whatever the width of a group: no bit depends on the width.
pub const SUM_LANES: usize = 8;
/// One figure for each sample of a block.
pub type PerSample = Lanes<{ BLOCK as usize }>;

/// The sum of `values` over the samples, each times its probability where there is one.
pub fn expectation(values: &PerSample, probability: Option<&[f64; BLOCK as usize]>) -> f64 {
    let mut lanes = [0.0; SUM_LANES];
    for (sample, value) in values.iter().enumerate() {
        lanes[sample % SUM_LANES] += value * probability.map_or(1.0, |p| p[sample]);
    }
    pairwise(&lanes)
}

/// One of each sample with a `global` resilience above zero: blood flows in it.
pub fn perfused(global: &PerSample) -> PerSample {
    let mut flows = PerSample::ZERO;
    for (flows, global) in flows.iter_mut().zip(global.iter()) {
        *flows = if *global > 0.0 { 1.0 } else { 0.0 };
    }
    flows
}

/// The next figures of a group or block.
#[inline(always)]
pub fn part<const N: usize>(values: &[f64], first: usize) -> Lanes<N> {
    let mut out = Lanes::ZERO;
    out.copy_from_slice(&values[first..first + N]);
    out
}

/// The sum of the lanes, pairwise.
pub fn pairwise(lanes: &[f64; SUM_LANES]) -> f64 {
    let [a, b, c, d, e, f, g, h] = lanes;
    ((a + e) + (c + g)) + ((b + f) + (d + h))
}

/// The number of words in which the bit of each sample is set.
#[inline(always)]
pub fn open_vessels(masks: &[u64]) -> PerSample {
    let mut open = PerSample::ZERO;
    // One shift for all words at a time, which any processor does for several of them at once.
    for (sample, open) in open.iter_mut().enumerate() {
        *open = masks.iter().map(|mask| mask >> sample & 1).sum::<u64>() as f64;
    }
    open
}
