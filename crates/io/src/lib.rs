//! Files of vascular centerlines, masks and images, for willis.
//!
//! An internal part of willis. Nothing here is stable: programs use the functions of the crate `willis`.

pub mod formats;
pub mod masks;
pub mod output;
