//! Reads masks and images saved by NumPy: an array of three axes, x, y and z, in a file of its own or beside its frame in an archive.

use super::voxels::{OpenedVoxels, Voxels};
use crate::formats::UnpackLimit;
use crate::formats::numpy::array::{Archive, NumpyArray};
use willis_core::{error::Fault, network::Frame};

/// What the array of an archive is called: by this program, in sets of segmentations, by NumPy for one without a name.
const VOXELS: [&str; 8] = ["mask", "seg", "segmentation", "label", "labels", "image", "data", "arr_0"];

/// Whether the arrays of an archive are those of a mask.
pub(crate) fn is_mask(bytes: &[u8]) -> bool {
    let room = UnpackLimit::of(bytes.len(), 0);
    Archive::open(bytes, &room).is_ok_and(|archive| {
        let is_graph = ["edges", "indptr", "row"].iter().any(|name| archive.has(name));
        !is_graph && VOXELS.iter().any(|name| archive.has(name))
    })
}

/// Reads the header, of an `.npy` file or of an archive whose array is called `mask` or another usual name, and hands over how the voxels are
/// stored with their bytes. The first axis of the array is x; axes of one before and after three say nothing.
///
/// The arrays `affine` (4, 4), nibabel's, and `spacing` (3) of an archive state the frame; else voxel 0,0,0 is at the origin, the spacing
/// is the one given, and nobody states which way the axes point. At most `most` bytes are read, which go to `other`.
pub(crate) fn open_numpy<'a>(bytes: &[u8], spacing: Option<[f64; 3]>, most: u64, other: &'a mut Vec<u8>) -> OpenedVoxels<'a> {
    let room = UnpackLimit::of(bytes.len(), most);
    let (array, affine, stated) = if bytes.starts_with(b"PK") {
        let mut archive = Archive::open(bytes, &room)?;
        let array = archive.first(&VOXELS)?.ok_or_else(|| archive.lacks(VOXELS[0]))?;
        (array, stated_affine(&mut archive)?, stated_spacing(&mut archive)?)
    } else {
        (NumpyArray::read("of voxels", bytes, bytes.len() as u64, &room)?, None, None)
    };
    let mut axes = array.shape.as_slice();
    while let (true, Some(fewer)) = (axes.len() > 3, axes.strip_suffix(&[1]).or_else(|| axes.strip_prefix(&[1]))) {
        axes = fewer;
    }
    let Ok([x, y, z]) = <[usize; 3]>::try_from(axes) else {
        let accepted = "expected a mask of three, or a skeleton graph as .npz: coords, edges, radii";
        return Err(array.fault(format!("{} dimensions", array.shape.len()), accepted));
    };
    let (rows, frame) = match (affine, stated.or(spacing)) {
        (Some(affine), _) => (affine, Frame::Ras),
        (None, Some([x, y, z])) => ([[x, 0.0, 0.0, 0.0], [0.0, y, 0.0, 0.0], [0.0, 0.0, z, 0.0]], Frame::Unknown),
        (None, None) => return Err(array.fault("no spacing: NumPy states none", "expected `spacing=SX,SY,SZ`, in mm")),
    };
    let (kind, size, big) = array.numbers()?;
    // In C order the last axis runs fastest.
    let reversed = !array.fortran;
    let (shape, affine) = if reversed { ([z, y, x], rows.map(|[x, y, z, origin]| [z, y, x, origin])) } else { ([x, y, z], rows) };
    *other = array.data;
    Ok((Voxels { shape, kind, size, big, slope: [1.0, 0.0], affine, frame, reversed }, Box::new(other.as_slice())))
}

/// The frame that an archive states beside its voxels.
fn stated_affine(archive: &mut Archive) -> Result<Option<crate::masks::Affine>, Fault> {
    let Some(array) = archive.first(&["affine"])? else { return Ok(None) };
    let rows = array.rows::<4>()?;
    let three = rows.first_chunk::<3>().filter(|_| rows.len() == 4 && rows[3] == [0.0, 0.0, 0.0, 1.0]);
    let accepted = "expected 4 rows, the last one 0, 0, 0, 1, as nibabel's affine";
    three.copied().map(Some).ok_or_else(|| array.fault(format!("{rows:?}"), accepted))
}

/// The spacing that it states, mm.
fn stated_spacing(archive: &mut Archive) -> Result<Option<[f64; 3]>, Fault> {
    let Some(array) = archive.first(&["spacing"])? else { return Ok(None) };
    let values = array.reals()?;
    let positive = <[f64; 3]>::try_from(values.as_slice()).ok().filter(|all| all.iter().all(|s| s.is_finite() && *s > 0.0));
    positive.map(Some).ok_or_else(|| array.fault(format!("{values:?}"), "expected three positive numbers, in mm"))
}
