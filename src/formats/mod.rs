//! File formats: one file per format over `BufRead` and `Write`, and one place that decides which it is.

mod column;
mod numpy;
mod table;

pub use column::{Column, Values};
pub use numpy::{write_npy, write_npz};
pub use table::write_csv;
