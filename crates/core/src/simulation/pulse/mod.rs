//! Pulsatile flow in a network of elastic tubes: one complex linear solve a harmonic, beside the steady flow, which is harmonic 0.
//!
//! Signals are f(t) = Re Σ c_n e^{iω_n t}, ω_n = 2πn/T. Each vessel is a two-port, nodes conserve flow: Σ Q into vessels + y_t P = injected,
//! a complex symmetric system. The theory is linear: no convective acceleration, no wall that widens in the cycle, no loss behind a stenosis.

pub mod arrival;
pub mod elimination;
pub mod fourier;
pub mod typical;
pub mod womersley;

mod setting;

use std::f64::consts::TAU;

use num_complex::Complex64;

use super::BothStates;
use crate::error::{Error, Result};
use crate::flow::{Boundary, state::State};
use crate::network::{Condition, Network, waveform::Quantity};
use crate::support::{elimination::Elimination, in_order};
use arrival::Arrivals;
use elimination::Equations;
use fourier::{Indices, behind};
use womersley::{Fluid, Halved, TubeSegment};

pub use setting::{Drive, Setting, TerminalImpedance, Walled, terminals, walled};
pub use womersley::Friction;

/// The most joins of an elimination.
const MOST_JOINS: usize = 1 << 27;

/// The pulse of one vessel by its harmonics. Flows are positive from the first node to the second.
#[derive(Debug, Clone, PartialEq)]
pub struct VesselPulse {
    /// Flow at the first end, in the middle, and at the second end, m³/s.
    pub flow: [Vec<Complex64>; 3],
    /// Pressure in the middle, Pa; `None` of a vessel that is closed or tied to no pressure.
    pub pressure: Option<Vec<Complex64>>,
}

/// The pulse of a network by its harmonics 0 to H.
#[derive(Debug, Clone, PartialEq)]
pub struct Pulse {
    /// T, s.
    pub period: f64,
    /// H.
    pub harmonics: usize,
    /// By node, Pa; `None` in floating components.
    pub pressure: Vec<Option<Vec<Complex64>>>,
    /// By row.
    pub vessels: Vec<VesselPulse>,
    /// The largest amplitude of any flow in the middle of a vessel, m³/s: what is less than a share of it is rounding.
    pub largest_flow: f64,
    /// By row, what the vessel is made of.
    pub walls: Vec<Walled>,
    /// When the wave arrives.
    pub arrivals: Arrivals,
}

/// The pulse of a simulation.
#[derive(Debug, Clone, PartialEq)]
pub struct Pulses {
    /// In the network as it is, and with its changes.
    pub both: BothStates<Pulse>,
    /// Blood.
    pub fluid: Fluid,
    /// The phase of what drives the first inlet ([`Indices::phase`]), from which delays are taken, s.
    pub first_phase: f64,
    /// At how many even times of the period waveforms are written.
    pub times: usize,
}

/// One harmonic: pressures by node, and by vessel flow at the first end, in the middle and at the second, and pressure in the middle.
struct Harmonic {
    pressure: Vec<Complex64>,
    vessels: Vec<[Complex64; 4]>,
}

