//! Where the blood of every vessel comes from and when: transport on a steady flow, each vessel a plug, nodes perfectly mixed.
//!
//! With I_j all that enters node j, s_j of it from outside, and t_e = V_e/|Q_e| the transit time of vessel e, over the vessels e that bring
//! blood to j: share of source k f_j^k = (s_j [j = k] + Σ q f_up^k)/I_j; mean time since entry M_j = Σ q (M_up + t)/I_j; its variance
//! V_j = (Σ q (V_up + (M_up + t - M_j)²) + s_j M_j²)/I_j; first arrival min(first_up + t); per source M_j^k = Σ q f_up^k (M_up^k + t)/(I_j f_j^k).
//! Pressure falls along the flow, so one pass over the nodes in the order of the flow is exact. Supply fractions: Kansagra and Wong 2008.

use super::{BothStates, Simulation};
use crate::flow::{Boundary, state::State};
use crate::network::{Network, walks::other};
use crate::support::{distinct, grouped, marked};

/// A flow is no source or exit where it is less than this share of what passes its node.
const ROUNDING: f64 = 1e-9;

/// Blood at one place: where it entered, and when.
#[derive(Debug, Clone, PartialEq)]
pub struct Blood {
    /// The share from each source; 1 in all.
    pub supply: Vec<f64>,
    /// Time since entry, s: mean, ...
    pub mean: f64,
    /// ... variance (s²), ...
    pub variance: f64,
    /// ... and that of the first to arrive. Along the axis of a parabolic profile blood is twice as fast.
    pub first: f64,
    /// The mean by source; NaN of one that sends nothing.
    pub mean_of_source: Vec<f64>,
    /// All that passes, m³/s.
    pub through: f64,
}

/// Where the blood of a network comes from, and when it arrives.
#[derive(Debug, Clone, PartialEq)]
pub struct Transport {
    /// The nodes through which blood enters.
    pub sources: Vec<usize>,
    /// What enters through each, m³/s.
    pub inflow: Vec<f64>,
    /// Node and flow (m³/s) of each place through which blood leaves, by node.
    pub exits: Vec<(usize, f64)>,
    /// Per node; `None` where no blood comes.
    pub nodes: Vec<Option<Blood>>,
    /// Per vessel the node at its upstream end and its transit time in s; `None` where nothing flows.
    pub vessels: Vec<Option<(usize, f64)>>,
    /// The nodes that blood reaches, in the order of the flow.
    pub order: Vec<usize>,
}

impl Transport {
    /// By node, of which of `count` marks the blood there last passed a vessel, as shares: of what entered and passed none, no share. Flows
    /// (m³/s) between `ends` are those that were followed; `marks` are by vessel.
    pub fn passed(&self, ends: &[[usize; 2]], flow: &[f64], marks: &[Option<usize>], count: usize) -> Vec<Option<Vec<f64>>> {
        let flowing = ends.iter().zip(&self.vessels).enumerate();
        let downstream = flowing.filter_map(|(row, (ends, vessel))| vessel.map(|(up, _)| (other(*ends, up), (row, up))));
        let into = grouped(self.nodes.len(), downstream);
        let mut passed: Vec<Option<Vec<f64>>> = vec![None; self.nodes.len()];
        for node in &self.order {
            let Some(blood) = &self.nodes[*node] else { continue };
            let mut shares = vec![0.0; count];
            for (row, up) in &into[*node] {
                let part = flow[*row].abs() / blood.through;
                match (marks[*row], &passed[*up]) {
                    (Some(mark), _) => shares[mark] += part,
                    (None, Some(before)) => shares.iter_mut().zip(before).for_each(|(share, before)| *share += part * before),
                    (None, None) => {}
                }
            }
            passed[*node] = Some(shares);
        }
        passed
    }

    /// The share of a source in some blood, and the mean time since entry of that share, s; of a node that is no source, zero.
    pub fn of_source(&self, blood: &Blood, source: usize) -> (f64, f64) {
        let at = self.sources.binary_search(&source);
        at.map_or((0.0, f64::NAN), |at| (blood.supply[at], blood.mean_of_source[at]))
    }

    /// What leaves through a node, m³/s.
    pub fn leaving(&self, node: usize) -> f64 {
        self.exits.binary_search_by_key(&node, |(exit, _)| *exit).map_or(0.0, |at| self.exits[at].1)
    }

    /// The blood at the upstream end of a vessel.
    pub fn of_vessel(&self, row: usize) -> Option<&Blood> {
        self.vessels[row].and_then(|(up, _)| self.nodes[up].as_ref())
    }
}

/// The transport of a simulation.
pub type Transports = BothStates<Transport>;

impl Transports {
    /// Follows the blood of both states of a simulation.
    pub fn of(network: &Network, boundary: &Boundary, simulation: &Simulation) -> Self {
        let ends: Vec<[usize; 2]> = network.vessels().map(|(ends, _)| ends).collect();
        let is_open = marked(network.node_count(), boundary.conditions.iter().map(|(node, _)| *node));
        let through = |state: &State| {
            let flow: Vec<f64> = state.vessels.iter().map(|vessel| vessel.flow).collect();
            let volume: Vec<f64> = state.vessels.iter().map(|vessel| vessel.volume).collect();
            transport(&ends, &flow, &volume, &is_open)
        };
        Self { unperturbed: through(&simulation.unperturbed), perturbed: simulation.perturbed.as_ref().map(through) }
    }

