//! Candidates, their evidence, and the prior that is trained on it.

#[path = "../support/command.rs"]
mod command;
#[path = "../support/draw.rs"]
mod draw;
#[path = "../support/extracted.rs"]
mod extracted;
#[path = "../support/refused.rs"]
mod refused;
#[path = "../support/shuffle.rs"]
mod shuffle;
#[path = "../support/vessels.rs"]
mod vessels;

mod candidates;
mod contact_loops;
mod contacts;
mod features;
mod image_outputs;
mod image_search;
mod images;
mod joins;
mod prior;
mod prior_command;
mod reference;
mod shipped_models;
