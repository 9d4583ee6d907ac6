//! Solves the pulse of a network with conditions as they stand, for the tests.

use num_complex::Complex64;
use willis::internals::flow::{Tube, WallLaw};
use willis::internals::network::waveform::Quantity;
use willis::internals::network::{Condition, Network, Node, Windkessel};
use willis::internals::simulation::pulse::womersley::Fluid;
use willis::internals::simulation::pulse::{Drive, Friction, Pulse, Setting, terminals, walled};
use willis::internals::simulation::{Perturbation, perturbed, simulate};

use crate::networks::{VISCOSITY, boundary};

/// Blood of 3.5 cP and 1060 kg/m³ in elastic walls.
pub const BLOOD: Fluid = Fluid { viscosity: VISCOSITY, density: 1060.0, friction: Friction::Womersley, wall_viscosity: 0.0 };

/// A network with everything that a pulse needs.
pub struct Case<'a> {
    pub network: &'a Network,
    pub conditions: &'a [(usize, Condition)],
    pub drives: Vec<Drive>,
    pub law: WallLaw,
    pub fluid: Fluid,
    pub time_constant: Option<f64>,
    pub period: f64,
    pub perturbations: Vec<Perturbation>,
}

impl<'a> Case<'a> {
    /// Olufsen's walls, one period a second, outlets with RC = 0.69 s.
    pub fn new(network: &'a Network, conditions: &'a [(usize, Condition)], drives: Vec<Drive>) -> Self {
        Self {
            network,
            conditions,
            drives,
            law: WallLaw::OLUFSEN,
            fluid: BLOOD,
            time_constant: Some(0.69),
            period: 1.0,
            perturbations: Vec::new(),
        }
    }

    /// The pulse, with all perturbations.
    pub fn solve(&self) -> Pulse {
        let boundary = boundary(self.network, self.conditions);
        let steady = simulate(self.network, &boundary, self.fluid.viscosity, &self.perturbations).expect("a flow");
        let at_rest = Tube::at_rest(self.network, self.fluid.viscosity);
        let tubes = perturbed(self.network, &at_rest, &self.perturbations).expect("changes");
        let before = walled(self.network, &at_rest, &[], &self.law, &self.fluid).expect("walls");
        let vessels = walled(self.network, &tubes, &self.perturbations, &self.law, &self.fluid).expect("walls");
        let stated: Vec<Windkessel> = self.network.nodes().map(Node::windkessel).collect();
        let terminals = terminals(self.network, &boundary, &stated, &before, &self.fluid, self.time_constant);
        let setting = Setting {
            fluid: &self.fluid,
            period: self.period,
            harmonics: self.drives[0].coefficients.len() - 1,
            vessels: &vessels,
            drives: &self.drives,
            terminals: &terminals,
        };
        let state = steady.perturbed.as_ref().unwrap_or(&steady.unperturbed);
        Pulse::of(self.network, &boundary, state, &setting).expect("a pulse")
    }
}

/// A prescribed flow.
pub fn flow(node: usize, coefficients: &[Complex64]) -> Drive {
    Drive { node, quantity: Quantity::Flow, coefficients: coefficients.to_vec() }
}

/// A prescribed pressure.
pub fn pressure_wave(node: usize, coefficients: &[Complex64]) -> Drive {
    Drive { node, quantity: Quantity::Pressure, coefficients: coefficients.to_vec() }
}

/// One over an impedance in mmHg·s/mL is its amplitude of flow.
pub const RESISTANCE: f64 = 133.322_387_415 * 1e6;
