//! The one generator: ChaCha8, whose seeds have 2⁶⁴ streams each.

#![expect(clippy::inline_always, reason = "compiled as a whole for each instruction set")]

use rand::SeedableRng;
use rand_chacha::ChaCha8Rng;

use super::simd::Simd;

/// Samples in one block, drawn together from one stream.
pub const BLOCK: u64 = 64;

/// Random numbers of a stream.
pub type RandomStream = ChaCha8Rng;

/// A stream of a seed, as the functions below number them: what it draws depends on these two numbers alone.
pub fn stream(seed: u64, stream: u64) -> RandomStream {
    let mut rng = ChaCha8Rng::seed_from_u64(seed);
    rng.set_stream(stream);
    rng
}

/// How many 64-byte blocks of the cipher are computed side by side.
const SIDE_BY_SIDE: usize = 16;
/// Words (32 bits) of one of the cipher's blocks.
const WORDS: usize = 16;

/// Consecutive blocks of the cipher, word by word: `rows[w][i]` is word w of block i.
#[derive(Debug, Clone, PartialEq, Eq)]
#[repr(C, align(64))]
pub struct Rows(pub [[u32; SIDE_BY_SIDE]; WORDS]);

impl Rows {
    /// Random words of 64 bits that one of these holds.
    pub const WORDS_OF_64: usize = WORDS * SIDE_BY_SIDE / 2;

    /// No words drawn yet.
    pub const ZERO: Self = Self([[0; SIDE_BY_SIDE]; WORDS]);
}

/// What [`stream`] draws, many words at a time.
#[derive(Debug, Clone)]
pub struct WideStream {
    /// The cipher's first block as it goes in: constants, key, counter, stream.
    state: [u32; WORDS],
}

impl WideStream {
    /// The stream from its start.
    pub fn new(seed: u64, stream: u64) -> Self {
        let key = ChaCha8Rng::seed_from_u64(seed).get_seed();
        let mut state = [
            0x6170_7865,
            0x3320_646e,
            0x7962_2d32,
            0x6b20_6574,
            0,
            0,
            0,
            0,
            0,
            0,
            0,
            0,
            0,
            0,
            stream as u32,
            (stream >> 32) as u32,
        ];
        for (word, bytes) in state[4..12].iter_mut().zip(key.as_chunks().0) {
            *word = u32::from_le_bytes(*bytes);
        }
        Self { state }
    }

    /// The next sixteen blocks of the cipher.
    #[inline(always)]
    pub fn next<S: Simd>(&mut self, simd: S, rows: &mut Rows) {
        const COUNTING: [u32; SIDE_BY_SIDE] = [0, 1, 2, 3, 4, 5, 6, 7, 8, 9, 10, 11, 12, 13, 14, 15];
        for (part, counting) in S::as_simd_u32s(&COUNTING).0.iter().enumerate() {
            let mut start = [simd.splat_u32s(0); WORDS];
            for (start, word) in start.iter_mut().zip(&self.state) {
                *start = simd.splat_u32s(*word);
            }
            // The counter is a multiple of sixteen: nothing is carried.
            start[12] = simd.add_u32s(start[12], *counting);
            let mut x = start;
            for _ in 0..4 {
                quarter(simd, &mut x, [0, 4, 8, 12]);
                quarter(simd, &mut x, [1, 5, 9, 13]);
                quarter(simd, &mut x, [2, 6, 10, 14]);
                quarter(simd, &mut x, [3, 7, 11, 15]);
                quarter(simd, &mut x, [0, 5, 10, 15]);
                quarter(simd, &mut x, [1, 6, 11, 12]);
                quarter(simd, &mut x, [2, 7, 8, 13]);
                quarter(simd, &mut x, [3, 4, 9, 14]);
            }
            for (word, row) in rows.0.iter_mut().enumerate() {
                S::as_mut_simd_u32s(row).0[part] = simd.add_u32s(x[word], start[word]);
            }
        }
        let counter = (u64::from(self.state[13]) << 32 | u64::from(self.state[12])) + SIDE_BY_SIDE as u64;
        [self.state[12], self.state[13]] = [counter as u32, (counter >> 32) as u32];
    }
}

/// The cipher's quarter round.
#[inline(always)]
fn quarter<S: Simd>(simd: S, x: &mut [S::u32s; WORDS], [a, b, c, d]: [usize; 4]) {
    x[a] = simd.add_u32s(x[a], x[b]);
    x[d] = turned(simd, simd.xor_u32s(x[d], x[a]), 16);
    x[c] = simd.add_u32s(x[c], x[d]);
    x[b] = turned(simd, simd.xor_u32s(x[b], x[c]), 12);
    x[a] = simd.add_u32s(x[a], x[b]);
    x[d] = turned(simd, simd.xor_u32s(x[d], x[a]), 8);
    x[c] = simd.add_u32s(x[c], x[d]);
    x[b] = turned(simd, simd.xor_u32s(x[b], x[c]), 7);
}

/// The bits of each word turned to the left.
#[inline(always)]
fn turned<S: Simd>(simd: S, x: S::u32s, bits: u32) -> S::u32s {
    let left = simd.wrapping_dyn_shl_u32s(x, simd.splat_u32s(bits));
    simd.or_u32s(left, simd.wrapping_dyn_shr_u32s(x, simd.splat_u32s(32 - bits)))
}

/// A block of samples: which vessels are open.
pub fn occlusion(block: u64) -> u64 {
    block
}

/// A block of topologies: where the free ends go on.
pub fn ends(block: u64) -> u64 {
    1 << 63 | block
}

/// A block of samples: which of equal vessels come first.
pub fn ties(block: u64) -> u64 {
    3 << 62 | block
}

/// The vessels of a network, for the same.
pub const VESSELS_THAT_TIE: u64 = u64::MAX;

/// A block of instances of the class in a place among the classes.
pub fn modulation(class: usize, block: u64) -> u64 {
    ((class as u64) << 48) + block
}

/// The anatomy of a phantom.
pub const ANATOMY: u64 = 0;

/// What breaks up a phantom.
pub const DAMAGE: u64 = 0;

/// The gaps of a phantom, so that a broken one is the whole one of the same seed, broken.
pub const GAPS: u64 = 1;

/// The veins beside the arteries in the mask of a phantom.
pub const VEINS: u64 = 1 << 62;

/// The signal along the vessels of a phantom.
pub const SIGNAL: u64 = VEINS + 1;

/// The noise of the image of a phantom.
pub const NOISE: u64 = VEINS + 2;

/// An attempt at the lattice of a phantom.
pub fn lattice(attempt: u64) -> u64 {
    2 + attempt
}