impl Pulse {
    /// The pulse on a steady flow of the same conditions.
    ///
    /// # Errors
    ///
    /// A network whose elimination has more joins than memory holds.
    pub fn of(network: &Network, boundary: &Boundary, state: &State, setting: &Setting<'_>) -> Result<Self> {
        let ends: Vec<[usize; 2]> = network.vessels().map(|(ends, _)| ends).collect();
        let system = System::new(&ends, boundary, state, setting)?;
        let numbers: Vec<usize> = (1..=setting.harmonics).collect();
        let all = in_order(&numbers, |_, n| system.harmonic(*n));
        let series = |first: Complex64, of: &dyn Fn(&Harmonic) -> Complex64| {
            std::iter::once(first).chain(all.iter().map(of)).collect::<Vec<Complex64>>()
        };
        let steady = |x: f64| Complex64::new(x, 0.0);
        let pressure = state.pressure.iter().enumerate();
        let pressure = pressure.map(|(node, mean)| mean.map(|mean| series(steady(mean), &|h| h.pressure[node])));
        let vessel = |row: usize| {
            let flow = state.vessels[row].flow;
            let [a, b] = ends[row].map(|node| state.pressure[node]);
            let middle = a.zip(b).filter(|_| setting.vessels[row].is_open()).map(|(a, b)| {
                let at_rest = Halved::of(&setting.vessels[row].halves, setting.fluid, 0.0);
                at_rest.middle([steady(a), steady(b)]).0
            });
            VesselPulse {
                flow: [0, 1, 2].map(|place| series(steady(flow), &|h| h.vessels[row][place])),
                pressure: middle.map(|mean| series(mean, &|h| h.vessels[row][3])),
            }
        };
        let pressure: Vec<Option<Vec<Complex64>>> = pressure.collect();
        let vessels: Vec<VesselPulse> = (0..ends.len()).map(vessel).collect();
        let places = pressure.iter().chain(vessels.iter().map(|vessel| &vessel.pressure));
        let arrivals = Arrivals::follow(&ends, setting, &places.map(Option::as_deref).collect::<Vec<_>>());
        let (period, harmonics, walls) = (setting.period, setting.harmonics, setting.vessels.to_vec());
        let largest_flow = vessels.iter().flat_map(|v| &v.flow[1]).map(|c| c.norm()).fold(0.0, f64::max);
        Ok(Self { period, harmonics, pressure, vessels, largest_flow, walls, arrivals })
    }

    /// The wall shear stress in the middle of a vessel where it is narrowest, Pa, by its harmonics.
    pub fn wall_shear(&self, row: usize, fluid: &Fluid) -> Vec<Complex64> {
        let radius = self.walls[row].narrowest;
        let at = |(n, q): (usize, &Complex64)| {
            let frequency = TAU * n as f64 / self.period;
            // At rest F10 is 1 exactly, whatever the profile.
            TubeSegment::wall_shear(radius, fluid, frequency, *q)
        };
        self.vessels[row].flow[1].iter().enumerate().map(at).collect()
    }

    /// The figures of the flow in the middle of a vessel.
    pub fn flow_indices(&self, row: usize) -> Indices {
        let (flow, rounding) = (&self.vessels[row].flow[1], ROUNDING * self.largest_flow);
        let found = Indices::of(flow, self.period, rounding);
        let is_none = flow.iter().all(|c| c.norm() <= rounding);
        if is_none { Indices { mean: 0.0, max: 0.0, min: 0.0, ..found } } else { found }
    }

    /// The figures of the pressure at a node.
    pub fn node_indices(&self, node: usize) -> Option<Indices> {
        self.pressure[node].as_ref().map(|pressure| Indices::of(pressure, self.period, 0.0))
    }
}

/// What holds at a node at every harmonic but 0.
enum NodeEquation {
    /// No pressure reaches it.
    Dead,
    /// Its pressure is prescribed.
    Fixed,
    /// Kirchhoff's law holds; its place in the elimination.
    Free(u32),
}

/// The equations of a network at any harmonic.
struct System<'a> {
    ends: &'a [[usize; 2]],
    setting: &'a Setting<'a>,
    elimination: Elimination,
    places: Vec<NodeEquation>,
    /// By node the terminal behind it; of the free ones only.
    drive: Vec<Option<&'a Drive>>,
}

