//! The voxels of a file whose header has been read, as a mask or as an image; and those of a segmentation of 3D Slicer in several layers.

use std::io::{self, Read};
use std::{cell::Cell, collections::BTreeMap, path::PathBuf};

use super::voxels::Voxels;
use crate::formats::{counted, ensure, plural};
use crate::masks::{Image, Mask};
use willis_core::error::{Fault, Result};
use willis_core::network::Frame;
use willis_core::support::distinct;

/// What is accepted of an image with more axes than those of space.
pub(super) const ONE_VOLUME: &str = "expected three dimensions; take one volume";
/// Classes are numbered by one byte.
pub(super) const MOST_SEGMENTS: usize = 255;

/// The voxels of a file, whose header has been read.
pub(crate) struct StoredImage<'a> {
    /// The file that they are in.
    pub file: PathBuf,
    pub voxels: Voxels,
    /// What an NRRD states of layers and segments; nothing of other formats.
    pub layers: Option<Layers>,
    /// Their bytes.
    pub stream: Box<dyn Read + 'a>,
}

impl StoredImage<'_> {
    /// The same in another frame; as it is where one of the two is not known.
    pub fn in_frame(mut self, to: Frame) -> Self {
        let Voxels { affine, frame, .. } = &mut self.voxels;
        for column in 0..4 {
            let turned = frame.turn(to, affine.map(|row| row[column]));
            affine.iter_mut().zip(turned).for_each(|(row, x)| row[column] = x);
        }
        if frame.is_known() && to.is_known() {
            *frame = to;
        }
        self
    }

    /// Reads a mask, at most `most` bytes of it. From `level` on a voxel is a vessel; without it the values are classes.
    ///
    /// # Errors
    ///
    /// A file that is cut, no mask of three dimensions, or one without a usable frame.
    pub fn mask(self, level: Option<f64>, most: u64) -> Result<Mask> {
        let mask = match self.layers {
            Some(layers) => layers.mask(self.voxels, self.stream, level, most),
            None => self.voxels.read(self.stream, level, most),
        };
        mask.map_err(|fault| fault.in_file(&self.file))
    }

    /// Reads an image, at most `most` bytes of it.
    ///
    /// # Errors
    ///
    /// A file that is cut, no image of three dimensions, or one without a usable frame.
    pub fn image(self, most: u64) -> Result<Image> {
        let one = self.layers.map_or(Ok(()), Layers::one);
        one.and_then(|()| self.voxels.read_values(self.stream, most)).map_err(|fault| fault.in_file(&self.file))
    }
}

/// The values of each voxel, which follow one another: one, or those of the layers of a segmentation of 3D Slicer.
pub(crate) struct Layers {
    /// The keys of programs with their values.
    pub keys: BTreeMap<String, String>,
    /// How many values a voxel has.
    pub count: usize,
    /// What is said of several where one is expected.
    pub several: Fault,
}

impl Layers {
    /// Reads a mask. Segments of 3D Slicer are classes, numbered from 1 in their order, with their names; where several layers overlap, the last
    /// segment has the voxel, as when Slicer exports a label map.
    fn mask(self, voxels: Voxels, mut stream: impl Read, level: Option<f64>, most: u64) -> Result<Mask, Fault> {
        let segments = self.segments()?;
        if segments.is_empty() || (self.count == 1 && level.is_some()) {
            self.one()?;
            return voxels.read(stream, level, most);
        }
        let (unnamed, shared) = (Cell::new(0), Cell::new(0));
        let bytes = voxels.size * self.count;
        // By the stored values of all its layers.
        let found_in = |voxel: &[u8]| {
            let values: Vec<f64> = voxel.chunks_exact(voxels.size).map(|stored| voxels.kind.value(stored, voxels.big)).collect();
            let mut of = (1_u8..).zip(&segments).filter(|(_, segment)| values[segment.layer] == segment.value);
            let (first, last) = (of.next(), of.last());
            let class = last.as_ref().or(first.as_ref()).map_or(0, |(class, _)| *class);
            let is_unnamed = class == 0 && values.iter().any(|value| *value != 0.0);
            LayeredVoxel { class, is_unnamed, is_shared: last.is_some() }
        };
        let mut block = Vec::with_capacity(PIECE * bytes);
        // What comes after the last voxel is read to the end of the stream, and is none.
        let mut left = voxels.shape.iter().product::<usize>();
        // Most voxels are as the one before.
        let (mut stored, mut found) = (vec![0; bytes], LayeredVoxel::default());
        let classes = Pieces::new(|piece| {
            block.clear();
            stream.by_ref().take((PIECE * bytes) as u64).read_to_end(&mut block)?;
            for voxel in block.chunks_exact(bytes) {
                if stored != voxel {
                    stored.copy_from_slice(voxel);
                    found = found_in(voxel);
                }
                unnamed.set(unnamed.get() + usize::from(found.is_unnamed && left > 0));
                shared.set(shared.get() + usize::from(found.is_shared && left > 0));
                left = left.saturating_sub(1);
                piece.push(found.class);
            }
            Ok(())
        });
        let as_bytes = Voxels { kind: crate::formats::binary::NumberType::Unsigned, size: 1, big: false, ..voxels.clone() };
        let mut mask = as_bytes.read(classes, level, most)?;
        mask.notes.extend(counted(unnamed.get(), "voxel", "with a value of no segment: left out"));
        mask.notes.extend(counted(shared.get(), "voxel", "in several segments: taken to the last of them"));
        let names = (1..).zip(segments).filter(|(_, segment)| !segment.name.is_empty());
        mask.names = names.map(|(class, segment)| (class, segment.name)).collect();
        Ok(mask)
    }

