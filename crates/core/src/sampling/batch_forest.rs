//! The maximum spanning forest of many samples at once, by elimination over the (max, min) semiring.
//!
//! Eliminating node k joins its neighbours i and j by the path through k, whose narrowest vessel is min(m_ki, m_kj). The widest vessel at k
//! belongs to the forest (Borůvka). All paths from k to its other neighbours lead through that vessel, so the remaining vessels of the forest
//! are the forest of the remaining graph. The low bits of a key ([`Coins`]) name its vessel, so one pass through the order finds the whole forest.
//! Maxima and minima only select: the answer is exact, and there is no sort and no branch.

#![expect(clippy::inline_always, reason = "compiled as a whole for each instruction set")]

use super::Coins;
use crate::support::elimination::Elimination;
use crate::support::simd::{Lanes, Simd, zip};

/// The compiled elimination of a graph's forests.
#[derive(Debug, Clone)]
pub struct ForestProgram {
    program: Elimination,
    /// Per ray the vessels whose keys go there.
    vessels_of: Vec<Vec<u32>>,
}

/// Whether a vessel is in the forest of each sample of a group: zero or 255. A list of these begins with one that means nothing; then come
/// the vessels, the last one first.
pub type InForest<const B: usize> = [u8; B];
/// The mark of a vessel that is in the forest.
pub const IN_FOREST: u8 = u8::MAX;

impl ForestProgram {
    /// Orders and compiles; `None` when it would take more than `limit` joins a sample. `None` among the ends is a vessel
    /// that is in no forest.
    pub fn compile(nodes: usize, ends: &[Option<[usize; 2]>], limit: usize) -> Option<Self> {
        let links: Vec<[usize; 2]> = ends.iter().flatten().copied().collect();
        let program = Elimination::compile(nodes, &links, limit)?;
        let links = (0..).zip(ends).filter_map(|(vessel, ends)| Some((vessel, ends.filter(|[a, b]| a != b)?)));
        let vessels_of = program.rows_by_ray(links.map(|(vessel, ends)| (vessel, ends.map(|node| program.place(node)))));
        Some(Self { program, vessels_of })
    }

    /// The joins of one sample: the length of the program.
    pub fn joins(&self) -> usize {
        self.program.joins()
    }

    /// How many rays there are: the length of the memory that a forest takes.
    pub fn rays(&self) -> usize {
        self.program.rays()
    }

    /// Per ray the vessels whose keys are put there: the larger ones, zero without any.
    pub fn vessels_of(&self) -> &[Vec<u32>] {
        &self.vessels_of
    }

    /// Grows the forests of the keys that were put in and marks their vessels.
    #[inline(always)]
    pub fn grow<S: Simd, const B: usize>(&self, simd: S, coins: &Coins, widest: &mut [Lanes<B>], taken: &mut [InForest<B>]) {
        for k in 0..self.program.nodes() {
            let star = self.program.star(k);
            let (done, later) = widest.split_at_mut(star.end);
            let mut mesh = self.program.mesh(k).iter();
            let rays = &done[star.clone()];
            let mut best = Lanes::ZERO;
            for (i, a) in rays.iter().enumerate() {
                best = wider(simd, &best, a);
                for (b, target) in rays[i + 1..].iter().zip(&mut mesh) {
                    let m = &mut later[*target as usize - star.end];
                    *m = wider(simd, m, &narrower(simd, a, b));
                }
            }
            take(simd, coins, &best, taken);
        }
    }
}

/// Marks the vessels of the keys, one a lane.
#[inline(always)]
fn take<S: Simd, const B: usize>(simd: S, coins: &Coins, keys: &Lanes<B>, taken: &mut [InForest<B>]) {
    let taken = taken.as_flattened_mut();
    let mut at = [0; B];
    for (i, (at, keys)) in S::as_mut_simd_u64s(&mut at).0.iter_mut().zip(keys.vectors::<S>()).enumerate() {
        let mut row = coins.numbers(simd, *keys);
        for _ in 0..B.ilog2() {
            row = simd.add_u64s(row, row);
        }
        *at = simd.add_u64s(row, S::as_simd_u64s(&LANE).0[i]);
    }
    for at in at {
        taken[at as usize] = IN_FOREST;
    }
}

/// The numbers of the lanes.
static LANE: [u64; 32] =
    [0, 1, 2, 3, 4, 5, 6, 7, 8, 9, 10, 11, 12, 13, 14, 15, 16, 17, 18, 19, 20, 21, 22, 23, 24, 25, 26, 27, 28, 29, 30, 31];

/// The larger of two, lane by lane.
#[inline(always)]
pub fn wider<S: Simd, const B: usize>(simd: S, a: &Lanes<B>, b: &Lanes<B>) -> Lanes<B> {
    zip(simd, a, b, |a, b| if S::IS_SCALAR { simd.select_f64s(simd.greater_than_f64s(a, b), a, b) } else { simd.max_f64s(a, b) })
}

/// The smaller of two, lane by lane.
#[inline(always)]
fn narrower<S: Simd, const B: usize>(simd: S, a: &Lanes<B>, b: &Lanes<B>) -> Lanes<B> {
    zip(simd, a, b, |a, b| if S::IS_SCALAR { simd.select_f64s(simd.less_than_f64s(a, b), a, b) } else { simd.min_f64s(a, b) })
}