impl<'a> System<'a> {
    fn new(ends: &'a [[usize; 2]], boundary: &Boundary, state: &State, setting: &'a Setting<'a>) -> Result<Self> {
        let nodes = state.pressure.len();
        let mut drive: Vec<Option<&Drive>> = vec![None; nodes];
        for one in setting.drives {
            drive[one.node] = Some(one);
        }
        let is_fixed = |node: usize| match drive[node] {
            Some(drive) => drive.quantity == Quantity::Pressure,
            None => matches!(boundary.condition(node), Some(Condition::Pressure(_))),
        };
        let is_dead = |node: usize| state.pressure[node].is_none();
        let is_free = |node: usize| !is_dead(node) && !is_fixed(node);
        let open = ends.iter().enumerate().filter(|(row, _)| setting.vessels[*row].is_open());
        let open: Vec<[usize; 2]> = open.map(|(_, ends)| *ends).collect();
        let order = |nodes: usize, links: &[[usize; 2]]| Elimination::compile(nodes, links, MOST_JOINS);
        let elimination = Elimination::among(nodes, &open, is_free, order).ok_or_else(|| {
            Error::parameter("pulse", format!("{nodes} nodes"), "the loops of the network are too many for a direct solution")
        })?;
        let place = |node: usize| match (is_dead(node), is_fixed(node)) {
            (true, _) => NodeEquation::Dead,
            (_, true) => NodeEquation::Fixed,
            _ => NodeEquation::Free(elimination.place(node)),
        };
        let places = (0..nodes).map(place).collect();
        Ok(Self { ends, setting, elimination, places, drive })
    }

    /// The c_n that a drive prescribes; zero without one.
    fn driven(&self, node: usize, n: usize) -> Complex64 {
        self.drive[node].map_or(Complex64::ZERO, |drive| drive.coefficients[n])
    }

    fn harmonic(&self, n: usize) -> Harmonic {
        let Setting { fluid, period, vessels, terminals, .. } = *self.setting;
        let frequency = TAU * n as f64 / period;
        let ports = vessels.iter().map(|vessel| vessel.is_open().then(|| Halved::of(&vessel.halves, fluid, frequency)));
        let ports: Vec<Option<Halved>> = ports.collect();

        let mut equations = Equations::new(&self.elimination);
        for (node, place) in self.places.iter().enumerate() {
            let NodeEquation::Free(place) = place else { continue };
            match (self.drive[node], &terminals[node]) {
                (Some(_), _) => equations.inject(*place, self.driven(node, n)),
                (None, Some(terminal)) => equations.ground(*place, terminal.admittance(frequency)),
                (None, None) => {}
            }
        }
        for (row, [a, b]) in self.ends.iter().enumerate() {
            let Some(port) = &ports[row] else { continue };
            for (node, shunt) in [*a, *b].into_iter().zip(port.whole.shunts) {
                if let NodeEquation::Free(place) = self.places[node] {
                    equations.ground(place, shunt);
                }
            }
            match (&self.places[*a], &self.places[*b]) {
                (NodeEquation::Free(p), NodeEquation::Free(q)) => equations.join(*p, *q, port.whole.series),
                (NodeEquation::Free(p), NodeEquation::Fixed) => equations.tie(*p, port.whole.series, self.driven(*b, n)),
                (NodeEquation::Fixed, NodeEquation::Free(q)) => equations.tie(*q, port.whole.series, self.driven(*a, n)),
                _ => {}
            }
        }
        let solved = equations.solve();
        let pressure = self.places.iter().enumerate().map(|(node, place)| match place {
            NodeEquation::Dead => Complex64::ZERO,
            NodeEquation::Fixed => self.driven(node, n),
            NodeEquation::Free(place) => solved[*place as usize],
        });
        let pressure: Vec<Complex64> = pressure.collect();
        let vessel = |(port, ends): (&Option<Halved>, &[usize; 2])| {
            let alive = ends.iter().all(|node| !matches!(self.places[*node], NodeEquation::Dead));
            let Some(port) = port.as_ref().filter(|_| alive) else { return [Complex64::ZERO; 4] };
            let at = ends.map(|node| pressure[node]);
            let ([a, b], (middle, through)) = (port.end_flows(at), port.middle(at));
            [a, through, b, middle]
        };
        let vessels = ports.iter().zip(self.ends).map(vessel).collect();
        Harmonic { pressure, vessels }
    }
}

/// Flows below this share of the largest amplitude in the network are rounding.
const ROUNDING: f64 = 1e-9;

impl Pulses {
    /// A phase as the time behind that of the first inlet, s.
    pub fn delay(&self, phase: f64, period: f64) -> f64 {
        behind(phase, self.first_phase, period)
    }
}
