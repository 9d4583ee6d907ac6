//! Reads masks and images saved by NumPy: an array of three axes, x, y and z, whose spacing the caller states.

use crate::formats::input::UnpackLimit;
use crate::formats::numpy::array::Array;
use crate::masks::{Image, Mask};
use willis_core::error::Fault;

use super::voxels::Voxels;

/// Reads a mask. The first axis of the array is x; voxel 0,0,0 is at the origin.
///
/// From `level` on a voxel is a vessel; without it the values are classes. At most `most` bytes are read.
///
/// # Errors
///
/// A file that is cut, no mask of three dimensions, or one without a usable frame.
pub fn read_npy_mask(bytes: &[u8], spacing: Option<[f64; 3]>, level: Option<f64>, most: u64) -> Result<Mask, Fault> {
    with_voxels(bytes, spacing, most, |voxels, stream| voxels.read(stream, level, most))
}

/// Reads an image, at most `most` bytes of it. The first axis of the array is x; voxel 0,0,0 is at the origin.
///
/// # Errors
///
/// A file that is cut, no image of three dimensions, or one without a usable frame.
pub fn read_npy_image(bytes: &[u8], spacing: Option<[f64; 3]>, most: u64) -> Result<Image, Fault> {
    with_voxels(bytes, spacing, most, |voxels, stream| voxels.read_values(stream, most))
}

/// Reads the header, and hands over how the voxels are stored with their bytes.
fn with_voxels<T>(
    bytes: &[u8],
    spacing: Option<[f64; 3]>,
    most: u64,
    take: impl FnOnce(Voxels, &[u8]) -> Result<T, Fault>,
) -> Result<T, Fault> {
    let array = Array::read("of voxels", bytes, bytes.len() as u64, &UnpackLimit::of(bytes.len(), most))?;
    // A fourth axis of one volume says nothing.
    let axes = array.shape.strip_suffix(&[1]).filter(|axes| axes.len() == 3).unwrap_or(&array.shape);
    let Ok([x, y, z]) = <[usize; 3]>::try_from(axes) else {
        return Err(array.fault(
            format!("{} dimensions", array.shape.len()),
            "expected a mask of three, or a skeleton graph as .npz: coords, edges, radii",
        ));
    };
    let Some(spacing) = spacing else {
        return Err(array.fault("no spacing: NumPy states none", "expected `spacing` SX,SY,SZ, in mm"));
    };
    let (kind, size, big) = array.numbers()?;
    let diagonal = |axis: usize| std::array::from_fn(|column| if column == axis { spacing[axis] } else { 0.0 });
    let rows: [[f64; 4]; 3] = std::array::from_fn(diagonal);
    // In C order the last axis runs fastest.
    let (shape, affine) =
        if array.is_fortran() { ([x, y, z], rows) } else { ([z, y, x], rows.map(|[x, y, z, origin]| [z, y, x, origin])) };
    take(Voxels { shape, kind, size, big, slope: [1.0, 0.0], affine }, array.bytes())
}
