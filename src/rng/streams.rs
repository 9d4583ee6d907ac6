//! The streams of a seed: every use of one takes its stream from here, so that no two uses of a command draw the same words.
//!
//! | stream | what draws from it |
//! |---|---|
//! | b | [`occlusion`]: block b of the samples of `infer`, b < 2⁴⁴ |
//! | 2⁶³ + b | [`ends`]: block b of the topologies of `classify`, which may draw samples too |
//! | 2⁴⁸ c + b | [`modulation`]: block b of the instances of class c of `modulate`, c < 12 and b < 2¹⁸ |
//! | 0 | [`ANATOMY`] of a phantom |
//! | 0 | [`DAMAGE`] of a phantom whose anatomy is a table, or a tree of another seed: under one seed both draw the same words |
//! | 1 | [`GAPS`] of a phantom whose anatomy has the same seed |
//! | 2 + a | [`lattice`]: attempt a at the lattice of a phantom with that anatomy |
//!
//! Samples leave bit 63 to the topologies, and a class has room for more blocks than it may have. A command draws from the rows of one of
//! `infer` and `classify`, `modulate`, or `phantom`, so that these may share streams.

/// A block of samples: which vessels are open.
pub fn occlusion(block: u64) -> u64 {
    block
}

/// A block of topologies: where the free ends go on.
pub fn ends(block: u64) -> u64 {
    1 << 63 | block
}

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

/// An attempt at the lattice of a phantom.
pub fn lattice(attempt: u64) -> u64 {
    2 + attempt
}
