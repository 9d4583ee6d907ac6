//! Files of other programs: Amira, iCafe, 3D Slicer, VesselVio, Voreen, VTrails.

pub(crate) mod amira;
pub(crate) mod icafe;
pub(crate) mod slicer_markups;
pub(crate) mod vesselvio;
pub(crate) mod voreen;
pub(crate) mod vtrails;
