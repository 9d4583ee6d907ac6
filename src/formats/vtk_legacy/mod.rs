//! VTK legacy PolyData, in digits or in binary, as VTK, ParaView, 3D Slicer and older programs write it.

mod arrays;
mod cursor;
mod read;
mod write;

pub use read::read_vtk;
pub use write::write_vtk;
