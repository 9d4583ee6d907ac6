//! Which voxel of the skeleton each voxel of the lumen belongs to.

use std::cmp::Reverse;
use std::collections::BinaryHeap;

use super::foreground::{Foreground, neighbours};
use crate::support::geometry::{Point, norm_squared};

/// For each voxel of the vessels the seed that is nearest, among those that its neighbours belong to: the row in `seeds`; `None` where
/// no seed is in the same component. Ties go to the earlier seed. `steps` are the vectors of one voxel along each axis.
pub fn nearest_seeds(vessels: &Foreground, seeds: &[u32], steps: [Point; 3]) -> Vec<Option<u32>> {
    let around = neighbours(vessels.strides());
    let mut of: Vec<Option<u32>> = vec![None; vessels.len()];
    let mut best: Vec<(u64, u32)> = vec![(u64::MAX, u32::MAX); vessels.len()];
    let apart = |voxel: usize, seed: u32| {
        let (a, b) = (vessels.voxel(voxel), vessels.voxel(seeds[seed as usize] as usize));
        let by = [0, 1, 2].map(|axis| a[axis] as f64 - b[axis] as f64);
        norm_squared([0, 1, 2].map(|row| (0..3).map(|axis| steps[axis][row] * by[axis]).sum()))
    };
    // Lengths are not negative, so that their bits are in their order.
    let mut open: BinaryHeap<Reverse<(u64, u32, u32)>> =
        seeds.iter().enumerate().map(|(seed, voxel)| Reverse((0, seed as u32, *voxel))).collect();
    while let Some(Reverse((_, seed, voxel))) = open.pop() {
        let voxel = voxel as usize;
        if of[voxel].is_some() {
            continue;
        }
        of[voxel] = Some(seed);
        for (step, _) in around {
            let next = vessels.row((vessels.places[voxel] as isize + step) as usize);
            let Some(next) = next.filter(|row| of[*row].is_none()) else { continue };
            let nearer = (apart(next, seed).to_bits(), seed);
            if nearer < best[next] {
                best[next] = nearer;
                open.push(Reverse((nearer.0, seed, next as u32)));
            }
        }
    }
    of
}
