//! VTK XML PolyData as VMTK, ParaView and this program write it.

mod array;
mod block;
mod read;
mod write;

pub use read::read_vtp;
pub(super) use read::unpack_vtp;
pub use write::write_vtp;
