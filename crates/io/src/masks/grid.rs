//! Where the voxels of an image are: in the order in which it holds them, and in space.

use willis_core::network::metres;
use willis_core::support::geometry::{Point, bounds, cross, dot, norm};

/// Millimetres in the scanner's frame (x to the patient's right, y forward, z up) from voxel indices: three rows of four.
pub type Affine = [[f64; 4]; 3];

/// The steps of one voxel along each axis, mm.
pub fn steps_of(affine: &Affine) -> [Point; 3] {
    [0, 1, 2].map(|axis| affine.map(|row| row[axis]))
}

/// The indices of the voxel of a row, in an image of these lengths.
pub fn indices_of([x, y, _]: [usize; 3], row: usize) -> [usize; 3] {
    [row % x, row / x % y, row / (x * y)]
}

/// The row of the voxel with these indices, in an image of these lengths.
pub fn row_at([x, y, _]: [usize; 3], at: [usize; 3]) -> usize {
    (at[2] * y + at[1]) * x + at[0]
}

/// Steps from a row to the next along each axis, in an image of these lengths.
pub fn strides_of([x, y, _]: [usize; 3]) -> [usize; 3] {
    [1, x, x * y]
}

/// The box (m) around the middles of the voxels between two indices.
pub(super) fn box_between(affine: &Affine, ends: [[f64; 3]; 2]) -> [Point; 2] {
    let index = |corner: usize| [0, 1, 2].map(|axis| ends[corner >> axis & 1][axis]);
    bounds((0..8).map(index).map(|at| affine.map(|[a, b, c, d]| metres(a * at[0] + b * at[1] + c * at[2] + d))))
}

/// The volume between the steps of one voxel.
pub fn volume_of([a, b, c]: [Point; 3]) -> f64 {
    dot(a, cross(b, c)).abs()
}

/// The rows that make indices of mm, from the steps of voxels.
pub fn inverse_of([a, b, c]: [Point; 3]) -> [Point; 3] {
    let volume = dot(a, cross(b, c));
    [cross(b, c), cross(c, a), cross(a, b)].map(|row| row.map(|x| x / volume))
}

/// The image's axis that runs along x, along y and along z the most, each taken once: of the six ways the one with the largest sum of
/// cosines.
pub(super) fn axes_by_direction(affine: &Affine) -> [usize; 3] {
    const WAYS: [[usize; 3]; 6] = [[0, 1, 2], [0, 2, 1], [1, 0, 2], [1, 2, 0], [2, 0, 1], [2, 1, 0]];
    let length = steps_of(affine).map(norm);
    let along = |way: &[usize; 3]| (0..3).map(|row| (affine[row][way[row]] / length[way[row]]).abs()).sum::<f64>();
    WAYS[1..].iter().fold(WAYS[0], |best, way| if along(way) > along(&best) + 1e-9 { *way } else { best })
}
