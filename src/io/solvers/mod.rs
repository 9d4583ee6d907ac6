//! Writes a network with its conditions for solvers in time: svZeroDSolver (lumped) and openBF (one-dimensional).

mod openbf;
mod svzerod;

use std::f64::consts::PI;
use std::io;

pub use openbf::write_openbf;
pub use svzerod::write_svzerod;

use crate::network::{Condition, Network, Vessel, Wall};

/// Blood, kg/m³ and Pa s.
const DENSITY: f64 = 1060.0;
const VISCOSITY: f64 = 3.5e-3;
/// Walls that are not stated have a thickness of this share of the radius.
const THICKNESS: f64 = 0.1;

/// A network with vessels along the way from inlets to outlets, and what holds at their ends.
struct Directed<'a> {
    network: &'a Network,
    /// By row the node where the vessel begins and that where it ends.
    turned: Vec<[usize; 2]>,
    /// By node its vessels.
    at: Vec<Vec<usize>>,
}

impl<'a> Directed<'a> {
    /// Turns the vessels away from the nodes where blood enters, by the number of vessels on the way.
    ///
    /// # Errors
    ///
    /// No condition at all, a condition in the middle of vessels, a self-loop (`InvalidInput`).
    fn of(network: &'a Network) -> io::Result<Self> {
        let refused = |why: String| io::Error::new(io::ErrorKind::InvalidInput, why);
        let mut at = vec![Vec::new(); network.node_count()];
        for (row, (ends, _)) in network.vessels().enumerate() {
            if ends[0] == ends[1] {
                return Err(refused(format!("{} joins a node to itself", network.vessel_name(row))));
            }
            for node in ends {
                at[node].push(row);
            }
        }
        let enters = |node: usize| match network.node(node).condition {
            Some(Condition::Flow(flow)) => flow > 0.0,
            Some(Condition::Pressure(pressure)) => {
                pressure > 0.0 && network.node(node).role != Some(crate::network::Role::Outlet)
            }
            _ => false,
        };
        let stated: Vec<usize> = (0..network.node_count()).filter(|node| network.node(*node).condition.is_some()).collect();
        if let Some(inner) = stated.iter().find(|node| at[**node].len() > 1) {
            return Err(refused(format!("the condition of node {} is not at a free end", network.node(*inner).id)));
        }
        let mut level = vec![usize::MAX; network.node_count()];
        let mut next: Vec<usize> = stated.into_iter().filter(|node| enters(*node)).collect();
        if next.is_empty() {
            return Err(refused("no node states an inlet; state conditions in the file".to_owned()));
        }
        for node in &next {
            level[*node] = 0;
        }
        let mut place = 0;
        while place < next.len() {
            let node = next[place];
            for row in &at[node] {
                let [a, b] = network.ends(*row);
                let other = if a == node { b } else { a };
                if level[other] == usize::MAX {
                    level[other] = level[node] + 1;
                    next.push(other);
                }
            }
            place += 1;
        }
        // A free end is where its vessel begins if blood enters there, and where it ends otherwise.
        let rank = |node: usize| match (enters(node), at[node].len()) {
            (true, _) => (0, node),
            (false, 1) => (usize::MAX, node),
            _ => (level[node], node),
        };
        let ends = network.vessels().map(|([a, b], _)| if rank(a) <= rank(b) { [a, b] } else { [b, a] }).collect();
        Ok(Self { network, turned: ends, at })
    }

    /// The condition of a free end; `None` of an inner node, a flow of zero of an end that states nothing.
    fn condition(&self, node: usize) -> Option<Condition> {
        (self.at[node].len() == 1).then(|| self.network.node(node).condition.unwrap_or(Condition::Flow(0.0)))
    }
}

/// Eh of a wall, Pa m: as it is stated, else Olufsen's law (1999).
fn stiffness(vessel: &Vessel) -> f64 {
    match vessel.wall {
        Some(Wall::Elastic { young, thickness }) => young * thickness,
        Some(Wall::Speed(speed)) => 1.5 * DENSITY * speed * speed * vessel.radius,
        None => vessel.radius * (2.0e6 * (-2253.0 * vessel.radius).exp() + 8.65e4),
    }
}

/// The cross-section of a vessel, m².
fn area(vessel: &Vessel) -> f64 {
    PI * vessel.radius * vessel.radius
}

/// Behind a terminal resistance: R1, R2 (Pa s/m³) and C (m³/Pa), where the node states one.
fn windkessel(network: &Network, node: usize, resistance: f64) -> Option<[f64; 3]> {
    let stated = network.node(node).windkessel;
    let proximal = stated.proximal.unwrap_or(0.0).min(resistance);
    stated.compliance.map(|compliance| [proximal, resistance - proximal, compliance])
}
