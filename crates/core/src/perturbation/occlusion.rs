//! ε-occlusion: every uncertain vessel is open with probability λA, independently, λ = 1 - ε.

use rand::Rng;

use crate::support::random::{self, RandomStream, stream};

/// Vessels that draw on the same words.
const TOGETHER: usize = 16;
/// Binary digits of the keep probability that are compared for all vessels; the rest only where these do not decide.
const DIGITS: usize = 8;
/// Words of 32 bits that vessels draw together, two for each digit of each.
const WORDS: usize = 2 * TOGETHER * DIGITS;

/// The keep probabilities of a network's vessels.
#[derive(Debug, Clone, PartialEq)]
pub struct Occlusion {
    /// Per vessel the samples in which it is open whatever is drawn: all or none.
    surely: Vec<u64>,
    /// Vessels that are open by chance, with their keep probabilities, times 2⁶⁴.
    random: Vec<(u32, u64)>,
}

impl Occlusion {
    /// From the keep probability λA of each vessel, in [0, 1]; exact to 2⁻⁶⁴.
    pub fn new(keep: impl IntoIterator<Item = f64>) -> Self {
        let (mut surely, mut random) = (Vec::new(), Vec::new());
        for (vessel, p) in keep.into_iter().enumerate() {
            surely.push(if p >= 1.0 { u64::MAX } else { 0 });
            if p > 0.0 && p < 1.0 {
                random.push((vessel as u32, (p * 2_f64.powi(64)) as u64));
            }
        }
        Self { surely, random }
    }

    /// Draws block `block` of `seed`: bit i of word e says whether vessel e is open in sample i of the block.
    ///
    /// A uniform fraction per vessel and sample is compared with the keep probability digit by digit, all 64 samples of a vessel in one word,
    /// until every comparison is decided.
    pub fn draw(&self, seed: u64, block: u64, masks: &mut Vec<u64>) {
        masks.clone_from(&self.surely);
        let number = random::occlusion(block);
        let mut rng = stream(seed, number);
        // What the first digits leave undecided draws on the words after those that all vessels draw.
        let mut rest = None;
        for together in self.random.chunks(TOGETHER) {
            let words = words(&mut rng);
            for (at, (vessel, keep)) in together.iter().enumerate() {
                let (mut below, mut open) = (0, u64::MAX);
                for (digit, words) in words.iter().enumerate() {
                    let (zeros, ones) = (open & !words[at], open & words[at]);
                    let is_set = keep >> (63 - digit) & 1 == 1;
                    below |= if is_set { zeros } else { 0 };
                    open = if is_set { ones } else { zeros };
                }
                if open != 0 {
                    let rng = rest.get_or_insert_with(|| {
                        let mut rng = stream(seed, number);
                        rng.set_word_pos((WORDS * self.random.len().div_ceil(TOGETHER)) as u128);
                        rng
                    });
                    below |= decide(*keep, open, rng);
                }
                masks[*vessel as usize] = below;
            }
        }
    }
}

/// The next random words, one for each vessel of each digit. Their order is that in which sixteen blocks of the cipher, of sixteen words each,
/// are computed side by side: the first words of all blocks come first.
fn words(rng: &mut RandomStream) -> [[u64; TOGETHER]; DIGITS] {
    let mut bytes = [0; 4 * WORDS];
    rng.fill_bytes(&mut bytes);
    let drawn = bytes.as_chunks().0;
    let half = |at: usize| u64::from(u32::from_le_bytes(drawn[at % 16 * 16 + at / 16]));
    let word = |at: usize| half(2 * at + 1) << 32 | half(2 * at);
    std::array::from_fn(|digit| std::array::from_fn(|vessel| word(digit * TOGETHER + vessel)))
}

/// The samples of `open` that are below the keep probability by the digits after the first ones, one word each.
fn decide(keep: u64, mut open: u64, rng: &mut RandomStream) -> u64 {
    let mut below = 0;
    while open != 0 {
        let sample = open & open.wrapping_neg();
        below |= if rng.next_u64() < keep << DIGITS { sample } else { 0 };
        open ^= sample;
    }
    below
}
