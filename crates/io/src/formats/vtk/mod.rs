//! VTK polylines: XML PolyData (VTP) and legacy files, read into one description.

/// Where a file states the frame of its positions, as 3D Slicer has it: a field of VTP, a word in the title of a legacy file.
pub(super) const SPACE: &str = "SPACE";

pub(crate) mod legacy;
pub(crate) mod polydata;
pub(crate) mod vtp;
pub(crate) mod write;
