//! What a page holds of images: small pictures along doubtful vessels, and the segmentation that the vessels were found in.

use base64::Engine;
use base64::engine::general_purpose::STANDARD;
use serde::{Deserialize, Serialize};

use willis_core::network::units::millimetres;
use willis_io::masks::strips::Strip;
use willis_io::masks::{Affine, Foreground, RunLengths};

/// Small pictures of the image along one vessel, for the page; see [`Strip`].
#[derive(Debug, Clone, Serialize, Deserialize)]
pub struct ImageCut {
    /// The row of the vessel.
    pub vessel: usize,
    /// Sizes of the straightened picture along and across the vessel, mm.
    pub size_mm: [f64; 2],
    /// [`Strip::pixels`] in base64.
    pub pixels: String,
}

impl ImageCut {
    /// The pictures of a vessel, by row.
    pub fn of(vessel: usize, strip: &Strip) -> Self {
        Self { vessel, size_mm: strip.size.map(millimetres), pixels: STANDARD.encode(&strip.pixels) }
    }
}

/// The faces of a segmentation's surface beyond which the page holds it in blocks of voxels: a graphics chip in a laptop draws so many.
const MOST_FACES: usize = 400_000;
/// The blocks of its box beyond which the page holds it in larger ones: a browser takes a byte for each.
const MOST_CELLS: usize = 1 << 26;

/// The segmentation that the vessels were found in, for the page, which makes a surface of it.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct Segmentation {
    /// The lengths of the box around it.
    pub shape: [usize; 3],
    /// Where the centre of each block of the box is, mm.
    pub affine: Affine,
    /// Voxels along each side of a block.
    pub block: usize,
    /// [`RunLengths::bytes`] in base64.
    pub runs: String,
}

impl Segmentation {
    /// The voxels inside vessels, in blocks where they are very many.
    pub fn of(vessels: &Foreground) -> Self {
        let RunLengths { shape, affine, block, bytes } = RunLengths::of(vessels, MOST_FACES, MOST_CELLS);
        Self { shape, affine, block, runs: STANDARD.encode(bytes) }
    }
}
