//! Reads masks and images in NRRD: `.nrrd` in one file, `.nhdr` with the voxels beside it, and the segmentations of 3D Slicer, `.seg.nrrd`.
//!
//! The file's `space` is turned to the scanner's frame; where it states none of a patient, nobody says which way the axes point. Source: teem.sourceforge.net/nrrd/format.html; for segments the documentation of 3D Slicer's module Segmentations.

use std::collections::BTreeMap;
use std::io::{self, Read, copy, sink};
use std::path::{Path, PathBuf};

use super::stored_image::{Layers, MOST_SEGMENTS, ONE_VOLUME, PIECE, Pieces, StoredImage};
use super::voxels::{Voxels, number_type};
use crate::formats::ensure;
use crate::formats::header_fields::{HeaderFields, HeaderLines};
use willis_core::error::{Fault, Result};
use willis_core::network::{Frame, LengthUnit};

/// The field that names another file of the voxels.
const DATA: &str = "data file";
/// No header is longer; that of a hundred segments has a tenth of it.
const MOST_HEADER: usize = 1 << 20;

/// The fields of a header, each with its line, the keys of programs with their values, and where the voxels of the same file begin.
struct NrrdHeader {
    fields: HeaderFields,
    keys: BTreeMap<String, String>,
    end: usize,
}

/// How the numbers are stored.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
enum Encoding {
    Raw,
    Gzip,
    Text,
}

/// Whether a file begins as NRRD does.
pub(crate) fn is_nrrd(bytes: &[u8]) -> bool {
    bytes.starts_with(b"NRRD000")
}

/// The file beside `path` that holds its voxels, if they are not in the same file.
pub(crate) fn file_of_voxels(path: &Path, bytes: &[u8]) -> Option<PathBuf> {
    NrrdHeader::read(bytes).ok()?.fields.file(path, DATA)
}

/// Reads the header, of which `path` tells where a second file is; the bytes of that go to `other`. `spacing` (mm) is for a header that states
/// none. At most `most` bytes are read.
pub(crate) fn open_nrrd<'a>(
    path: &Path,
    bytes: &'a [u8],
    other: &'a mut Vec<u8>,
    spacing: Option<[f64; 3]>,
    most: u64,
) -> Result<StoredImage<'a>> {
    let here = |fault: Fault| fault.in_file(path);
    let header = NrrdHeader::read(bytes).map_err(here)?;
    let encoding = header.encoding().map_err(here)?;
    let (voxels, layers) = header.voxels(encoding, spacing).map_err(here)?;
    let needed = Voxels { size: voxels.size.saturating_mul(layers), ..voxels.clone() }.bytes(most).map_err(here)?;
    let (file, mut data) = if header.fields.get(DATA).is_none() {
        (path.to_owned(), bytes.get(header.end..).unwrap_or_default())
    } else {
        let file;
        (file, *other) = header.fields.file_bytes(path, DATA, most, "expected the name of one file in the same folder")?;
        (file, other.as_slice())
    };
    for _ in 0..header.fields.whole("line skip").map_err(here)?.unwrap_or(0).max(0) {
        let Some(end) = data.iter().position(|byte| *byte == b'\n') else {
            return Err(Fault::file("fewer lines than are to be skipped", "expected a whole file").in_file(&file));
        };
        data = &data[end + 1..];
    }
    let skipped = header.fields.whole("byte skip").map_err(here)?.unwrap_or(0);
    let stream: Box<dyn Read + 'a> = if encoding == Encoding::Gzip {
        let mut stream = flate2::read::MultiGzDecoder::new(data);
        let skip = copy(&mut stream.by_ref().take(u64::try_from(skipped).unwrap_or(0)), &mut sink());
        skip.map_err(|error| Fault::file(format!("unreadable: {error}"), "expected a whole file").in_file(&file))?;
        Box::new(stream)
    } else {
        // Byte skip -1: the voxels are the last bytes of the file.
        let skipped = match usize::try_from(skipped) {
            Ok(skipped) => skipped,
            Err(_) if encoding == Encoding::Raw => data.len().saturating_sub(usize::try_from(needed).unwrap_or(usize::MAX)),
            Err(_) => 0,
        };
        let data = data.get(skipped..).unwrap_or_default();
        if encoding == Encoding::Text { Box::new(written_numbers(data)) } else { Box::new(data) }
    };
    let several = header.fields.wrong("sizes", ONE_VOLUME);
    Ok(StoredImage { file, voxels, layers: Some(Layers { keys: header.keys, count: layers, several }), stream })
}

