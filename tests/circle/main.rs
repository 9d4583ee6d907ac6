//! The Circle of Willis: phantoms, variants and phenotypes.

#[path = "../support/command.rs"]
mod command;
#[path = "../support/refused.rs"]
mod refused;

mod classify;
mod label;
mod landmarks;
mod named_stretches;
mod phantom;
mod phantom_large;
mod phenotype;
mod phenotype_posterior;
mod supply;
mod variants;
