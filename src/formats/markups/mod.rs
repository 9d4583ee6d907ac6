//! 3D Slicer markups: curves of control points, the radius a measurement at each.

mod read;
mod write;

pub use read::read_markups;
pub use write::write_markups;
