//! What centerlines are. Each kind has a model of its own, which knows them with points at a step of its own.

/// How centerlines came about.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum CenterlineKind {
    /// A person traced trees of vessels in an image, one point after the other.
    Tracing,
    /// A person drew vessel by vessel, each from within the lumen of the one it leaves, as in TubeTK.
    Tubes,
    /// A mask was thinned.
    Skeleton,
}
