//! The picture that a mask was made from, or that lies beside centerlines: a number for every voxel.

use std::collections::VecDeque;

use super::grid::{Affine, axes_by_direction, box_between, inverse_of, row_at, steps_of, strides_of};
use willis_core::network::{metres, millimetres};
use willis_core::support::geometry::{Point, bounds, dot, norm};
use willis_core::support::in_chunks;

/// A kernel reaches so many standard deviations to either side.
const KERNEL_REACH: f64 = 2.5;
/// A kernel narrower than this many voxels changes nothing.
const LEAST_SIGMA: f64 = 0.2;

/// A value for every voxel of an image.
#[derive(Debug, Clone)]
pub struct Image {
    /// Voxels along the three axes; the first runs fastest.
    pub shape: [usize; 3],
    /// The value of each voxel; those that are not finite are not known.
    pub values: Vec<f32>,
    /// Where the centre of each voxel is, mm.
    pub affine: Affine,
}

/// Probabilities are taken to be no nearer to 0 and 1 than this.
const LEAST_PROBABLE: f32 = 1e-3;

impl Image {
    /// The log odds of an image of probabilities, of which those below 0.001 count as 0.001, and those above 0.999 as that.
    ///
    /// # Errors
    ///
    /// The first value that is no probability.
    pub fn log_odds(mut self) -> Result<Self, f32> {
        if let Some(x) = self.values.iter().find(|x| x.is_finite() && !(0.0..=1.0).contains(*x)) {
            return Err(*x);
        }
        for x in &mut self.values {
            let p = x.clamp(LEAST_PROBABLE, 1.0 - LEAST_PROBABLE);
            *x = (p / (1.0 - p)).ln();
        }
        Ok(self)
    }

    /// The box (m) around the middles of its voxels.
    pub fn bounds(&self) -> [Point; 2] {
        box_between(&self.affine, [[0.0; 3], self.shape.map(|length| (length - 1) as f64)])
    }
}

/// The part of an image around some places, smoothed.
#[derive(Debug, Clone)]
pub struct Picture {
    /// Voxels along the three axes.
    pub(super) shape: [usize; 3],
    /// The values, the first axis fastest.
    pub(super) values: Vec<f32>,
    /// From mm to indices: rows of three, after subtracting `at`.
    inverse: [Point; 3],
    /// The position of the first voxel, mm.
    at: Point,
    /// The steps of one voxel, mm.
    steps: [Point; 3],
}

impl Picture {
    /// The part of an image in the box from `low` to `high` (m), averaged with a Gaussian of this standard deviation (m); `None` where the image
    /// does not reach into the box.
    pub fn of(image: Image, [low, high]: [Point; 2], sigma: f64) -> Option<Self> {
        let mut steps = steps_of(&image.affine);
        let inverse = inverse_of(steps);
        let mut at = image.affine.map(|row| row[3]);
        let index = |corner: usize| {
            let place = [0, 1, 2].map(|k| millimetres(if corner >> k & 1 == 0 { low[k] } else { high[k] }) - at[k]);
            inverse.map(|row| dot(row, place))
        };
        let [least, most] = bounds((0..8).map(index));
        let mut range = [[0; 2]; 3];
        for (axis, range) in range.iter_mut().enumerate() {
            let (least, most) = (least[axis], most[axis]);
            let last = (image.shape[axis] - 1) as f64;
            if !(most >= 0.0 && least <= last) {
                return None;
            }
            *range = [least.floor().max(0.0) as usize, most.ceil().min(last) as usize];
        }
        let shape = range.map(|[first, last]| last - first + 1);
        // The rows of the box move to the front, so that there is never a second image.
        let (mut values, mut end) = (image.values, 0);
        for z in range[2][0]..=range[2][1] {
            for y in range[1][0]..=range[1][1] {
                let row = row_at(image.shape, [0, y, z]);
                values.copy_within(row + range[0][0]..=row + range[0][1], end);
                end += shape[0];
            }
        }
        values.truncate(end);
        for k in 0..3 {
            at[k] += (0..3).map(|axis| steps[axis][k] * range[axis][0] as f64).sum::<f64>();
        }
        // What is measured goes by blocks from the first voxel on: which one that is must not depend on the order in the file.
        for (direction, axis) in axes_by_direction(&image.affine).into_iter().enumerate() {
            if steps[axis][direction] < 0.0 {
                reverse_along(&mut values, shape, axis);
                at = [0, 1, 2].map(|k| at[k] + steps[axis][k] * (shape[axis] - 1) as f64);
                steps[axis] = steps[axis].map(|x| -x);
            }
        }
        for (axis, step) in steps.iter().enumerate() {
            smooth_along(&mut values, shape, axis, millimetres(sigma) / norm(*step));
        }
        Some(Self { shape, values, inverse: inverse_of(steps), at, steps })
    }

