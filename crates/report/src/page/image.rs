//! What a page holds of images: the image around doubtful vessels, and the segmentation that the vessels were found in.

use base64::Engine;
use base64::engine::general_purpose::STANDARD;
use serde::{Deserialize, Serialize};

use willis_core::network::units::millimetres;
use willis_core::support::geometry::Point;
use willis_io::masks::cubes::ImageCube;
use willis_io::masks::{Affine, Foreground, RunLengths};

/// What the image shows around a doubtful vessel or contact, for the page; see [`ImageCube`].
#[derive(Debug, Clone, Serialize, Deserialize)]
pub struct ImagePlace {
    /// The rows of the vessels that lie there.
    pub vessels: Vec<usize>,
    /// The middle of the cube, mm.
    pub centre: [f64; 3],
    /// [`ImageCube::held`].
    pub held: [f64; 2],
    /// [`ImageCube::shown`].
    pub shown: [f64; 2],
    /// Whether vessels are dark.
    pub is_dark: bool,
    /// [`ImageCube::samples`] in base64.
    pub samples: String,
}

impl ImagePlace {
    /// A cube around a place (m) at which vessels lie, by row.
    pub fn of(vessels: Vec<usize>, centre: Point, cube: &ImageCube) -> Self {
        let samples = STANDARD.encode(&cube.samples);
        Self { vessels, centre: centre.map(millimetres), held: cube.held, shown: cube.shown, is_dark: cube.is_dark, samples }
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
