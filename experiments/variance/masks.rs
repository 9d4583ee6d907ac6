//! Ways to draw the masks of the samples: bit i of word e says whether vessel e is open in sample i of a block of 64.
//!
//! Whatever the way, each bit alone is open with exactly the vessel's keep probability, so L stays unbiased. The net
//! and the arrays need, besides the block's own stream, what their group of blocks shares.

use rand::Rng;
use willis::internals::perturbation::Occlusion;
use willis::internals::support::random::stream;

use crate::array::{Array, Shape};

/// Digits of a level of the net; its points come in groups of 2 to this power.
const DIGITS: usize = 10;
/// Streams from here on serve the groups of the net.
const GROUPS: u64 = 1 << 40;

#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Scheme {
    /// Independent bits, as `willis infer`.
    Plain,
    /// Sample i + 32 of a block compares 1 - U where sample i compares U.
    Antithetic,
    /// As many of the 64 bits open as the keep probability asks for, rounded at random, in a random place.
    Stratified,
    /// U = (permutation(i) + u) / 64 per vessel.
    Latin,
    /// A digital net of 1,024 points: Sobol' sequences with random direction numbers, linear scrambling, random shift.
    Net,
    /// An orthogonal array.
    Array(Shape),
}

impl Scheme {
    pub fn name(self) -> String {
        match self {
            Self::Plain => "plain".into(),
            Self::Antithetic => "antithetic halves of a block".into(),
            Self::Stratified => "stratified counts in a block".into(),
            Self::Latin => "Latin hypercube of a block".into(),
            Self::Net => "scrambled net of 1024".into(),
            Self::Array(shape) => format!("orthogonal array of {}^{}", shape.levels, shape.digits),
        }
    }

    /// Samples of one replicate.
    pub fn samples(self) -> u64 {
        if let Self::Array(shape) = self { shape.samples() } else { 1 << DIGITS }
    }
}

/// The masks of one seed.
pub struct Masks<'a> {
    scheme: Scheme,
    keep: &'a [f64],
    occlusion: Occlusion,
    seed: u64,
    group: Option<u64>,
    sequences: Vec<Sequence>,
    array: Option<Array>,
}

/// One coordinate of the net.
struct Sequence {
    columns: [u16; DIGITS],
    shift: u16,
    /// Levels below are open.
    open: u16,
}

impl<'a> Masks<'a> {
    pub fn new(scheme: Scheme, keep: &'a [f64], seed: u64) -> Self {
        let occlusion = Occlusion::new(keep.iter().copied());
        let array = if let Scheme::Array(shape) = scheme { Some(Array::new(shape, keep, seed)) } else { None };
        Self { scheme, keep, occlusion, seed, group: None, sequences: Vec::new(), array }
    }

    /// Draws block `block`.
    pub fn draw(&mut self, block: u64, masks: &mut Vec<u64>) {
        if self.scheme == Scheme::Plain {
            return self.occlusion.draw(self.seed, block, masks);
        }
        if let Some(array) = &self.array {
            return array.draw(self.seed, block, masks);
        }
        masks.clear();
        if self.scheme == Scheme::Net {
            self.prepare_group(block >> (DIGITS - 6));
            return masks.extend(self.sequences.iter().map(|s| s.bits(block)));
        }
        let mut rng = stream(self.seed, block);
        masks.extend(self.keep.iter().map(|keep| match self.scheme {
            Scheme::Antithetic => antithetic(*keep, &mut rng),
            Scheme::Stratified => stratified(*keep, &mut rng),
            _ => latin(*keep, &mut rng),
        }));
    }

    fn prepare_group(&mut self, group: u64) {
        if self.group != Some(group) {
            let mut rng = stream(self.seed, GROUPS + group);
            self.sequences = self.keep.iter().map(|keep| Sequence::random(*keep, &mut rng)).collect();
            self.group = Some(group);
        }
    }
}

fn uniform(rng: &mut impl Rng) -> f64 {
    (rng.next_u64() >> 11) as f64 * 2_f64.powi(-53)
}

/// `keep` of `count`, rounded up with the probability of its fraction.
fn rounded(keep: f64, count: u32, rng: &mut impl Rng) -> u32 {
    let mean = keep * f64::from(count);
    mean as u32 + u32::from(uniform(rng) < mean.fract())
}

/// The digit-by-digit comparison of willis' plain masks, on digits that the upper half has complemented: U and 1 - U.
fn antithetic(keep: f64, rng: &mut impl Rng) -> u64 {
    let bits = (keep * 2_f64.powi(64)) as u64;
    if keep >= 1.0 {
        return u64::MAX;
    }
    let (mut below, mut open) = (0, u64::MAX);
    for digit in (bits.trailing_zeros()..64).rev() {
        let half = rng.next_u64() & u64::from(u32::MAX);
        let random = half | !half << 32;
        if bits >> digit & 1 == 1 {
            below |= open & !random;
            open &= random;
        } else {
            open &= !random;
        }
        if open == 0 {
            break;
        }
    }
    below
}

/// The rarer kind of bit is placed by drawing places of six digits until there are enough different ones.
fn stratified(keep: f64, rng: &mut impl Rng) -> u64 {
    let open = rounded(keep, 64, rng);
    let fewer = open.min(64 - open);
    let (mut set, mut places, mut left) = (0_u64, 0, 0);
    while set.count_ones() < fewer {
        if left == 0 {
            (places, left) = (rng.next_u64(), 10);
        }
        set |= 1 << (places & 63);
        (places, left) = (places >> 6, left - 1);
    }
    if open == fewer { set } else { !set }
}

/// The hypercube as the textbook has it.
fn latin(keep: f64, rng: &mut impl Rng) -> u64 {
    let mut strata: [u32; 64] = std::array::from_fn(|i| i as u32);
    for last in (1..64_usize).rev() {
        let other = (u64::from(rng.next_u64() as u32) * (last as u64 + 1)) >> 32;
        strata.swap(last, other as usize);
    }
    strata.iter().enumerate().fold(0, |mask, (i, stratum)| {
        let u = (f64::from(*stratum) + uniform(rng)) / 64.0;
        mask | u64::from(u < keep) << i
    })
}

impl Sequence {
    fn random(keep: f64, rng: &mut impl Rng) -> Self {
        let all: u16 = (1 << DIGITS) - 1;
        // The first digit is the highest bit; above(k) are the digits before digit k.
        let digit = |k: usize| 1_u16 << (DIGITS - 1 - k);
        let above = |k: usize| all & !((digit(k) << 1) - 1);
        let rows: [u16; DIGITS] = std::array::from_fn(|k| digit(k) | rng.next_u64() as u16 & above(k));
        let columns = std::array::from_fn(|k| {
            let direction = digit(k) | rng.next_u64() as u16 & above(k);
            (0..DIGITS).filter(|r| (direction & rows[*r]).count_ones() % 2 == 1).fold(0, |word, r| word | digit(r))
        });
        let open = rounded(keep, 1 << DIGITS, rng) as u16;
        Self { columns, shift: rng.next_u64() as u16 & all, open }
    }

    fn bits(&self, block: u64) -> u64 {
        let mut levels = [self.shift; 64];
        for (k, column) in self.columns.iter().enumerate().skip(6) {
            levels[0] ^= if block >> (k - 6) & 1 == 1 { *column } else { 0 };
        }
        for i in 1..64_usize {
            levels[i] = levels[i & (i - 1)] ^ self.columns[i.trailing_zeros() as usize];
        }
        levels.iter().enumerate().fold(0, |mask, (i, level)| mask | u64::from(*level < self.open) << i)
    }
}
