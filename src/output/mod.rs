//! Files on the disk: outputs that appear whole or not at all, locks, checkpoints, JSON.

pub mod atomic;
mod files;
mod in_progress;
pub mod names;
mod ownership;
pub mod partial_run;

pub use atomic::{StagedFile, StagedFolder};
pub use files::{read_json, write_json, write_record};
pub use in_progress::{InProgress, final_path, write_error};
pub use ownership::is_cohort_file;
pub use partial_run::{read_part, write_part};
