//! GraphML as NetworkX, igraph and this program write it.

mod keys;
mod read;
mod write;

pub use read::read_graphml;
pub use write::write_graphml;
