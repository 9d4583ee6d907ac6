//! VTK legacy PolyData, in digits or in binary, as VTK, ParaView, 3D Slicer and older programs write it.

mod arrays;
mod cursor;
pub(crate) mod read;
pub(crate) mod write;
