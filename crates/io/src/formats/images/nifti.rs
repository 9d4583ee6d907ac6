//! Reads masks and images in NIfTI-1 and NIfTI-2, plain or compressed by gzip, and writes masks in NIfTI-1.
//!
//! The frame is that of nibabel: sform where it has a code, else qform, else the middle of the image with x to the left. Source: the
//! headers `nifti1.h` and `nifti2.h` of nifti.nimh.nih.gov.

use std::io::{self, Read, Write, copy, sink};

use flate2::{Compression, read::MultiGzDecoder, write::GzEncoder};

use super::voxels::{OpenedVoxels, Voxels, number_type};
use crate::formats::binary::{NumberType, signed, word};
use crate::formats::input::is_gzip;
use crate::formats::{ensure, refused};
use crate::masks::{Affine, Image, Mask, steps_of};
use willis_core::{error::Fault, network::Frame, support::geometry::norm};

/// The length of the header of NIfTI-2, the longer one.
pub(crate) const HEAD: usize = 540;
const ACCEPTED: &str = "expected a NIfTI mask or image (.nii, .nii.gz) of three dimensions";

/// Which of the two versions a file has that begins with these (unpacked) bytes, and whether its numbers have the most significant
/// byte first.
fn version(head: &[u8]) -> Option<(Layout, bool)> {
    let size = head.get(..4)?;
    let of = |big: bool| match word(size, big) {
        348 if matches!(head.get(344..348), Some(b"n+1\0" | b"ni1\0")) => Some((ONE, big)),
        540 if matches!(head.get(4..7), Some(b"n+2" | b"ni2")) => Some((TWO, big)),
        _ => None,
    };
    of(false).or_else(|| of(true))
}

/// Whether unpacked bytes begin a NIfTI file.
pub(crate) fn is_nifti(head: &[u8]) -> bool {
    version(head).is_some()
}

/// Where the fields of a header are.
#[derive(Clone, Copy)]
struct Layout {
    /// Whether numbers are as wide as in NIfTI-2.
    wide: bool,
    dim: usize,
    datatype: usize,
    pixdim: usize,
    /// The first byte of the voxels, followed by slope and intercept.
    offset: usize,
    /// The code of qform, followed by that of sform.
    codes: usize,
    /// The quaternion and the origin of qform, followed by the rows of sform.
    frames: usize,
    units: usize,
}

const ONE: Layout = Layout { wide: false, dim: 40, datatype: 70, pixdim: 76, offset: 108, codes: 252, frames: 256, units: 123 };
const TWO: Layout = Layout { wide: true, dim: 16, datatype: 12, pixdim: 104, offset: 168, codes: 344, frames: 352, units: 500 };

impl Layout {
    /// Bytes of a real number; a code has half of them.
    fn real(self) -> usize {
        if self.wide { 8 } else { 4 }
    }
}

/// A header and how it is read.
struct NiftiHeader<'a> {
    head: &'a [u8],
    layout: Layout,
    big: bool,
}

/// Reads the header, and hands over how the voxels are stored with their bytes, of which at most `most` are allowed.
pub(crate) fn open_nifti(bytes: &[u8], most: u64) -> OpenedVoxels<'_> {
    let mut stream: Box<dyn Read + '_> = if is_gzip(bytes) { Box::new(MultiGzDecoder::new(bytes)) } else { Box::new(bytes) };
    let mut head = Vec::new();
    let cut = |error: std::io::Error| Fault::file(format!("unreadable: {error}"), "expected a whole file");
    stream.by_ref().take(348).read_to_end(&mut head).map_err(cut)?;
    if head.len() == 348 && head[4..6] == *b"n+" {
        stream.by_ref().take((HEAD - 348) as u64).read_to_end(&mut head).map_err(cut)?;
    }
    let (layout, big) = version(&head)
        .filter(|(layout, _)| head.len() >= layout.frames + 18 * layout.real())
        .ok_or_else(|| Fault::file(format!("a header of {} bytes", head.len()), ACCEPTED))?;
    let header = NiftiHeader { head: &head, layout, big };
    let (voxels, offset) = header.voxels()?;
    voxels.bytes(most)?;
    let skipped = offset.saturating_sub(head.len() as u64);
    copy(&mut stream.by_ref().take(skipped), &mut sink()).map_err(cut)?;
    Ok((voxels, stream))
}

