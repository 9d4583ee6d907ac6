//! The maximum spanning forest of resilience, equal to the minimum spanning forest of 1/ρ, by Kruskal's algorithm.

use crate::support::simd::{Lanes, Scalar, Simd, map};

const INDEX_BITS: u32 = 29;
/// A key has room for so many vessels.
pub const MAX_VESSELS: usize = 1 << INDEX_BITS;

/// The sort key of a diffused vessel: ρ rounded to 24 significant bits, then the lower row first.
///
/// Vessels in series with one radius have exactly equal ρ; rounding makes them tie in the computer too, and the rule for
/// ties then makes every algorithm find the same forest. Larger keys come first. Read as the bits of a double the keys
/// are positive, finite and in the same order, for ρ up to an eighth of the largest double.
pub fn key(resilience: f64, vessel: usize) -> u64 {
    keys(Scalar::new(), resilience, vessel).to_bits()
}

/// The [`key`]s of a vessel in several samples, as doubles.
#[expect(clippy::inline_always, reason = "compiled into the caller's instruction set")]
#[inline(always)]
fn keys<S: Simd>(simd: S, resilience: S::f64s, vessel: usize) -> S::f64s {
    let half = simd.splat_u64s(1 << (INDEX_BITS - 1));
    let high = simd.splat_u64s(u64::MAX << INDEX_BITS);
    let index = simd.splat_u64s((MAX_VESSELS - 1 - vessel) as u64);
    let rounded = simd.and_u64s(simd.add_u64s(simd.transmute_u64s_f64s(resilience), half), high);
    simd.transmute_f64s_u64s(simd.or_u64s(rounded, index))
}

/// The [`key`]s of a vessel in a group of samples, as doubles; zero where it is not diffused.
#[expect(clippy::inline_always, reason = "compiled into the caller's instruction set")]
#[inline(always)]
pub fn keys_or_zero<S: Simd, const B: usize>(simd: S, resilience: &Lanes<B>, vessel: usize) -> Lanes<B> {
    let zero = simd.splat_f64s(0.0);
    map(simd, resilience, |rho| simd.select_f64s(simd.greater_than_f64s(rho, zero), keys(simd, rho, vessel), zero))
}

/// The vessel of a [`key`].
#[inline]
pub fn vessel(key: u64) -> usize {
    MAX_VESSELS - 1 - key as usize % MAX_VESSELS
}

/// The rows of the vessels of [`keys_or_zero`], counted from the last of `vessels`, which has row 1; zero for a key of zero.
#[expect(clippy::inline_always, reason = "compiled into the caller's instruction set")]
#[inline(always)]
pub fn rows<S: Simd>(simd: S, keys: S::f64s, vessels: usize) -> S::u64s {
    let (bits, zero) = (simd.transmute_u64s_f64s(keys), simd.splat_u64s(0));
    let index = simd.and_u64s(bits, simd.splat_u64s(MAX_VESSELS as u64 - 1));
    let row = simd.sub_u64s(index, simd.splat_u64s((MAX_VESSELS - 1 - vessels) as u64));
    simd.select_u64s(simd.greater_than_u64s(bits, zero), row, zero)
}

/// The memory of Kruskal's algorithm for one worker.
#[derive(Debug, Clone, Default)]
pub struct Forest {
    keys: Vec<u64>,
    parent: Vec<u32>,
}

impl Forest {
    /// Forgets the vessels of the last sample.
    pub fn clear(&mut self) {
        self.keys.clear();
    }

    /// Adds a diffused vessel by its [`key`].
    pub fn add(&mut self, key: u64) {
        self.keys.push(key);
    }

    /// Calls `take` for each vessel of the maximum spanning forest, largest resilience first.
    pub fn grow(&mut self, nodes: usize, ends: &[[usize; 2]], mut take: impl FnMut(usize)) {
        self.keys.sort_unstable_by(|a, b| b.cmp(a));
        self.parent.clear();
        self.parent.extend(0..nodes as u32);
        for key in &self.keys {
            let vessel = vessel(*key);
            let [a, b] = ends[vessel].map(|node| root(&mut self.parent, node as u32));
            if a != b {
                self.parent[a.max(b) as usize] = a.min(b);
                take(vessel);
            }
        }
    }
}

/// The root of a node's tree, halving the path on the way.
fn root(parent: &mut [u32], mut node: u32) -> u32 {
    while parent[node as usize] != node {
        parent[node as usize] = parent[parent[node as usize] as usize];
        node = parent[node as usize];
    }
    node
}
