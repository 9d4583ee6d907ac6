//! What decides between vessels of equal resilience: the keys by which forests sort vessels, with a coin for those that tie. And a block of
//! samples that are taken together, with one figure for each of them: how many vessels are open, whether blood flows, sums.

#![expect(clippy::inline_always, reason = "compiled into the caller's instruction set")]

use rand::Rng;

use crate::support::random;
use crate::support::random::{BLOCK, stream};
use crate::support::simd::{Lanes, Scalar, Simd};

/// The bits of a double that are left out when ρ is rounded.
const FREE_BITS: u32 = 29;
/// A key has room for so many vessels.
pub const MAX_VESSELS: usize = 1 << FREE_BITS;
const FREE: u64 = MAX_VESSELS as u64 - 1;

/// ρ to 24 significant bits, the others zero.
pub fn rounded(resilience: f64) -> f64 {
    f64::from_bits((resilience.to_bits() + (1 << (FREE_BITS - 1))) & !FREE)
}

/// The sort keys of the vessels of a network: ρ rounded to 24 significant bits, then a coin, then the vessel.
///
/// Vessels in series with one radius have exactly equal ρ, and so have the two halves of a symmetric circle; rounding makes them tie in the
/// computer too. Then a coin decides, tossed for each vessel in each sample by the seed and the number of the sample alone. So every algorithm finds
/// the same forest, and of equal vessels each is left out as often as any other. The coin is made of the last bits of the product of a random
/// figure of the vessel and one of the sample: as good as independent of those of other vessels and samples. It has the bits that the number of
/// the vessel leaves free; should two be equal (once in 2²² comparisons among a hundred vessels, once in 2⁹ among a million), the lower row comes first.
///
/// Larger keys come first. Read as the bits of a double the keys are positive, finite and in the same order, for ρ up to an eighth of the
/// largest double.
#[derive(Debug, Clone)]
pub struct Coins {
    seed: u64,
    /// A random figure from 1 to 2 for each vessel.
    figure: Vec<f64>,
    /// The bits in which a key has the number of its vessel, counted from the last, which is 1.
    numbers: u64,
}

impl Coins {
    /// The coins of a seed for so many vessels, fewer than [`MAX_VESSELS`].
    pub fn new(vessels: usize, seed: u64) -> Self {
        let mut rng = stream(seed, random::VESSELS_THAT_TIE);
        let figure = (0..vessels).map(|_| figure(rng.next_u64())).collect();
        Self { seed, figure, numbers: (vessels + 1).next_power_of_two() as u64 - 1 }
    }

    /// The figures of the samples of a block.
    pub fn of_block(&self, block: u64) -> PerSample {
        let mut rng = stream(self.seed, random::ties(block));
        let mut out = PerSample::ZERO;
        out.iter_mut().for_each(|out| *out = figure(rng.next_u64()));
        out
    }

    /// The figure of a vessel.
    pub fn of_vessel(&self, vessel: usize) -> f64 {
        self.figure[vessel]
    }

    /// How a vessel compares with others of equal resilience in a sample, given the figures of both: the smaller comes later.
    pub fn toss(&self, of_vessel: f64, of_sample: f64) -> u64 {
        (of_vessel * of_sample).to_bits() & FREE & !self.numbers
    }

    /// The key of a vessel in the sample of a figure.
    pub fn key(&self, resilience: f64, vessel: usize, of_sample: f64) -> u64 {
        let number = (self.figure.len() - vessel) as u64;
        self.keys(Scalar::new(), resilience, self.figure[vessel], of_sample, number).to_bits()
    }

    /// The vessel of a key.
    pub fn vessel(&self, key: u64) -> usize {
        self.figure.len() - self.number_of(key)
    }

    /// The number of the vessel of a key, counted from the last, which is 1.
    pub fn number_of(&self, key: u64) -> usize {
        (key & self.numbers) as usize
    }

    /// The numbers of the vessels of some keys; zero for a key of zero.
    #[inline(always)]
    pub fn numbers<S: Simd>(&self, simd: S, keys: S::f64s) -> S::u64s {
        simd.and_u64s(simd.transmute_u64s_f64s(keys), simd.splat_u64s(self.numbers))
    }

    /// The keys of a vessel in several samples, as doubles, given the figures of both and the vessel's number.
    #[inline(always)]
    fn keys<S: Simd>(&self, simd: S, resilience: S::f64s, of_vessel: S::f64s, of_sample: S::f64s, number: u64) -> S::f64s {
        let half = simd.splat_u64s(1 << (FREE_BITS - 1));
        let rounded = simd.and_u64s(simd.add_u64s(simd.transmute_u64s_f64s(resilience), half), simd.splat_u64s(!FREE));
        let product = simd.transmute_u64s_f64s(simd.mul_f64s(of_vessel, of_sample));
        let coin = simd.and_u64s(product, simd.splat_u64s(FREE & !self.numbers));
        simd.transmute_f64s_u64s(simd.or_u64s(rounded, simd.or_u64s(coin, simd.splat_u64s(number))))
    }

    /// The keys of a vessel of a number in a group of samples, as doubles, zero where it is not diffused; given the figures of both, that of the
    /// vessel in each sample.
    #[inline(always)]
    pub fn keys_or_zero<S: Simd, const B: usize>(
        &self,
        simd: S,
        resilience: &Lanes<B>,
        of_vessel: &Lanes<B>,
        of_samples: &Lanes<B>,
        number: u64,
    ) -> Lanes<B> {
        let (mut out, zero) = (Lanes::ZERO, simd.splat_f64s(0.0));
        let figures = of_vessel.vectors::<S>().iter().zip(of_samples.vectors::<S>());
        for (out, (rho, (of_vessel, of_sample))) in
            out.vectors_mut::<S>().iter_mut().zip(resilience.vectors::<S>().iter().zip(figures))
        {
            let keys = self.keys(simd, *rho, *of_vessel, *of_sample, number);
            *out = simd.select_f64s(simd.greater_than_f64s(*rho, zero), keys, zero);
        }
        out
    }
}

/// A figure from 1 to 2.
fn figure(random: u64) -> f64 {
    f64::from_bits(1.0_f64.to_bits() | random >> 12)
}

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
