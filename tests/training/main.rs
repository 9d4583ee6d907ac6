//! `willis train`: the fits, the cases that they read, the files that they write.

#[path = "../support/command.rs"]
mod command;
#[path = "../support/refused.rs"]
mod refused;

mod contact_truth;
mod joins;
mod train_command;
mod training;