/// Writes a mask as NIfTI-1, one byte a voxel, with its frame as sform; as qform too where the axes are those of the frame. `packed`
/// compresses it by gzip.
///
/// # Errors
///
/// Those of `out`; `InvalidInput` for more than 32767 voxels along an axis.
pub fn write_nifti(out: impl Write, mask: &Mask, packed: bool) -> io::Result<()> {
    let head = header_of(mask.shape, &mask.affine, (2, 8), 1.0)?;
    write_voxels(out, &head, &mask.classes, packed)
}

/// Writes an image as [`write_nifti`] writes a mask, two bytes a voxel: the largest value is kept to one part in 32,000.
///
/// # Errors
///
/// Those of [`write_nifti`].
pub fn write_nifti_image(out: impl Write, image: &Image, packed: bool) -> io::Result<()> {
    let most = image.values.iter().map(|x| x.abs()).fold(f32::MIN_POSITIVE, f32::max);
    let slope = most / 32_000.0;
    let voxels: Vec<u8> = image.values.iter().flat_map(|x| ((x / slope).round() as i16).to_le_bytes()).collect();
    let head = header_of(image.shape, &image.affine, (4, 16), slope)?;
    write_voxels(out, &head, &voxels, packed)
}

fn write_voxels(mut out: impl Write, head: &[u8], voxels: &[u8], packed: bool) -> io::Result<()> {
    if packed {
        let mut packer = GzEncoder::new(&mut out, Compression::best());
        packer.write_all(head)?;
        packer.write_all(voxels)?;
        packer.finish()?;
    } else {
        out.write_all(head)?;
        out.write_all(voxels)?;
    }
    out.flush()
}

/// A header of NIfTI-1 and four bytes that say that nothing follows it but the voxels, of this type and so many bits.
fn header_of(shape: [usize; 3], affine: &Affine, (datatype, bits): (i16, i16), slope: f32) -> io::Result<[u8; 352]> {
    let mut head = [0; 352];
    let mut put = |at: usize, bytes: &[u8]| head[at..at + bytes.len()].copy_from_slice(bytes);
    let real = |x: f64| (x as f32).to_le_bytes();
    put(0, &348_i32.to_le_bytes());
    put(ONE.dim, &3_i16.to_le_bytes());
    for n in 0..7 {
        let length = shape.get(n).copied().unwrap_or(1);
        let many = |_| refused(format!("{length} voxels along an axis, more than 32767"));
        let length = i16::try_from(length).map_err(many)?;
        put(ONE.dim + 2 * (n + 1), &length.to_le_bytes());
    }
    put(ONE.datatype, &datatype.to_le_bytes());
    put(ONE.datatype + 2, &bits.to_le_bytes());
    put(ONE.pixdim, &real(1.0));
    for (n, spacing) in steps_of(affine).map(norm).into_iter().enumerate() {
        put(ONE.pixdim + 4 * (n + 1), &real(spacing));
    }
    put(ONE.offset, &real(352.0));
    put(ONE.offset + ONE.real(), &slope.to_le_bytes());
    // Millimetres.
    put(ONE.units, &[2]);
    put(ONE.codes + ONE.real() / 2, &1_i16.to_le_bytes());
    for (n, x) in affine.iter().flatten().enumerate() {
        put(ONE.frames + 4 * (6 + n), &real(*x));
    }
    let is_straight =
        (0..3).all(|row| (0..3).all(|column| if row == column { affine[row][column] > 0.0 } else { affine[row][column] == 0.0 }));
    if is_straight {
        put(ONE.codes, &1_i16.to_le_bytes());
        for (n, row) in affine.iter().enumerate() {
            put(ONE.frames + 4 * (3 + n), &real(row[3]));
        }
    }
    put(344, b"n+1\0");
    Ok(head)
}