    /// Refuses several layers.
    fn one(self) -> Result<(), Fault> {
        if self.count == 1 { Ok(()) } else { Err(self.several) }
    }

    /// The segments of 3D Slicer in their order. Where no layer or value is stated, as by Slicer before 4.11, each segment is a layer of its own, of
    /// ones.
    fn segments(&self) -> Result<Vec<SlicerSegment>, Fault> {
        let number = |key: &str| key.strip_prefix("Segment")?.split_once('_')?.0.parse::<usize>().ok();
        let rows = distinct(self.keys.keys().filter_map(|key| number(key)));
        let many = || Fault::file(format!("{} segments", rows.len()), format!("expected at most {MOST_SEGMENTS}"));
        ensure(rows.len() <= MOST_SEGMENTS, many)?;
        let segment = |row: usize| {
            let text = |what: &str| self.keys.get(&format!("Segment{row}_{what}")).map(String::as_str);
            let wrong = |what: &str, text: &str, accepted: String| {
                Fault::item(format!("Segment{row}_{what}"), format!("\"{text}\""), accepted)
            };
            let layer = match text("Layer") {
                None => Some(if self.count == 1 { 0 } else { row }),
                Some(text) => text.parse().ok(),
            };
            let layer = layer.filter(|layer| *layer < self.count);
            let found = || text("Layer").map_or_else(|| row.to_string(), str::to_owned);
            let layer = layer
                .ok_or_else(|| wrong("Layer", &found(), format!("expected one of {}, from 0", plural(self.count, "layer"))))?;
            let value = match text("LabelValue") {
                None => 1.0,
                Some(text) => text.parse().map_err(|_| wrong("LabelValue", text, "expected a number".to_owned()))?,
            };
            let name = text("Name").or_else(|| text("ID")).unwrap_or_default();
            Ok(SlicerSegment { layer, value, name: name.replace("\\n", " ").replace("\\\\", "\\").trim().to_owned() })
        };
        rows.into_iter().map(segment).collect()
    }
}

/// What the layers say of a voxel: its class, whether it has a value of no segment alone, and whether it is in several segments.
#[derive(Default)]
struct LayeredVoxel {
    class: u8,
    is_unnamed: bool,
    is_shared: bool,
}

/// A segment of 3D Slicer: the voxels of a layer that have its value.
struct SlicerSegment {
    layer: usize,
    value: f64,
    name: String,
}

/// Voxels of a piece.
pub(super) const PIECE: usize = 1 << 12;

/// A stream of bytes that are made piece by piece, so that no more than one piece is in memory. `next` puts the following piece into an empty
/// buffer, and nothing at the end.
pub(super) struct Pieces<F> {
    next: F,
    piece: Vec<u8>,
    read: usize,
}

impl<F: FnMut(&mut Vec<u8>) -> io::Result<()>> Pieces<F> {
    pub(super) fn new(next: F) -> Self {
        Self { next, piece: Vec::new(), read: 0 }
    }
}

impl<F: FnMut(&mut Vec<u8>) -> io::Result<()>> Read for Pieces<F> {
    fn read(&mut self, out: &mut [u8]) -> io::Result<usize> {
        if self.read == self.piece.len() {
            self.piece.clear();
            self.read = 0;
            (self.next)(&mut self.piece)?;
        }
        let count = out.len().min(self.piece.len() - self.read);
        out[..count].copy_from_slice(&self.piece[self.read..self.read + count]);
        self.read += count;
        Ok(count)
    }
}
