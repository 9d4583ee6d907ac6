//! The pressures of several samples side by side, by whichever solver suits the circuit.

#![expect(clippy::inline_always, reason = "compiled as a whole for each instruction set")]

use super::conjugate_gradients::{ConjugateGradients, GradientsWorkspace};
use super::star_mesh::{StarMesh, StarMeshWorkspace};
use crate::error::{Error, Result};
use crate::flow::circuit::Circuit;
use crate::support::simd::{Lanes, Simd};

/// Joins of star-mesh elimination above which conjugate gradients solve a network that is solved few times.
const MOST_JOINS_ONCE: usize = 2_000_000;

/// A circuit compiled for one of the two solvers.
#[derive(Debug)]
pub enum BatchSolver {
    /// Star-mesh elimination.
    StarMesh(Box<StarMesh>),
    /// Conjugate gradients on the core that elimination leaves.
    Gradients(Box<ConjugateGradients>),
}

/// The memory of one worker that solves `B` samples side by side.
#[derive(Debug, Clone)]
pub enum BatchWorkspace<const B: usize> {
    /// For star-mesh elimination.
    StarMesh(Box<StarMeshWorkspace<B>>),
    /// For conjugate gradients.
    Gradients(Box<GradientsWorkspace<B>>),
}

impl<const B: usize> BatchWorkspace<B> {
    /// The pressures that were found, Pa above the circuit's level; those of a node stand at its [`BatchSolver::slot`].
    #[inline(always)]
    pub fn pressure(&self) -> &[Lanes<B>] {
        match self {
            Self::StarMesh(work) => &work.pressure,
            Self::Gradients(work) => &work.mesh.pressure,
        }
    }

    /// The pressures, and memory that is free until the next group is solved.
    #[inline(always)]
    pub fn pressure_and_spare(&mut self) -> (&[Lanes<B>], &mut [Lanes<B>]) {
        match self {
            Self::StarMesh(work) => work.pressure_and_spare(),
            Self::Gradients(work) => work.mesh.pressure_and_spare(),
        }
    }
}

impl BatchSolver {
    /// The solver of a network that is solved once or a few hundred times, as in a simulation.
    ///
    /// # Errors
    ///
    /// More vessels than indices can count.
    pub fn for_few(circuit: &Circuit) -> Result<Self> {
        match StarMesh::compile(circuit, MOST_JOINS_ONCE) {
            Some(program) => Ok(Self::StarMesh(Box::new(program))),
            None => Ok(Self::Gradients(Box::new(ConjugateGradients::compile(circuit).ok_or(Error::Breakdown)?))),
        }
    }

    /// The solver's name: `lanes` or `gradients`.
    pub fn name(&self) -> &'static str {
        match self {
            Self::StarMesh(_) => "lanes",
            Self::Gradients(_) => "gradients",
        }
    }

    /// The joins of one sample.
    pub fn joins(&self) -> usize {
        match self {
            Self::StarMesh(program) => program.updates(),
            Self::Gradients(program) => program.joins(),
        }
    }

    /// Where the pressure of a node stands in a workspace.
    pub fn slot(&self, node: usize) -> usize {
        match self {
            Self::StarMesh(program) => program.slot(node),
            Self::Gradients(program) => program.slot(node),
        }
    }

    /// The memory for groups of `B` samples, of which at least so many places are [spare](BatchWorkspace::pressure_and_spare).
    pub fn workspace<const B: usize>(&self, spare: usize) -> BatchWorkspace<B> {
        match self {
            Self::StarMesh(program) => BatchWorkspace::StarMesh(Box::new(program.workspace_with(spare))),
            Self::Gradients(program) => BatchWorkspace::Gradients(Box::new(program.workspace())),
        }
    }

    /// Solves the samples `first .. first + B` of a block, as [`StarMesh::solve`] does.
    #[inline(always)]
    pub fn solve<S: Simd, const B: usize>(
        &self,
        simd: S,
        masks: &[u64],
        first: usize,
        stranded: &[(usize, u64)],
        work: &mut BatchWorkspace<B>,
    ) {
        match (self, work) {
            (Self::StarMesh(program), BatchWorkspace::StarMesh(work)) => program.solve(simd, masks, first, stranded, work),
            (Self::Gradients(program), BatchWorkspace::Gradients(work)) => program.solve(simd, masks, first, stranded, work),
            _ => debug_assert!(false, "the memory of another solver"),
        }
    }

    /// Solves a group of samples that differ in the conductances of their vessels, as [`StarMesh::solve_with`] does.
    #[inline(always)]
    pub fn solve_with<S: Simd, const B: usize>(
        &self,
        simd: S,
        conductance: &[Lanes<B>],
        stranded: &[(usize, u64)],
        work: &mut BatchWorkspace<B>,
    ) {
        match (self, work) {
            (Self::StarMesh(program), BatchWorkspace::StarMesh(work)) => program.solve_with(simd, conductance, stranded, work),
            (Self::Gradients(program), BatchWorkspace::Gradients(work)) => program.solve_with(simd, conductance, stranded, work),
            _ => debug_assert!(false, "the memory of another solver"),
        }
    }
}