    /// Takes from every voxel the mean of the voxels around it that count, by a Gaussian of this standard deviation (m). Where too few count
    /// within its reach, the mean over a wider one is taken.
    pub fn flatten(&mut self, sigma: f64, counts: impl Fn(usize) -> bool + Sync) {
        let around = LocalMean::of(self, millimetres(sigma), counts);
        let [x, y, _] = self.shape;
        let along: Vec<(usize, f32)> = (0..x).map(|n| around.between(0, n)).collect();
        in_chunks(&mut self.values, x, |row, line| {
            let means = around.row(row % y, row / y);
            for (value, (low, share)) in line.iter_mut().zip(&along) {
                let [a, b] = [means[*low], means[(low + 1).min(means.len() - 1)]];
                *value -= a + share * (b - a);
            }
        });
    }

    /// The row of a voxel in the values.
    pub fn row(&self, at: [usize; 3]) -> usize {
        row_at(self.shape, at)
    }

    /// The indices of a place (m), between voxels too.
    pub fn index(&self, place: Point) -> [f64; 3] {
        let from = [0, 1, 2].map(|k| millimetres(place[k]) - self.at[k]);
        self.inverse.map(|row| dot(row, from))
    }

    /// The step (m) along an axis.
    pub fn step(&self, axis: usize) -> Point {
        self.steps[axis].map(metres)
    }

    /// The value at a place (m), linear between voxels; `None` outside and where it is not known.
    pub fn value(&self, place: Point) -> Option<f64> {
        self.value_at(self.index(place))
    }

    /// The value at indices, linear between voxels; `None` outside and where it is not known.
    pub fn value_at(&self, at: [f64; 3]) -> Option<f64> {
        let (mut low, mut share) = ([0; 3], [0.0; 3]);
        for axis in 0..3 {
            let last = (self.shape[axis] - 1) as f64;
            // Half a voxel beyond the last centre is inside too.
            if !(at[axis] >= -0.5 && at[axis] <= last + 0.5) {
                return None;
            }
            let inside = at[axis].clamp(0.0, last);
            // Nothing is below zero here, so that what is cut off is what floor takes.
            low[axis] = (inside as usize).min(self.shape[axis].saturating_sub(2));
            share[axis] = inside - low[axis] as f64;
        }
        let steps = strides_of(self.shape);
        let next = [0, 1, 2].map(|axis| if self.shape[axis] > 1 { steps[axis] } else { 0 });
        let row = self.row(low);
        let corner = |i: usize, j: usize, k: usize| f64::from(self.values[row + k * next[2] + j * next[1] + i * next[0]]);
        Some(trilinear(corner, share)).filter(|x| x.is_finite())
    }
}

