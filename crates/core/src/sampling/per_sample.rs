//! One figure for each sample of a block: how many vessels are open, whether blood flows, sums over the samples.

#![expect(clippy::inline_always, reason = "compiled as a whole for each instruction set")]

use crate::support::random::BLOCK;
use crate::support::simd::{Lanes, Simd, masked, plus, splat};

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
pub fn open_vessels<S: Simd>(simd: S, masks: &[u64]) -> PerSample {
    let mut planes = [0_u64; 32];
    let (eights, rest) = masks.as_chunks();
    for [a, b, c, d, e, f, g, h] in eights {
        let pairs = [[a, b], [c, d], [e, f], [g, h]].map(|[a, b]| add_bits(&mut planes[0], *a, *b));
        let fours = [[pairs[0], pairs[1]], [pairs[2], pairs[3]]].map(|[a, b]| add_bits(&mut planes[1], a, b));
        let carry = add_bits(&mut planes[2], fours[0], fours[1]);
        count_bits(&mut planes[3..], carry);
    }
    for mask in rest {
        count_bits(&mut planes, *mask);
    }
    let (mut open, mut worth) = (PerSample::ZERO, splat(simd, 1.0));
    let used = planes.iter().rposition(|plane| *plane != 0).map_or(0, |last| last + 1);
    for plane in &planes[..used] {
        open = plus(simd, &open, &masked(simd, &worth, *plane, 0));
        worth = plus(simd, &worth, &worth);
    }
    open
}

/// Adds two to a plane of bits; returns what is carried to the next one.
#[inline(always)]
fn add_bits(plane: &mut u64, a: u64, b: u64) -> u64 {
    let differ = *plane ^ a;
    let carry = (*plane & a) | (differ & b);
    *plane = differ ^ b;
    carry
}

/// Adds a word to the planes of a count.
#[inline(always)]
fn count_bits(planes: &mut [u64], mut carry: u64) {
    for plane in planes {
        if carry == 0 {
            break;
        }
        (*plane, carry) = (*plane ^ carry, *plane & carry);
    }
}
