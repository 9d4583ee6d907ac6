//! VTK polylines: XML PolyData (VTP) and legacy files, read into one description.

pub(crate) mod legacy;
pub(crate) mod polydata;
pub(crate) mod xml;