/// Numbers that are written as text, as reals of 8 bytes.
fn written_numbers(text: &[u8]) -> impl Read {
    let mut words = text.split(|byte| byte.is_ascii_whitespace() || *byte == b',').filter(|word| !word.is_empty());
    Pieces::new(move |piece| {
        for word in words.by_ref().take(PIECE) {
            let number = std::str::from_utf8(word).ok().and_then(|word| word.parse::<f64>().ok());
            let number = number.ok_or_else(|| {
                let word = String::from_utf8_lossy(&word[..word.len().min(20)]).into_owned();
                io::Error::new(io::ErrorKind::InvalidData, format!("\"{}\" is no number", word.escape_debug()))
            })?;
            piece.extend_from_slice(&number.to_le_bytes());
        }
        Ok(())
    })
}

impl NrrdHeader {
    fn read(bytes: &[u8]) -> Result<Self, Fault> {
        let (mut fields, mut keys) = (HeaderFields::default(), BTreeMap::new());
        // The format's own programs pass over spaces and capitals in names.
        fields.is_loose = true;
        let head = &bytes[..bytes.len().min(2 * MOST_HEADER)];
        let mut lines = HeaderLines::new(head);
        loop {
            let at = head.len() - lines.rest.len();
            let wrong = || Fault::file(format!("no empty line in {MOST_HEADER} bytes"), "expected one after the header");
            ensure(at < MOST_HEADER, wrong)?;
            // A header whose voxels are in another file may end with the file.
            let Some((line, text)) = lines.line().filter(|(_, text)| !text.is_empty()) else {
                return Ok(Self { fields, keys, end: head.len() - lines.rest.len() });
            };
            let text = String::from_utf8_lossy(text);
            if line == 1 || text.starts_with('#') {
                continue;
            }
            // A key may have colons, a field none before its own.
            let (field, key) = (text.find(": "), text.find(":="));
            if let Some(key) = key.filter(|key| field.is_none_or(|field| *key < field)) {
                keys.insert(text[..key].trim().to_owned(), text[key + 2..].trim().to_owned());
            } else if let Some((name, value)) = text.split_once(':') {
                fields.insert(name, line, value.trim());
            } else {
                return Err(Fault::line(line, format!("\"{text}\""), "expected a line `field: value`"));
            }
        }
    }

    fn encoding(&self) -> Result<Encoding, Fault> {
        let (_, word) = self.fields.needed("encoding")?;
        match word.to_ascii_lowercase().as_str() {
            "raw" => Ok(Encoding::Raw),
            "gzip" | "gz" => Ok(Encoding::Gzip),
            "text" | "txt" | "ascii" => Ok(Encoding::Text),
            _ => Err(self.fields.wrong("encoding", "expected raw, gzip or ascii")),
        }
    }

    /// How the voxels are stored, and in how many layers.
    fn voxels(&self, encoding: Encoding, spacing: Option<[f64; 3]>) -> Result<(Voxels, usize), Fault> {
        let (_, word) = self.fields.needed("type")?;
        let wrong = || self.fields.wrong("type", "expected uchar, short, float or another type of number");
        let word = word.split_whitespace().collect::<Vec<_>>().join(" ").to_ascii_lowercase();
        let (kind, size) = number_type(|(.., of_nrrd)| of_nrrd.split('|').any(|known| known == word)).ok_or_else(wrong)?;
        let (of_space, sizes, layers) = self.axes()?;
        let (affine, shape) = (self.affine(of_space, &sizes, spacing)?, of_space.map(|axis| sizes[axis]));
        let frame = if self.turn()?.is_some() { Frame::Ras } else { Frame::Unknown };
        let as_stored = Voxels { shape, kind, size, big: false, slope: [1.0, 0.0], affine, frame, reversed: false };
        if encoding == Encoding::Text {
            return Ok((Voxels { kind: crate::formats::binary::NumberType::Real, size: 8, ..as_stored }, layers));
        }
        let big = match self.fields.get("endian").map(|(_, word)| word.to_ascii_lowercase()).as_deref() {
            Some("little") => false,
            Some("big") => true,
            None if size == 1 => false,
            _ => return Err(self.fields.wrong("endian", "expected little or big")),
        };
        Ok((Voxels { big, ..as_stored }, layers))
    }

