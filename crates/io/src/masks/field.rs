//! The depth of every place below the wall of a mask's lumen: a signed distance, between voxels by trilinear interpolation.

use super::{Foreground, distances, inverse_of, neighbours, steps_of};
use willis_core::network::{metres, millimetres};
use willis_core::support::geometry::{Point, cross, dot, norm, norm_squared};

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
        dot(self.steps[0], cross(self.steps[1], self.steps[2])).abs() * metres(1.0).powi(3)
    }

    /// The depth (m) of a place (m) below the wall; negative outside.
    pub fn signed(&self, place: Point) -> f64 {
        let at = self.index(place);
        let low = at.map(floor);
        let share = [0, 1, 2].map(|k| at[k] - low[k]);
        let [x, y, z] = low.map(|index| index as isize);
        let between = |a: f64, b: f64, share: f64| a + share * (b - a);
        // Where all eight voxels are in the box, their rows follow from the first.
        let [along_y, along_z] = [self.shape[0], self.shape[0] * self.shape[1]];
        let is_inside = [x, y, z].iter().zip(self.shape).all(|(index, length)| *index >= 0 && (*index as usize) + 1 < length);
        let first = if is_inside { z as usize * along_z + y as usize * along_y + x as usize } else { 0 };
        let corner = |i: usize, j: usize, k: usize| {
            if is_inside {
                f64::from(self.depth[first + k * along_z + j * along_y + i])
            } else {
                self.at([x + i as isize, y + j as isize, z + k as isize])
            }
        };
        let along_x = |j: usize, k: usize| between(corner(0, j, k), corner(1, j, k), share[0]);
        let in_layer = |k: usize| between(along_x(0, k), along_x(1, k), share[1]);
        metres(between(in_layer(0), in_layer(1), share[2]))
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
                        if norm_squared(apart) <= reach * reach {
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
        let [x, y, z] = index.map(|x| x as usize);
        if x >= self.shape[0] || y >= self.shape[1] || z >= self.shape[2] {
            return OUTSIDE * self.voxel;
        }
        f64::from(self.depth[(z * self.shape[1] + y) * self.shape[0] + x])
    }
}

/// The largest whole number that is not above `x`: `f64::floor`, which is a call where the processor is not known.
fn floor(x: f64) -> f64 {
    let whole = x as isize as f64;
    if whole > x { whole - 1.0 } else { whole }
}
