//! Partial volume: how much of a voxel at the wall of a vessel is inside, by the values that the mask was cut from.
//!
//! The wall is the voxels that touch the other side of the level by a face, an edge or a corner: the outermost of a vessel, and the first
//! around it. What is deeper is inside as a whole, and what is further is outside, whatever its value, so that no haze counts.
//!
//! | image | what a value means |
//! |---|---|
//! | values from 0 to 1, about 0 around vessels: probabilities | the part of the voxel that is inside, whatever the level |
//! | any other | the second voxels around vessels are outside, by their median; a value twice as far from that as the level is inside |
//!
//! In the first case a vessel is as wide as the image says, in the second a wide one is as wide as the level cuts it.

use super::{indices_of, row_at};

/// Up to this value the surroundings of vessels are about 0.
const HAZE: f64 = 0.05;
/// Rounding may take probabilities so far out of 0 to 1.
const ROUNDING: f64 = 1e-3;

/// The voxels that the walls of vessels cut.
#[derive(Debug, Clone, PartialEq)]
pub struct Walls {
    /// The value of a voxel outside vessels, and of one inside.
    pub values: [f64; 2],
    /// Voxels by their index in the image, rising, and the part of each that is inside. Those that lie on one side as a whole are left out.
    pub voxels: Vec<(u32, f32)>,
}

/// Finds the walls while an image is read. It holds the values of few slices at a time.
#[derive(Debug)]
pub struct WallFinder {
    shape: [usize; 3],
    /// The slice to look at next, and the values from it on.
    next: usize,
    values: Vec<f32>,
    /// The least and the largest value.
    range: [f64; 2],
    /// The voxels of the wall with their values.
    found: Vec<(u32, f32)>,
    /// The values of the second voxels around vessels.
    around: Vec<f32>,
}

impl WallFinder {
    /// For an image of these lengths; `None` where 32 bits do not count its voxels.
    pub fn new(shape: [usize; 3]) -> Option<Self> {
        shape.iter().try_fold(1_u32, |all, n| all.checked_mul(u32::try_from(*n).ok()?))?;
        let range = [f64::INFINITY, f64::NEG_INFINITY];
        Some(Self { shape, next: 0, values: Vec::new(), range, found: Vec::new(), around: Vec::new() })
    }

    /// Takes the value of the next voxel.
    pub fn add(&mut self, value: f64) {
        self.range = [self.range[0].min(value), self.range[1].max(value)];
        self.values.push(value as f32);
    }

    /// Looks at every slice that is read with the two after it; `classes` are those of the voxels that are read.
    pub fn advance(&mut self, classes: &[u8]) {
        let [x, y, z] = self.shape;
        let (slice, first) = (x * y, self.next);
        while self.next < z && classes.len() >= (self.next + 3).min(z) * slice {
            self.look(classes, (self.next - first) * slice);
            self.next += 1;
        }
        self.values.drain(..(self.next - first) * slice);
    }

    /// Looks at slice `next`; its values begin at `from`.
    fn look(&mut self, classes: &[u8], from: usize) {
        let slice = self.shape[0] * self.shape[1];
        let second = self.within(2, classes);
        if !second.contains(&true) {
            return;
        }
        let first = self.within(1, classes);
        for at in (0..slice).filter(|at| second[*at]) {
            let (row, value) = (self.next * slice + at, self.values[from + at]);
            if !first[at] {
                self.around.push(value);
            } else if classes[row] == 0 || self.is_outermost(row, classes) {
                self.found.push((row as u32, value));
            }
        }
    }

    /// The voxels of slice `next` that are a vessel's, or so many voxels from one along each axis.
    fn within(&self, reach: usize, classes: &[u8]) -> Vec<bool> {
        let [x, y, z] = self.shape;
        let mut marks = vec![false; x * y];
        let lines = (self.next.saturating_sub(reach)..(self.next + reach + 1).min(z)).flat_map(|z| (0..y).map(move |y| (z, y)));
        for (slice, row) in lines {
            let line = &classes[(slice * y + row) * x..][..x];
            if line.iter().fold(0, |all, class| all | class) == 0 {
                continue;
            }
            let mut end = 0;
            while let Some(begin) = line[end..].iter().position(|class| *class > 0).map(|by| end + by) {
                end = line[begin..].iter().position(|class| *class == 0).map_or(x, |by| begin + by);
                for other in row.saturating_sub(reach)..(row + reach + 1).min(y) {
                    marks[other * x + begin.saturating_sub(reach)..other * x + (end + reach).min(x)].fill(true);
                }
            }
        }
        marks
    }

    /// Whether a vessel's voxel touches background. Beyond the image nothing is known, so that is none.
    fn is_outermost(&self, row: usize, classes: &[u8]) -> bool {
        let ([x, y, z], at) = (self.shape, indices_of(self.shape, row));
        let near = |axis: usize, length: usize| at[axis].saturating_sub(1)..(at[axis] + 2).min(length);
        near(2, z).any(|c| near(1, y).any(|b| near(0, x).any(|a| classes[row_at(self.shape, [a, b, c])] == 0)))
    }

    /// The walls, once all is read; `None` where every voxel lies on one side as a whole, or nothing tells how much of it does.
    pub fn finish(mut self, level: f64, classes: &[u8]) -> Option<Walls> {
        self.advance(classes);
        let middle = self.around.len() / 2;
        let around =
            (middle < self.around.len()).then(|| f64::from(*self.around.select_nth_unstable_by(middle, f32::total_cmp).1));
        let from_0_to_1 = self.range[0] >= -ROUNDING && self.range[1] <= 1.0 + ROUNDING;
        let values = if from_0_to_1 && around.is_none_or(|value| value <= HAZE) {
            [0.0, 1.0]
        } else {
            around.map(|outside| [outside, 2.0 * level - outside])?
        };
        let [outside, inside] = values;
        if !(inside - outside).is_normal() || inside <= outside {
            return None;
        }
        let mut voxels = self.found;
        voxels.retain_mut(|(row, value)| {
            *value = ((f64::from(*value) - outside) / (inside - outside)).clamp(0.0, 1.0) as f32;
            *value != if classes[*row as usize] > 0 { 1.0 } else { 0.0 }
        });
        voxels.shrink_to_fit();
        (!voxels.is_empty()).then_some(Walls { values, voxels })
    }
}
