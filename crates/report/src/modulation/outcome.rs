//! A modulation with everything that its files need.

use std::borrow::Cow;

use crate::run_record::Provenance;
use willis_core::flow::{Boundary, FoundOutlets};
use willis_core::modulation::{HypertensionByClass, Instances, Modulation, ModulationOptions};
use willis_core::network::units::mmhg;
use willis_core::network::{Condition, Network};

/// How a network responds to resistances that vary at random, with everything that its files need.
#[derive(Debug)]
pub struct ModulationRun<'a> {
    /// The network.
    pub network: Cow<'a, Network>,
    /// Its boundary conditions.
    pub boundary: Boundary,
    /// The condition of outlets without one.
    pub outlets: FoundOutlets,
    /// The command and input of the run.
    pub provenance: Cow<'a, Provenance>,
    /// The options of the modulation.
    pub params: ModulationOptions,
    /// The instances.
    pub result: Modulation,
    /// The distribution of hypertension.
    pub hypertension: HypertensionByClass,
    /// The time of the solves, s.
    pub seconds: f64,
}

impl ModulationRun<'_> {
    /// For each node whether its pressure can change.
    pub fn free(&self) -> Vec<bool> {
        let fixed = |node| matches!(self.boundary.condition(node), Some(Condition::Pressure(_)));
        (0..self.network.node_count()).map(|node| !fixed(node)).collect()
    }

    /// The mean pressure of the free nodes by instance, mmHg.
    pub fn mean_pressure(&self, instances: &Instances) -> Vec<f64> {
        Instances::means(&instances.pressure, self.network.node_count(), &self.free(), mmhg)
    }
}
