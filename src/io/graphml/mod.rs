//! GraphML as NetworkX, igraph and this program write it.

mod keys;
pub(crate) mod read;
pub(crate) mod write;