    /// Which axes are those of space, the lengths of all, and how many layers a fourth one holds.
    fn axes(&self) -> Result<([usize; 3], Vec<usize>, usize), Fault> {
        self.fields.needed("sizes")?;
        self.fields.needed("dimension")?;
        let dimension = self.fields.whole("dimension")?.unwrap_or_default();
        let wrong = |_| self.fields.wrong("sizes", format!("expected {dimension} whole numbers"));
        let count = usize::try_from(dimension).map_err(wrong)?;
        let sizes: Vec<usize> = self.fields.numbers("sizes", count, "whole numbers", |_| true)?.unwrap_or_default();
        let not_three = || self.fields.wrong("sizes", ONE_VOLUME);
        let (layers, of_space) = match sizes.len() {
            3 => (1, [0, 1, 2]),
            4 => {
                let list = self.list_axis(&sizes)?.ok_or_else(not_three)?;
                ensure(list == 0 || sizes[list] == 1, not_three)?;
                (sizes[list], [0, 1, 2].map(|axis| axis + usize::from(axis >= list)))
            }
            _ => return Err(not_three()),
        };
        let wrong = || self.fields.wrong("sizes", format!("expected from 1 to {MOST_SEGMENTS} layers"));
        ensure((1..=MOST_SEGMENTS).contains(&layers), wrong)?;
        Ok((of_space, sizes, layers))
    }

    /// The axis of four that is not one of space.
    fn list_axis(&self, sizes: &[usize]) -> Result<Option<usize>, Fault> {
        let only =
            |is: Vec<bool>| (is.len() == 4 && is.iter().filter(|is| **is).count() == 1).then(|| is.iter().position(|is| *is));
        if let Some(directions) = self.directions(4)?
            && let Some(axis) = only(directions.iter().map(Option::is_none).collect())
        {
            return Ok(axis);
        }
        let is_space = |kind: &str| ["domain", "space"].contains(&kind.to_ascii_lowercase().as_str());
        if let Some((_, kinds)) = self.fields.get("kinds")
            && let Some(axis) = only(kinds.split_whitespace().map(|kind| !is_space(kind)).collect())
        {
            return Ok(axis);
        }
        if let Some(spacings) = self.fields.numbers::<f64>("spacings", 4, "numbers", |_| true)?
            && let Some(axis) = only(spacings.iter().map(|spacing| spacing.is_nan()).collect())
        {
            return Ok(axis);
        }
        Ok([3, 0].into_iter().find(|axis| sizes[*axis] == 1))
    }

    /// The step along each axis; `None` for one that is not of space.
    fn directions(&self, axes: usize) -> Result<Option<Vec<Option<[f64; 3]>>>, Fault> {
        let Some((_, text)) = self.fields.get("space directions") else { return Ok(None) };
        let steps = vectors(text).filter(|steps| steps.len() == axes);
        let accepted = || format!("expected {axes} vectors of three numbers, or none for an axis");
        steps.map(Some).ok_or_else(|| self.fields.wrong("space directions", accepted()))
    }

    /// The scanner's frame in mm from voxels, of `given` spacing (mm) where none is stated.
    fn affine(&self, of_space: [usize; 3], sizes: &[usize], given: Option<[f64; 3]>) -> Result<crate::masks::Affine, Fault> {
        let unit = self.unit(of_space, sizes.len())?;
        let turn = self.turn()?.unwrap_or([1.0; 3]);
        let (mut steps, mut origin) = ([[0.0; 3]; 3], [0.0; 3]);
        if let Some(directions) = self.directions(sizes.len())? {
            for (step, axis) in steps.iter_mut().zip(of_space) {
                let none = || Fault::file(format!("axis {axis} has no space direction"), "expected three axes of space");
                *step = directions[axis].ok_or_else(none)?;
            }
        } else {
            for (n, axis) in of_space.into_iter().enumerate() {
                (steps[n][n], origin[n]) = self.along(axis, sizes, given.map(|mm| mm[n] / unit))?;
            }
            if let Some(bad) = [0, 1, 2].map(|n| steps[n][n]).iter().find(|s| !(s.is_finite() && **s > 0.0)) {
                return Err(Fault::file(format!("spacing {bad}"), "expected a positive spacing along every axis"));
            }
        }
        if let Some((_, text)) = self.fields.get("space origin") {
            let found = vectors(text).filter(|all| all.len() == 1).and_then(|all| all[0]);
            origin = found.ok_or_else(|| self.fields.wrong("space origin", "expected a vector of three numbers"))?;
        }
        Ok(std::array::from_fn(|row| {
            std::array::from_fn(|column| turn[row] * unit * if column < 3 { steps[column][row] } else { origin[row] })
        }))
    }

