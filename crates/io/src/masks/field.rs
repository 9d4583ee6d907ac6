//! The depth of every place below the wall of a mask's lumen: a signed distance, between voxels by trilinear interpolation.

use super::image::trilinear;
use super::{Foreground, distances, inverse_of, neighbours, row_at, steps_of, strides_of, volume_of};
use willis_core::network::{metres, millimetres};
use willis_core::support::geometry::{Point, dot, norm, norm_squared};
use willis_core::support::ties::{near_zero, steady};

/// Further outside than the neighbours of the lumen every place has this depth, in voxels.
const OUTSIDE: f64 = -1.5;
/// No depth is larger, in voxels: where the image shows no wall.
const DEEPEST: f64 = 1e3;

/// The wall of a mask as a signed distance: inside the distance of a voxel to the nearest one outside less half a voxel, outside the
/// opposite.
#[derive(Debug, Clone)]
pub struct Field {
    /// The box's lengths.
    shape: [usize; 3],
    /// The indices in the image of the box's first voxel.
    origin: [f64; 3],
    /// From mm to indices: rows of three, after subtracting `at`.
    inverse: [Point; 3],
    /// The position of the image's first voxel, mm.
    at: Point,
    /// The least side of a voxel, mm.
    voxel: f64,
    /// The depth of each voxel of the box, mm.
    depth: Vec<f32>,
    /// The steps of one voxel, mm.
    steps: [Point; 3],
}

impl Field {
    /// The field around the voxels of a mask.
    pub fn of(vessels: &Foreground) -> Self {
        let steps = steps_of(&vessels.affine);
        let spacing = steps.map(norm);
        let voxel = spacing.iter().copied().fold(f64::INFINITY, f64::min);
        let mut depth = vec![(OUTSIDE * voxel) as f32; vessels.box_size()];
        let inside = distances(vessels, spacing);
        let around = neighbours(vessels.strides()).map(|(step, by)| {
            let apart = [0, 1, 2].map(|row| (0..3).map(|axis| steps[axis][row] * f64::from(by[axis])).sum());
            (step, (0.5 * voxel - norm_squared(apart).sqrt()) as f32)
        });
        for place in vessels.places() {
            for (step, value) in around {
                let next = &mut depth[(place as isize + step) as usize];
                *next = next.max(value);
            }
        }
        for (place, distance) in vessels.places().zip(inside) {
            depth[place] = (distance.min(DEEPEST * voxel) - 0.5 * voxel) as f32;
        }
        let (shape, origin) = (vessels.shape, vessels.box_origin());
        let at = vessels.affine.map(|row| row[3]);
        Self { shape, origin, inverse: inverse_of(steps), at, voxel, depth, steps }
    }

    /// The least side of a voxel, m.
    pub fn voxel(&self) -> f64 {
        metres(self.voxel)
    }

    /// The volume of a voxel, m³.
    pub fn voxel_volume(&self) -> f64 {
        volume_of(self.steps) * metres(1.0).powi(3)
    }

    /// The depth (m) of a place (m) below the wall, to so many parts of a voxel that rounding does not decide what is inside or deeper; negative outside.
    pub fn signed(&self, place: Point) -> f64 {
        let at = self.index(place);
        let low = at.map(floor);
        let share = [0, 1, 2].map(|k| at[k] - low[k]);
        let [x, y, z] = low.map(|index| index as isize);
        // Where all eight voxels are in the box, their rows follow from the first.
        let [_, along_y, along_z] = strides_of(self.shape);
        let is_inside = [x, y, z].iter().zip(self.shape).all(|(index, length)| *index >= 0 && (*index as usize) + 1 < length);
        let first = if is_inside { z as usize * along_z + y as usize * along_y + x as usize } else { 0 };
        let corner = |i: usize, j: usize, k: usize| {
            if is_inside {
                f64::from(self.depth[first + k * along_z + j * along_y + i])
            } else {
                self.at([x + i as isize, y + j as isize, z + k as isize])
            }
        };
        metres(near_zero(trilinear(corner, share) / self.voxel) * self.voxel)
    }

    /// The depth (m) of a place (m) in the lumen; zero outside.
    pub fn depth(&self, place: Point) -> f64 {
        self.signed(place).max(0.0)
    }

    /// The positions (m) of the lumen's voxels within a distance (m) of a place (m).
    pub fn voxels_around(&self, place: Point, reach: f64) -> Vec<Point> {
        let (centre, reach) = (self.index(place), millimetres(reach));
        // A box of indices that holds the ball.
        let half = self.inverse.map(|row| norm_squared(row).sqrt() * reach);
        let range = |k: usize| {
            let low = (centre[k] - half[k]).floor().max(0.0);
            let high = (centre[k] + half[k]).ceil().min((self.shape[k] - 1) as f64);
            low as isize..=high.max(-1.0) as isize
        };
        let [along_x, along_y, along_z] = [0, 1, 2].map(range);
        let mut out = Vec::new();
        for z in along_z {
            for y in along_y.clone() {
                for x in along_x.clone() {
                    // Inside the depth is half a voxel at least, outside at most half a voxel the other way.
                    if self.at([x, y, z]) > 0.0 {
                        let to = [x as f64 - centre[0], y as f64 - centre[1], z as f64 - centre[2]];
                        let apart: Point = [0, 1, 2].map(|row| (0..3).map(|axis| self.steps[axis][row] * to[axis]).sum());
                        if steady(norm_squared(apart)) <= steady(reach * reach) {
                            out.push([0, 1, 2].map(|k| place[k] + metres(apart[k])));
                        }
                    }
                }
            }
        }
        out
    }

    /// Indices in the box of a place (m).
    fn index(&self, place: Point) -> [f64; 3] {
        let from = [0, 1, 2].map(|k| millimetres(place[k]) - self.at[k]);
        [0, 1, 2].map(|k| dot(self.inverse[k], from) - self.origin[k])
    }

    /// The depth of a voxel, mm.
    fn at(&self, index: [isize; 3]) -> f64 {
        // Below zero is no small number without a sign.
        let at = index.map(|x| x as usize);
        if (0..3).any(|axis| at[axis] >= self.shape[axis]) {
            return OUTSIDE * self.voxel;
        }
        f64::from(self.depth[row_at(self.shape, at)])
    }
}

/// The largest whole number that is not above `x`: `f64::floor`, which is a call where the processor is not known.
fn floor(x: f64) -> f64 {
    let whole = x as isize as f64;
    if whole > x { whole - 1.0 } else { whole }
}
