//! The conductances of a circuit's rows in several samples side by side.

#![expect(clippy::inline_always, reason = "compiled as a whole for each instruction set")]

use crate::support::simd::{Lanes, Simd, masked, splat};

/// The conductance of each row of a circuit in each of `B` samples, m³/(Pa s); zero where the row is closed.
pub trait Conductances<const B: usize> {
    /// Those of a row.
    fn of_row<S: Simd>(&self, simd: S, row: usize) -> Lanes<B>;

    /// Whether a row is open in a sample.
    fn is_open(&self, row: usize, lane: usize) -> bool;
}

impl<const B: usize> Conductances<B> for Vec<Lanes<B>> {
    #[inline(always)]
    fn of_row<S: Simd>(&self, _: S, row: usize) -> Lanes<B> {
        self[row]
    }

    fn is_open(&self, row: usize, lane: usize) -> bool {
        self[row][lane] > 0.0
    }
}

/// The rows of a circuit in the samples of a block from one on.
#[derive(Debug, Clone, Copy)]
pub struct MaskedRows<'a> {
    /// Where a row is open, m³/(Pa s).
    pub conductance: &'a [f64],
    /// Per row in which samples of the block it is open, as bits.
    pub masks: &'a [u64],
    /// The first sample of the group.
    pub first: usize,
}

impl<const B: usize> Conductances<B> for MaskedRows<'_> {
    #[inline(always)]
    fn of_row<S: Simd>(&self, simd: S, row: usize) -> Lanes<B> {
        masked(simd, &splat(simd, self.conductance[row]), self.masks[row], self.first)
    }

    fn is_open(&self, row: usize, lane: usize) -> bool {
        self.conductance[row] > 0.0 && self.masks[row] >> (self.first + lane) & 1 == 1
    }
}
