//! The voxels inside vessels as one bit each, numbered in their order: a row for each voxel, a place in the box for each row.

use fixedbitset::{Block, FixedBitSet};

use super::grid::{box_between, indices_of, row_at, strides_of};
use willis_core::support::geometry::Point;

/// Bits of a block.
const BITS: usize = Block::BITS as usize;

/// The voxels of a mask that are not background, in the order x, y, z with x fastest, in the box around them and one voxel more.
///
/// It takes a fifth of a byte for each voxel of the box, however many are inside vessels.
#[derive(Debug, Clone)]
pub struct Foreground {
    /// The box's lengths; its first voxel is `origin`.
    pub(super) shape: [usize; 3],
    /// The indices in the image of the box's first voxel, which may be -1.
    origin: [isize; 3],
    /// The image's own lengths.
    image: [usize; 3],
    /// Where the centre of each of its voxels is, mm.
    pub(super) affine: super::grid::Affine,
    /// One bit for each place of the box.
    bits: FixedBitSet,
    /// How many voxels come before each block of bits, and all of them last.
    before: Vec<u32>,
}

impl Foreground {
    /// The voxels of a mask; `None` for an empty mask, or where the box has more voxels than 32 bits count.
    pub fn of(mask: &super::mask::Mask) -> Option<Self> {
        let (mut low, mut high) = ([usize::MAX; 3], [0; 3]);
        for (row, line) in mask.classes.chunks_exact(mask.shape[0]).enumerate() {
            let (Some(first), Some(last)) = (line.iter().position(|c| *c > 0), line.iter().rposition(|c| *c > 0)) else {
                continue;
            };
            let at = [first, row % mask.shape[1], row / mask.shape[1]];
            for axis in 0..3 {
                low[axis] = low[axis].min(at[axis]);
                high[axis] = high[axis].max(if axis == 0 { last } else { at[axis] });
            }
        }
        if low[0] == usize::MAX {
            return None;
        }
        let shape = [0, 1, 2].map(|axis| high[axis] - low[axis] + 3);
        let size = shape[0].checked_mul(shape[1])?.checked_mul(shape[2]).filter(|size| *size < u32::MAX as usize)?;
        let mut bits = FixedBitSet::with_capacity(size);
        for z in low[2]..=high[2] {
            for y in low[1]..=high[1] {
                let line = row_at(mask.shape, [0, y, z]);
                let place = row_at(shape, [1, y - low[1] + 1, z - low[2] + 1]);
                for x in low[0]..=high[0] {
                    if mask.classes[line + x] > 0 {
                        bits.insert(place + x - low[0]);
                    }
                }
            }
        }
        let mut before = Vec::with_capacity(bits.as_slice().len() + 1);
        before.push(0);
        before.extend(bits.as_slice().iter().scan(0, |count, block| {
            *count += block.count_ones();
            Some(*count)
        }));
        let origin = low.map(|index| index as isize - 1);
        Some(Self { shape, origin, image: mask.shape, affine: mask.affine, bits, before })
    }

    /// How many voxels there are.
    pub fn count(&self) -> usize {
        self.before.last().map_or(0, |count| *count as usize)
    }

    /// The box (m) around the middles of its voxels.
    pub fn bounds(&self) -> [Point; 2] {
        // The box has a voxel more to every side.
        let first = self.origin.map(|index| (index + 1) as f64);
        let last = [0, 1, 2].map(|axis| first[axis] + (self.shape[axis] - 3) as f64);
        box_between(&self.affine, [first, last])
    }

    /// How many voxels the box has.
    pub fn box_size(&self) -> usize {
        self.shape.iter().product()
    }

    /// The indices in the image of the box's first voxel, which may be -1.
    pub fn box_origin(&self) -> [f64; 3] {
        self.origin.map(|index| index as f64)
    }

    /// Steps from a place of the box to the next along each axis.
    pub fn strides(&self) -> [usize; 3] {
        strides_of(self.shape)
    }

    /// Whether a place is inside a vessel.
    pub fn contains(&self, place: usize) -> bool {
        self.bits.contains(place)
    }

    /// The row of the voxel at a place; `None` for background.
    pub fn row(&self, place: usize) -> Option<usize> {
        self.contains(place).then(|| {
            let lower = self.bits.as_slice()[place / BITS] & ((1 << (place % BITS)) - 1);
            self.before[place / BITS] as usize + lower.count_ones() as usize
        })
    }

    /// The place of a row.
    pub fn place(&self, row: usize) -> usize {
        // The last block that not more than `row` voxels come before.
        let at = self.before.partition_point(|before| *before as usize <= row) - 1;
        let mut block = self.bits.as_slice()[at];
        for _ in self.before[at] as usize..row {
            block &= block - 1;
        }
        at * BITS + block.trailing_zeros() as usize
    }

    /// The places of all rows, in their order.
    pub fn places(&self) -> impl Iterator<Item = usize> {
        self.bits.ones()
    }

    /// The indices in the image of a place.
    pub fn voxel_at(&self, place: usize) -> [usize; 3] {
        let at = indices_of(self.shape, place);
        [0, 1, 2].map(|axis| (at[axis] as isize + self.origin[axis]) as usize)
    }

    /// The place of a voxel, given by its indices in the image; `None` outside the box.
    pub fn place_of(&self, voxel: [usize; 3]) -> Option<usize> {
        let mut place = 0;
        for axis in [2, 1, 0] {
            let at = usize::try_from(voxel[axis] as isize - self.origin[axis]).ok().filter(|at| *at < self.shape[axis])?;
            place = place * self.shape[axis] + at;
        }
        Some(place)
    }

    /// The indices of a voxel in the image.
    pub fn voxel(&self, row: usize) -> [usize; 3] {
        self.voxel_at(self.place(row))
    }

    /// Whether the image ends right after a voxel, given by its indices, in a direction of an axis, so that nothing is known of what lies
    /// there.
    pub fn is_last(&self, voxel: [usize; 3], axis: usize, forward: bool) -> bool {
        if forward { voxel[axis] + 1 == self.image[axis] } else { voxel[axis] == 0 }
    }
}

/// The steps to the 26 neighbours, in the order x, y, z with x fastest, each with how many axes it moves along.
pub fn neighbours(strides: [usize; 3]) -> [(isize, [i8; 3]); 26] {
    let mut steps = [(0, [0; 3]); 26];
    let all = (0..27).filter(|n| *n != 13).map(|n: i8| [n % 3 - 1, n / 3 % 3 - 1, n / 9 - 1]);
    for (slot, by) in steps.iter_mut().zip(all) {
        *slot = ((0..3).map(|axis| isize::from(by[axis]) * strides[axis] as isize).sum(), by);
    }
    steps
}
