//! The picture that a mask was made from, or that lies beside centerlines: a number for every voxel.

use super::mask::Affine;
use crate::network::units::{metres, millimetres};
use crate::support::geometry::{Point, cross, dot, norm_squared};
use crate::support::in_order;

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

/// The part of an image around some places, smoothed.
#[derive(Debug, Clone)]
pub struct Picture {
    shape: [usize; 3],
    values: Vec<f32>,
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
    pub fn of(image: &Image, [low, high]: [Point; 2], sigma: f64) -> Option<Self> {
        let steps: [Point; 3] = [0, 1, 2].map(|axis| image.affine.map(|row| row[axis]));
        let volume = dot(steps[0], cross(steps[1], steps[2]));
        let inverse = [
            cross(steps[1], steps[2]).map(|x| x / volume),
            cross(steps[2], steps[0]).map(|x| x / volume),
            cross(steps[0], steps[1]).map(|x| x / volume),
        ];
        let mut at = image.affine.map(|row| row[3]);
        let index = |corner: usize| {
            let place = [0, 1, 2].map(|k| millimetres(if corner >> k & 1 == 0 { low[k] } else { high[k] }) - at[k]);
            inverse.map(|row| dot(row, place))
        };
        let corners: Vec<[f64; 3]> = (0..8).map(index).collect();
        let mut range = [[0; 2]; 3];
        for (axis, range) in range.iter_mut().enumerate() {
            let least = corners.iter().map(|c| c[axis]).fold(f64::INFINITY, f64::min);
            let most = corners.iter().map(|c| c[axis]).fold(f64::NEG_INFINITY, f64::max);
            let last = (image.shape[axis] - 1) as f64;
            if !(most >= 0.0 && least <= last) {
                return None;
            }
            *range = [least.floor().max(0.0) as usize, most.ceil().min(last) as usize];
        }
        let shape = range.map(|[first, last]| last - first + 1);
        let mut values = Vec::with_capacity(shape.iter().product());
        for z in range[2][0]..=range[2][1] {
            for y in range[1][0]..=range[1][1] {
                let row = (z * image.shape[1] + y) * image.shape[0];
                values.extend_from_slice(&image.values[row + range[0][0]..=row + range[0][1]]);
            }
        }
        for k in 0..3 {
            at[k] += (0..3).map(|axis| steps[axis][k] * range[axis][0] as f64).sum::<f64>();
        }
        for (axis, step) in steps.iter().enumerate() {
            smooth_along(&mut values, shape, axis, millimetres(sigma) / norm_squared(*step).sqrt());
        }
        Some(Self { shape, values, inverse, at, steps })
    }

    /// Voxels along the three axes.
    pub fn shape(&self) -> [usize; 3] {
        self.shape
    }

    /// The values, the first axis fastest.
    pub fn values(&self) -> &[f32] {
        &self.values
    }

    /// The row of a voxel in the values.
    pub fn row(&self, [x, y, z]: [usize; 3]) -> usize {
        (z * self.shape[1] + y) * self.shape[0] + x
    }

    /// The indices of a place (m), between voxels too.
    pub fn index(&self, place: Point) -> [f64; 3] {
        let from = [0, 1, 2].map(|k| millimetres(place[k]) - self.at[k]);
        self.inverse.map(|row| dot(row, from))
    }

    /// The position (m) of indices.
    pub fn position(&self, index: [f64; 3]) -> Point {
        [0, 1, 2].map(|k| metres(self.at[k] + (0..3).map(|axis| self.steps[axis][k] * index[axis]).sum::<f64>()))
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
            low[axis] = (inside.floor() as usize).min(self.shape[axis].saturating_sub(2));
            share[axis] = inside - low[axis] as f64;
        }
        let steps = [1, self.shape[0], self.shape[0] * self.shape[1]];
        let next = [0, 1, 2].map(|axis| if self.shape[axis] > 1 { steps[axis] } else { 0 });
        let row = self.row(low);
        let between = |a: f64, b: f64, share: f64| a + share * (b - a);
        let v = |row: usize| f64::from(self.values[row]);
        let along_x = |row: usize| between(v(row), v(row + next[0]), share[0]);
        let in_layer = |row: usize| between(along_x(row), along_x(row + next[1]), share[1]);
        Some(between(in_layer(row), in_layer(row + next[2]), share[2])).filter(|x| x.is_finite())
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
    // Lines of voxels along the axis lie `step` apart from each other in blocks of `block`.
    let step: usize = shape[..axis].iter().product();
    let (length, block) = (shape[axis], step * shape[axis]);
    let blocks: Vec<&[f32]> = values.chunks_exact(block).collect();
    let smoothed = in_order(&blocks, |_, old| {
        let mut new = vec![0.0_f32; block];
        for i in 0..length {
            let out = &mut new[i * step..(i + 1) * step];
            for (o, w) in kernel.iter().enumerate() {
                let (before, after) = (i.saturating_sub(o), (i + o).min(length - 1));
                let w = if o == 0 { 0.5 * w } else { *w };
                let sides = old[before * step..(before + 1) * step].iter().zip(&old[after * step..(after + 1) * step]);
                for (x, (a, b)) in out.iter_mut().zip(sides) {
                    *x += w * (a + b);
                }
            }
        }
        new
    });
    for (old, new) in values.chunks_exact_mut(block).zip(smoothed) {
        old.copy_from_slice(&new);
    }
}
