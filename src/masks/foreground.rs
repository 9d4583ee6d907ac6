//! The voxels inside vessels as a list, and the way from a place to its row in that list.

use super::mask::Mask;

/// No voxel of a vessel.
const NONE: u32 = u32::MAX;

/// The voxels of a mask that are not background, in the order x, y, z with x fastest, in the box around them and one voxel more.
#[derive(Debug, Clone)]
pub struct Foreground {
    /// The box's lengths; its first voxel is `origin`.
    shape: [usize; 3],
    /// The indices in the image of the box's first voxel, which may be -1.
    origin: [isize; 3],
    /// The image's own lengths.
    image: [usize; 3],
    /// The place of each voxel in the box.
    pub places: Vec<u32>,
    /// The class of each voxel.
    pub classes: Vec<u8>,
    row_at: Vec<u32>,
}

impl Foreground {
    /// The voxels of a mask; `None` for an empty mask, or where the box has more voxels than 32 bits count.
    pub fn of(mask: &Mask) -> Option<Self> {
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
        let size = shape[0].checked_mul(shape[1])?.checked_mul(shape[2]).filter(|size| *size < NONE as usize)?;
        let mut found = Self {
            shape,
            origin: low.map(|index| index as isize - 1),
            image: mask.shape,
            places: Vec::new(),
            classes: Vec::new(),
            row_at: vec![NONE; size],
        };
        for z in low[2]..=high[2] {
            for y in low[1]..=high[1] {
                let line = (z * mask.shape[1] + y) * mask.shape[0];
                let place = ((z - low[2] + 1) * shape[1] + y - low[1] + 1) * shape[0] + 1;
                for x in low[0]..=high[0] {
                    let class = mask.classes[line + x];
                    if class > 0 {
                        found.row_at[place + x - low[0]] = found.places.len() as u32;
                        found.places.push((place + x - low[0]) as u32);
                        found.classes.push(class);
                    }
                }
            }
        }
        Some(found)
    }

    /// How many voxels there are.
    pub fn len(&self) -> usize {
        self.places.len()
    }

    /// Whether there is none.
    pub fn is_empty(&self) -> bool {
        self.places.is_empty()
    }

    /// How many voxels the box has.
    pub fn box_size(&self) -> usize {
        self.row_at.len()
    }

    /// Steps from a place of the box to the next along each axis.
    pub fn strides(&self) -> [usize; 3] {
        [1, self.shape[0], self.shape[0] * self.shape[1]]
    }

    /// The row of the voxel at a place; `None` for background.
    pub fn row(&self, place: usize) -> Option<usize> {
        self.row_at.get(place).filter(|row| **row != NONE).map(|row| *row as usize)
    }

    /// The indices of a voxel in the image.
    pub fn voxel(&self, row: usize) -> [usize; 3] {
        let place = self.places[row] as usize;
        let at = [place % self.shape[0], place / self.shape[0] % self.shape[1], place / (self.shape[0] * self.shape[1])];
        [0, 1, 2].map(|axis| (at[axis] as isize + self.origin[axis]) as usize)
    }

    /// Whether the image ends right after a voxel in a direction of an axis, so that nothing is known of what lies there.
    pub fn is_last(&self, row: usize, axis: usize, forward: bool) -> bool {
        let index = self.voxel(row)[axis];
        if forward { index + 1 == self.image[axis] } else { index == 0 }
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
