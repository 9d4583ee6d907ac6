//! Tables of text: centerline points, graphs, boundary conditions, manifests, priors.

pub mod conditions;
pub(crate) mod decisions;
pub(crate) mod graph;
pub(crate) mod lists;
pub(crate) mod manifest;
pub(crate) mod pairs;
pub(crate) mod points;
pub(crate) mod prior;
pub mod reader;
pub(crate) mod unread;
pub(crate) mod waveform;
pub(crate) mod write;
