//! The command as a person or a script runs it.

#[path = "../support/command.rs"]
mod command;
#[path = "../support/refused.rs"]
mod refused;

mod bids;
mod checkpoint;
mod cohort;
mod commands;
mod decisions;
mod extremes;
mod limits;
mod manifest;
mod measure;
mod modulation_folder;
mod pulse;
mod real_data;
mod refusals;
mod separate_runs;
mod several_files;
mod shared_folder;
mod side_files;
mod signals;
mod simulate;
mod skeleton;
mod terminal;
mod unused_options;
