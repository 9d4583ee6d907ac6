//! Pictures and tables of a run.

pub mod plots;
