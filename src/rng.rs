//! The one generator: ChaCha8, whose stream b of a seed serves block b of the samples.

use rand::SeedableRng;
use rand_chacha::ChaCha8Rng;

/// Samples in one block, drawn together from one stream.
pub const BLOCK: u64 = 64;

/// The generator of block `block` for `seed`: a sample depends on nothing but the seed and its index.
pub fn block_stream(seed: u64, block: u64) -> ChaCha8Rng {
    let mut rng = ChaCha8Rng::seed_from_u64(seed);
    rng.set_stream(block);
    rng
}