    /// The spacing along an axis without a direction, and where its first sample is. Samples lie in the middle of cells, which the least and
    /// the largest position bound, unless they are said to be nodes.
    fn along(&self, axis: usize, sizes: &[usize], given: Option<f64>) -> Result<(f64, f64), Fault> {
        let of_axis = |name: &str| -> Result<Option<f64>, Fault> {
            let numbers = self.fields.numbers::<f64>(name, sizes.len(), "numbers", |_| true)?;
            Ok(numbers.map(|numbers| numbers[axis]))
        };
        let (stated, least, most) = (of_axis("spacings")?, of_axis("axis mins")?, of_axis("axis maxs")?);
        let centers = self.fields.get("centers").or_else(|| self.fields.get("centerings")).map_or("", |(_, words)| words);
        let is_node = centers.split_whitespace().nth(axis) == Some("node");
        let steps = if is_node { sizes[axis].saturating_sub(1) } else { sizes[axis] } as f64;
        let stated = stated.filter(|spacing| !spacing.is_nan()).or_else(|| Some((most? - least?) / steps)).or(given);
        let accepted = "expected spacings, axis mins and axis maxs, or space directions, or give `spacing=SX,SY,SZ`, in mm";
        let spacing = stated.ok_or_else(|| Fault::file(format!("no spacing along axis {axis}"), accepted))?;
        let first = least.map_or(0.0, |least| if is_node { least } else { least + spacing / 2.0 });
        Ok((spacing, first))
    }

    /// What turns each axis of the file's space to the scanner's, where it states one.
    fn turn(&self) -> Result<Option<[f64; 3]>, Fault> {
        let Some((_, space)) = self.fields.get("space") else { return Ok(None) };
        match space.to_ascii_lowercase().as_str() {
            "right-anterior-superior" | "ras" => Ok(Some([1.0, 1.0, 1.0])),
            "left-anterior-superior" | "las" => Ok(Some([-1.0, 1.0, 1.0])),
            "left-posterior-superior" | "lps" => Ok(Some([-1.0, -1.0, 1.0])),
            "scanner-xyz" | "3d-right-handed" | "3d-left-handed" => Ok(None),
            _ => {
                let accepted = "expected right-anterior-superior, left-anterior-superior or left-posterior-superior";
                Err(self.fields.wrong("space", accepted))
            }
        }
    }

    /// Millimetres of the unit of lengths, of which a file of so many axes has one for each, or for each of its space.
    fn unit(&self, of_space: [usize; 3], axes: usize) -> Result<f64, Fault> {
        let field = |name: &'static str| Some((name, self.fields.get(name)?.1));
        let Some((name, text)) = field("space units").or_else(|| field("units")) else { return Ok(1.0) };
        // Of quoted words every second piece lies between quotes.
        let words: Vec<&str> =
            if text.contains('"') { text.split('"').skip(1).step_by(2).collect() } else { text.split_whitespace().collect() };
        let of_axis = |row: usize| words.len() != axes || name == "space units" || of_space.contains(&row);
        let stated = words.iter().enumerate().filter(|(row, word)| of_axis(*row) && !["", "none", "???"].contains(&word.trim()));
        let mut units = stated.map(|(_, word)| LengthUnit::named(word.trim()));
        let Some(first) = units.next() else { return Ok(1.0) };
        let wrong = || self.fields.wrong(name, "expected one unit for all axes of space: mm, um, cm or m");
        first.filter(|_| units.all(|other| other == first)).map(LengthUnit::mm).ok_or_else(wrong)
    }
}

/// Vectors such as `(1,0,0) (0,1,0)`, `None` for the word `none`; nothing where the text is no list of such.
fn vectors(text: &str) -> Option<Vec<Option<[f64; 3]>>> {
    let (mut rest, mut all) = (text.trim(), Vec::new());
    while !rest.is_empty() {
        if let Some(after) = rest.strip_prefix("none") {
            all.push(None);
            rest = after.trim_start();
        } else {
            let (inside, after) = rest.strip_prefix('(')?.split_once(')')?;
            let numbers = inside.split(',').map(|word| word.trim().parse().ok()).collect::<Option<Vec<f64>>>()?;
            all.push(Some(numbers.try_into().ok()?));
            rest = after.trim_start();
        }
    }
    Some(all)
}
