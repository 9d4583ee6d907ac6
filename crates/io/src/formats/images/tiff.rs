//! Reads masks and images in TIFF: a stack of pages, the first axis along a row, the second from row to row, the third from page to page.
//!
//! The spacing is that of ImageJ (its description of the first page and the tags of the resolution) or of OME-XML. Source: TIFF 6.0; ImageJ's
//! `ij/io/TiffEncoder.java`; the OME data model.

use std::collections::HashMap;
use std::io::{self, Cursor, Read};

use tiff::decoder::{Decoder, DecodingResult, Limits, ifd::Value};
use tiff::{ColorType, tags::Tag};

use super::{stored_image::Pieces, voxels::Voxels};
use crate::formats::{NumberType, ensure};
use willis_core::error::Fault;
use willis_core::network::{Frame, LengthUnit};

/// More than the methods of compression can gain: LZW codes up to 4,096 bytes in 12 bits.
const MOST_GAIN: u64 = 1 << 12;
/// The most bytes of one page, which is in memory as a whole.
const MOST_PAGE: u64 = 1 << 30;
/// The bytes of a description that are looked at; OME-XML states the spacing near its beginning.
const MOST_DESCRIPTION: usize = 1 << 18;
/// What a page says whose values are rows of a table of colours.
const COLOUR_TABLE: u16 = 3;
/// What a page says in which 0 is drawn white, which changes no value: programs save masks with an inverted table of greys.
const WHITE_IS_ZERO: u16 = 0;
const NO_SPACING: &str = "expected that of ImageJ or OME-XML, or give `spacing=SX,SY,SZ`, in mm";
const NOT_ONE_VOLUME: &str = "expected three dimensions; take one channel and one time";

type Pages<'a> = Decoder<Cursor<&'a [u8]>>;

/// Whether a file begins as TIFF or BigTIFF does.
pub(crate) fn is_tiff(bytes: &[u8]) -> bool {
    [b"II\x2a\0", b"MM\0\x2a", b"II\x2b\0", b"MM\0\x2b"].iter().any(|signature| bytes.starts_with(*signature))
}

/// A fault of the file from one of the library.
fn broken(error: &tiff::TiffError) -> Fault {
    let accepted = "expected a whole TIFF file of grey values, as they are or packed by Deflate, LZW or PackBits";
    Fault::file(format!("unreadable: {error}"), accepted)
}

/// Reads the headers of all pages, and hands over how the voxels are stored with their bytes. `spacing` (mm) stands for what the file states;
/// voxel 0,0,0 is at the origin, and nobody states which way the axes point. At most `most` bytes are read.
pub(crate) fn open_tiff(bytes: &[u8], spacing: Option<[f64; 3]>, most: u64) -> super::voxels::OpenedVoxels<'_> {
    let limits = || {
        let mut limits = Limits::default();
        limits.decoding_buffer_size = usize::try_from(most.min(MOST_PAGE)).unwrap_or(usize::MAX);
        limits.intermediate_buffer_size = limits.decoding_buffer_size;
        // Tables of strips, and descriptions.
        limits.ifd_value_size = 1 << 26;
        limits
    };
    let opened = || Decoder::new(Cursor::new(bytes)).map(|pages| pages.with_limits(limits())).map_err(|error| broken(&error));
    let mut pages = opened()?;
    let description = description(&mut pages);
    let (stated, slices) = if description.starts_with("ImageJ=") {
        of_imagej(&mut pages, &description)?
    } else if description.trim_start().starts_with('<') && description.contains("Pixels") {
        of_ome(&description)?
    } else {
        Stated::default()
    };
    let ([x, y], (kind, size)) = page(&mut pages)?;
    let mut count = 1;
    while pages.more_images() {
        pages.next_image().map_err(|error| broken(&error))?;
        let (other, number) = page(&mut pages)?;
        let found = || format!("page {}: {} x {} pixels of {} bytes", count + 1, other[0], other[1], number.1);
        let wrong = || Fault::file(found(), format!("expected {x} x {y} of {size} bytes, as the first page"));
        ensure(other == [x, y] && number == (kind, size), wrong)?;
        count += 1;
    }
    if let Some(slices) = slices.filter(|slices| *slices != count) {
        let found = format!("{count} of {slices} pages");
        return Err(Fault::file(found, "expected every slice as a page of the same file; export it as NIfTI or NRRD"));
    }
    let spacing = match (spacing, stated.map(|length| length.filter(|length| length.is_finite() && *length > 0.0))) {
        (Some(given), _) => given,
        (None, [Some(x), Some(y), Some(z)]) => [x, y, z],
        (None, [Some(x), Some(y), None]) if count == 1 => [x, y, x],
        (None, [None, ..] | [_, None, _]) => return Err(Fault::file("no spacing of the pixels", NO_SPACING)),
        (None, _) => return Err(Fault::file("no spacing of the slices", NO_SPACING)),
    };
    let affine = std::array::from_fn(|row| std::array::from_fn(|column| if row == column { spacing[row] } else { 0.0 }));
    // The library gives numbers as this machine has them.
    let big = cfg!(target_endian = "big");
    let voxels =
        Voxels { shape: [x, y, count], kind, size, big, slope: [1.0, 0.0], affine, frame: Frame::Unknown, reversed: false };
    let of_page = voxels.bytes(most)? / count as u64;
    let found = || format!("pages of {of_page} bytes in a file of {}", bytes.len());
    let wrong = || Fault::file(found(), "expected a whole file, and pages of at most 1 GiB");
    ensure(of_page <= MOST_PAGE && of_page / MOST_GAIN <= bytes.len() as u64, wrong)?;
    Ok((voxels, Box::new(values_of(opened()?))))
}

