//! The steady pressures of one network, with all of its vessels open or some of them closed.

use super::batch::solver::BatchSolver;
use super::circuit::Circuit;
use super::floating_components::{grounded, stranded};
use super::residual::Check;
use crate::error::{Error, Result};
use crate::support::simd::Scalar;

/// A solver with a backward error above this has not found the pressures.
pub const MOST_BACKWARD: f64 = 1e-10;

/// A compiled circuit, which can be solved for one pattern of open vessels after another.
#[derive(Debug)]
pub struct PressureSolver<'a> {
    circuit: &'a Circuit,
    solver: BatchSolver,
}

impl<'a> PressureSolver<'a> {
    /// Compiles a circuit.
    ///
    /// # Errors
    ///
    /// More vessels than indices can count.
    pub fn new(circuit: &'a Circuit) -> Result<Self> {
        Ok(Self { circuit, solver: BatchSolver::for_few(circuit)? })
    }

    /// The pressure of every node with the rows `open`, vessels and terminals that hold, Pa above the circuit's level, so that drops keep all of their digits;
    /// `None` in floating components, where it is undefined.
    ///
    /// # Errors
    ///
    /// Conjugate gradients that do not converge on a large circuit.
    pub fn above_level(&self, open: impl Fn(usize) -> bool) -> Result<Vec<Option<f64>>> {
        let Self { circuit, solver } = self;
        let masks: Vec<u64> = (0..circuit.row_count()).map(|row| u64::from(open(row))).collect();
        let stranded = stranded(circuit, &masks, 1);
        let mut work = solver.workspace::<1>();
        solver.solve(Scalar::new(), &solver.masked(&masks, 0), 0, &stranded, &mut work);
        let pressure = |node: usize| work.pressure()[solver.slot(node)][0];
        if solver.core().is_some() {
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
/// As [`PressureSolver::new`] and [`PressureSolver::above_level`].
pub fn pressures(circuit: &Circuit, open: impl Fn(usize) -> bool) -> Result<Vec<Option<f64>>> {
    Ok(circuit.pressures(&PressureSolver::new(circuit)?.above_level(open)?))
}
