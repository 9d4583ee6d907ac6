//! The one generator: ChaCha8, whose seeds have 2⁶⁴ streams each.

use rand::SeedableRng;
use rand_chacha::ChaCha8Rng;

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