/// The pixels of a page along its two axes, and their type of number with its bytes.
fn page(pages: &mut Pages) -> Result<([usize; 2], (NumberType, usize)), Fault> {
    let accepted = "expected grey values; in ImageJ take Image > Lookup Tables > Grays before it is saved";
    ensure(photometric(pages) != Some(COLOUR_TABLE), || Fault::file("pixels with a table of colours", accepted))?;
    let color = pages.colortype().map_err(|error| broken(&error))?;
    let bits = match color {
        ColorType::Gray(bits @ (8 | 16 | 32 | 64)) => bits,
        other => {
            let found = format!("pixels of type {other:?}");
            return Err(Fault::file(found, "expected one grey value each, of 8, 16, 32 or 64 bits"));
        }
    };
    let kind = match pages.find_tag_unsigned::<u16>(Tag::SampleFormat).map_err(|error| broken(&error))? {
        None | Some(1 | 4) => NumberType::Unsigned,
        Some(2) => NumberType::Signed,
        Some(3) if bits >= 32 => NumberType::Real,
        Some(other) => return Err(Fault::file(format!("SampleFormat {other} of {bits} bits"), "expected whole or real numbers")),
    };
    let (x, y) = pages.dimensions().map_err(|error| broken(&error))?;
    Ok(([x as usize, y as usize], (kind, usize::from(bits) / 8)))
}

/// The stored values, page by page.
fn values_of(mut pages: Pages<'_>) -> impl Read {
    let mut is_first = true;
    Pieces::new(move |piece: &mut Vec<u8>| {
        if !is_first {
            if !pages.more_images() {
                return Ok(());
            }
            pages.next_image().map_err(io::Error::other)?;
        }
        is_first = false;
        let is_turned = photometric(&mut pages) == Some(WHITE_IS_ZERO);
        let mut values = pages.read_image().map_err(io::Error::other)?;
        if is_turned {
            turn_back(&mut values);
        }
        match values {
            DecodingResult::U8(values) => *piece = values,
            mut values => piece.extend_from_slice(values.as_buffer(0).as_bytes()),
        }
        Ok(())
    })
}

/// Gives the values of a page in which 0 is white as they are stored, reals but for rounding: the library turns them round, and refuses
/// whole numbers with a sign.
fn turn_back(values: &mut DecodingResult) {
    match values {
        DecodingResult::F32(reals) => *reals = reals.iter().map(|x| 1.0 - x).collect(),
        DecodingResult::F64(reals) => *reals = reals.iter().map(|x| 1.0 - x).collect(),
        whole => {
            for byte in whole.as_buffer(0).as_bytes_mut() {
                *byte = !*byte;
            }
        }
    }
}

