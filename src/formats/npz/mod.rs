//! A skeleton graph as NumPy arrays in one `.npz`: `coords`, `edges`, `radii`, and `labels` and `lengths` where there are any.

mod array;
mod arrays;
mod matrix;
mod read;
mod write;

pub use arrays::read_arrays;
pub(super) use matrix::read_npy_matrix;
pub use read::read_skeleton_npz;
pub(super) use read::unpack_skeleton_npz;
pub use write::write_skeleton_npz;
