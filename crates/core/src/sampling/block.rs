//! A block of samples that are taken together.

use super::{Coins, per_sample::PerSample};
use crate::support::random::BLOCK;

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
