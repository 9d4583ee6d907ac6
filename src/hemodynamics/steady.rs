//! The steady pressures of one network, all its vessels open or some of them closed.

use super::cholesky::{self, Cholesky};
use super::circuit::Circuit;
use super::floating::{grounded, stranded};
use super::star_mesh::StarMesh;
use crate::error::{Error, Result};
use crate::simd::Scalar;

/// Mesh updates above which the sparse Cholesky solver takes over from star-mesh elimination.
pub const LANES_LIMIT: usize = 2_000_000;

/// A circuit compiled to be solved with one pattern of open vessels after another.
#[derive(Debug)]
pub struct Steady<'a> {
    circuit: &'a Circuit,
    solver: Solver,
}

#[derive(Debug)]
enum Solver {
    Mesh(Box<StarMesh>),
    Sparse(Box<Cholesky>),
}

impl<'a> Steady<'a> {
    /// Compiles a circuit.
    ///
    /// # Errors
    ///
    /// No memory for the factorisation of a large one.
    pub fn new(circuit: &'a Circuit) -> Result<Self> {
        let solver = match StarMesh::compile(circuit, LANES_LIMIT) {
            Some(program) => Solver::Mesh(Box::new(program)),
            None => Solver::Sparse(Box::new(Cholesky::compile(circuit).ok_or(Error::Breakdown)?)),
        };
        Ok(Self { circuit, solver })
    }

    /// The pressure (Pa) of every node with the vessels `open`; `None` in floating components, where it is undefined.
    ///
    /// # Errors
    ///
    /// A large circuit whose conductances lie too far apart for the sparse factorisation.
    pub fn pressures(&self, open: impl Fn(usize) -> bool) -> Result<Vec<Option<f64>>> {
        let circuit = self.circuit;
        let mut above_level = vec![0.0; circuit.node_count()];
        match &self.solver {
            Solver::Mesh(program) => {
                let masks: Vec<u64> = (0..circuit.vessel_count()).map(|v| u64::from(open(v))).collect();
                let mut work = program.workspace::<1>();
                program.solve(Scalar::new(), &masks, 0, &stranded(circuit, &masks, 1), &mut work);
                for (node, p) in above_level.iter_mut().enumerate() {
                    *p = work.pressure[program.slot(node)][0];
                }
            }
            Solver::Sparse(factor) => {
                factor.solve(&open, &mut cholesky::Workspace::default(), |node, p| above_level[node] = p)?;
            }
        }
        let grounded = grounded(circuit, open);
        Ok(above_level.iter().zip(grounded).map(|(p, grounded)| grounded.then_some(p + circuit.level)).collect())
    }
}

/// The pressure (Pa) of every node with the vessels `open`; `None` in floating components, where it is undefined.
///
/// # Errors
///
/// As [`Steady::new`] and [`Steady::pressures`].
pub fn pressures(circuit: &Circuit, open: impl Fn(usize) -> bool) -> Result<Vec<Option<f64>>> {
    Steady::new(circuit)?.pressures(open)
}
