//! From a segmentation mask to centerlines: thinning, the graph of the skeleton, spurs, smoothing, radii by area.
//!
//! | step | file |
//! |---|---|
//! | a mask in the scanner's frame, in one order of axes | `mask.rs` |
//! | rows, indices and steps of voxels | `grid.rs` |
//! | what is no mask of vessels | `no_vessels.rs` |
//! | cavities that are filled before | `cavities.rs` |
//! | topology-preserving thinning (Lee, Kashyap and Chu 1994) | `thinning.rs` |
//! | exact Euclidean distance to the background (Felzenszwalb and Huttenlocher 2012) | `distance.rs` |
//! | voxels to nodes and branches, spurs | `skeleton.rs` |
//! | how much of a voxel at the wall is inside | `partial.rs` |
//! | the depth below the wall of the lumen at any place | `field.rs` |
//! | which stretch each voxel of the lumen belongs to | `trace.rs` |
//! | smoothing, lengths, radii, labels | `trace.rs` |
//! | the picture beside a mask: smoothed, its value at any place | `image.rs` |
//! | the voxels in few bytes, for the page | `run_lengths.rs` |
//! | background, noise and the contrast of every vessel in it | `scene.rs` |
//! | the part of it around a place | `cubes.rs` |

mod cavities;
pub mod cubes;
mod distance;
mod field;
mod foreground;
mod grid;
mod image;
mod mask;
mod no_vessels;
mod partial;
mod run_lengths;
pub mod scene;
mod skeleton;
mod thinning;
mod trace;

pub use self::{distance::distances, field::Field, run_lengths::RunLengths, thinning::thin};
pub use cavities::{Cavities, Filled};
pub use foreground::{Foreground, neighbours};
pub use grid::{Affine, indices_of, inverse_of, row_at, steps_of, strides_of, volume_of};
pub use image::{Image, Picture};
pub use mask::Mask;
pub use no_vessels::{why_no_centerlines, why_no_vessels};
pub use partial::{WallFinder, Walls};
pub use scene::{Appearance, Level, ScanCenterlines, Scene, Unseen, View};
pub use trace::{RadiusFrom, Traced, trace};
