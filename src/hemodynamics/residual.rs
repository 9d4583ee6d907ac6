//! How well pressures solve a circuit: what is left of Kirchhoff's current law A P = b.

use super::circuit::Circuit;

/// What is left in one sample.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub struct Residual {
    /// ‖b - A P‖/‖b‖.
    pub relative: f64,
    /// ‖b - A P‖ beside what flows through all conductances at these pressures, which rounding alone leaves at 1e-16 or so.
    pub backward: f64,
}

/// The memory of a check.
#[derive(Debug, Clone, Default)]
pub struct Check {
    /// What flows into each node less what flows out, m³/s.
    net: Vec<f64>,
    /// b: what drives flow into each node, m³/s.
    driven: Vec<f64>,
    /// The conductance at each node, m³/(Pa s).
    total: Vec<f64>,
}

impl Check {
    /// Checks the pressures (Pa above the level) of the free nodes in one sample of a block: bit `sample` of `masks[e]` says whether vessel
    /// e is open, that of a node's among the `stranded` whether its injection counts for nothing.
    pub fn residual(
        &mut self,
        circuit: &Circuit,
        masks: &[u64],
        sample: usize,
        stranded: &[(usize, u64)],
        pressure: impl Fn(usize) -> f64,
    ) -> Residual {
        let Self { net, driven, total } = self;
        let is_set = |word: u64| word >> sample & 1 == 1;
        net.clone_from(&circuit.source);
        stranded.iter().filter(|(_, samples)| is_set(*samples)).for_each(|(node, _)| net[*node] = 0.0);
        driven.clone_from(net);
        total.clone_from(&circuit.shunt);
        for (vessel, [a, b]) in circuit.ends.iter().copied().enumerate().filter(|(vessel, _)| is_set(masks[*vessel])) {
            let c = circuit.conductance[vessel];
            let flow = c * (pressure(a) - pressure(b));
            net[a] -= flow;
            net[b] += flow;
            driven[a] += c * circuit.fixed[b].unwrap_or(0.0);
            driven[b] += c * circuit.fixed[a].unwrap_or(0.0);
            total[a] += c;
            total[b] += c;
        }
        let (mut error, mut right, mut left) = (0.0, 0.0, 0.0);
        for node in (0..net.len()).filter(|node| circuit.fixed[*node].is_none()) {
            error += (net[node] - circuit.shunt[node] * pressure(node)).powi(2);
            right += driven[node].powi(2);
            left += (total[node] * pressure(node)).powi(2);
        }
        let share = |all: f64| if all > 0.0 { (error / all).sqrt() } else { 0.0 };
        Residual { relative: share(right), backward: share(right + left) }
    }
}
