//! The steady pressures of one network, with all of its vessels open or some of them closed; and how well pressures solve a circuit: what
//! is left of Kirchhoff's current law A P = b.

use super::{BatchSolver, Circuit, batch::conductances::MaskedRows, grounded, stranded};
use crate::error::{Error, Result};
use crate::support::simd::Scalar;

/// A solver with a backward error above this has not found the pressures.
pub const MOST_BACKWARD: f64 = 1e-10;

impl BatchSolver {
    /// The pressure of every node of the circuit that was compiled, with the rows `open`, vessels and terminals that hold, Pa above the circuit's
    /// level, so that drops keep all of their digits; `None` in floating components, where it is undefined.
    ///
    /// # Errors
    ///
    /// Conjugate gradients that do not converge on a large circuit.
    pub fn above_level(&self, circuit: &Circuit, open: impl Fn(usize) -> bool) -> Result<Vec<Option<f64>>> {
        let masks: Vec<u64> = (0..circuit.row_count()).map(|row| u64::from(open(row))).collect();
        let stranded = stranded(circuit, &masks, 1);
        let mut work = self.workspace::<1>();
        let rows = MaskedRows { conductance: &circuit.conductance, masks: &masks, first: 0 };
        self.solve(Scalar::new(), &rows, 0, &stranded, &mut work);
        let pressure = |node: usize| work.pressure()[self.slot(node)][0];
        if self.core().is_some() {
            let residual = Check::default().residual(circuit, circuit.if_open(&masks), &stranded, pressure);
            if residual.backward > MOST_BACKWARD {
                return Err(Error::Breakdown);
            }
        }
        let grounded = grounded(circuit, |row| masks[row] == 1).into_iter().enumerate();
        Ok(grounded.map(|(node, grounded)| grounded.then(|| pressure(node))).collect())
    }
}

/// The pressure (Pa) of every node with the vessels `open`; `None` in floating components, where it is undefined.
///
/// # Errors
///
/// As [`BatchSolver::for_few`] and [`BatchSolver::above_level`].
pub fn pressures(circuit: &Circuit, open: impl Fn(usize) -> bool) -> Result<Vec<Option<f64>>> {
    Ok(circuit.pressures(&BatchSolver::for_few(circuit)?.above_level(circuit, open)?))
}

/// The residual of one sample.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub struct Residual {
    /// ‖b - A P‖/‖b‖.
    pub relative: f64,
    /// ‖b - A P‖ over the norm of the flows through all conductances at these pressures; about 1e-16 from rounding alone.
    pub backward: f64,
}

/// The memory of a check.
#[derive(Debug, Clone, Default)]
pub struct Check {
    /// By node, one after another: its conductance, what drives flow into it, what flows in less what flows out.
    at: Vec<f64>,
    /// By node the pressure that is fixed in this sample.
    fixed: Vec<Option<f64>>,
}

impl Check {
    /// Checks the pressures (Pa above the level) of the free nodes in the first sample of a block, in which each vessel has such a
    /// conductance, zero where it is closed. The injected flow of the `stranded` nodes whose bit 0 is set counts for nothing.
    pub fn residual(
        &mut self,
        circuit: &Circuit,
        conductance: impl Fn(usize) -> f64,
        stranded: &[(usize, u64)],
        pressure: impl Fn(usize) -> f64,
    ) -> Residual {
        let Self { at, fixed } = self;
        fixed.clone_from(&circuit.fixed);
        for (_, [node, outside]) in circuit.fixing().filter(|(row, _)| conductance(*row) > 0.0) {
            fixed[node] = circuit.fixed[outside];
        }
        let vessels = || circuit.ends.iter().enumerate().map(|(vessel, ends)| (ends, conductance(vessel)));
        let free = || (0..circuit.node_count()).filter(|node| fixed[*node].is_none());

        at.clone_from(&circuit.shunt);
        for ([a, b], c) in vessels() {
            at[*a] += c;
            at[*b] += c;
        }
        let left: f64 = free().map(|node| (at[node] * pressure(node)).powi(2)).sum();

        let sources = |at: &mut Vec<f64>| {
            at.clone_from(&circuit.source);
            stranded.iter().filter(|(_, samples)| samples & 1 == 1).for_each(|(node, _)| at[*node] = 0.0);
        };
        sources(at);
        for ([a, b], c) in vessels() {
            at[*a] += c * fixed[*b].unwrap_or(0.0);
            at[*b] += c * fixed[*a].unwrap_or(0.0);
        }
        let right: f64 = free().map(|node| at[node].powi(2)).sum();

        sources(at);
        for ([a, b], c) in vessels() {
            let flow = c * (pressure(*a) - pressure(*b));
            at[*a] -= flow;
            at[*b] += flow;
        }
        let error: f64 = free().map(|node| (at[node] - circuit.shunt[node] * pressure(node)).powi(2)).sum();

        let share = |all: f64| if all > 0.0 { (error / all).sqrt() } else { 0.0 };
        Residual { relative: share(right), backward: share(right + left) }
    }
}
