//! Files on the disk: outputs that appear whole or not at all, locks, checkpoints, JSON.

pub mod atomic;
mod disk;
pub mod in_progress;
pub mod json;
mod lock;
pub mod names;
mod ownership;
pub mod partial_run;

pub use atomic::{StagedFile, StagedFolder};
pub use in_progress::{Making, told};
pub use json::{read_json, write_json, write_record};
pub use ownership::is_of_cohort;
pub use partial_run::{read_part, write_part};
