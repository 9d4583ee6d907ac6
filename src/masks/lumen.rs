//! Which voxel of the skeleton each voxel of the lumen belongs to.

use std::cmp::Reverse;
use std::collections::BinaryHeap;

use super::foreground::{Foreground, neighbours};
use crate::support::geometry::{Point, norm_squared};

/// A voxel that belongs to no seed.
pub const NONE: u32 = u32::MAX;
/// The bit of a voxel whose seed is settled.
const SETTLED: u32 = 1 << 31;

/// For each voxel of the vessels the seed that is nearest, among those that its neighbours belong to: the row in `seeds`; [`NONE`] where
/// no seed is in the same component. Ties go to the earlier seed. `steps` are the vectors of one voxel along each axis.
pub fn nearest_seeds(vessels: &Foreground, seeds: &[u32], steps: [Point; 3]) -> Vec<u32> {
    let around = neighbours(vessels.strides());
    let indices = |place: usize| vessels.voxel_at(place).map(|index| index as f64);
    let seeds: Vec<(usize, [f64; 3])> =
        seeds.iter().map(|row| vessels.place(*row as usize)).map(|place| (place, indices(place))).collect();
    let apart = |at: [f64; 3], seed: u32| {
        let (_, from) = seeds[seed as usize];
        let by = [0, 1, 2].map(|axis| at[axis] - from[axis]);
        norm_squared([0, 1, 2].map(|row| (0..3).map(|axis| steps[axis][row] * by[axis]).sum()))
    };
    // The nearest seed so far of each voxel, or the settled one.
    let mut best = vec![NONE; vessels.len()];
    // Lengths are not negative, so that their bits are in their order.
    let mut open: BinaryHeap<Reverse<(u64, u32, u32)>> =
        (0_u32..).zip(&seeds).map(|(seed, (place, _))| Reverse((0, seed, *place as u32))).collect();
    while let Some(Reverse((_, seed, place))) = open.pop() {
        let place = place as usize;
        let Some(voxel) = vessels.row(place).filter(|row| best[*row] == NONE || best[*row] & SETTLED == 0) else { continue };
        best[voxel] = seed | SETTLED;
        let here = indices(place);
        for (step, by) in around {
            let next = (place as isize + step) as usize;
            let Some(row) = vessels.row(next) else { continue };
            let known = best[row];
            if known == seed || (known != NONE && known & SETTLED != 0) {
                continue;
            }
            let at = [0, 1, 2].map(|axis| here[axis] + f64::from(by[axis]));
            let nearer = (apart(at, seed).to_bits(), seed);
            if known == NONE || nearer < (apart(at, known).to_bits(), known) {
                best[row] = seed;
                open.push(Reverse((nearer.0, seed, next as u32)));
            }
        }
    }
    best.iter_mut().filter(|seed| **seed != NONE).for_each(|seed| *seed &= !SETTLED);
    best
}
