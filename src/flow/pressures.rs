//! The steady pressures of one network, all its vessels open or some of them closed.

use super::batch::conjugate_gradients::ConjugateGradients;
use super::batch::star_mesh::StarMesh;
use super::circuit::Circuit;
use super::floating::{grounded, stranded};
use super::residual::Check;
use crate::error::{Error, Result};
use crate::support::simd::Scalar;

/// Mesh updates above which conjugate gradients take over from star-mesh elimination.
pub const LANES_LIMIT: usize = 2_000_000;
/// A backward error beyond this means that pressures were not found.
pub const MOST_BACKWARD: f64 = 1e-10;

/// A circuit compiled to be solved with one pattern of open vessels after another.
#[derive(Debug)]
pub struct PressureSolver<'a> {
    circuit: &'a Circuit,
    solver: Solver,
}

#[derive(Debug)]
enum Solver {
    Mesh(Box<StarMesh>),
    Gradients(Box<ConjugateGradients>),
}

impl<'a> PressureSolver<'a> {
    /// Compiles a circuit.
    ///
    /// # Errors
    ///
    /// More vessels than indices can count.
    pub fn new(circuit: &'a Circuit) -> Result<Self> {
        match StarMesh::compile(circuit, LANES_LIMIT) {
            Some(program) => Ok(Self { circuit, solver: Solver::Mesh(Box::new(program)) }),
            None => Self::iterative(circuit),
        }
    }

    /// Compiles a circuit that is known to be too large for elimination.
    ///
    /// # Errors
    ///
    /// More vessels than indices can count.
    pub fn iterative(circuit: &'a Circuit) -> Result<Self> {
        let program = ConjugateGradients::compile(circuit).ok_or(Error::Breakdown)?;
        Ok(Self { circuit, solver: Solver::Gradients(Box::new(program)) })
    }

    /// The pressure of every node with the vessels `open`, Pa above the circuit's level, from which drops are taken without a loss;
    /// `None` in floating components, where it is undefined.
    ///
    /// # Errors
    ///
    /// Conjugate gradients that do not converge on a large circuit.
    pub fn above_level(&self, open: impl Fn(usize) -> bool) -> Result<Vec<Option<f64>>> {
        let circuit = self.circuit;
        let masks: Vec<u64> = (0..circuit.vessel_count()).map(|v| u64::from(open(v))).collect();
        let stranded = stranded(circuit, &masks, 1);
        let above_level: Vec<f64> = match &self.solver {
            Solver::Mesh(program) => {
                let mut work = program.workspace::<1>();
                program.solve(Scalar::new(), &masks, 0, &stranded, &mut work);
                (0..circuit.node_count()).map(|node| work.pressure[program.slot(node)][0]).collect()
            }
            Solver::Gradients(program) => {
                let mut work = program.workspace::<1>();
                program.solve(Scalar::new(), &masks, 0, &stranded, &mut work);
                let mut pressure = vec![0.0; circuit.node_count()];
                program.pressures(&masks, 0, 0, &mut work, &mut pressure);
                if Check::default().residual(circuit, &masks, 0, &stranded, |node| pressure[node]).backward > MOST_BACKWARD {
                    return Err(Error::Breakdown);
                }
                pressure
            }
        };
        let grounded = grounded(circuit, open);
        Ok(above_level.iter().zip(grounded).map(|(p, grounded)| grounded.then_some(*p)).collect())
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
