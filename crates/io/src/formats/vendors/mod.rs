//! Files of other programs: Amira, iCafe, 3D Slicer, VesselVio, Voreen, VTrails.

pub(crate) mod amira;
pub(crate) mod edge_tables;
pub(crate) mod icafe;
pub(crate) mod slicer_markups;
pub(crate) mod vtrails;
