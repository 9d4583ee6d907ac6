//! The voxels of a mask in few bytes: alternating lengths of background and vessel, in blocks of voxels where there are too many.

use super::{Affine, Foreground, indices_of, row_at, strides_of};

/// A block counts as vessel from this share of its voxels on: a vessel one voxel wide stays whole in blocks of two.
const LEAST_OF_BLOCK: usize = 4;

/// The voxels inside vessels, in a box with one voxel of background around them.
#[derive(Debug, Clone, PartialEq)]
pub struct RunLengths {
    /// The box's lengths.
    pub shape: [usize; 3],
    /// Where the centre of each block of the box is, mm.
    pub affine: Affine,
    /// Voxels along each side of a block; 1 where none is left out.
    pub block: usize,
    /// Lengths along x, then y, then z, first of background, then of vessel, and so on: seven bits a byte, the lowest first, with the
    /// eighth bit where another byte follows (LEB128).
    pub bytes: Vec<u8>,
}

impl RunLengths {
    /// The voxels in the smallest blocks whose surface has at most `faces` faces, in a box of at most `cells` blocks.
    pub fn of(vessels: &Foreground, faces: usize, cells: usize) -> Self {
        let mut block = 1;
        loop {
            if let Some(runs) = Self::in_blocks(vessels, block, faces, cells) {
                return runs;
            }
            block += 1;
        }
    }

    /// The voxels in blocks of one size; `None` where that is more than is allowed. One block is always allowed.
    fn in_blocks(vessels: &Foreground, block: usize, faces: usize, cells: usize) -> Option<Self> {
        let inner = vessels.shape.map(|length| length - 2);
        let shape = inner.map(|length| length.div_ceil(block) + 2);
        let is_one = shape == [3; 3];
        if shape.iter().product::<usize>() > cells && !is_one {
            return None;
        }
        let is_too_many = |count: usize| count > faces && !is_one;
        let bytes = if block == 1 {
            if is_too_many(faces_of(vessels.places(), vessels.strides(), |place| vessels.contains(place), faces)) {
                return None;
            }
            runs(vessels.places())
        } else {
            let blocks = blocks_of(vessels, block, shape);
            let contains = |place| blocks.binary_search(&place).is_ok();
            if is_too_many(faces_of(blocks.iter().copied(), strides_of(shape), contains, faces)) {
                return None;
            }
            runs(blocks.into_iter())
        };
        // The centre of the first block, in voxels of the image: the block of background before the first one of the box within.
        let first = vessels.box_origin().map(|origin| origin + 1.0 + 0.5 * (block as f64 - 1.0) - block as f64);
        let affine = vessels.affine.map(|row| {
            let at = row[3] + (0..3).map(|axis| row[axis] * first[axis]).sum::<f64>();
            [row[0] * block as f64, row[1] * block as f64, row[2] * block as f64, at]
        });
        Some(Self { shape, affine, block, bytes })
    }
}

/// The blocks that count as vessel, by their places in a box of this shape, rising.
fn blocks_of(vessels: &Foreground, block: usize, shape: [usize; 3]) -> Vec<usize> {
    let of = |place: usize| row_at(shape, indices_of(vessels.shape, place).map(|at| (at - 1) / block + 1));
    let mut all: Vec<usize> = vessels.places().map(of).collect();
    all.sort_unstable();
    all.chunk_by(|a, b| a == b).filter(|same| LEAST_OF_BLOCK * same.len() >= block.pow(3)).map(|same| same[0]).collect()
}

/// How many faces lie between what is inside and what is not; counting ends beyond `most`.
fn faces_of(places: impl Iterator<Item = usize>, strides: [usize; 3], contains: impl Fn(usize) -> bool, most: usize) -> usize {
    let mut count = 0;
    for place in places {
        count +=
            strides.iter().map(|step| usize::from(!contains(place + step)) + usize::from(!contains(place - step))).sum::<usize>();
        if count > most {
            break;
        }
    }
    count
}

/// The lengths of the runs that rising places make.
fn runs(places: impl Iterator<Item = usize>) -> Vec<u8> {
    let (mut bytes, mut before, mut places) = (Vec::new(), 0, places.peekable());
    while let Some(begin) = places.next() {
        let mut end = begin + 1;
        while places.next_if_eq(&end).is_some() {
            end += 1;
        }
        put(&mut bytes, begin - before);
        put(&mut bytes, end - begin);
        before = end;
    }
    bytes
}

fn put(bytes: &mut Vec<u8>, mut length: usize) {
    while length >= 0x80 {
        bytes.push(length as u8 | 0x80);
        length >>= 7;
    }
    bytes.push(length as u8);
}
