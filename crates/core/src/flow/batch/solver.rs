//! The pressures of several samples side by side, by whichever solver suits the circuit.

#![expect(clippy::inline_always, reason = "compiled as a whole for each instruction set")]

use super::conjugate_gradients::{ConjugateGradients, GradientsWorkspace};
use super::star_mesh::{Conductances, Open, StarMesh, StarMeshWorkspace};
use crate::error::{Error, Result};
use crate::flow::circuit::Circuit;
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

    /// The pressures, and memory that is free until the next group is solved.
    #[inline(always)]
    pub fn pressure_and_spare(&mut self) -> (&[Lanes<B>], &mut [Lanes<B>]) {
        self.mesh.pressure_and_spare()
    }
}

impl BatchSolver {
    /// Star-mesh elimination; `None` when it would take more than `limit` joins a sample.
    pub fn star_mesh(circuit: &Circuit, limit: usize) -> Option<Self> {
        StarMesh::compile(circuit, limit).map(|mesh| Self { mesh, core: None })
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
        self.mesh.updates() + self.core.as_ref().map_or(0, ConjugateGradients::joins)
    }

    /// Conductances of the core that a step of conjugate gradients passes over, those of its incomplete elimination twice.
    pub fn rays_in_step(&self) -> usize {
        self.core.as_ref().map_or(0, |core| 2 * core.rays() + self.mesh.program().core_rays())
    }

    /// Where the pressure of a node stands in a workspace.
    pub fn slot(&self, node: usize) -> usize {
        self.mesh.slot(node)
    }

    /// The memory for groups of `B` samples, of which without a core at least so many places are [spare](BatchWorkspace::pressure_and_spare).
    pub fn workspace<const B: usize>(&self, spare: usize) -> BatchWorkspace<B> {
        BatchWorkspace { mesh: self.mesh.workspace_with(spare), core: self.core.as_ref().map(ConjugateGradients::workspace) }
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
        let is_open = |vessel: usize, lane: usize| masks[vessel] >> (first + lane) & 1 == 1;
        self.solve_at(simd, (&Open { masks, first }, first), stranded, is_open, work);
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
        self.solve_at(simd, (conductance, 0), stranded, |vessel, lane| conductance[vessel][lane] > 0.0, work);
    }

    #[inline(always)]
    fn solve_at<S: Simd, const B: usize>(
        &self,
        simd: S,
        (conductances, first): (&(impl Conductances<B> + ?Sized), usize),
        stranded: &[(usize, u64)],
        is_open: impl Fn(usize, usize) -> bool,
        work: &mut BatchWorkspace<B>,
    ) {
        let BatchWorkspace { mesh: of_mesh, core: of_core } = work;
        self.mesh.assemble(simd, conductances, first, stranded, of_mesh);
        self.mesh.eliminate(simd, of_mesh);
        let mut core = self.core.as_ref().zip(of_core.as_mut());
        if let Some((core, work)) = &mut core {
            core.solve(simd, &self.mesh, of_mesh, work);
        }
        self.mesh.substitute_back(simd, of_mesh);
        if let Some((core, work)) = &mut core {
            core.level_dead_ends(&self.mesh, of_mesh, work, is_open);
        }
    }
}
