//! Sampling, likelihoods, the posterior and the answer.

#[path = "../support/draw.rs"]
mod draw;
#[path = "../support/figure.rs"]
mod figure;
#[path = "../support/networks.rs"]
mod networks;
#[path = "../support/oracle.rs"]
mod python_oracle;
#[path = "../support/shuffle.rs"]
mod shuffle;
#[path = "../support/vessels.rs"]
mod vessels;

mod answer;
mod determinism;
mod edits;
mod exact;
mod found_conditions;
mod front_door;
mod instruction_sets;
mod invariants;
mod large;
mod metamorphic;
mod oracle;
mod oracle_script;
mod posterior;
mod probable;
mod resumption;
mod solvers;
mod statistics;
mod textbook;
mod ties;
mod topologies;
mod wide_vessels;