/// The value between the eight corners of a cell, by the share of the way along each axis.
pub(super) fn trilinear(corner: impl Fn(usize, usize, usize) -> f64, share: [f64; 3]) -> f64 {
    let between = |a: f64, b: f64, share: f64| a + share * (b - a);
    let along_x = |j: usize, k: usize| between(corner(0, j, k), corner(1, j, k), share[0]);
    let in_layer = |k: usize| between(along_x(0, k), along_x(1, k), share[1]);
    between(in_layer(0), in_layer(1), share[2])
}

/// The block whose middle comes before an index along an axis of so many blocks, each so many voxels wide, and how far the index is on the way to the
/// next one; at the ends of the axis the outermost block.
pub(super) fn block_before(index: f64, width: f64, blocks: usize) -> (usize, f64) {
    let at = ((index + 0.5) / width - 0.5).clamp(0.0, (blocks - 1) as f64);
    (at as usize, at.fract())
}

/// The mean of what counts around each place, on a grid of blocks of voxels.
struct LocalMean {
    shape: [usize; 3],
    /// Voxels of a block along each axis.
    block: [f64; 3],
    mean: Vec<f32>,
}

/// A block is so many standard deviations wide.
const BLOCK: f64 = 0.7;
/// A mean that rests on less than this share of the blocks around gives way to the mean over twice the reach.
const LEAST_SHARE: f32 = 0.02;

impl LocalMean {
    fn of(picture: &Picture, sigma: f64, counts: impl Fn(usize) -> bool + Sync) -> Self {
        let voxels = picture.shape;
        let along = picture.steps.map(norm);
        let size = [0, 1, 2].map(|axis| (BLOCK * sigma / along[axis]).round().max(1.0) as usize);
        let shape = [0, 1, 2].map(|axis| voxels[axis].div_ceil(size[axis]));
        let whole = (size[0] * size[1] * size[2]) as f32;
        // Per block the sum and the number of what counts, as shares of all its voxels.
        let mut blocks = vec![[0.0_f32; 2]; shape.iter().product()];
        in_chunks(&mut blocks, shape[0], |line, blocks| {
            let range = |axis: usize, block: usize| block * size[axis]..((block + 1) * size[axis]).min(voxels[axis]);
            for z in range(2, line / shape[1]) {
                for y in range(1, line % shape[1]) {
                    let first = picture.row([0, y, z]);
                    for (at, block) in blocks.iter_mut().enumerate() {
                        for voxel in range(0, at) {
                            let value = picture.values[first + voxel];
                            if value.is_finite() && counts(first + voxel) {
                                *block = [block[0] + value, block[1] + 1.0];
                            }
                        }
                    }
                }
            }
        });
        let [sum, share] = [0, 1].map(|k| blocks.iter().map(|block| block[k] / whole).collect::<Vec<f32>>());
        drop(blocks);
        let mut mean = vec![0.0; sum.len()];
        let mut is_known = vec![false; sum.len()];
        let mut wide = 1.0;
        let longest = shape.iter().copied().max().unwrap_or(1) as f64;
        while wide < 2.0 * longest && is_known.contains(&false) {
            let blurred = |values: &[f32]| {
                let mut out = values.to_vec();
                for axis in 0..3 {
                    smooth_along(&mut out, shape, axis, wide * sigma / (along[axis] * size[axis] as f64));
                }
                out
            };
            let (sums, shares) = (blurred(&sum), blurred(&share));
            for (row, is_known) in is_known.iter_mut().enumerate().filter(|(_, is_known)| !**is_known) {
                if shares[row] >= LEAST_SHARE {
                    (mean[row], *is_known) = (sums[row] / shares[row], true);
                }
            }
            wide *= 2.0;
        }
        Self { shape, block: size.map(|size| size as f64), mean }
    }

    /// The block before the middle of a voxel along an axis, and how far that is on the way to the next one.
    fn between(&self, axis: usize, voxel: usize) -> (usize, f32) {
        let (before, share) = block_before(voxel as f64, self.block[axis], self.shape[axis]);
        (before, share as f32)
    }

