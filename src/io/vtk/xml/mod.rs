//! VTK XML PolyData as VMTK, ParaView and this program write it.

mod array;
mod block;
pub(crate) mod read;
pub(crate) mod write;