impl NiftiHeader<'_> {
    fn whole(&self, at: usize, bytes: usize) -> i64 {
        signed(word(&self.head[at..at + bytes], self.big), bytes)
    }

    fn real(&self, first: usize, n: usize) -> f64 {
        let bytes = self.layout.real();
        NumberType::Real.value(&self.head[first + n * bytes..][..bytes], self.big)
    }

    /// The code of qform, or of sform.
    fn code(&self, form: usize) -> i64 {
        let bytes = self.layout.real() / 2;
        self.whole(self.layout.codes + form * bytes, bytes)
    }

    /// How the voxels are stored, and where they begin.
    fn voxels(&self) -> Result<(Voxels, u64), Fault> {
        let layout = &self.layout;
        let magic: &[u8] = if layout.wide { &self.head[4..7] } else { &self.head[344..347] };
        let apart = || Fault::file("a header whose voxels are in another file", "expected both in one file (.nii, .nii.gz)");
        ensure(!magic.starts_with(b"ni"), apart)?;
        let bytes = if layout.wide { 8 } else { 2 };
        let dim = |n: usize| self.whole(layout.dim + n * bytes, bytes);
        let shape: Vec<i64> = (1..=dim(0).clamp(0, 7) as usize).map(dim).collect();
        let more = shape.iter().skip(3).any(|n| *n > 1);
        let length = |n: usize| shape.get(n).and_then(|n| usize::try_from(*n).ok()).filter(|n| *n > 0);
        let (Some(x), Some(y), Some(z), false) = (length(0), length(1), length(2), more) else {
            let words: Vec<String> = shape.iter().map(i64::to_string).collect();
            let found = format!("an image of {} dimensions: {}", shape.len(), words.join(" x "));
            return Err(Fault::file(found, super::stored_image::ONE_VOLUME));
        };
        let code = self.whole(layout.datatype, 2);
        let unknown = || Fault::file(format!("voxels of type {code}"), "expected whole or real numbers, one a voxel");
        let (kind, size) = number_type(|(_, _, of_nifti, ..)| *of_nifti == code).ok_or_else(unknown)?;
        let slope = [self.real(layout.offset, 1), self.real(layout.offset, 2)];
        let scaled = slope[0].is_finite() && slope[0] != 0.0;
        let offset = if layout.wide { self.whole(layout.offset, 8) } else { self.real(layout.offset, 0) as i64 };
        let affine = self.affine([x, y, z])?;
        let slope = if scaled { [slope[0], if slope[1].is_finite() { slope[1] } else { 0.0 }] } else { [1.0, 0.0] };
        let states_sides = [0, 1].into_iter().any(|form| self.code(form) > 0);
        let frame = if states_sides { Frame::Ras } else { Frame::Unknown };
        let offset = u64::try_from(offset).unwrap_or(0);
        Ok((Voxels { shape: [x, y, z], kind, size, big: self.big, slope, affine, frame, reversed: false }, offset))
    }

    /// The scanner's frame in mm from voxels.
    fn affine(&self, shape: [usize; 3]) -> Result<Affine, Fault> {
        let layout = &self.layout;
        let unit = match self.whole(layout.units, if layout.wide { 4 } else { 1 }) & 7 {
            1 => 1e3,
            3 => 1e-3,
            _ => 1.0,
        };
        let spacing = [1, 2, 3].map(|n| self.real(layout.pixdim, n));
        let affine = if self.code(1) > 0 {
            std::array::from_fn(|row| std::array::from_fn(|column| self.real(layout.frames, 6 + 4 * row + column)))
        } else if spacing.iter().any(|s| !(s.is_finite() && *s > 0.0)) {
            let found = format!("voxels of {} x {} x {} mm", spacing[0], spacing[1], spacing[2]);
            return Err(Fault::file(found, "expected a positive spacing along every axis (pixdim)"));
        } else if self.code(0) > 0 {
            self.qform(spacing)?
        } else {
            let middle = [0, 1, 2].map(|axis| (shape[axis] - 1) as f64 / 2.0 * spacing[axis]);
            let [x, y, z] = spacing;
            [[-x, 0.0, 0.0, middle[0]], [0.0, y, 0.0, -middle[1]], [0.0, 0.0, z, -middle[2]]]
        };
        Ok(affine.map(|row| row.map(|x: f64| x * unit)))
    }

    /// The frame of a rotation by a quaternion.
    fn qform(&self, spacing: [f64; 3]) -> Result<Affine, Fault> {
        let at = |n: usize| self.real(self.layout.frames, n);
        let (b, c, d) = (at(0), at(1), at(2));
        let square = 1.0 - (b * b + c * c + d * d);
        let wrong = || Fault::file(format!("quaternion {b} {c} {d}"), "expected a rotation: squares of at most 1 in all");
        // Three numbers of single precision may exceed 1 by their rounding.
        ensure(square >= -1e-5, wrong)?;
        let a = square.max(0.0).sqrt();
        let rotation = [
            [a * a + b * b - c * c - d * d, 2.0 * (b * c - a * d), 2.0 * (b * d + a * c)],
            [2.0 * (b * c + a * d), a * a + c * c - b * b - d * d, 2.0 * (c * d - a * b)],
            [2.0 * (b * d - a * c), 2.0 * (c * d + a * b), a * a + d * d - b * b - c * c],
        ];
        let last = if self.real(self.layout.pixdim, 0) < 0.0 { -spacing[2] } else { spacing[2] };
        Ok(std::array::from_fn(|row| {
            let [x, y, z] = rotation[row];
            [x * spacing[0], y * spacing[1], z * last, at(3 + row)]
        }))
    }
}
