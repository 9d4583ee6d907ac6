//! Tables of text: centerline points, graphs, boundary conditions, manifests, priors.

pub mod conditions;
pub(crate) mod graph;
pub(crate) mod lists;
pub(crate) mod manifest;
pub(crate) mod pairs;
pub mod reader;
pub(crate) mod unread;
pub(crate) mod write;
