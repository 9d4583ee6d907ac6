//! ITK TRE: a MetaIO scene of tubes, as ITK and TubeTK write blood vessels.

mod scene;
pub(crate) mod tubes;
