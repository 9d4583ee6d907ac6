//! NumPy files: the likelihood matrix, arrays by name, and skeleton graphs.

pub(crate) mod array;
pub(crate) mod skeleton;
