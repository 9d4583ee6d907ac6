//! A segmentation mask: a class for every voxel, and where the voxels are.

use super::grid::{Affine, axes_by_direction, indices_of, row_at, steps_of, volume_of};
use willis_core::network::Frame;
use willis_core::support::geometry::{Point, norm};

/// A class for every voxel of an image; 0 is background.
#[derive(Debug, Clone)]
pub struct Mask {
    /// Voxels along the three axes of the image; the first runs fastest.
    pub shape: [usize; 3],
    /// The class of each voxel.
    pub classes: Vec<u8>,
    /// Where the centre of each voxel is, mm.
    pub affine: Affine,
    /// The voxels that lie inside vessels in part, where that is known.
    pub walls: Option<super::partial::Walls>,
    /// The frame of positions: the scanner's, RAS, unless the file states none.
    pub frame: Frame,
    /// Whether the file's array counts its axes from the one that varies slowest, as NumPy does.
    pub reversed: bool,
    /// What its file calls classes; others are known by their number.
    pub names: std::collections::BTreeMap<u8, String>,
    /// Notes for the user about how it was read, one line each.
    pub notes: Vec<String>,
}

impl Mask {
    /// A mask in the scanner's frame.
    pub fn new(shape: [usize; 3], classes: Vec<u8>, affine: Affine) -> Self {
        let (walls, names, notes) = Default::default();
        Self { shape, classes, affine, walls, frame: Frame::Ras, reversed: false, names, notes }
    }

    /// Numbers along the three axes, in the order in which the file counts them.
    pub fn as_in_file<T>(&self, mut along: [T; 3]) -> [T; 3] {
        if self.reversed {
            along.reverse();
        }
        along
    }

    /// The length of a voxel along each axis, mm.
    pub fn spacing(&self) -> [f64; 3] {
        steps_of(&self.affine).map(norm)
    }

    /// The volume of a voxel, mm³.
    pub fn voxel_volume(&self) -> f64 {
        volume_of(steps_of(&self.affine))
    }

    /// The position of a voxel, or of a place between voxels, mm.
    pub fn position(&self, voxel: Point) -> Point {
        self.affine.map(|[a, b, c, d]| a * voxel[0] + b * voxel[1] + c * voxel[2] + d)
    }

    /// The same mask with its axes in the order and the direction of the scanner's frame, as close as whole turns bring them, so that
    /// a result does not depend on how the file orders its axes.
    #[must_use]
    pub fn in_scanner_order(self) -> Self {
        // The new axes 0, 1, 2 are the scanner's z, y, x: the last one varies slowest, as in the arrays that nibabel makes.
        let by_direction = axes_by_direction(&self.affine);
        let source = [2, 1, 0].map(|direction| by_direction[direction]);
        let towards = self.frame.turn(Frame::Ras, [1.0; 3]);
        let flipped = [0, 1, 2].map(|axis| self.affine[2 - axis][source[axis]] * towards[2 - axis] < 0.0);
        if source == [0, 1, 2] && flipped == [false; 3] {
            return self;
        }
        let shape = source.map(|axis| self.shape[axis]);
        // The new row of an old one.
        let place = |row: usize| {
            let old = source.map(|axis| indices_of(self.shape, row)[axis]);
            row_at(shape, [0, 1, 2].map(|axis| if flipped[axis] { shape[axis] - 1 - old[axis] } else { old[axis] }))
        };
        let mut classes = vec![0; self.classes.len()];
        for (row, class) in self.classes.iter().enumerate().filter(|(_, class)| **class > 0) {
            classes[place(row)] = *class;
        }
        let affine = self.affine.map(|row| {
            let sign = [0, 1, 2].map(|axis| if flipped[axis] { -1.0 } else { 1.0 });
            let origin =
                (0..3).filter(|axis| flipped[*axis]).map(|axis| row[source[axis]] * (shape[axis] - 1) as f64).sum::<f64>();
            [sign[0] * row[source[0]], sign[1] * row[source[1]], sign[2] * row[source[2]], row[3] + origin]
        });
        let walls = self.walls.map(|mut walls| {
            for (voxel, _) in &mut walls.voxels {
                *voxel = place(*voxel as usize) as u32;
            }
            walls.voxels.sort_unstable_by_key(|(voxel, _)| *voxel);
            walls
        });
        Self { shape, classes, affine, walls, reversed: false, ..self }
    }
}
