//! Finds the plausible topology of vascular centerlines by neurovascular resilience.

pub mod error;
pub mod quantity;
pub mod rng;
pub mod stats;
pub mod units;

pub mod geometry;

pub mod centerline;

pub mod network;

pub mod candidates;
pub mod formats;
pub mod hemodynamics;
pub mod perturbation;

pub mod resilience;

pub mod inference;

pub mod phantom;

pub mod report;
