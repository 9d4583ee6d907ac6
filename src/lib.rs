//! Finds the plausible topology of vascular centerlines by neurovascular resilience.

pub mod error;
pub mod units;

pub mod geometry;

pub mod centerline;

pub mod network;

pub mod formats;

pub mod phantom;

pub mod report;
