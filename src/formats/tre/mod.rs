//! ITK TRE: a MetaIO scene of tubes, as ITK and TubeTK write blood vessels.

mod nearest;
mod points;
mod read;
mod scene;
mod transform;
mod write;

pub use read::read_tre;
pub use write::write_tre;
