//! The pressures of several samples side by side, by whichever solver suits the circuit.

#![expect(clippy::inline_always, reason = "compiled as a whole for each instruction set")]

use super::conductances::Conductances;
use super::conjugate_gradients::{ConjugateGradients, GradientsWorkspace};
use super::star_mesh::{StarMesh, StarMeshWorkspace};
use crate::error::{Error, Result};
use crate::flow::{circuit::Circuit, dead_ends::DeadEnds};
use crate::support::elimination::Elimination;
use crate::support::simd::{Lanes, Simd};

/// Joins of star-mesh elimination above which conjugate gradients solve a network that is solved few times.
const MOST_JOINS_ONCE: usize = 2_000_000;

/// A compiled circuit: star-mesh elimination of all of its nodes, or of those of few neighbours and conjugate gradients for the core that these leave.
#[derive(Debug)]
pub struct BatchSolver {
    mesh: StarMesh,
    core: Option<ConjugateGradients>,
}

/// The memory of one worker that solves `B` samples side by side.
#[derive(Debug, Clone)]
pub struct BatchWorkspace<const B: usize> {
    mesh: StarMeshWorkspace<B>,
    core: Option<GradientsWorkspace<B>>,
}

impl<const B: usize> BatchWorkspace<B> {
    /// The pressures that were found, Pa above the circuit's level; those of a node stand at its [`BatchSolver::slot`].
    #[inline(always)]
    pub fn pressure(&self) -> &[Lanes<B>] {
        &self.mesh.pressure
    }
}

impl BatchSolver {
    /// Star-mesh elimination; `None` when it would take more than `limit` joins a sample.
    pub fn star_mesh(circuit: &Circuit, limit: usize) -> Option<Self> {
        let mesh = StarMesh::compile(circuit, |nodes, links| Elimination::compile(nodes, links, limit))?;
        Some(Self { mesh, core: None })
    }

    /// Conjugate gradients.
    ///
    /// # Errors
    ///
    /// More joins than indices can count.
    pub fn gradients(circuit: &Circuit) -> Result<Self> {
        let (mesh, core) = ConjugateGradients::compile(circuit).ok_or(Error::Breakdown)?;
        Ok(Self { mesh, core: Some(core) })
    }

    /// The solver of a network that is solved once or a few hundred times, as in a simulation.
    ///
    /// # Errors
    ///
    /// More vessels than indices can count.
    pub fn for_few(circuit: &Circuit) -> Result<Self> {
        Self::star_mesh(circuit, MOST_JOINS_ONCE).map_or_else(|| Self::gradients(circuit), Ok)
    }

    /// The same for a circuit with the same vessels and free nodes, whatever its conductances, pressures and inflows.
    ///
    /// # Errors
    ///
    /// As [`Self::for_few`].
    pub fn of_same_graph(&self, circuit: &Circuit) -> Result<Self> {
        if self.core.is_some() {
            return Self::gradients(circuit);
        }
        Ok(Self { mesh: self.mesh.of_same_graph(circuit), core: None })
    }

    /// The core that conjugate gradients solve; none where elimination does it all.
    pub fn core(&self) -> Option<&ConjugateGradients> {
        self.core.as_ref()
    }

    /// The solver's name: `lanes` or `gradients`.
    pub fn name(&self) -> &'static str {
        if self.core.is_none() { "lanes" } else { "gradients" }
    }

    /// The joins of one sample, exact and incomplete.
    pub fn joins(&self) -> usize {
        self.mesh.program.joins() + self.core.as_ref().map_or(0, |core| core.incomplete.program.joins())
    }

    /// Conductances of the core that a step of conjugate gradients passes over, those of its incomplete elimination twice.
    pub fn rays_in_step(&self) -> usize {
        self.core.as_ref().map_or(0, |core| 2 * core.incomplete.program.rays() + self.mesh.program.core_rays())
    }

    /// Where the pressure of a node stands in a workspace.
    pub fn slot(&self, node: usize) -> usize {
        self.mesh.slot(node)
    }

    /// The memory for groups of `B` samples.
    pub fn workspace<const B: usize>(&self) -> BatchWorkspace<B> {
        BatchWorkspace { mesh: self.mesh.workspace(), core: self.core.as_ref().map(ConjugateGradients::workspace) }
    }

    /// Injects what is injected in a circuit that does not differ in anything else from the one that was compiled.
    pub fn inject_as(&mut self, circuit: &Circuit) {
        self.mesh.inject_as(circuit);
        if let Some(core) = &mut self.core {
            core.dead_ends = DeadEnds::new(circuit);
        }
    }

    /// Solves the samples `first .. first + B` of a block; `stranded` lists the nodes whose injected flow has nowhere to go, with the samples in
    /// which that is so.
    #[inline(always)]
    pub fn solve<S: Simd, const B: usize>(
        &self,
        simd: S,
        rows: &impl Conductances<B>,
        first: usize,
        stranded: &[(usize, u64)],
        work: &mut BatchWorkspace<B>,
    ) {
        let BatchWorkspace { mesh, core } = work;
        self.mesh.assemble(simd, rows, first, stranded, mesh);
        self.mesh.eliminate(simd, mesh);
        let mut core = self.core.as_ref().zip(core.as_mut());
        if let Some((core, work)) = &mut core {
            core.precondition(simd, &self.mesh.program, mesh, work);
            core.iterate(simd, &self.mesh.program, mesh, work);
        }
        self.mesh.substitute_back(simd, mesh);
        if let Some((core, work)) = &mut core {
            core.level_dead_ends(&self.mesh, mesh, work, rows);
        }
    }
}
