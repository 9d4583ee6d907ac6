//! File formats: one file per format over `BufRead` and `Write`, and one place that decides which it is.

mod column;
pub mod conditions;

pub use column::{Column, Values};
