//! ε-occlusion: every uncertain vessel is open with probability λA, independently, λ = 1 - ε.

use rand::Rng;

use crate::support::random;
use crate::support::random::{Rows, WideStream, stream};
use crate::support::simd::{InstructionSet, Kernel, Simd};

/// Vessels drawn side by side.
const TOGETHER: usize = 16;
/// Binary digits of the keep probability that are compared for all of them; the rest only where these do not decide.
const DIGITS: usize = Rows::WORDS_OF_64 / TOGETHER;

/// The keep probabilities of a network's vessels.
#[derive(Debug, Clone, PartialEq)]
pub struct Occlusion {
    /// Per vessel the samples in which it is open whatever is drawn: all or none.
    surely: Vec<u64>,
    random: Vec<ChanceVessels>,
    instructions: InstructionSet,
}

/// Vessels that are open by chance.
#[derive(Debug, Clone, PartialEq)]
struct ChanceVessels {
    vessels: Vec<u32>,
    /// The keep probabilities, times 2⁶⁴.
    keep: [u64; TOGETHER],
}

impl Occlusion {
    /// From the keep probability λA of each vessel, in [0, 1]; exact to 2⁻⁶⁴.
    pub fn new(keep: impl IntoIterator<Item = f64>) -> Self {
        let (mut surely, mut chances) = (Vec::new(), Vec::new());
        for (vessel, p) in keep.into_iter().enumerate() {
            surely.push(if p >= 1.0 { u64::MAX } else { 0 });
            if p > 0.0 && p < 1.0 {
                chances.push((vessel as u32, (p * 2_f64.powi(64)) as u64));
            }
        }
        let random = chances.chunks(TOGETHER).map(|some| ChanceVessels {
            vessels: some.iter().map(|(vessel, _)| *vessel).collect(),
            keep: std::array::from_fn(|i| some.get(i).map_or(0, |(_, keep)| *keep)),
        });
        Self { random: random.collect(), surely, instructions: InstructionSet::detect() }
    }

    /// Draws block `block` of `seed`: bit i of word e says whether vessel e is open in sample i of the block.
    pub fn draw(&self, seed: u64, block: u64, masks: &mut Vec<u64>) {
        masks.clone_from(&self.surely);
        self.instructions.run(Draw { occlusion: self, seed, number: random::occlusion(block), masks });
    }
}

struct Draw<'a> {
    occlusion: &'a Occlusion,
    seed: u64,
    /// Of the stream.
    number: u64,
    masks: &'a mut [u64],
}

impl Kernel for Draw<'_> {
    type Output = ();

    /// A uniform fraction per vessel and sample is compared with the keep probability digit by digit, all 64 samples of a
    /// vessel in one word, until every comparison is decided.
    #[expect(clippy::inline_always, reason = "compiled as a whole for each instruction set")]
    #[inline(always)]
    fn with_simd<S: Simd>(self, simd: S) {
        let Self { occlusion, seed, number, masks } = self;
        let (mut wide, mut rows) = (WideStream::new(seed, number), Rows::ZERO);
        // What the first digits leave undecided draws on the words after those that all vessels draw.
        let mut rest = None;
        for together in &occlusion.random {
            wide.next(simd, &mut rows);
            let (mut below, mut open) = ([0; TOGETHER], [0; TOGETHER]);
            compare(simd, &together.keep, &rows, &mut below, &mut open);
            let (mut undecided, mut count) = ([0; TOGETHER], 0);
            for (i, open) in open.iter().enumerate() {
                undecided[count] = i;
                count += usize::from(*open != 0);
            }
            for i in &undecided[..count] {
                let rng = rest.get_or_insert_with(|| {
                    let mut rng = stream(seed, number);
                    rng.set_word_pos(2 * (Rows::WORDS_OF_64 * occlusion.random.len()) as u128);
                    rng
                });
                below[*i] |= decide(together.keep[*i], open[*i], rng);
            }
            for (vessel, below) in together.vessels.iter().zip(&below) {
                masks[*vessel as usize] = *below;
            }
        }
    }
}

/// Compares the first digits: the samples that are below the keep probability, and those that are still open.
#[expect(clippy::inline_always, reason = "compiled as a whole for each instruction set")]
#[inline(always)]
fn compare<S: Simd>(simd: S, keep: &[u64; TOGETHER], rows: &Rows, below: &mut [u64; TOGETHER], open: &mut [u64; TOGETHER]) {
    let words = words(rows);
    let parts = S::as_simd_u64s(keep).0.iter().zip(S::as_mut_simd_u64s(below).0).zip(S::as_mut_simd_u64s(open).0);
    for (part, ((keep, below), open)) in parts.enumerate() {
        let (none, all) = (simd.splat_u64s(0), simd.splat_u64s(u64::MAX));
        let (mut under, mut undecided) = (none, all);
        for (digit, random) in words.iter().enumerate() {
            let bit = simd.splat_u64s(1 << (63 - digit));
            let set = simd.equal_u64s(simd.and_u64s(*keep, bit), bit);
            let random = S::as_simd_u64s(random).0[part];
            let zeros = simd.and_u64s(undecided, simd.not_u64s(random));
            let ones = simd.and_u64s(undecided, random);
            under = simd.or_u64s(under, simd.select_u64s(set, zeros, none));
            undecided = simd.select_u64s(set, ones, zeros);
        }
        (*below, *open) = (under, undecided);
    }
}

/// The random words, one for each vessel of each digit.
#[expect(clippy::inline_always, reason = "compiled as a whole for each instruction set")]
#[inline(always)]
fn words(rows: &Rows) -> [[u64; TOGETHER]; DIGITS] {
    let (mut out, flat) = ([[0; TOGETHER]; DIGITS], rows.0.as_flattened());
    for (word, [low, high]) in out.as_flattened_mut().iter_mut().zip(flat.as_chunks().0) {
        *word = u64::from(*high) << 32 | u64::from(*low);
    }
    out
}

/// The samples of `open` that are below the keep probability by the digits after the first ones, one word each.
fn decide(keep: u64, mut open: u64, rng: &mut impl Rng) -> u64 {
    let mut below = 0;
    while open != 0 {
        let sample = open & open.wrapping_neg();
        below |= if rng.next_u64() < keep << DIGITS { sample } else { 0 };
        open ^= sample;
    }
    below
}