/// What a page says that its values stand for, if it does.
fn photometric(pages: &mut Pages) -> Option<u16> {
    pages.find_tag_unsigned::<u16>(Tag::PhotometricInterpretation).ok().flatten()
}

/// The description of the first page; empty where it has none.
fn description(pages: &mut Pages) -> String {
    let mut bytes = vec![0; MOST_DESCRIPTION];
    match pages.image_ifd().find_tag_bytes(Tag::ImageDescription, &mut bytes, 0) {
        Ok(Some(count)) => {
            bytes.truncate(count.min(MOST_DESCRIPTION));
            let text = String::from_utf8(bytes).unwrap_or_else(|error| error.into_bytes().into_iter().map(char::from).collect());
            text.trim_end_matches('\0').to_owned()
        }
        _ => String::new(),
    }
}

/// What a file states of its voxels: millimetres along each axis, and how many slices.
type Stated = ([Option<f64>; 3], Option<usize>);

/// Lines such as `spacing=0.5`; the tags hold pixels per unit.
fn of_imagej(pages: &mut Pages, description: &str) -> Result<Stated, Fault> {
    let lines = description.lines().filter_map(|line| line.trim().split_once('='));
    let fields: HashMap<String, String> = lines.map(|(name, text)| (name.to_owned(), text.to_owned())).collect();
    ["channels", "frames"].iter().try_for_each(|name| one_of(&fields, name, |several| format!("{several} {name}")))?;
    let unit = fields.get("unit").and_then(|unit| millimetres_of(unit));
    let resolution = |pages: &mut Pages, tag: Tag| match pages.find_tag(tag) {
        Ok(Some(Value::Rational(pixels, of))) if pixels > 0 => Some(f64::from(of) / f64::from(pixels)),
        _ => None,
    };
    let [x, y] = [Tag::XResolution, Tag::YResolution].map(|tag| resolution(pages, tag));
    let z = fields.get("spacing").and_then(|text| text.parse::<f64>().ok());
    // ImageJ states no unit, or pixels, for what is not calibrated.
    let spacing = [x, y, z].map(|length| Some(length? * unit?));
    Ok((spacing, count(&fields, "images")))
}

/// The attributes of the first element Pixels.
fn of_ome(description: &str) -> Result<Stated, Fault> {
    let mut events = crate::formats::xml::Events::new(description.as_bytes());
    // What comes after that element may be cut off.
    while let Some(step) = events.next()? {
        if !matches!(step, crate::formats::xml::XmlStep::Start) || events.tag.name() != "Pixels" {
            continue;
        }
        let fields: HashMap<String, String> = events.tag.attributes()?.into_iter().collect();
        ["SizeC", "SizeT"].iter().try_for_each(|name| one_of(&fields, name, |several| format!("{name} {several}")))?;
        let spacing = ["PhysicalSizeX", "PhysicalSizeY", "PhysicalSizeZ"].map(|name| {
            let unit = fields.get(&format!("{name}Unit")).map_or(Some(1e-3), |unit| millimetres_of(unit));
            Some(fields.get(name)?.parse::<f64>().ok()? * unit?)
        });
        return Ok((spacing, count(&fields, "SizeZ")));
    }
    Ok(Stated::default())
}

fn count(fields: &HashMap<String, String>, name: &str) -> Option<usize> {
    fields.get(name).and_then(|text| text.parse().ok())
}

/// Refuses more than one of what a field counts.
fn one_of(fields: &HashMap<String, String>, name: &str, found: impl Fn(usize) -> String) -> Result<(), Fault> {
    let several = count(fields, name).filter(|count| *count > 1);
    several.map_or(Ok(()), |several| Err(Fault::file(found(several), NOT_ONE_VOLUME)))
}

/// Millimetres of a unit of ImageJ or OME; nothing for pixels and for what is no length.
fn millimetres_of(unit: &str) -> Option<f64> {
    match unit.trim() {
        "nm" => Some(1e-6),
        "inch" | "in" => Some(25.4),
        other => LengthUnit::named(other).map(LengthUnit::mm),
    }
}
