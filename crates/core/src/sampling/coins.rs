//! What decides between vessels of equal resilience: the keys by which forests sort vessels, with a coin for those that tie.

#![expect(clippy::inline_always, reason = "compiled into the caller's instruction set")]

use rand::Rng;

use super::per_sample::PerSample;
use crate::support::simd::{Lanes, Scalar, Simd};
use crate::support::{random, random::stream};

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