    /// The nodes through which blood enters in either state.
    pub fn sources(&self) -> Vec<usize> {
        distinct(self.states().flat_map(|(state, _)| state.sources.iter().copied()))
    }

    /// The nodes through which blood leaves in either state.
    pub fn exits(&self) -> Vec<usize> {
        distinct(self.states().flat_map(|(state, _)| state.exits.iter().map(|(node, _)| *node)))
    }
}

/// Follows the blood through vessels between the nodes `ends`, with flows from the first to the second (m³/s, no cycle among them) and
/// volumes of the lumen (m³). Blood enters and leaves only where `is_open` is set.
pub fn transport(ends: &[[usize; 2]], flow: &[f64], volume: &[f64], is_open: &[bool]) -> Transport {
    let count = is_open.len();
    let (mut net, mut passing) = (vec![0.0; count], vec![0.0; count]);
    let (mut into, mut outof) = (vec![Vec::new(); count], vec![Vec::new(); count]);
    let mut vessels = vec![None; ends.len()];
    for (row, ([a, b], q)) in ends.iter().zip(flow).enumerate() {
        if a == b || *q == 0.0 || q.is_nan() {
            continue;
        }
        let (up, down) = if *q > 0.0 { (*a, *b) } else { (*b, *a) };
        net[up] += q.abs();
        net[down] -= q.abs();
        passing[up] += q.abs();
        passing[down] += q.abs();
        into[down].push(row);
        outof[up].push(down);
        vessels[row] = Some((up, volume[row] / q.abs()));
    }
    for (node, net) in net.iter_mut().enumerate() {
        if !is_open[node] || net.abs() <= ROUNDING * passing[node] {
            *net = 0.0;
        }
    }
    let sources: Vec<usize> = (0..count).filter(|node| net[*node] > 0.0).collect();
    let mut waiting: Vec<usize> = into.iter().map(Vec::len).collect();
    let mut ready: Vec<usize> = (0..count).filter(|node| waiting[*node] == 0 && net[*node] > 0.0).collect();
    let mut nodes: Vec<Option<Blood>> = vec![None; count];
    let mut order = Vec::new();
    while let Some(node) = ready.pop() {
        order.push(node);
        let source = sources.binary_search(&node).ok().map(|source| (source, net[node]));
        let arriving = into[node].iter().filter_map(|row| {
            let (up, time) = vessels[*row]?;
            Some((flow[*row].abs(), nodes[up].as_ref()?, time))
        });
        nodes[node] = Some(Blood::mixed(sources.len(), source, &arriving.collect::<Vec<_>>()));
        for down in &outof[node] {
            waiting[*down] -= 1;
            if waiting[*down] == 0 {
                ready.push(*down);
            }
        }
    }
    let inflow = sources.iter().map(|node| net[*node]).collect();
    let exits = net.iter().enumerate().filter(|(_, net)| **net < 0.0).map(|(node, net)| (node, -net)).collect();
    Transport { sources, inflow, exits, nodes, vessels, order }
}

impl Blood {
    /// What a node mixes: from outside, as one of the `sources`, and by vessels, each with its flow, what it brings, and how long it takes.
    fn mixed(sources: usize, source: Option<(usize, f64)>, arriving: &[(f64, &Self, f64)]) -> Self {
        let entering = source.map_or(0.0, |(_, inflow)| inflow);
        let total = |of: &dyn Fn(&(f64, &Self, f64)) -> f64| arriving.iter().map(of).fold(0.0, |sum: f64, one| sum + one);
        let through = entering + total(&|(q, ..)| *q);
        let (mut supply, mut delayed) = (vec![0.0; sources], vec![0.0; sources]);
        if let Some((source, inflow)) = source {
            supply[source] += inflow / through;
        }
        for (q, blood, time) in arriving {
            for (k, share) in blood.supply.iter().enumerate().filter(|(_, share)| **share > 0.0) {
                supply[k] += q * share / through;
                delayed[k] += q * share * (blood.mean_of_source[k] + time) / through;
            }
        }
        let mean = total(&|(q, blood, time)| q * (blood.mean + time)) / through;
        let spread = total(&|(q, blood, time)| q * (blood.variance + (blood.mean + time - mean).powi(2)));
        let variance = (spread + entering * mean * mean) / through;
        let arrivals = arriving.iter().map(|(_, blood, time)| blood.first + time);
        let first = source.map(|_| 0.0).into_iter().chain(arrivals).fold(f64::INFINITY, f64::min);
        let mean_of_source = delayed.iter().zip(&supply).map(|(delayed, share)| delayed / share).collect();
        Self { supply, mean, variance, first, mean_of_source, through }
    }

    /// The source of the largest share, the earlier one of equals, with that share.
    pub fn territory(&self) -> (usize, f64) {
        let larger = |best: (usize, f64), one: (usize, &f64)| if *one.1 > best.1 + ROUNDING { (one.0, *one.1) } else { best };
        self.supply.iter().enumerate().fold((0, f64::NEG_INFINITY), larger)
    }
}
