//! A simulation with everything that its files need, and what its vessels are called in pictures.

use std::borrow::Cow;
use std::collections::BTreeMap;

use serde_json::Value;

use crate::run_record::Provenance;
use willis_core::flow::state::State;
use willis_core::flow::{Boundary, FoundOutlets};
use willis_core::network::{Network, RadiusRule};
use willis_core::simulation::ClosedVessel;
use willis_core::simulation::pulse::Pulses;
use willis_core::simulation::transport::Transports;
use willis_core::simulation::{Perturbation, Simulation};

/// The flow of an input, before and after the changes, with everything that its files need.
#[derive(Debug)]
pub struct SimulationRun<'a> {
    /// The vessels.
    pub network: Cow<'a, Network>,
    /// Their boundary conditions.
    pub boundary: Boundary,
    /// The condition of outlets without one.
    pub outlets: FoundOutlets,
    /// The command and input of the run.
    pub provenance: Cow<'a, Provenance>,
    /// Which radius stands for a vessel.
    pub radius_rule: RadiusRule,
    /// The changes.
    pub perturbations: Vec<Perturbation>,
    /// The flow before and after the changes.
    pub result: Simulation,
    /// Blood viscosity, Pa s.
    pub viscosity: f64,
    /// Where the blood comes from and when, if it was asked for.
    pub transports: Option<Transports>,
    /// What each closed vessel does, if that was asked for.
    pub closures: Option<Vec<ClosedVessel>>,
    /// The pulse, if it was asked for, and its record.
    pub pulses: Option<(Pulses, Value)>,
}

impl SimulationRun<'_> {
    /// The state whose columns end so.
    pub(super) fn state(&self, suffix: &str) -> Option<&State> {
        if suffix.is_empty() { Some(&self.result.unperturbed) } else { self.result.perturbed.as_ref() }
    }
}

/// What each vessel is called in pictures: its label; where this is empty or not unique the name has the row.
pub(super) fn picture_names(network: &Network) -> Vec<String> {
    let mut uses = BTreeMap::new();
    network.vessels().for_each(|(_, vessel)| *uses.entry(vessel.label.as_str()).or_insert(0_usize) += 1);
    let name = |(row, (_, vessel)): (usize, (_, &willis_core::network::Vessel))| match vessel.label.as_str() {
        "" => format!("edge {row}"),
        label if uses[label] > 1 => format!("{label} (edge {row})"),
        label => label.to_owned(),
    };
    network.vessels().enumerate().map(name).collect()
}
