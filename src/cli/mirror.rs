//! Boundary conditions as data, exactly as they are in memory, in SI units: what a shard hands on.

use serde::{Deserialize, Serialize};
use willis::hemodynamics::boundary::Total;
use willis::hemodynamics::{Boundary, FoundOutlets};
use willis::network::{Condition, Role};

#[derive(Serialize, Deserialize)]
#[serde(remote = "Boundary")]
pub struct BoundaryMirror {
    conditions: Vec<(usize, Condition)>,
    roles: Vec<Role>,
    found_inlets: Vec<usize>,
    found_outlets: Vec<usize>,
}

#[derive(Serialize, Deserialize)]
#[serde(remote = "FoundOutlets")]
pub enum FoundOutletsMirror {
    Ground,
    Murray(#[serde(with = "TotalMirror")] Total),
}

#[derive(Serialize, Deserialize)]
#[serde(remote = "Total")]
enum TotalMirror {
    Flow(f64),
    Resistance(f64),
}