    /// The means along the first axis at a voxel of the other two.
    fn row(&self, y: usize, z: usize) -> Vec<f32> {
        let [(y, v), (z, w)] = [self.between(1, y), self.between(2, z)];
        let of = |y: usize, z: usize| {
            let first = row_at(self.shape, [0, y.min(self.shape[1] - 1), z.min(self.shape[2] - 1)]);
            &self.mean[first..first + self.shape[0]]
        };
        let mix = |a: f32, b: f32, share: f32| a + share * (b - a);
        let [near, far] = [z, z + 1].map(|z| of(y, z).iter().zip(of(y + 1, z)).map(move |(a, b)| mix(*a, *b, v)));
        near.zip(far).map(|(a, b)| mix(a, b, w)).collect()
    }
}

/// Turns the order of the voxels along an axis round.
fn reverse_along(values: &mut [f32], shape: [usize; 3], axis: usize) {
    let stride = strides_of(shape)[axis];
    for part in values.chunks_exact_mut(stride * shape[axis]) {
        for n in 0..shape[axis] / 2 {
            let (low, high) = part.split_at_mut((shape[axis] - 1 - n) * stride);
            low[n * stride..][..stride].swap_with_slice(&mut high[..stride]);
        }
    }
}

/// Averages along an axis with a Gaussian of so many voxels; the first and the last voxel go on beyond the border.
fn smooth_along(values: &mut [f32], shape: [usize; 3], axis: usize, sigma: f64) {
    if sigma < LEAST_SIGMA || shape[axis] < 2 {
        return;
    }
    let reach = (KERNEL_REACH * sigma).ceil() as usize;
    let weight = |o: usize| (-0.5 * (o as f64 / sigma).powi(2)).exp();
    let total: f64 = weight(0) + 2.0 * (1..=reach).map(weight).sum::<f64>();
    let kernel: Vec<f32> = (0..=reach).map(|o| (weight(o) / total) as f32).collect();
    let [x, y, z] = shape;
    if axis < 2 {
        let stride = if axis == 0 { 1 } else { x };
        in_chunks(values, stride * shape[axis], |_, part| {
            let edge = |n: usize| part[n * stride..][..stride].repeat(reach);
            let padded = [&edge(0)[..], part, &edge(shape[axis] - 1)].concat();
            part.fill(0.0);
            for (o, w) in kernel.iter().enumerate() {
                let [before, after] = [reach - o, reach + o].map(|n| &padded[n * stride..][..part.len()]);
                add_both(part, before, after, if o == 0 { 0.5 * w } else { *w });
            }
        });
    } else {
        // From the first layer on, so that only as many old layers are kept as the kernel reaches back.
        let size = x * y;
        let mut before: VecDeque<Vec<f32>> = VecDeque::from(vec![values[..size].to_vec(); reach]);
        for layer in 0..z {
            let (done, after) = values.split_at_mut((layer + 1) * size);
            let here = &mut done[layer * size..];
            let own = here.to_vec();
            let last = after.len().checked_sub(size).map(|first| &after[first..]);
            // The old layer so many layers on; beyond the border the last one.
            let ahead = |o: usize| after.get((o - 1) * size..o * size).or(last).unwrap_or(&own);
            in_chunks(here, x, |row, line| {
                let range = row * x..(row + 1) * x;
                line.fill(0.0);
                add_both(line, &own[range.clone()], &own[range.clone()], 0.5 * kernel[0]);
                for (o, w) in kernel.iter().enumerate().skip(1) {
                    add_both(line, &before[reach - o][range.clone()], &ahead(o)[range.clone()], *w);
                }
            });
            before.pop_front();
            before.push_back(own);
        }
    }
}

/// Adds the weighted sum of two rows.
fn add_both(out: &mut [f32], before: &[f32], after: &[f32], weight: f32) {
    for ((x, a), b) in out.iter_mut().zip(before).zip(after) {
        *x += weight * (a + b);
    }
}
