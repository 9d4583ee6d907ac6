//! ITK TRE: a MetaIO scene of tubes, as ITK and TubeTK write blood vessels.

mod points;
pub(crate) mod read;
mod scene;
mod transform;
pub(crate) mod write;
