//! What willis has learned: connections, contacts, names of arteries, the Circle of Willis.
//!
//! An internal part of willis. Nothing here is stable: programs use the functions of the crate `willis`.

pub mod candidates;
pub mod circle_of_willis;
pub mod contacts;
pub mod naming;
