//! ε-occlusion: every vessel on trial is open with probability λA, independently, λ = 1 - ε.

use rand::Rng;

use crate::rng::block_stream;

/// The keep probabilities of a network's vessels.
#[derive(Debug, Clone, PartialEq)]
pub struct Occlusion {
    keep: Vec<Keep>,
}

/// When a vessel is open.
#[derive(Debug, Clone, Copy, PartialEq)]
enum Keep {
    Always,
    Never,
    /// With probability `bits` / 2⁶⁴.
    Random {
        bits: u64,
    },
}

impl Occlusion {
    /// From the keep probability λA of each vessel, in [0, 1]; exact to 2⁻⁶⁴.
    pub fn new(keep: impl IntoIterator<Item = f64>) -> Self {
        let keep = keep.into_iter().map(|p| match p {
            p if p >= 1.0 => Keep::Always,
            p if p > 0.0 => Keep::Random { bits: (p * 2_f64.powi(64)) as u64 },
            _ => Keep::Never,
        });
        Self { keep: keep.collect() }
    }

    /// Draws block `block` of `seed`: bit i of word e says whether vessel e is open in sample i of the block.
    pub fn draw(&self, seed: u64, block: u64, masks: &mut Vec<u64>) {
        let mut rng = block_stream(seed, block);
        masks.clear();
        masks.extend(self.keep.iter().map(|keep| match *keep {
            Keep::Always => u64::MAX,
            Keep::Never => 0,
            Keep::Random { bits } => bernoulli(bits, &mut rng),
        }));
    }
}

/// 64 independent bits, each set with probability `bits` / 2⁶⁴: a uniform fraction per bit is compared with the
/// threshold digit by digit, all 64 side by side, until every comparison is decided.
fn bernoulli(bits: u64, rng: &mut impl Rng) -> u64 {
    let (mut below, mut open) = (0, u64::MAX);
    for digit in (bits.trailing_zeros()..64).rev() {
        let random = rng.next_u64();
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
