//! Files on the disk: outputs that appear whole or not at all, locks, checkpoints, JSON.

pub mod atomic;
mod files;
mod in_progress;
mod lock;
pub mod names;
mod own_files;
mod stored;

pub use atomic::{StagedFiles, StagedFolder};
pub use files::{give_up_when, plain, read_json, relative, replace_file, write_file, write_json, write_record};
pub use in_progress::{InProgress, clear_leftovers, final_path, is_in_progress, write_error};
pub use own_files::{foreign_file, is_cohort_file};
pub use stored::{read_stored, write_stored};
