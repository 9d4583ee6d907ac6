//! Reads masks and images in MetaImage, the format of ITK: `.mha` in one file, `.mhd` with the voxels beside it.
//!
//! ITK's frame has x to the patient's left and y backward; both are turned. Source: the documentation of MetaIO.

use std::path::{Path, PathBuf};

use super::stored_image::{ONE_VOLUME, StoredImage};
use super::voxels::{Voxels, number_type};
use crate::formats::ensure;
use crate::formats::header_fields::{HeaderFields, HeaderLines};
use willis_core::error::{Fault, Result};

/// The field that names the file of the voxels.
const DATA: &str = "ElementDataFile";
/// No header is longer; some list the tags of every slice.
const MOST_HEADER: usize = 1 << 22;

/// The fields of a header, each with its line, and where the voxels of the same file begin.
struct MetaHeader {
    fields: HeaderFields,
    end: usize,
}

/// Whether a file begins with the header of an image.
pub(crate) fn is_metaimage(bytes: &[u8]) -> bool {
    let head = &bytes[..bytes.len().min(MOST_HEADER)];
    let lines =
        head.split(|byte| *byte == b'\n').filter(|line| !line.trim_ascii().is_empty()).take_while(|line| line.contains(&b'='));
    let mut keys = lines.filter_map(|line| line.split(|byte| *byte == b'=').next()).map(<[u8]>::trim_ascii);
    keys.any(|key| key == b"ElementDataFile")
}

/// The file beside `path` that holds its voxels, if they are not in the same file.
pub(crate) fn file_of_voxels(path: &Path, bytes: &[u8]) -> Option<PathBuf> {
    let header = MetaHeader::read(bytes).ok()?;
    header.fields.file(path, DATA).filter(|_| !header.is_local())
}

/// Reads the header, of which `path` tells where a second file is; the bytes of that go to `other`. `spacing` (mm) is for a header that states
/// none. At most `most` bytes are read.
pub(crate) fn open_metaimage<'a>(
    path: &Path,
    bytes: &'a [u8],
    other: &'a mut Vec<u8>,
    spacing: Option<[f64; 3]>,
    most: u64,
) -> Result<StoredImage<'a>> {
    let here = |fault: Fault| fault.in_file(path);
    let header = MetaHeader::read(bytes).map_err(here)?;
    let voxels = header.voxels(spacing).map_err(here)?;
    let needed = voxels.bytes(most).map_err(here)?;
    let (file, data) = if header.is_local() {
        (path.to_owned(), &bytes[header.end..])
    } else {
        let file;
        let accepted = "expected LOCAL, or the name of one file in the same folder";
        (file, *other) = header.fields.file_bytes(path, DATA, most, accepted)?;
        (file, other.as_slice())
    };
    if header.fields.is_true("CompressedData") {
        return Ok(StoredImage { file, voxels, layers: None, stream: Box::new(flate2::read::ZlibDecoder::new(data)) });
    }
    // HeaderSize -1: the voxels are the last bytes of the file.
    let skipped = match header.fields.get("HeaderSize") {
        Some((_, "-1")) => data.len().saturating_sub(usize::try_from(needed).unwrap_or(usize::MAX)),
        Some((_, size)) => size.parse().map_err(|_| here(header.fields.wrong("HeaderSize", "expected a whole number")))?,
        None => 0,
    };
    Ok(StoredImage { file, voxels, layers: None, stream: Box::new(data.get(skipped..).unwrap_or_default()) })
}

impl MetaHeader {
    fn read(bytes: &[u8]) -> Result<Self, Fault> {
        // A line that begins within the header is read whole.
        let head = &bytes[..bytes.len().min(2 * MOST_HEADER)];
        let (mut fields, mut lines) = (HeaderFields::default(), HeaderLines::new(head));
        while head.len() - lines.rest.len() < MOST_HEADER
            && let Some((line, key, value)) = lines.entry()?
        {
            fields.insert(&key, line, &value);
            if key == DATA {
                return Ok(Self { fields, end: head.len() - lines.rest.len() });
            }
        }
        Err(Fault::file("no ElementDataFile", "expected it as the last line of the header"))
    }

    /// Whether the voxels are in the file of the header.
    fn is_local(&self) -> bool {
        self.fields.get(DATA).is_some_and(|(_, name)| name.eq_ignore_ascii_case("local"))
    }

    fn voxels(&self, given: Option<[f64; 3]>) -> Result<Voxels, Fault> {
        let axes = match self.fields.needed("NDims")? {
            (_, "3") => 3,
            (_, "4") => 4,
            _ => return Err(self.fields.wrong("NDims", ONE_VOLUME)),
        };
        if let Some((line, channels)) = self.fields.get("ElementNumberOfChannels").filter(|(_, channels)| *channels != "1") {
            return Err(Fault::line(line, format!("{channels} values a voxel"), "expected one"));
        }
        let is_binary = self.fields.get("BinaryData").is_none() || self.fields.is_true("BinaryData");
        ensure(is_binary, || Fault::file("voxels as text", "expected BinaryData = True"))?;
        let (_, word) = self.fields.needed("ElementType")?;
        let accepted = "expected MET_UCHAR, MET_SHORT, MET_FLOAT or another type of number";
        let (kind, size) = number_type(|(.., of_metaimage, _)| of_metaimage.split('|').any(|known| known == word))
            .ok_or_else(|| self.fields.wrong("ElementType", accepted))?;
        self.fields.needed("DimSize")?;
        let shape: Vec<usize> = self.fields.numbers("DimSize", axes, "whole numbers", |_| true)?.unwrap_or_default();
        ensure(shape.get(3).is_none_or(|volumes| *volumes == 1), || self.fields.wrong("DimSize", ONE_VOLUME))?;
        let shape = [shape[0], shape[1], shape[2]];
        let numbers = |names: &[&str], count: usize| self.fields.first_numbers(names, count, "numbers", |_| true);
        let three = |all: Vec<f64>| [all[0], all[1], all[2]];
        let none = || Fault::file("no ElementSpacing", "expected it in the header, or give `spacing=SX,SY,SZ`, in mm");
        let spacing = numbers(&["ElementSpacing", "ElementSize"], axes)?.map(three).or(given).ok_or_else(none)?;
        let origin = numbers(&["Offset", "Position", "Origin"], axes)?.map_or([0.0; 3], three);
        let identity = |at: usize| if at.is_multiple_of(axes + 1) { 1.0 } else { 0.0 };
        let directions = numbers(&["TransformMatrix", "Rotation", "Orientation"], axes * axes)?;
        let directions = directions.unwrap_or_else(|| (0..axes * axes).map(identity).collect());
        if let Some(bad) = spacing.iter().find(|s| !(s.is_finite() && **s > 0.0)) {
            return Err(Fault::file(format!("ElementSpacing {bad}"), "expected a positive spacing along every axis"));
        }
        // The matrix has the direction of one axis after the other.
        let affine = std::array::from_fn(|row| {
            let turn = if row < 2 { -1.0 } else { 1.0 };
            std::array::from_fn(|column| {
                turn * if column < 3 { directions[axes * column + row] * spacing[column] } else { origin[row] }
            })
        });
        let big = self.fields.is_true("BinaryDataByteOrderMSB") || self.fields.is_true("ElementByteOrderMSB");
        Ok(Voxels { shape, kind, size, big, slope: [1.0, 0.0], affine, frame: willis_core::network::Frame::Ras, reversed: false })
    }
}
