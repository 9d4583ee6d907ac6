//! VTK polylines: XML PolyData (VTP) and legacy files, read into one description.

mod array;
mod cursor;
pub(crate) mod legacy;
pub(crate) mod polydata;
pub(crate) mod vtp;
pub(crate) mod write;
