//! Which voxel of the skeleton each voxel of the lumen belongs to, and with what volume.

use std::{cmp::Reverse, collections::BinaryHeap};

use super::{Foreground, Mask, neighbours, steps_of};
use willis_core::support::geometry::{Point, norm_squared};

/// A voxel that belongs to no seed.
pub const NONE: u32 = u32::MAX;
/// The bit of a voxel whose seed is settled.
const SETTLED: u32 = 1 << 31;

/// Between voxels given by their indices, mm².
fn squared_distance(steps: [Point; 3], at: [f64; 3], from: [f64; 3]) -> f64 {
    let by = [0, 1, 2].map(|axis| at[axis] - from[axis]);
    norm_squared([0, 1, 2].map(|row| (0..3).map(|axis| steps[axis][row] * by[axis]).sum()))
}

/// For each voxel of the vessels the seed that is nearest, among those that its neighbours belong to: the row in `seeds`; [`NONE`] where
/// no seed is in the same component. Ties go to the earlier seed.
pub fn nearest_seeds(mask: &Mask, vessels: &Foreground, seeds: &[u32]) -> Vec<u32> {
    let steps = steps_of(&mask.affine);
    let around = neighbours(vessels.strides());
    let indices = |place: usize| vessels.voxel_at(place).map(|index| index as f64);
    let seeds: Vec<(usize, [f64; 3])> =
        seeds.iter().map(|row| vessels.place(*row as usize)).map(|place| (place, indices(place))).collect();
    let apart = |at: [f64; 3], seed: u32| squared_distance(steps, at, seeds[seed as usize].1);
    // The nearest seed so far of each voxel, or the settled one.
    let mut best = vec![NONE; vessels.count()];
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

/// The volume of the lumen in pieces: the place of each voxel, the seed it belongs to, and how much of it is inside, mm³. A piece may
/// take away from one before it: a voxel of a vessel counts as a whole first, then less what its wall leaves outside. A voxel beside a
/// vessel belongs to the nearest of the seeds that its neighbours belong to.
pub fn volumes(mask: &Mask, vessels: &Foreground, seeds: &[u32], nearest: &[u32]) -> impl Iterator<Item = (usize, u32, f64)> {
    let (cell, steps, around) = (mask.voxel_volume(), steps_of(&mask.affine), neighbours(vessels.strides()));
    let indices = |place: usize| vessels.voxel_at(place).map(|index| index as f64);
    let at: Vec<[f64; 3]> = seeds.iter().map(|row| indices(vessels.place(*row as usize))).collect();
    let nearest_beside = move |place: usize| {
        let touched = around.iter().filter_map(|(step, _)| vessels.row((place as isize + step) as usize)).map(|row| nearest[row]);
        let apart = |seed: u32| squared_distance(steps, indices(place), at[seed as usize]);
        touched.filter(|seed| *seed != NONE).map(|seed| (apart(seed).to_bits(), seed)).min().map(|(_, seed)| seed)
    };
    let of_wall = move |(voxel, part): &(u32, f32)| {
        let ([x, y, _], row) = (mask.shape, *voxel as usize);
        let place = vessels.place_of([row % x, row / x % y, row / (x * y)])?;
        let part = f64::from(*part);
        match vessels.row(place) {
            Some(row) => Some((place, nearest[row], cell * (part - 1.0))),
            None => nearest_beside(place).map(|seed| (place, seed, cell * part)),
        }
    };
    let walls = mask.walls.iter().flat_map(|walls| &walls.voxels).filter_map(of_wall);
    let whole = vessels.places().zip(nearest).map(move |(place, seed)| (place, *seed, cell));
    whole.chain(walls).filter(|(_, seed, _)| *seed != NONE)
}
